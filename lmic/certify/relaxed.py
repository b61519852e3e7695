"""What the compiler's finite LMIs are exactly: each one as a functional of the statement's polynomials."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import product

import numpy as np

from lmic.algebra.polynomials import homogeneous_exponents
from lmic.certify.domain import ProofDomain
from lmic.certify.finite import Coefficient, Functional
from lmic.compiler.assemble import ConicProblem
from lmic.plants.domains import BoxDomain, Domain, SimplexDomain
from lmic.relax.family import AxisRelaxation, LMIFamily
from lmic.relax.grid import grid_points
from lmic.relax.relax import Relaxation, chosen_grid
from lmic.relax.space import Axis, space


def functionals(problem: ConicProblem, relaxation: Relaxation, domain: ProofDomain) -> list[Functional]:
    """The functional of every LMI of the problem, in their order; ``domain`` has the exact vertices."""
    every_axis = space(problem.binding, relaxation.ties, relaxation.joint).axes
    found: list[Functional] = []
    for family in problem.families:
        axes = [axis for axis in every_axis if family.lmi.monomials.split(set(axis.symbols))[0].atoms]
        choices = [
            list(_coefficients(axis, made, family, relaxation, domain))
            for axis, made in zip(axes, family.axes, strict=True)
        ]
        every = [Functional(family.lmi.place.lmi, combination) for combination in product(*choices)]
        found += [every[int(member)] for member in family.members]
    return found


def exact_vertices(axis: Axis, domain: ProofDomain) -> tuple[tuple[Fraction, ...], ...]:
    """The exact vertices of an axis, in the order of its floating-point ones."""
    mine = [one for one in domain.axes if set(one.symbols) <= set(axis.symbols)]
    order = [symbol for one in mine for symbol in one.symbols]
    places = [order.index(symbol) for symbol in axis.symbols]
    exact = [tuple(sum(rows, ())[k] for k in places) for rows in product(*(one.points for one in mine))]
    table = np.array(exact, dtype=float)
    return tuple(exact[int(np.abs(table - row).max(axis=1).argmin())] for row in axis.domain.vertices)


def _coefficients(
    axis: Axis, made: AxisRelaxation, family: LMIFamily, relaxation: Relaxation, domain: ProofDomain
) -> Iterator[Coefficient]:
    """The choices on one axis, in the order of the relaxation's labels."""
    part = family.lmi.monomials.split(set(axis.symbols))[0]
    degree = int(part.exponents.sum(axis=1).max())
    if made.method.startswith("grid"):
        for point in grid_points(axis, chosen_grid(axis, relaxation)).tolist():
            yield Coefficient(axis.symbols, (_inside(point, axis.domain),), (degree,))
        return
    corners = exact_vertices(axis, domain)
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
            positive = [max(value, Fraction(0)) for value in exact]
            return tuple(value / sum(positive) for value in positive)
    return tuple(exact)
