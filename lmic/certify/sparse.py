"""Exact matrix polynomials by their nonzero terms.

With symbolic unknowns a theorem's matrix has a monomial for every coordinate of every unknown, and
each of them stands in a few entries only: what is zero is not kept.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import chain
from typing import Any, TypeAlias

import numpy as np
import sympy as sp

from lmic.algebra.polynomials import MatrixPolynomial, Monomials, scalar_terms, union
from lmic.errors import CertificateError

#: atoms with their powers; the empty set is the constant 1
Monomial: TypeAlias = frozenset[tuple[sp.Expr, int]]
#: a scalar polynomial: coefficients other than zero
Terms: TypeAlias = Mapping[Monomial, Fraction]
Place: TypeAlias = tuple[int, int]

ONE: Monomial = frozenset()


@dataclass(frozen=True)
class SparsePolynomial:
    """A matrix of ``shape`` whose entry at (row, col) is Σ coefficient · monomial; absent entries are zero."""

    shape: tuple[int, int]
    entries: Mapping[Place, Terms]

    @classmethod
    def of(cls, shape: tuple[int, int], terms: Iterable[tuple[Place, Monomial, Fraction]]) -> SparsePolynomial:
        """The sum of the terms, without those that cancel."""
        sums: dict[Place, dict[Monomial, Fraction]] = {}
        for place, monomial, value in terms:
            entry = sums.setdefault(place, {})
            entry[monomial] = entry[monomial] + value if monomial in entry else value
        kept = {place: {m: value for m, value in entry.items() if value} for place, entry in sums.items()}
        return cls(shape, {place: entry for place, entry in kept.items() if entry})

    @classmethod
    def constant(cls, matrix: Any) -> SparsePolynomial:
        """A matrix of numbers; a float is its dyadic value."""
        array = np.asarray(matrix)
        rows, cols = array.shape
        values = zip(np.ndindex(rows, cols), array.ravel().tolist(), strict=True)
        return cls.of((rows, cols), ((place, ONE, Fraction(value)) for place, value in values))

    @classmethod
    def scalar(cls, expression: sp.Expr) -> SparsePolynomial:
        """A scalar expression, 1 x 1."""
        terms = scalar_terms(expression)
        monomials = listed(terms)
        return cls.of((1, 1), (((0, 0), m, value) for m, value in zip(monomials, terms.coefficients, strict=True)))

    @classmethod
    def from_dense(cls, matrix: MatrixPolynomial) -> SparsePolynomial:
        """The nonzero terms of a polynomial with exact coefficients."""
        monomials = listed(matrix.monomials)
        places = np.nonzero(matrix.coefficients)
        found = zip(*(axis.tolist() for axis in places), matrix.coefficients[places].tolist(), strict=True)
        return cls.of(matrix.shape, (((i, j), monomials[m], Fraction(value)) for m, i, j, value in found))

    @classmethod
    def joined(
        cls, blocks: Sequence[Sequence[SparsePolynomial | None]], heights: Sequence[int], widths: Sequence[int]
    ) -> SparsePolynomial:
        """A matrix of blocks; None is a block of zeros."""
        entries: dict[Place, Terms] = {}
        for top, height, row in zip(np.cumsum([0, *heights]).tolist(), heights, blocks, strict=False):
            for left, width, block in zip(np.cumsum([0, *widths]).tolist(), widths, row, strict=False):
                if block is None:
                    continue
                if block.shape != (height, width):
                    raise CertificateError(f"a block is {_size(block.shape)} where {height} x {width} is needed")
                entries |= {(top + i, left + j): entry for (i, j), entry in block.entries.items()}
        return cls((sum(heights), sum(widths)), entries)

    def terms(self) -> Iterator[tuple[Place, Monomial, Fraction]]:
        """Place, monomial and coefficient of everything that is not zero."""
        return ((place, monomial, value) for place, entry in self.entries.items() for monomial, value in entry.items())

    @cached_property
    def monomials(self) -> frozenset[Monomial]:
        """Every monomial that occurs."""
        return frozenset(chain.from_iterable(self.entries.values()))

    @cached_property
    def atoms(self) -> frozenset[sp.Expr]:
        """Every atom that occurs."""
        return frozenset(atom for monomial in self.monomials for atom, _ in monomial)

    @property
    def entry(self) -> Terms:
        """The only entry of a 1 x 1 polynomial."""
        return self.entries.get((0, 0), {})

    @property
    def T(self) -> SparsePolynomial:
        """The transpose."""
        rows, cols = self.shape
        return SparsePolynomial((cols, rows), {(j, i): entry for (i, j), entry in self.entries.items()})

    @property
    def trace(self) -> SparsePolynomial:
        """The sum of the diagonal, 1 x 1."""
        return SparsePolynomial.of((1, 1), (((0, 0), m, value) for (i, j), m, value in self.terms() if i == j))

    @property
    def is_symmetric(self) -> bool:
        """Whether it equals its transpose."""
        return self.shape == self.T.shape and self.entries == self.T.entries

    def __neg__(self) -> SparsePolynomial:
        return SparsePolynomial.of(self.shape, ((place, monomial, -value) for place, monomial, value in self.terms()))

    def __add__(self, other: SparsePolynomial) -> SparsePolynomial:
        if self.shape != other.shape:
            raise CertificateError(f"{_size(self.shape)} and {_size(other.shape)} matrices are added")
        return SparsePolynomial.of(self.shape, chain(self.terms(), other.terms()))

    def __matmul__(self, other: SparsePolynomial) -> SparsePolynomial:
        if self.shape[1] != other.shape[0]:
            raise CertificateError(f"{_size(self.shape)} and {_size(other.shape)} matrices are multiplied")
        rows: dict[int, list[tuple[int, Monomial, Fraction]]] = {}
        for (k, j), monomial, value in other.terms():
            rows.setdefault(k, []).append((j, monomial, value))
        products = (
            ((i, j), _product(mine, its), value * factor)
            for (i, k), mine, value in self.terms()
            for j, its, factor in rows.get(k, ())
        )
        return SparsePolynomial.of((self.shape[0], other.shape[1]), products)

    def kronecker(self, other: SparsePolynomial) -> SparsePolynomial:
        """self ⊗ other."""
        rows, cols = other.shape
        products = (
            ((i * rows + k, j * cols + m), _product(mine, its), value * factor)
            for (i, j), mine, value in self.terms()
            for (k, m), its, factor in other.terms()
        )
        return SparsePolynomial.of((self.shape[0] * rows, self.shape[1] * cols), products)

    def scaled(self, factor: SparsePolynomial) -> SparsePolynomial:
        """Product with a 1 x 1 polynomial."""
        return factor.kronecker(self)

    def renamed(self, new: Mapping[sp.Symbol, sp.Symbol]) -> SparsePolynomial:
        """With the symbols inside the atoms replaced; monomials that become equal are added up."""
        if not new:
            return self
        atoms = {atom: atom.xreplace(new) for atom in self.atoms}
        found: dict[Monomial, Terms] = {}
        for monomial in self.monomials:
            renamed = ONE
            for atom, power in monomial:
                renamed = _product(renamed, frozenset([(atoms[atom], power)]))
            found[monomial] = {renamed: Fraction(1)}
        return self.replaced(found)

    def replaced(self, new: Mapping[Monomial, Terms]) -> SparsePolynomial:
        """With a polynomial in place of each monomial."""
        terms = ((place, m, value * factor) for place, old, value in self.terms() for m, factor in new[old].items())
        return SparsePolynomial.of(self.shape, terms)

    def dense(self) -> MatrixPolynomial:
        """The same as one array of coefficients, its monomials in their usual order."""
        monomials = dense_monomials(self.monomials or {ONE})
        number = {monomial: k for k, monomial in enumerate(listed(monomials))}
        coefficients = np.full((len(monomials), *self.shape), Fraction(0), dtype=object)
        for (i, j), monomial, value in self.terms():
            coefficients[number[monomial], i, j] = value
        return MatrixPolynomial(monomials, coefficients)


def dense_monomials(monomials: Iterable[Monomial]) -> Monomials:
    """Different monomials by their exponents, in the order of these."""
    found = list(monomials)
    atoms = union([atom for monomial in found for atom, _ in monomial], ())
    rows = sorted(tuple(powers.get(atom, 0) for atom in atoms) for powers in map(dict, found))
    return Monomials(atoms, np.array(rows, dtype=np.int64).reshape(len(rows), len(atoms)))


@lru_cache(maxsize=1 << 16)
def _product(first: Monomial, second: Monomial) -> Monomial:
    if not first or not second:
        return first or second
    powers = dict(first)
    for atom, power in second:
        powers[atom] = powers.get(atom, 0) + power
    return frozenset(powers.items())


def listed(monomials: Monomials) -> list[Monomial]:
    """The monomials one by one, in their order."""
    return [
        frozenset((atom, power) for atom, power in zip(monomials.atoms, row, strict=True) if power)
        for row in monomials.exponents.tolist()
    ]


def _size(shape: tuple[int, int]) -> str:
    return f"{shape[0]} x {shape[1]}"
