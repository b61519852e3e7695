"""Bernstein coefficients of a matrix polynomial on a cell, a product of simplexes.

A point of a simplex is p = Σ_v λ_v V_v with λ ≥ 0, Σλ = 1. The polynomial in λ, made homogeneous,
has coefficients whose convex hull holds all its values on the cell; at the corners they are its
values. An interval is a simplex with two vertices, and a polytope is covered by the simplex of
weights on its vertices. Functions that are no polynomials enter as a Taylor polynomial and a ball
(:mod:`lmic.certify.taylor`); then the coefficients are balls.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import factorial, prod
from typing import Any, TypeAlias

import flint
import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.algebra.polynomials import MatrixPolynomial, homogeneous_exponents
from lmic.certify import taylor
from lmic.certify.statement import to_flint

Array: TypeAlias = NDArray[Any]
Vertex: TypeAlias = tuple[flint.fmpq, ...]
#: the vertices on every axis
Cell: TypeAlias = tuple[tuple[Vertex, ...], ...]
Powers: TypeAlias = tuple[int, ...]

#: bits of the ball arithmetic where functions are not polynomial
PRECISION = 192


@dataclass(frozen=True)
class Coefficients:
    """Coefficient k of the cell is row k of ``rows``, a matrix row by row; ``powers[k]`` are its
    powers of the barycentric coordinates on each axis.
    """

    order: int
    rows: list[list[Any]]
    powers: list[tuple[Powers, ...]]

    def matrix(self, k: int) -> Any:
        """Coefficient ``k``, rational or a ball."""
        kind = flint.fmpq_mat if isinstance(self.rows[k][0], flint.fmpq) else flint.arb_mat
        return kind(self.order, self.order, self.rows[k])

    def corners(self) -> list[int]:
        """The numbers of the coefficients that belong to a corner."""
        return [k for k, powers in enumerate(self.powers) if all(max(axis) == sum(axis) for axis in powers)]

    @cached_property
    def floats(self) -> tuple[Array, Array]:
        """Midpoints and radii in floating point, shape (K, order, order)."""
        shape = (len(self.rows), self.order, self.order)
        flat = [entry for row in self.rows for entry in row]
        if isinstance(flat[0], flint.fmpq):
            values = np.array([int(entry.p) / int(entry.q) for entry in flat])
            return values.reshape(shape), np.zeros(shape)
        middle = np.array([float(entry.mid()) for entry in flat]).reshape(shape)
        return middle, np.array([float(entry.rad()) for entry in flat]).reshape(shape)


class Form:
    """A matrix polynomial whose symbols are those of the axes, ready to be expanded on any cell."""

    def __init__(self, polynomial: MatrixPolynomial, axes: Sequence[tuple[sp.Symbol, ...]]) -> None:
        self.axes = tuple(axes)
        self.symbols = tuple(symbol for axis in axes for symbol in axis)
        self.order = polynomial.shape[0]
        self.atoms = polynomial.monomials.atoms
        self.exponents = polynomial.monomials.exponents
        self.matrices = to_flint(polynomial.coefficients.reshape(len(self.exponents), -1))
        self.polynomial = set(self.atoms) <= set(self.symbols)

    def is_affine(self, axis: tuple[sp.Symbol, ...]) -> bool:
        """Whether the matrix is affine in the symbols of an axis, whatever the others are."""
        columns = [k for k, atom in enumerate(self.atoms) if atom.free_symbols & set(axis)]
        simple = all(self.atoms[k] in axis for k in columns)
        return simple and int(self.exponents[:, columns].sum(axis=1).max(initial=0)) <= 1

    def coefficients(self, cell: Cell) -> Coefficients:
        """The Bernstein coefficients on a cell, exact or as balls."""
        if self.polynomial:
            place = [self.atoms.index(s) if s in self.atoms else None for s in self.symbols]
            exponents = [tuple(0 if k is None else int(row[k]) for k in place) for row in self.exponents]
            powers, weights = _weights(cell, self.axes, exponents)
            return Coefficients(self.order, (weights * self.matrices).tolist(), powers)
        with flint.ctx.workprec(PRECISION):
            centred, polynomials = self._enclosed(cell)
            exponents = sorted({powers for polynomial in polynomials for powers in polynomial})
            powers, weights = _weights(centred, self.axes, exponents)
            entries = [[p.get(row, flint.arb(0)) for p in polynomials] for row in exponents]
            rows = flint.arb_mat(weights) * flint.arb_mat(entries) * flint.arb_mat(self.matrices)
            return Coefficients(self.order, rows.tolist(), powers)

    def value(self, point: tuple[Vertex, ...]) -> Any:
        """The matrix at a point, rational or a ball."""
        return self.coefficients(tuple((vertex,) for vertex in point)).matrix(0)

    def _enclosed(self, cell: Cell) -> tuple[Cell, list[taylor.Polynomial]]:
        """The cell moved to its centre, and every monomial as a polynomial in the offsets from it."""
        sides = [list(zip(*vertices, strict=True)) for vertices in cell]
        middle = [tuple((min(side) + max(side)) / 2 for side in axis) for axis in sides]
        half = [tuple((max(side) - min(side)) / 2 for side in axis) for axis in sides]
        where = taylor.Range(
            dict(zip(self.symbols, (c for axis in middle for c in axis), strict=True)),
            dict(zip(self.symbols, (r for axis in half for r in axis), strict=True)),
        )
        atoms = [taylor.enclosure(atom, self.symbols, where) for atom in self.atoms]
        monomials = []
        for row in self.exponents:
            monomial: taylor.Polynomial = {(0,) * len(self.symbols): flint.arb(1)}
            for atom, power in zip(atoms, row, strict=True):
                for _ in range(int(power)):
                    monomial = taylor.product(monomial, atom)
            monomials.append(monomial)
        centred = tuple(
            tuple(tuple(p - c for p, c in zip(vertex, centre, strict=True)) for vertex in vertices)
            for vertices, centre in zip(cell, middle, strict=True)
        )
        return centred, monomials


def _weights(
    cell: Cell, axes: tuple[tuple[sp.Symbol, ...], ...], exponents: list[Powers]
) -> tuple[list[tuple[Powers, ...]], flint.fmpq_mat]:
    """The share of each monomial in each Bernstein coefficient: the product of its shares on the axes."""
    starts = np.cumsum([0, *map(len, axes)]).tolist()
    found: list[list[tuple[Powers, list[flint.fmpq]]]] = []
    for vertices, start, end in zip(cell, starts, starts[1:], strict=False):
        parts = [row[start:end] for row in exponents]
        degree = max(map(sum, parts), default=0)
        shares = {part: _shares(vertices, part, degree) for part in set(parts)}
        targets = [tuple(row) for row in homogeneous_exponents(len(vertices), degree).tolist()]
        found.append([(target, [shares[part].get(target, flint.fmpq(0)) for part in parts]) for target in targets])
    powers, rows = [], []
    for choice in product(*found):
        powers.append(tuple(target for target, _ in choice))
        row = [flint.fmpq(1)] * len(exponents)
        for _, shares_here in choice:
            row = [a * b for a, b in zip(row, shares_here, strict=True)]
        rows.append(row)
    return powers, flint.fmpq_mat(rows)


def _shares(vertices: tuple[Vertex, ...], exponents: Powers, degree: int) -> dict[Powers, flint.fmpq]:
    """Bernstein coefficients of Π_i p_i^exponents[i] on a simplex, in the given degree."""
    count = len(vertices)
    one = [flint.fmpq(1)] * count
    factors = [[vertex[i] for vertex in vertices] for i, power in enumerate(exponents) for _ in range(power)]
    form = {(0,) * count: flint.fmpq(1)}
    for factor in [*factors, *[one] * (degree - len(factors))]:
        following: dict[Powers, flint.fmpq] = {}
        for powers, value in form.items():
            for v in range(count):
                if factor[v] != 0:
                    raised = (*powers[:v], powers[v] + 1, *powers[v + 1 :])
                    following[raised] = following.get(raised, flint.fmpq(0)) + value * factor[v]
        form = following
    return {powers: value / (factorial(degree) // prod(map(factorial, powers))) for powers, value in form.items()}
