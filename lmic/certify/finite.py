"""The finite problem of a relaxation, with exact rational data, or balls where functions are transcendental.

A finite LMI is a linear functional of the polynomial matrix F(θ; x) that the statement makes: its
value at a point, or a coefficient of its form in barycentric coordinates. Both are one thing: with
corners V_v and θ = Σ_v λ_v V_v, a polynomial of degree D or less is a form of degree D in λ, of
which one coefficient is taken. A single corner gives the value there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, cached_property
from typing import Any, TypeAlias

import flint
import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.algebra.polynomials import MatrixPolynomial, Monomials
from lmic.certify import taylor
from lmic.certify.balls import PRECISION, ball, balls, has_balls, is_zero
from lmic.certify.sparse import Monomial, SparsePolynomial, dense_monomials, listed
from lmic.certify.statement import Statement, is_coordinate
from lmic.errors import CertificateError

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

    @property
    def at_point(self) -> bool:
        """Whether it is the value at a point: the theorem asks for that, and for other coefficients a relaxation."""
        return all(axis.point is not None for axis in self.axes)

    def weights(self, polynomial: MatrixPolynomial) -> list[Any]:
        """Its value for each monomial of a matrix."""
        return self.monomial_weights(polynomial.monomials)

    def monomial_weights(self, monomials: Monomials) -> list[Any]:
        """Its value for each monomial, a fraction, or a ball where functions are not polynomial.

        Raises CertificateError where such a function is not taken at a point.
        """
        atoms = monomials.atoms
        columns = [[atoms.index(s) if s in atoms else None for s in axis.symbols] for axis in self.axes]
        own = {symbol for axis in self.axes for symbol in axis.symbols}
        functions = [(k, self._value(atom)) for k, atom in enumerate(atoms) if atom not in own]
        found: list[Any] = []
        for row in monomials.exponents.tolist():
            product: Any = Fraction(1)
            for axis, places in zip(self.axes, columns, strict=True):
                product *= axis.weight(tuple(0 if c is None else row[c] for c in places))
            for k, value in functions:
                if row[k]:
                    product = ball(product) * value ** row[k]
            found.append(product)
        return found

    def _value(self, atom: sp.Expr) -> flint.arb:
        """A function of the parameters at the point that the functional is the value at."""
        values = {s: v for axis in self.axes if axis.point for s, v in zip(axis.symbols, axis.point, strict=True)}
        if not atom.free_symbols <= set(values):
            raise CertificateError(f"{atom} has no exact rational value in the LMI '{self.lmi}'")
        return taylor.value(atom, {s: flint.fmpq(v.numerator, v.denominator) for s, v in values.items()})


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
        products = np.full(size + 1, flint.arb(0) if has_balls(self.values) else Fraction(0), dtype=object)
        np.add.at(products, self.columns, self.values * dual[self.rows, self.cols] * double)
        return products


@dataclass(frozen=True)
class FiniteProblem:
    """minimise cost·x + constant subject to every LMI positive semidefinite, all exact; ``cost`` has shape (size,)."""

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
        return not any(has_balls(lmi.values) for lmi in self.lmis)


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
    occurring = dict.fromkeys(functional.lmi for functional in functionals)
    terms = {lmi: _Terms.of(statement.sparse_matrix(lmi, unknowns).renamed(equal)) for lmi in occurring}
    with flint.ctx.workprec(PRECISION):
        lmis = tuple(terms[functional.lmi].at(functional) for functional in functionals)
        if any(has_balls(lmi.values) for lmi in lmis):  # then all, so that the values may be added
            lmis = tuple(replace(lmi, values=balls(lmi.values)) for lmi in lmis)
    cost = np.full(first + 1, Fraction(0), dtype=object)
    if statement.theorem.minimise is not None:
        for monomial, value in statement.sparse_expression(statement.theorem.minimise, unknowns).entry.items():
            function, column = _affine(monomial)
            if function:
                raise CertificateError("the objective depends on a parameter")
            cost[column] += value
    return FiniteProblem(lmis, cost[1:], cost[0])


def _affine(monomial: Monomial) -> tuple[Monomial, int]:
    """The function of the parameters, and 1 + the number of the coordinate, 0 without one; raises unless affine."""
    function, column = [], 0
    for atom, power in monomial:
        if not any(map(is_coordinate, atom.free_symbols)):
            function.append((atom, power))
        elif column or power != 1 or not is_coordinate(atom):
            raise CertificateError("the unknowns do not enter affinely")
        else:
            column = 1 + int(atom.name[2:-1])
    return frozenset(function), column


@dataclass(frozen=True)
class _Terms:
    """An LMI's terms on and above the diagonal, each a value · a monomial of the parameters in F_column - 1.

    ``monomial`` is the number of that among ``monomials``; column 0 is the constant.
    """

    order: int
    monomials: Monomials
    monomial: Array
    columns: Array
    rows: Array
    cols: Array
    values: Array

    @classmethod
    def of(cls, matrix: SparsePolynomial) -> _Terms:
        """The terms of a matrix that is affine in the coordinates."""
        parts = {monomial: _affine(monomial) for monomial in matrix.monomials}
        monomials = dense_monomials({function for function, _ in parts.values()})
        number = {function: k for k, function in enumerate(listed(monomials))}
        upper = [((i, j), *parts[m], value) for (i, j), m, value in matrix.terms() if i <= j]
        places = np.array([place for place, *_ in upper], dtype=int).reshape(-1, 2)
        return cls(
            matrix.shape[0],
            monomials,
            np.array([number[function] for _, function, _, _ in upper], dtype=int),
            np.array([column for _, _, column, _ in upper], dtype=int),
            places[:, 0],
            places[:, 1],
            np.array([value for *_, value in upper], dtype=object),
        )

    def at(self, functional: Functional) -> FiniteLMI:
        """The finite LMI of a functional."""
        weights = np.array([None, *functional.monomial_weights(self.monomials)], dtype=object)[1:]
        factors = self.values
        if has_balls(weights):
            weights, factors = balls(weights), balls(factors)
        weights = weights[self.monomial]
        order = self.order
        keys = (self.columns * order + self.rows) * order + self.cols
        key, place = np.unique(keys, return_inverse=True)
        values = np.full(len(key), 0 * weights[0] if len(weights) else Fraction(0), dtype=object)
        np.add.at(values, place, weights * factors)
        used = np.array([not is_zero(value) for value in values], dtype=bool)
        key, values = key[used], values[used]
        return FiniteLMI(order, key // order**2, key // order % order, key % order, values)
