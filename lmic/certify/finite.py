"""The finite problem of a relaxation, with exact rational data.

A finite LMI is a linear functional of the polynomial matrix F(θ; x) that the statement makes: its
value at a point, or a coefficient of its form in barycentric coordinates. Both are one thing: with
corners V_v and θ = Σ_v λ_v V_v, a polynomial of degree D or less is a form of degree D in λ, of
which one coefficient is taken. A single corner gives the value there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from typing import Any, TypeAlias

import flint
import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.certify.statement import Statement, is_coordinate
from lmic.errors import CertificateError
from lmic.polynomials import MatrixPolynomial

Array: TypeAlias = NDArray[Any]
Powers: TypeAlias = tuple[int, ...]


@dataclass(frozen=True)
class Coefficient:
    """On one axis: the coefficient of λ^``powers`` of the form over ``corners``, one row of ``symbols`` each."""

    symbols: tuple[sp.Symbol, ...]
    corners: tuple[tuple[Fraction, ...], ...]
    powers: Powers

    def weight(self, exponents: Powers) -> Fraction:
        """Its value for the monomial with these exponents of ``symbols``."""
        return _form(self.corners, exponents, sum(self.powers)).get(self.powers, Fraction(0))

    @property
    def point(self) -> tuple[Fraction, ...] | None:
        """The point at which it is the value, if it is one."""
        used = [v for v, power in enumerate(self.powers) if power]
        if len(self.corners) == 1:
            return self.corners[0]
        return self.corners[used[0]] if len(used) == 1 else None


@dataclass(frozen=True)
class Functional:
    """One finite LMI: a coefficient on each independent axis of the LMI named ``lmi``."""

    lmi: str
    axes: tuple[Coefficient, ...]

    def weights(self, polynomial: MatrixPolynomial) -> list[Fraction]:
        """Its value for each monomial, the coordinates of the unknowns apart."""
        atoms = polynomial.monomials.atoms
        columns = [[atoms.index(s) if s in atoms else None for s in axis.symbols] for axis in self.axes]
        covered = {atoms[c] for axis in columns for c in axis if c is not None}
        for atom in atoms:
            if atom not in covered and not (isinstance(atom, sp.Symbol) and is_coordinate(atom)):
                raise CertificateError(f"{atom} has no exact rational value in the LMI '{self.lmi}'")
        found: list[Fraction] = []
        for row in polynomial.monomials.exponents.tolist():
            product = Fraction(1)
            for axis, places in zip(self.axes, columns, strict=True):
                product *= axis.weight(tuple(0 if c is None else row[c] for c in places))
            found.append(product)
        return found


@cache
def _form(corners: tuple[tuple[Fraction, ...], ...], exponents: Powers, degree: int) -> Mapping[Powers, Fraction]:
    """Coefficients of Π_i (Σ_v corners[v][i] λ_v)^exponents[i] · (Σλ)^rest, of total degree ``degree``."""
    if sum(exponents) > degree:
        raise CertificateError(f"a polynomial of degree {sum(exponents)} has no form of degree {degree}")
    count = len(corners)
    linear = [[corner[i] for corner in corners] for i, power in enumerate(exponents) for _ in range(power)]
    form: dict[Powers, Fraction] = {(0,) * count: Fraction(1)}
    for factor in [*linear, *[[Fraction(1)] * count] * (degree - len(linear))]:
        following: dict[Powers, Fraction] = {}
        for monomial, value in form.items():
            for v, entry in enumerate(factor):
                if entry:
                    raised = (*monomial[:v], monomial[v] + 1, *monomial[v + 1 :])
                    following[raised] = following.get(raised, Fraction(0)) + value * entry
        form = following
    return form


@dataclass(frozen=True)
class FiniteLMI:
    """F_0 + Σ_i x_i F_i by its entries on and above the diagonal: value in (row, col) of F_column - 1.

    Column 0 is the constant.
    """

    order: int
    columns: Array
    rows: Array
    cols: Array
    values: Array

    def at(self, x: Sequence[Fraction]) -> Array:
        """The matrix at x."""
        matrix = np.full((self.order, self.order), Fraction(0), dtype=object)
        factors = np.array([Fraction(1), *x], dtype=object)[self.columns]
        np.add.at(matrix, (self.rows, self.cols), factors * self.values)
        return np.triu(matrix) + np.triu(matrix, 1).T

    def inner(self, dual: Array, size: int) -> Array:
        """⟨F_0, Z⟩ and ⟨F_i, Z⟩ for a symmetric Z, shape (1 + size,)."""
        double = np.where(self.rows == self.cols, 1, 2)
        products = np.full(size + 1, Fraction(0), dtype=object)
        np.add.at(products, self.columns, self.values * dual[self.rows, self.cols] * double)
        return products


@dataclass(frozen=True)
class FiniteProblem:
    """minimise cost·x + constant subject to every LMI positive semidefinite, all exact.

    ``names`` are the unknowns with their basis functions, in the order of their coordinates.
    """

    lmis: tuple[FiniteLMI, ...]
    cost: Array
    constant: Fraction

    @property
    def size(self) -> int:
        """Number of scalar unknowns."""
        return len(self.cost)

    @cached_property
    def rational(self) -> bool:
        """Whether all data are fractions, and none is known as a ball only."""
        return not any(isinstance(value, flint.arb) for lmi in self.lmis for value in lmi.values)


def finite_problem(
    statement: Statement,
    functions: Mapping[str, Sequence[sp.Expr]],
    equal: Mapping[sp.Symbol, sp.Symbol],
    functionals: Sequence[Functional],
) -> FiniteProblem:
    """The exact problem of a statement whose unknowns have these basis functions.

    Coordinates are numbered in the order of ``functions``; ``equal`` are the symbols that ties and
    constant parameters make equal to others.
    """
    unknowns, first = {}, 0
    for name, basis in functions.items():
        unknowns[name] = statement.symbolic(name, basis, first)
        first += (int(statement.coordinates(name).max()) + 1) * len(basis)
    matrices = {
        lmi: statement.matrix(lmi, unknowns).renamed(equal) for lmi in dict.fromkeys(f.lmi for f in functionals)
    }
    sparse = {lmi: _sparse(matrix) for lmi, matrix in matrices.items()}
    lmis = tuple(_applied(f, matrices[f.lmi], sparse[f.lmi]) for f in functionals)
    if statement.theorem.minimise is None:
        return FiniteProblem(lmis, np.full(first, Fraction(0), dtype=object), Fraction(0))
    objective = statement.expression(statement.theorem.minimise, unknowns)
    cost = np.full(first + 1, Fraction(0), dtype=object)
    np.add.at(cost, _columns(objective), objective.coefficients[:, 0, 0])
    return FiniteProblem(lmis, cost[1:], cost[0])


def _columns(polynomial: MatrixPolynomial) -> Array:
    """For each monomial 1 + the number of its coordinate, 0 without one; raises unless affine."""
    columns = np.zeros(len(polynomial.monomials), dtype=int)
    degrees = np.zeros(len(polynomial.monomials), dtype=int)
    for k, atom in enumerate(polynomial.monomials.atoms):
        inside = [symbol for symbol in atom.free_symbols if is_coordinate(symbol)]
        if inside:
            powers = polynomial.monomials.exponents[:, k]
            degrees += powers if atom == inside[0] else 2
            columns[powers > 0] = 1 + int(str(inside[0])[2:-1])
    if (degrees > 1).any():
        raise CertificateError("the unknowns do not enter affinely")
    return columns


def _sparse(polynomial: MatrixPolynomial) -> tuple[Array, Array, Array, Array, Array]:
    """Monomial, column, row, col and value of the nonzero entries on and above the diagonal."""
    upper = np.triu(np.ones(polynomial.shape, dtype=bool))
    monomial, row, col = np.nonzero((polynomial.coefficients != 0) & upper)
    return monomial, _columns(polynomial)[monomial], row, col, polynomial.coefficients[monomial, row, col]


def _applied(functional: Functional, matrix: MatrixPolynomial, sparse: tuple[Array, ...]) -> FiniteLMI:
    monomial, column, row, col, value = sparse
    weighted = np.array(functional.weights(matrix), dtype=object)[monomial] * value
    order = matrix.shape[0]
    key, place = np.unique((column * order + row) * order + col, return_inverse=True)
    values = np.full(len(key), Fraction(0), dtype=object)
    np.add.at(values, place, weighted)
    used = values != 0
    key, values = key[used], values[used]
    return FiniteLMI(order, key // order**2, key // order % order, key % order, values)
