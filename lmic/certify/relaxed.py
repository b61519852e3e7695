"""What the compiler's finite LMIs are exactly: each one as a functional of the statement's polynomials."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from itertools import product

import numpy as np
import sympy as sp

from lmic.assemble import ConicProblem
from lmic.certify.finite import Coefficient, Functional
from lmic.domains import BoxDomain, Domain, SimplexDomain
from lmic.relax.family import AxisRelaxation, LMIFamily
from lmic.relax.grid import Grid, grid_points
from lmic.relax.polya import homogeneous_exponents
from lmic.relax.relax import Relaxation, chosen_grid
from lmic.relax.space import Axis, Space, space


def geometry(problem: ConicProblem, relaxation: Relaxation) -> Space:
    """The axes behind a compiled problem, and the symbols that are equal to others."""
    joint = frozenset(name for name, grid in relaxation.grid.items() if isinstance(grid, Grid) and grid.joint)
    return space(problem.binding, relaxation.ties, joint)


def functionals(
    problem: ConicProblem, relaxation: Relaxation
) -> tuple[list[Functional], Mapping[sp.Symbol, sp.Symbol]]:
    """The functional of every LMI of the problem, in their order, and the symbols that are equal to others."""
    where = geometry(problem, relaxation)
    found: list[Functional] = []
    for family in problem.families:
        axes = [axis for axis in where.axes if family.lmi.monomials.split(set(axis.symbols))[0].atoms]
        choices = [
            list(_coefficients(axis, made, family, relaxation)) for axis, made in zip(axes, family.axes, strict=True)
        ]
        every = [Functional(family.lmi.place.lmi, combination) for combination in product(*choices)]
        found += [every[int(member)] for member in family.members]
    return found, where.equal


def exact_vertices(domain: Domain) -> tuple[tuple[Fraction, ...], ...]:
    """The vertices in the order of ``domain.vertices``; those of a polytope are the decimals they print as."""
    match domain:
        case SimplexDomain():
            return tuple(tuple(map(Fraction, row)) for row in np.eye(len(domain.components), dtype=int).tolist())
        case BoxDomain():
            ends = [sorted({low, high}) for low, high in zip(domain.lower, domain.upper, strict=True)]
            return tuple(product(*ends))
    return tuple(tuple(Fraction(repr(value)) for value in row) for row in domain.vertices.tolist())


def _coefficients(axis: Axis, made: AxisRelaxation, family: LMIFamily, relaxation: Relaxation) -> Iterator[Coefficient]:
    """The choices on one axis, in the order of the relaxation's labels."""
    part = family.lmi.monomials.split(set(axis.symbols))[0]
    degree = int(part.exponents.sum(axis=1).max())
    if made.method.startswith("grid"):
        for point in grid_points(axis, chosen_grid(axis, relaxation)).tolist():
            yield Coefficient(axis.symbols, (_inside(point, axis.domain),), (degree,))
        return
    corners = exact_vertices(axis.domain)
    if made.method == "vertices":
        powers = [tuple(row) for row in (degree * np.eye(len(corners), dtype=int)).tolist()]
    else:
        target = degree + int(made.method.rpartition(" ")[2])
        powers = [tuple(row) for row in homogeneous_exponents(len(corners), target).tolist()]
    for row in powers:
        yield Coefficient(axis.symbols, corners, row)


def _inside(point: list[float], domain: Domain) -> tuple[Fraction, ...]:
    """A grid point's dyadic value, moved to the domain where rounding has left it."""
    exact = [Fraction(value) for value in point]
    match domain:
        case BoxDomain():
            ends = zip(exact, domain.lower, domain.upper, strict=True)
            return tuple(min(max(value, low), high) for value, low, high in ends)
        case SimplexDomain():
            total = sum(exact)
            return tuple(value / total for value in exact)
    return tuple(exact)
