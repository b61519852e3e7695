"""Matrix polynomials in scalar atoms: the numeric form of everything that depends on a parameter.

An atom is a parameter's component (a sympy symbol), a scalar given when compiling, or any other
function of them such as ``sin(rho1)``; a matrix is then Σ_m g_m F_m with monomials g_m in the
atoms. Coefficients are one array with the monomials on the leading axis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import combinations_with_replacement
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from sympy.polys.orderings import lex
from sympy.polys.polyutils import dict_from_expr
from sympy.polys.rings import PolyRing

from lmic.algebra.functions import ExponentialEntry, replaced_entries

Array: TypeAlias = NDArray[Any]
Atom: TypeAlias = sp.Expr


@dataclass(frozen=True)
class Monomials:
    """``exponents[m, a]`` is the power of ``atoms[a]`` in monomial ``m``; shape (M, atoms)."""

    atoms: tuple[Atom, ...]
    exponents: Array

    @classmethod
    def one(cls) -> Monomials:
        """The constant monomial alone."""
        return cls((), np.zeros((1, 0), dtype=np.int64))

    @classmethod
    def of(cls, *atoms: Atom) -> Monomials:
        """Each atom to the power one."""
        return cls(tuple(atoms), np.eye(len(atoms), dtype=np.int64))

    def __len__(self) -> int:
        return int(self.exponents.shape[0])

    def over(self, atoms: tuple[Atom, ...]) -> Array:
        """Exponents in the columns of ``atoms``, a superset of this record's atoms."""
        if atoms == self.atoms:
            return self.exponents
        exponents = np.zeros((len(self), len(atoms)), dtype=np.int64)
        place = {atom: column for column, atom in enumerate(atoms)}
        for column, atom in enumerate(self.atoms):
            exponents[:, place[atom]] += self.exponents[:, column]
        return exponents

    def times(self, other: Monomials) -> Monomials:
        """All products, in row-major order of (self, other)."""
        atoms = union(self.atoms, other.atoms)
        product = self.over(atoms)[:, None, :] + other.over(atoms)[None, :, :]
        return Monomials(atoms, product.reshape(len(self) * len(other), len(atoms)))

    def merged(self) -> tuple[Monomials, Array]:
        """Distinct monomials and, for each old one, its place among them."""
        used = np.flatnonzero(self.exponents.any(axis=0))
        atoms = tuple(self.atoms[column] for column in used)
        exponents, inverse = np.unique(self.exponents[:, used], axis=0, return_inverse=True)
        if not atoms:
            exponents = np.zeros((min(len(self), 1), 0), dtype=np.int64)
        return Monomials(atoms, exponents), inverse.reshape(-1)

    def renamed(self, new: Mapping[sp.Symbol, sp.Symbol]) -> Monomials:
        """The symbols inside every atom replaced; atoms that become equal are merged."""
        renamed = tuple(atom.xreplace(new) for atom in self.atoms)
        atoms = union(renamed, ())
        return Monomials(atoms, Monomials(renamed, self.exponents).over(atoms))

    def evaluate(self, values: Mapping[sp.Symbol, Any]) -> Array:
        """Values of the monomials, shape (K, M), where each symbol has K values (or one)."""
        length = max((np.size(value) for value in values.values()), default=1)
        result = np.ones((length, len(self)))
        for column, atom in enumerate(self.atoms):
            powers = self.exponents[:, column]
            result *= np.asarray(atom_values(atom, values), dtype=float).reshape(-1, 1) ** powers[None, :]
        return result

    def split(self, symbols: set[sp.Symbol]) -> tuple[Monomials, Monomials]:
        """Each monomial as (part in atoms of ``symbols`` alone, rest)."""
        inside = [atom.free_symbols <= symbols for atom in self.atoms]
        parts = []
        for wanted in (True, False):
            columns = [column for column, flag in enumerate(inside) if flag is wanted]
            parts.append(Monomials(tuple(self.atoms[c] for c in columns), self.exponents[:, columns]))
        return parts[0], parts[1]


def union(first: Sequence[Atom], second: Sequence[Atom]) -> tuple[Atom, ...]:
    """The atoms of both, in one order."""
    return _ordered(frozenset((*first, *second)))


@lru_cache(maxsize=4096)
def _ordered(atoms: frozenset[Atom]) -> tuple[Atom, ...]:
    return tuple(sorted(atoms, key=str))


def atom_values(atom: Atom, values: Mapping[sp.Symbol, Any]) -> Array:
    """Value of an atom where its symbols take the given values (arrays allowed)."""
    atom, values = replaced_entries(atom, values)
    if atom in values:
        return np.asarray(values[atom], dtype=float)
    symbols = sorted(atom.free_symbols, key=str)
    # numpy has no integers beyond 64 bits
    atom = atom.xreplace({n: sp.Float(n) for n in atom.atoms(sp.Integer) if abs(n) > 2**53})
    function = sp.lambdify(symbols, atom, "numpy")
    return np.asarray(function(*(np.asarray(values[symbol], dtype=float) for symbol in symbols)), dtype=float)


@dataclass(frozen=True)
class MatrixPolynomial:
    """Σ_m monomials[m] · coefficients[m], coefficients of shape (M, rows, cols).

    The coefficients are exact (object arrays of fractions) in a plant and float in the compiler.
    """

    monomials: Monomials
    coefficients: Array

    @classmethod
    def constant(cls, matrix: Array) -> MatrixPolynomial:
        """A matrix that depends on nothing."""
        return cls(Monomials.one(), np.asarray(matrix)[None, :, :])

    @classmethod
    def from_sympy(cls, matrix: sp.MatrixBase) -> MatrixPolynomial:
        """Exact coefficients of a matrix of expressions; what is not polynomial becomes an atom."""
        entries = [scalar_terms(entry) for entry in matrix]
        atoms = union([atom for terms in entries for atom in terms.atoms], ())
        rows = [terms.over(atoms) for terms in entries]
        place = np.repeat(np.arange(len(entries)), [len(row) for row in rows])
        stacked = Monomials(atoms, np.concatenate(rows, axis=0))
        monomials, inverse = stacked.merged()
        coefficients = np.full((len(monomials), len(entries)), Fraction(0), dtype=object)
        values = [value for terms in entries for value in terms.coefficients]
        for index, (monomial, entry) in enumerate(zip(inverse, place, strict=True)):
            coefficients[monomial, entry] += values[index]
        used = (coefficients != 0).any(axis=1)
        used[0] |= not used.any()
        kept = Monomials(monomials.atoms, monomials.exponents[used])
        return cls(kept, coefficients[used].reshape(len(kept), *matrix.shape)).merged()

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        rows, cols = self.coefficients.shape[1:]
        return (int(rows), int(cols))

    @property
    def T(self) -> MatrixPolynomial:
        """The transpose."""
        return MatrixPolynomial(self.monomials, self.coefficients.transpose(0, 2, 1))

    def __matmul__(self, other: MatrixPolynomial) -> MatrixPolynomial:
        product = self.coefficients[:, None] @ other.coefficients[None, :]
        flat = product.reshape(-1, *product.shape[2:])
        return MatrixPolynomial(self.monomials.times(other.monomials), flat).merged()

    def __add__(self, other: MatrixPolynomial) -> MatrixPolynomial:
        atoms = union(self.monomials.atoms, other.monomials.atoms)
        monomials = Monomials(atoms, np.concatenate([self.monomials.over(atoms), other.monomials.over(atoms)]))
        return MatrixPolynomial(monomials, np.concatenate([self.coefficients, other.coefficients])).merged()

    def inverse(self) -> MatrixPolynomial:
        """The inverse; where the matrix is not constant its entries are rational functions, kept as atoms."""
        if not self.monomials.merged()[0].atoms:
            return MatrixPolynomial(self.monomials, np.linalg.inv(self.coefficients.astype(float)))
        return MatrixPolynomial.from_sympy(self.to_sympy().inv().applyfunc(sp.cancel)).numeric()

    def to_sympy(self) -> sp.Matrix:
        """The matrix of expressions, floats as exact rationals."""
        total = sp.zeros(*self.shape)
        for powers, coefficient in zip(self.monomials.exponents, self.coefficients, strict=True):
            monomial = sp.Mul(*(atom ** int(power) for atom, power in zip(self.monomials.atoms, powers, strict=True)))
            total += sp.Matrix(*self.shape, [sp.Rational(value) for value in coefficient.ravel()]) * monomial
        return total

    def scaled(self, factor: MatrixPolynomial) -> MatrixPolynomial:
        """Product with a 1 x 1 polynomial."""
        product = factor.coefficients[:, None] * self.coefficients[None, :]
        flat = product.reshape(-1, *product.shape[2:])
        return MatrixPolynomial(factor.monomials.times(self.monomials), flat).merged()

    def merged(self) -> MatrixPolynomial:
        """With equal monomials added up."""
        monomials, inverse = self.monomials.merged()
        coefficients = np.zeros((len(monomials), *self.shape), dtype=self.coefficients.dtype)
        if len(monomials) == len(self.monomials):  # nothing to add up
            coefficients[inverse] = self.coefficients
        else:
            np.add.at(coefficients, inverse, self.coefficients)
        return MatrixPolynomial(monomials, coefficients)

    def kron_identity(self, before: int, after: int) -> MatrixPolynomial:
        """I_before ⊗ self ⊗ I_after."""
        if before == after == 1:
            return self
        wide = np.kron(self.coefficients, np.eye(after)[None]) if after > 1 else self.coefficients
        wide = np.kron(np.eye(before)[None], wide) if before > 1 else wide
        return MatrixPolynomial(self.monomials, wide)

    def renamed(self, new: Mapping[sp.Symbol, sp.Symbol]) -> MatrixPolynomial:
        """With the symbols inside the atoms replaced."""
        return MatrixPolynomial(self.monomials.renamed(new), self.coefficients) if new else self

    def numeric(self) -> MatrixPolynomial:
        """The same with float coefficients."""
        return MatrixPolynomial(self.monomials, self.coefficients.astype(float))

    def evaluate(self, values: Mapping[sp.Symbol, Any]) -> Array:
        """Values at K points, shape (K, rows, cols)."""
        return np.tensordot(self.monomials.evaluate(values), self.coefficients.astype(float), axes=1)


@dataclass(frozen=True)
class ScalarTerms(Monomials):
    """A scalar polynomial with exact coefficients, one per monomial."""

    coefficients: tuple[Fraction, ...] = ()


def scalar_terms(expression: sp.Expr) -> ScalarTerms:
    """A scalar expression as a polynomial in its atoms, e.g. ``2*a*sin(r) + r**2``."""
    expression = sp.sympify(expression)
    # a float means the decimal that it was written as, here as in a plant
    expression = expression.xreplace({f: sp.Rational(repr(float(f))) for f in expression.atoms(sp.Float)})
    return _product_terms(expression) or _polynomial_terms(expression) or _expanded_terms(sp.expand(expression))


def _product_terms(expression: sp.Expr) -> ScalarTerms | None:
    """A number times powers of symbols or of entries of exp(tM), as most entries are; None for anything else."""
    number, product = expression.as_coeff_Mul()
    if not number.is_Rational:
        return None
    powers = [factor.as_base_exp() for factor in sp.Mul.make_args(product) if factor != 1]
    if not all(isinstance(b, (sp.Symbol, ExponentialEntry)) and p.is_Integer and p > 0 for b, p in powers):
        return None
    exponents = np.array([[int(power) for _, power in powers]], dtype=np.int64).reshape(1, len(powers))
    return ScalarTerms(tuple(base for base, _ in powers), exponents, (Fraction(int(number.p), int(number.q)),))


def _polynomial_terms(expression: sp.Expr) -> ScalarTerms | None:
    """A polynomial in symbols, multiplied out in sympy's polynomial ring, which is fast; None for anything else."""
    if not expression.free_symbols:
        return None
    generators = sp.Poly(sp.Add(*expression.free_symbols)).gens
    try:
        terms = PolyRing(generators, sp.QQ, lex).from_expr(expression).terms()
    except ValueError:
        return None
    if not terms:
        return None
    exponents = np.array([powers for powers, _ in terms], dtype=np.int64)
    used = np.flatnonzero(exponents.any(axis=0))
    coefficients = tuple(Fraction(int(value.numerator), int(value.denominator)) for _, value in terms)
    return ScalarTerms(tuple(generators[column] for column in used), exponents[:, used], coefficients)


def _expanded_terms(expression: sp.Expr) -> ScalarTerms:
    # functions stay whole: sympy would split exp(0.123*x) into exp(x/1000)**123
    hidden = {function: sp.Dummy() for function in sorted(expression.atoms(sp.Function), key=str)}
    shown = {dummy: function for function, dummy in hidden.items()}
    terms, generators = dict_from_expr(expression.xreplace(hidden), domain=sp.QQ)
    exponents = np.array(list(terms), dtype=np.int64).reshape(len(terms), -1)
    coefficients = tuple(Fraction(int(c.numerator), int(c.denominator)) for c in terms.values())
    return ScalarTerms(tuple(generator.xreplace(shown) for generator in generators), exponents, coefficients)


@lru_cache(maxsize=4096)
def scalar_polynomial(expression: sp.Expr) -> MatrixPolynomial:
    """A scalar expression as a 1 x 1 float polynomial."""
    return row_polynomial({0: expression}, 1)


def row_polynomial(entries: Mapping[int, sp.Expr], width: int) -> MatrixPolynomial:
    """A float row with the given entries at their places and zeros elsewhere."""
    found = [scalar_terms(entry) for entry in entries.values()]
    atoms = union([atom for terms in found for atom in terms.atoms], ())
    monomials, inverse = Monomials(atoms, np.concatenate([terms.over(atoms) for terms in found])).merged()
    place = np.repeat(list(entries), [len(terms) for terms in found])
    coefficients = np.zeros((len(monomials), width))
    np.add.at(coefficients, (inverse, place), [float(c) for terms in found for c in terms.coefficients])
    return MatrixPolynomial(monomials, coefficients[:, None, :])


def homogeneous_exponents(variables: int, degree: int) -> Array:
    """Exponents of all monomials of the given degree, shape (count, variables)."""
    chosen = list(combinations_with_replacement(range(variables), degree))
    exponents = np.zeros((len(chosen), variables), dtype=np.int64)
    for row, choice in enumerate(chosen):
        np.add.at(exponents[row], list(choice), 1)
    return exponents
