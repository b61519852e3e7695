"""The sets that parameters range over, and how parameters move in them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import product
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import HalfspaceIntersection

from lmic.errors import DomainError

Array: TypeAlias = NDArray[Any]
Bounds: TypeAlias = Mapping[str, Any]

#: how far outside a domain rounding may leave a point that was computed in floating point, relative to its size
ROUNDING = 1e-9


class Domain(ABC):
    """A polytope of parameter values; ``components`` name its coordinates."""

    kind: str
    components: tuple[str, ...]

    @property
    @abstractmethod
    def vertices(self) -> Array:
        """Vertices, shape (V, components)."""

    @abstractmethod
    def sample(self, count: int, generator: np.random.Generator) -> Array:
        """Random points, shape (count, components)."""

    @abstractmethod
    def contains(self, points: Array) -> Array:
        """Whether each of the points, shape (K, components), lies in the domain, rounding apart."""


@dataclass(frozen=True)
class SimplexDomain(Domain):
    """The unit simplex; its components are nonnegative and sum to one."""

    components: tuple[str, ...]
    kind = "simplex"

    def __post_init__(self) -> None:
        if not self.components:
            raise DomainError("a simplex has no vertex; give at least one")

    @classmethod
    def named(cls, parameter: str, vertices: int) -> SimplexDomain:
        """The simplex with components alpha1, alpha2, …"""
        return cls(tuple(f"{parameter}{i + 1}" for i in range(vertices)))

    @property
    def vertices(self) -> Array:
        """The unit vectors."""
        return np.eye(len(self.components))

    def sample(self, count: int, generator: np.random.Generator) -> Array:
        """Uniform on the simplex."""
        return generator.dirichlet(np.ones(len(self.components)), size=count)

    def contains(self, points: Array) -> Array:
        """Nonnegative, with the sum one."""
        inside: Array = (points >= -ROUNDING).all(axis=1) & (np.abs(points.sum(axis=1) - 1) <= ROUNDING)
        return inside

    def __str__(self) -> str:
        return f"unit simplex with {len(self.components)} vertices"


@dataclass(frozen=True)
class BoxDomain(Domain):
    """Every component in its own interval, with exact ends."""

    components: tuple[str, ...]
    lower: tuple[Fraction, ...]
    upper: tuple[Fraction, ...]
    kind = "box"

    def __post_init__(self) -> None:
        if not self.components:
            raise DomainError("a box has no component; give at least one interval")
        for name, low, high in zip(self.components, self.lower, self.upper, strict=True):
            if not (np.isfinite(float(low)) and np.isfinite(float(high))):
                raise DomainError(f"the interval of {name} is unbounded; give two finite ends")
            if low > high:
                raise DomainError(
                    f"the interval of {name} is empty: [{float(low):g}, {float(high):g}]; give its lower end first"
                )

    @property
    def sides(self) -> tuple[BoxDomain, ...]:
        """The intervals of the components as boxes of their own."""
        sides = zip(self.components, self.lower, self.upper, strict=True)
        return tuple(BoxDomain((name,), (low,), (high,)) for name, low, high in sides)

    @property
    def vertices(self) -> Array:
        """All combinations of ends; an interval of one point has one."""
        ends = [sorted({float(a), float(b)}) for a, b in zip(self.lower, self.upper, strict=True)]
        return np.array(list(product(*ends)))

    def sample(self, count: int, generator: np.random.Generator) -> Array:
        """Uniform in the box."""
        low, high = np.array(self.lower, dtype=float), np.array(self.upper, dtype=float)
        return low + generator.random((count, len(low))) * (high - low)

    def contains(self, points: Array) -> Array:
        """Every component in its interval."""
        low, high = np.array(self.lower, dtype=float), np.array(self.upper, dtype=float)
        allowance = ROUNDING * np.maximum(np.abs(low), np.abs(high))
        inside: Array = ((points >= low - allowance) & (points <= high + allowance)).all(axis=1)
        return inside

    def __str__(self) -> str:
        sides = zip(self.components, self.lower, self.upper, strict=True)
        return " x ".join(f"{name} in [{float(a):g}, {float(b):g}]" for name, a, b in sides)


@dataclass(frozen=True)
class PolytopeDomain(Domain):
    """The convex hull of points."""

    components: tuple[str, ...]
    points: tuple[tuple[float, ...], ...]
    kind = "polytope"

    @cached_property
    def vertices(self) -> Array:
        """The given points."""
        return np.array(self.points)

    def sample(self, count: int, generator: np.random.Generator) -> Array:
        """Random convex combinations of the vertices."""
        return generator.dirichlet(np.ones(len(self.points)), size=count) @ self.vertices

    def contains(self, points: Array) -> Array:
        """Convex combinations of the vertices."""
        from scipy.optimize import nnls

        system = np.vstack([self.vertices.T, np.ones(len(self.vertices))])
        allowance = ROUNDING * max(1.0, float(np.abs(self.vertices).max()))
        return np.array([nnls(system, np.append(point, 1.0))[1] <= allowance for point in points])

    def __str__(self) -> str:
        return f"polytope with {len(self.points)} vertices"


@dataclass(frozen=True)
class Motion:
    """How a parameter moves.

    ``step`` bounds the change ρ⁺ − ρ of each component in discrete time, or is "free" or "constant"; ``rate`` bounds
    dρ/dt in continuous time, per unit of the plant's time. A bound is a number, for both signs, or a pair (lowest,
    highest).
    """

    step: str | Bounds | None = None
    rate: Bounds | None = None


def joint_step(domain: Domain, bounds: Bounds) -> PolytopeDomain:
    """All (ρ, ρ⁺) in the domain twice with ρ⁺ − ρ within its bounds, components (ρ, ρ⁺)."""
    count = len(domain.components)
    names = (*domain.components, *(f"{c}+" for c in domain.components))
    steps = [_interval(bounds, c, "step") for c in domain.components]
    if isinstance(domain, SimplexDomain):
        # the last component follows from the others: −Σ α_i ≥ −1 and its step is −Σ of theirs
        free = count - 1
        reduced = _simplex_step(free, steps)
        last = 1 - reduced.reshape(-1, 2, free).sum(axis=2, keepdims=True)
        points = np.concatenate([reduced.reshape(-1, 2, free), last], axis=2).reshape(-1, 2 * count)
        return PolytopeDomain(names, tuple(map(tuple, points.tolist())))
    if count != 1 or not isinstance(domain, BoxDomain):
        raise DomainError(
            f"a bounded step on a {domain.kind} is taken component by component; give step = 'free' or 'constant'"
        )
    low, high = float(domain.lower[0]), float(domain.upper[0])
    (least, most) = steps[0]
    rows = [[1, 0, -high], [-1, 0, low], [0, 1, -high], [0, -1, low], [-1, 1, -most], [1, -1, least]]
    return PolytopeDomain(names, tuple(map(tuple, _polytope(np.array(rows)).tolist())))


def _simplex_step(free: int, steps: list[tuple[float, float]]) -> Array:
    """Vertices of the joint polytope in the first ``free`` components now and next."""
    rows = []
    for offset in (0, free):
        for i in range(free):
            rows.append(_row(2 * free, {offset + i: -1.0}, 0.0))
        rows.append(_row(2 * free, {offset + i: 1.0 for i in range(free)}, -1.0))
    for i, (least, most) in enumerate(steps[:free]):
        rows.append(_row(2 * free, {free + i: 1.0, i: -1.0}, -most))
        rows.append(_row(2 * free, {free + i: -1.0, i: 1.0}, least))
    least, most = steps[free]
    forward = {**{free + i: -1.0 for i in range(free)}, **dict.fromkeys(range(free), 1.0)}
    rows.append(_row(2 * free, forward, -most))
    rows.append(_row(2 * free, {k: -v for k, v in forward.items()}, least))
    return _polytope(np.array(rows))


def rate_polytope(domain: Domain, bounds: Bounds) -> Domain:
    """The admissible rates dρ/dt: a box, on a simplex cut by Σ dα/dt = 0."""
    rates = [_interval(bounds, c, "rate") for c in domain.components]
    if not isinstance(domain, SimplexDomain):
        ends = [(Fraction(low), Fraction(high)) for low, high in rates]
        return BoxDomain(domain.components, tuple(low for low, _ in ends), tuple(high for _, high in ends))
    if all(low == high == 0 for low, high in rates):
        return PolytopeDomain(domain.components, ((0.0,) * len(rates),))
    free = len(rates) - 1
    rows = []
    for i, (least, most) in enumerate(rates[:free]):
        rows += [_row(free, {i: 1.0}, -most), _row(free, {i: -1.0}, least)]
    least, most = rates[free]
    rows += [_row(free, dict.fromkeys(range(free), -1.0), -most), _row(free, dict.fromkeys(range(free), 1.0), least)]
    points = _polytope(np.array(rows))
    points = np.concatenate([points, -points.sum(axis=1, keepdims=True)], axis=1)
    return PolytopeDomain(domain.components, tuple(map(tuple, points.tolist())))


def _row(size: int, entries: Mapping[int, float], constant: float) -> Array:
    row = np.zeros(size + 1)
    for place, value in entries.items():
        row[place] = value
    row[-1] = constant
    return row


def _polytope(halfspaces: Array) -> Array:
    """Vertices of {p : halfspaces · (p, 1) ≤ 0}; degenerate sets (a bound of zero) are refused."""
    from scipy.optimize import linprog

    # small sets are enlarged by a power of two: tolerances here and in what is called are meant for a size of one
    size = min(1.0, 2.0 ** np.ceil(np.log2(np.abs(halfspaces[:, -1]).max() or 1.0)))
    halfspaces = np.column_stack([halfspaces[:, :-1], halfspaces[:, -1] / size])
    norms = np.linalg.norm(halfspaces[:, :-1], axis=1)
    centre = linprog(
        c=[*np.zeros(halfspaces.shape[1] - 1), -1.0],
        A_ub=np.column_stack([halfspaces[:, :-1], norms]),
        b_ub=-halfspaces[:, -1],
        bounds=[(None, None)] * (halfspaces.shape[1] - 1) + [(0, None)],
    )
    if not centre.success or centre.x is None or centre.x[-1] <= 0:
        raise DomainError("the bounds on the motion leave no interior; widen them, or call the parameter constant")
    if halfspaces.shape[1] == 2:
        offsets = -halfspaces[:, 1] / halfspaces[:, 0]
        upper, lower = halfspaces[:, 0] > 0, halfspaces[:, 0] < 0
        return size * np.array([[offsets[lower].max()], [offsets[upper].min()]])
    corners = HalfspaceIntersection(halfspaces, centre.x[:-1]).intersections
    return size * np.unique(np.round(corners, 12), axis=0) + 0.0


def _interval(bounds: Bounds, component: str, what: str) -> tuple[float, float]:
    """The bound of a component as (lowest, highest)."""
    if component not in bounds:
        raise DomainError(f"the {what} of {component} has no bound; give one for each component")
    bound = bounds[component]
    low, high = (float(end) for end in ((-bound, bound) if np.ndim(bound) == 0 else bound))
    if not (np.isfinite(low) and np.isfinite(high)):
        raise DomainError(f"the bound on the {what} of {component} is not finite; give a number, or step = 'free'")
    if low > high:
        raise DomainError(
            f"the bound on the {what} of {component} is empty: [{low:g}, {high:g}]; give its lower end first"
        )
    return low, high


def vertex_points(domains: Mapping[str, Domain]) -> dict[str, Array]:
    """All combinations of the domains' vertices: for each parameter its values, shape (combinations, components)."""
    if not domains:
        return {}
    combined = np.indices([len(domain.vertices) for domain in domains.values()]).reshape(len(domains), -1)
    return {name: domain.vertices[index] for (name, domain), index in zip(domains.items(), combined, strict=True)}
