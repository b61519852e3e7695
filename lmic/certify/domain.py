"""A symmetric matrix function proven positive definite on a whole parameter domain.

Where the matrix is affine its values at the vertices decide. Elsewhere the domain is cut into cells
until the Bernstein coefficients of each are positive definite, or a corner shows that the matrix is
not. Floating point only chooses what to try next.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import combinations, count, product
from typing import Any, TypeAlias

import flint
import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.algebra.polynomials import MatrixPolynomial
from lmic.certify import polytopes
from lmic.certify.bernstein import PRECISION, Cell, Coefficients, Form, Vertex
from lmic.certify.definite import decide, is_positive_definite, proves_positive_definite
from lmic.certify.polytopes import Point, polytope
from lmic.errors import CertificateError
from lmic.language.parameters import NEXT, Parameter, instance_symbol, rate_symbol
from lmic.plants.domains import Bounds, BoxDomain, Domain, Motion

Array: TypeAlias = NDArray[Any]

#: relative eigenvalue below which floating point is sure that a coefficient is not positive definite
SURELY_NEGATIVE = -1e-9
#: relative eigenvalue below which a corner is worth an exact decision
DOUBTFUL = 1e-9


@dataclass(frozen=True)
class ProofAxis:
    """Symbols that range together over the convex hull of ``points``, exact rows of coordinates."""

    symbols: tuple[sp.Symbol, ...]
    points: tuple[Point, ...]


@dataclass(frozen=True)
class ProofDomain:
    """Independent axes, and the symbols that equal others."""

    axes: tuple[ProofAxis, ...]
    equal: Mapping[sp.Symbol, sp.Symbol] = field(default_factory=dict)


@dataclass(frozen=True)
class Proven:
    """Positive definite on the whole domain.

    ``method`` is "vertices" (affine), "Bernstein" (polynomial) or "balls"; ``cells`` were examined.
    """

    method: str
    cells: int


@dataclass(frozen=True)
class Witness:
    """At ``point`` of the domain the matrix is proven not to be positive definite."""

    point: Mapping[sp.Symbol, Fraction]
    cells: int


@dataclass(frozen=True)
class Undecided:
    """The budget of cells is spent; ``point`` is the centre of the cell that looks worst."""

    point: Mapping[sp.Symbol, Fraction]
    cells: int


def proof_domain(
    domains: Mapping[str, Domain],
    instances: Mapping[str, Sequence[Parameter]],
    motions: Mapping[str, Motion] | None = None,
    ties: Mapping[str, str] | None = None,
) -> ProofDomain:
    """The domain of a theorem's parameters at all their instances, as a relaxation takes them.

    ``domains`` and ``motions`` are the plant's, ``instances`` the theorem's ``parameters``; ``ties``
    equate instances, {"b": "a"}. Instances are independent, unless a bound on the step joins now
    and next, a constant parameter makes them equal, or a tie does.
    """
    axes: list[ProofAxis] = []
    equal: dict[sp.Symbol, sp.Symbol] = {}
    for name, domain in domains.items():
        found = [parameter.instance for parameter in instances[name]]
        motion = (motions or {}).get(name, Motion())
        same = dict(ties or {})
        step = _step(name, instances[name], motion) if NEXT in found and NEXT not in same else "free"
        if step == "constant":
            same[NEXT] = ""
        roots = {instance: _root(instance, same) for instance in found}
        for instance, root in roots.items():
            if instance != root:
                equal |= {instance_symbol(c, instance): instance_symbol(c, root) for c in domain.components}
        free = sorted(set(roots.values()))
        if not isinstance(step, str):
            axes += _stepping(domain, step)
            free = [instance for instance in free if instance not in ("", NEXT)]
        for instance in free:
            axes += _split(domain, tuple(instance_symbol(c, instance) for c in domain.components))
        if motion.rate is not None:
            axes += _rates(domain, motion.rate)
    return ProofDomain(tuple(axes), equal)


def prove_positive(matrix: MatrixPolynomial, domain: ProofDomain, budget: int) -> Proven | Witness | Undecided:
    """Prove that a symmetric matrix with exact coefficients is positive definite on the whole domain.

    ``budget`` is the number of cells to examine. Raises CertificateError where the matrix is not
    symmetric, or depends on symbols that the domain does not hold.
    """
    matrix = matrix.renamed(domain.equal).merged()
    _check(matrix, domain)
    occurring = {symbol for atom in matrix.monomials.atoms for symbol in atom.free_symbols}
    axes = tuple(axis for axis in domain.axes if occurring & set(axis.symbols))
    search = _Search(domain, axes, Form(matrix, [axis.symbols for axis in axes]))
    number = count()
    waiting: list[tuple[float, int, Cell]] = [(0.0, next(number), cell) for cell in search.first_cells()]
    for cells in count():
        if not waiting:
            return Proven(search.method, cells)
        margin, _, cell = waiting[0]
        if cells >= budget:
            return Undecided(search.point(_centre(cell)), cells)
        heapq.heappop(waiting)
        coefficients = search.form.coefficients(cell)
        margins = _margins(coefficients)
        corner = search.failing_corner(cell, coefficients, margins)
        if corner is not None:
            return Witness(search.point(corner), cells + 1)
        if not search.is_proven(coefficients, margins):
            margin = float(margins.min())
            for part in search.halves(cell, coefficients):
                heapq.heappush(waiting, (margin, next(number), part))
    raise AssertionError("the cells are counted without end")


@dataclass(frozen=True)
class _Search:
    """What every cell is judged by: the axes that occur, and the matrix in their symbols."""

    domain: ProofDomain
    axes: tuple[ProofAxis, ...]
    form: Form

    @property
    def bent(self) -> list[bool]:
        """Whether an axis is one in which the matrix is not affine."""
        return [not self.form.is_affine(axis.symbols) for axis in self.axes]

    @property
    def method(self) -> str:
        """What the proof rests on."""
        if not self.form.polynomial:
            return "balls"
        return "Bernstein" if any(self.bent) else "vertices"

    def first_cells(self) -> Iterator[Cell]:
        """Every vertex of the axes in which the matrix is affine, with the whole of the others."""
        choices = []
        for axis, bent in zip(self.axes, self.bent, strict=True):
            points = [tuple(flint.fmpq(f.numerator, f.denominator) for f in point) for point in axis.points]
            choices.append([tuple(points)] if bent else [(point,) for point in points])
        yield from product(*choices)

    def failing_corner(self, cell: Cell, coefficients: Coefficients, margins: Array) -> tuple[Vertex, ...] | None:
        """A corner at which the matrix is proven not to be positive definite."""
        for k in coefficients.corners():
            if margins[k] > DOUBTFUL:
                continue
            corner = tuple(
                vertices[int(np.argmax(powers))] for vertices, powers in zip(cell, coefficients.powers[k], strict=True)
            )
            if self.refutes(corner):
                return corner
        return None

    def refutes(self, point: tuple[Vertex, ...]) -> bool:
        """Whether the matrix at a point is proven not to be positive definite."""
        value = self.form.value(point)
        if self.form.polynomial:
            return not is_positive_definite(value)
        with flint.ctx.workprec(PRECISION):
            return decide(value) is False

    def is_proven(self, coefficients: Coefficients, margins: Array) -> bool:
        """Whether every coefficient is positive definite for certain, the doubtful ones asked first."""
        if margins.min() < SURELY_NEGATIVE:
            return False
        matrices = map(coefficients.matrix, np.argsort(margins).tolist())
        if self.form.polynomial:
            return all(map(is_positive_definite, matrices))
        with flint.ctx.workprec(PRECISION):
            return all(map(proves_positive_definite, matrices))

    def halves(self, cell: Cell, coefficients: Coefficients) -> tuple[Cell, Cell]:
        """The cell bisected at the longest edge of the axis along which the matrix bends most."""
        bends = [
            _bend(coefficients, k, _length(cell[k]) / _length(axis.points)) if bent else -1.0
            for k, (axis, bent) in enumerate(zip(self.axes, self.bent, strict=True))
        ]
        chosen = int(np.argmax(bends))
        vertices = list(cell[chosen])
        i, j = max(combinations(range(len(vertices)), 2), key=lambda pair: _distance(*(vertices[k] for k in pair)))
        middle = tuple((a + b) / 2 for a, b in zip(vertices[i], vertices[j], strict=True))
        return tuple((*cell[:chosen], (*vertices[:k], middle, *vertices[k + 1 :]), *cell[chosen + 1 :]) for k in (i, j))  # type: ignore[return-value]

    def point(self, place: tuple[Vertex, ...]) -> dict[sp.Symbol, Fraction]:
        """A place on the occurring axes as values of all symbols; an axis that does not occur is at its first point."""
        values = {s: value for axis in self.domain.axes for s, value in zip(axis.symbols, axis.points[0], strict=True)}
        for axis, vertex in zip(self.axes, place, strict=True):
            values |= {s: Fraction(int(v.p), int(v.q)) for s, v in zip(axis.symbols, vertex, strict=True)}
        return values


def _margins(coefficients: Coefficients) -> Array:
    """The least eigenvalue of each coefficient, relative to the mean diagonal, less its radius; in floating point."""
    middle, radius = coefficients.floats
    if not np.isfinite(middle).all():
        return np.full(len(middle), -np.inf)
    diagonal = np.abs(np.einsum("kii->ki", middle)).mean(axis=0)
    root = 1 / np.sqrt(np.maximum(diagonal, np.finfo(float).tiny))
    scale = root[:, None] * root
    margins: Array = np.linalg.eigvalsh(middle * scale)[:, 0] - np.linalg.norm(radius * scale, axis=(1, 2))
    return margins


def _bend(coefficients: Coefficients, axis: int, share: float) -> float:
    """How far the coefficients are from affine along an axis, and its share of what the balls leave open."""
    middle, radius = coefficients.floats
    if not np.isfinite(middle).all():
        return share
    diagonal = np.abs(np.einsum("kii->ki", middle)).mean(axis=0)
    root = 1 / np.sqrt(np.maximum(diagonal, np.finfo(float).tiny))
    scale = root[:, None] * root
    index = {powers: k for k, powers in enumerate(coefficients.powers)}
    most = 0.0
    for powers, k in index.items():
        mine = powers[axis]
        degree = sum(mine)
        straight = np.zeros_like(middle[k])
        for v, power in enumerate(mine):
            if power:
                corner = tuple(degree if u == v else 0 for u in range(len(mine)))
                straight += power / degree * middle[index[(*powers[:axis], corner, *powers[axis + 1 :])]]
        most = max(most, float(np.abs((middle[k] - straight) * scale).max()) if degree else 0.0)
    return most + share * float((radius * scale).max())


def _distance(first: Sequence[Any], second: Sequence[Any]) -> Any:
    return sum((a - b) ** 2 for a, b in zip(first, second, strict=True))


def _length(vertices: Sequence[Sequence[Any]]) -> float:
    """The longest edge."""
    square = max((_distance(a, b) for a, b in combinations(vertices, 2)), default=0)
    return float(Fraction(int(square.p), int(square.q)) if isinstance(square, flint.fmpq) else square) ** 0.5


def _centre(cell: Cell) -> tuple[Vertex, ...]:
    return tuple(tuple(sum(side) / len(side) for side in zip(*vertices, strict=True)) for vertices in cell)


def _check(matrix: MatrixPolynomial, domain: ProofDomain) -> None:
    if (matrix.coefficients != matrix.coefficients.transpose(0, 2, 1)).any():
        raise CertificateError(
            "a matrix that is not symmetric cannot be proven positive definite; give a symmetric one"
        )
    known = {symbol for axis in domain.axes for symbol in axis.symbols}
    unknown = {symbol for atom in matrix.monomials.atoms for symbol in atom.free_symbols} - known
    if unknown:
        raise CertificateError(f"{min(map(str, unknown))} has no domain; give the domain of its parameter")


# The axes of a theorem's parameters -----------------------------------------------------------------


def _step(name: str, instances: Sequence[Parameter], motion: Motion) -> str | Bounds:
    """How far a parameter moves in a step: what the plant says, else what the theorem itself states."""
    if motion.step is not None:
        return motion.step
    for parameter in instances:
        if parameter.step:
            return parameter.step
    raise CertificateError(f"nothing says how far {name} moves in a step; give its step in the plant")


def _root(instance: str, same: Mapping[str, str]) -> str:
    """The instance that a tied one equals in the end."""
    path = [instance]
    while path[-1] in same:
        path.append(same[path[-1]])
        if path[-1] in path[:-1]:
            raise CertificateError(f"the ties {' = '.join(path)} go in a circle; tie to one instance that is free")
    return path[-1]


def _split(domain: Domain, symbols: tuple[sp.Symbol, ...]) -> Iterator[ProofAxis]:
    """A box's components one by one, any other domain whole."""
    if isinstance(domain, BoxDomain):
        for symbol, side in zip(symbols, domain.sides, strict=True):
            yield ProofAxis((symbol,), polytope(side).vertices)
    else:
        yield ProofAxis(symbols, polytope(domain).vertices)


def _stepping(domain: Domain, bounds: Bounds) -> Iterator[ProofAxis]:
    """The parameter and its next value together: a box component by component, a simplex whole."""
    for part in domain.sides if isinstance(domain, BoxDomain) else (domain,):
        symbols = tuple(instance_symbol(c, i) for i in ("", NEXT) for c in part.components)
        yield ProofAxis(symbols, polytopes.joint_step(part, bounds).vertices)


def _rates(domain: Domain, bounds: Bounds) -> Iterator[ProofAxis]:
    """The rates of change: of a box component by component, of a simplex whole."""
    for part in domain.sides if isinstance(domain, BoxDomain) else (domain,):
        yield ProofAxis(tuple(map(rate_symbol, part.components)), polytopes.rates(part, bounds).vertices)
