"""Exact vertices of the polytopes in which a parameter and its next value, or its rates, range."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any, TypeAlias

from lmic.errors import CertificateError
from lmic.plants.domains import Bounds, BoxDomain, Domain, SimplexDomain

Point: TypeAlias = tuple[Fraction, ...]


@dataclass(frozen=True)
class Halfspace:
    """The points p with normal·p ≤ limit."""

    normal: Point
    limit: Fraction

    def slack(self, point: Point) -> Fraction:
        """limit − normal·p."""
        return self.limit - sum((a * p for a, p in zip(self.normal, point, strict=True)), Fraction(0))


@dataclass(frozen=True)
class Polytope:
    """The convex hull of ``vertices``, which is also the set within ``faces`` (and its affine hull)."""

    vertices: tuple[Point, ...]
    faces: tuple[Halfspace, ...]

    def cut(self, new: Halfspace) -> Polytope:
        """The part in a halfspace: its new vertices lie on the edges that cross the plane (double description)."""
        slack = {vertex: new.slack(vertex) for vertex in self.vertices}
        tight = {v: frozenset(k for k, face in enumerate(self.faces) if face.slack(v) == 0) for v in self.vertices}
        crossings = []
        for inner, outer in product(self.vertices, repeat=2):
            if not slack[inner] > 0 > slack[outer]:
                continue
            common = tight[inner] & tight[outer]
            if any(common <= tight[v] for v in self.vertices if v not in (inner, outer)):
                continue
            share = slack[inner] / (slack[inner] - slack[outer])
            crossings.append(tuple(a + share * (b - a) for a, b in zip(inner, outer, strict=True)))
        kept = [vertex for vertex in self.vertices if slack[vertex] >= 0]
        return Polytope((*kept, *crossings), (*self.faces, new))

    def times(self, other: Polytope) -> Polytope:
        """All pairs of points."""
        before, after = (0,) * len(self.vertices[0]), (0,) * len(other.vertices[0])
        return Polytope(
            tuple((*a, *b) for a, b in product(self.vertices, other.vertices)),
            (
                *(Halfspace(_point((*face.normal, *after)), face.limit) for face in self.faces),
                *(Halfspace(_point((*before, *face.normal)), face.limit) for face in other.faces),
            ),
        )


def polytope(domain: Domain) -> Polytope:
    """A simplex or a box with its faces."""
    size = range(len(domain.components))
    unit = [_point([int(i == j) for j in size]) for i in size]
    opposite = [_point([-int(i == j) for j in size]) for i in size]
    match domain:
        case SimplexDomain():
            return Polytope(tuple(unit), tuple(Halfspace(row, Fraction(0)) for row in opposite))
        case BoxDomain():
            return _box(domain.lower, domain.upper)
    raise CertificateError(f"a {domain.kind} is known by rounded vertices; state the domain as a simplex or a box")


def joint_step(domain: Domain, bounds: Bounds) -> Polytope:
    """All (ρ, ρ⁺) in the domain twice with ρ⁺ − ρ within its bounds."""
    once = polytope(domain)
    both = once.times(once)
    size = range(len(domain.components))
    for i, component in enumerate(domain.components):
        least, most = exact_bound(bounds[component])
        row = _point([*(-int(i == j) for j in size), *(int(i == j) for j in size)])
        both = _between(both, row, least, most)
    return _nonempty(both, "step")


def rates(domain: Domain, bounds: Bounds) -> Polytope:
    """The admissible rates dρ/dt: a box, on a simplex cut by Σ dα/dt = 0."""
    ends = [exact_bound(bounds[component]) for component in domain.components]
    box = _box([low for low, _ in ends], [high for _, high in ends])
    if isinstance(domain, SimplexDomain):
        box = _between(box, _point([1] * len(ends)), Fraction(0), Fraction(0))
    return _nonempty(box, "rate")


def exact_bound(bound: Any) -> tuple[Fraction, Fraction]:
    """A bound as (lowest, highest); a float is the decimal that it is written as."""
    low, high = bound if isinstance(bound, Sequence) else (-bound, bound)
    return _exact(low), _exact(high)


def _box(lower: Sequence[Fraction], upper: Sequence[Fraction]) -> Polytope:
    size = range(len(lower))
    vertices = product(*(sorted({low, high}) for low, high in zip(lower, upper, strict=True)))
    faces = []
    for i in size:
        faces.append(Halfspace(_point([int(i == j) for j in size]), upper[i]))
        faces.append(Halfspace(_point([-int(i == j) for j in size]), -lower[i]))
    return Polytope(tuple(vertices), tuple(faces))


def _between(cut: Polytope, row: Point, least: Fraction, most: Fraction) -> Polytope:
    opposite = tuple(-value for value in row)
    return cut.cut(Halfspace(row, most)).cut(Halfspace(opposite, -least))


def _nonempty(cut: Polytope, what: str) -> Polytope:
    if not cut.vertices:
        raise CertificateError(f"the bounds on the {what} leave no point; widen them")
    return cut


def _point(values: Sequence[int | Fraction]) -> Point:
    return tuple(map(Fraction, values))


def _exact(value: Any) -> Fraction:
    return Fraction(repr(value)) if isinstance(value, float) else Fraction(value)
