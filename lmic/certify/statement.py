"""The theorem's matrices as exact polynomials, read off the statement itself.

Every LMI becomes the polynomial matrix F(θ) ≻ 0 that it states, with rational coefficients, in the
components of the parameters at their instances. The expressions are walked as written, so that a
certificate shares nothing with the compiler's expansion, binding and assembly.
"""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, reduce
from typing import Any, TypeAlias

import flint
import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.errors import CertificateError, Place
from lmic.language.declarations import Star
from lmic.language.nodes import (
    Block,
    Hermitian,
    Identity,
    Inverse,
    Kronecker,
    Leaf,
    MatrixProduct,
    MatrixSum,
    Node,
    Trace,
    Transposed,
    Zero,
    is_zero,
)
from lmic.language.parameters import instance_symbol, rate_symbol
from lmic.language.theorem import LMI, Theorem
from lmic.plants.plant import Plant
from lmic.polynomials import MatrixPolynomial, Monomials, scalar_terms, union
from lmic.sizes import solve_sizes

Array: TypeAlias = NDArray[Any]
#: an unknown's value: a matrix of fractions for each basis function
Value: TypeAlias = Mapping[sp.Expr, Array]


@dataclass(frozen=True)
class Statement:
    """A theorem for a plant, with exact values of the given scalars and the plant's scalars, by name.

    ``dimensions`` are the sizes that no matrix of the plant determines.
    """

    theorem: Theorem
    plant: Plant
    scalars: Mapping[str, Fraction]
    dimensions: Mapping[str, int]

    @cached_property
    def sizes(self) -> dict[sp.Symbol, int]:
        """Values of the symbolic dimensions; raises where the plant's matrices do not fit."""
        return solve_sizes(self.theorem, self.plant, self.dimensions, Place(self.theorem.name))

    def size(self, expression: sp.Expr) -> int:
        """Value of a symbolic dimension."""
        return int(expression.subs(self.sizes))

    @cached_property
    def data(self) -> dict[str, MatrixPolynomial]:
        """The plant's matrices with its scalars put in."""
        values = {sp.Symbol(name): _rational(value) for name, value in self.scalars.items()}
        return {
            name: MatrixPolynomial.from_sympy(matrix.to_sympy().xreplace(values))
            if any(atom.free_symbols & set(values) for atom in matrix.monomials.atoms)
            else matrix
            for name, matrix in self.plant.matrices.items()
        }

    def components(self, leaf: Leaf) -> list[tuple[str, str]]:
        """(component, instance) of every parameter at which a matrix is taken; none without domains."""
        return [
            (component, parameter.instance)
            for parameter in leaf.arguments
            if parameter.name in self.plant.domains
            for component in self.plant.domains[parameter.name].components
        ]

    # unknowns

    def coordinates(self, name: str) -> Array:
        """Number of the free coordinate of each entry of an unknown, -1 where it is zero, from its declaration."""
        if name not in self.theorem.unknowns:
            return np.zeros((1, 1), dtype=int)
        leaf = self.theorem.unknowns[name]
        rows, cols = (self.size(size) for size in leaf.shape)
        blocks = [] if name in self.theorem.full else [self.size(size) for size in leaf.blocks]
        member = np.repeat(np.arange(len(blocks)), blocks) if blocks else np.zeros(max(rows, cols), dtype=int)
        numbers = np.full((rows, cols), -1)
        free = 0
        for i in range(rows):
            for j in range(cols):
                if member[i] != member[j]:
                    continue
                if leaf.symmetric and j < i:
                    numbers[i, j] = numbers[j, i]
                else:
                    numbers[i, j], free = free, free + 1
        return numbers

    def check_dependence(self, name: str, functions: Sequence[sp.Expr]) -> None:
        """Raise where an unknown depends on something that the theorem does not let it depend on."""
        allowed = {
            sp.Symbol(component)
            for parameter in (self.theorem.dependence(name) if name in self.theorem.unknowns else ())
            if parameter in self.plant.domains
            for component in self.plant.domains[parameter].components
        }
        for function in functions:
            foreign = function.free_symbols - allowed
            if foreign:
                raise self.error(f"the unknown {name} may not depend on {min(map(str, foreign))}")

    def value(self, name: str, matrices: Value) -> MatrixPolynomial:
        """An unknown as a polynomial; raises where its matrices are not of its declared form."""
        self.check_dependence(name, list(matrices))
        numbers = self.coordinates(name)
        for matrix in matrices.values():
            if matrix.shape != numbers.shape:
                raise self.error(f"the unknown {name} is {_shape(matrix)} but {_shape(numbers)} is declared")
            if (matrix[numbers < 0] != 0).any():
                raise self.error(f"the unknown {name} has an entry outside its blocks")
            if self._symmetric(name) and (matrix != matrix.T).any():
                raise self.error(f"the unknown {name} is not symmetric")
        return reduce(operator.add, [constant(matrix).scaled(scalar(f)) for f, matrix in matrices.items()])

    def symbolic(self, name: str, functions: Sequence[sp.Expr], first: int) -> MatrixPolynomial:
        """An unknown with its coordinates as atoms, ``first`` the number of its first one.

        Basis function b and coordinate c are atom number first + b·count + c.
        """
        self.check_dependence(name, functions)
        numbers = self.coordinates(name)
        count = int(numbers.max()) + 1
        parts = []
        for b, function in enumerate(functions):
            atoms = [coordinate_symbol(first + b * count + c) for c in range(count)]
            picked = np.array([numbers == c for c in range(count)]) + fractions(np.zeros((count, *numbers.shape)))
            parts.append(MatrixPolynomial(Monomials.of(*atoms), picked).scaled(scalar(function)))
        return reduce(operator.add, parts)

    def _symmetric(self, name: str) -> bool:
        return name in self.theorem.unknowns and self.theorem.unknowns[name].symmetric

    # LMIs

    def matrix(self, name: str, unknowns: Mapping[str, MatrixPolynomial]) -> MatrixPolynomial:
        """F of the LMI ``name``, with F ≻ 0 stated; ``unknowns`` hold matrices and scalars (1 x 1) by name."""
        return _Reader(self, unknowns).lmi(self.theorem.lmis[name], name)

    def expression(self, expression: sp.Expr, unknowns: Mapping[str, MatrixPolynomial]) -> MatrixPolynomial:
        """A scalar expression in the given scalars and the scalar unknowns, 1 x 1."""
        return _Reader(self, unknowns).scalar(sp.sympify(expression))

    def error(self, message: str, lmi: str = "") -> CertificateError:
        """The error of this theorem (and LMI) with that message."""
        return CertificateError(message, Place(self.theorem.name, lmi))


@dataclass(frozen=True)
class _Reader:
    statement: Statement
    unknowns: Mapping[str, MatrixPolynomial]

    def lmi(self, lmi: LMI, name: str) -> MatrixPolynomial:
        """The block matrix with its stars filled, turned to F ≻ 0."""
        size = len(lmi.rows)
        blocks = [[self.entry(entry) for entry in row] for row in lmi.rows]
        for i, row in enumerate(lmi.rows):
            for j, entry in enumerate(row):
                mirrored = blocks[j][i]
                if isinstance(entry, Star) and mirrored is not None:
                    blocks[i][j] = mirrored.T
        partition = []
        for k in range(size):
            heights = [block.shape[0] for block in blocks[k] if block is not None]
            widths = [block.shape[1] for row in blocks if (block := row[k]) is not None]
            if len(set(heights + widths)) != 1:
                raise self.statement.error(f"block row {k + 1} has no size, or more than one", name)
            partition.append((heights + widths)[0])
        matrix = _nonzero(_joined(blocks, partition, partition))
        if (matrix.coefficients != matrix.coefficients.transpose(0, 2, 1)).any():
            raise self.statement.error("the matrix is not symmetric", name)
        return matrix if lmi.sense > 0 else MatrixPolynomial(matrix.monomials, -matrix.coefficients)

    def entry(self, entry: Any) -> MatrixPolynomial | None:
        """A block; None for a star or a zero."""
        if isinstance(entry, Node):
            return self.node(entry)
        return None if isinstance(entry, Star) or is_zero(entry) else self.scalar(sp.sympify(entry))

    def scalar(self, expression: sp.Expr) -> MatrixPolynomial:
        """A scalar expression as a 1 x 1 polynomial; floats stand for the decimals they are written as."""
        values: dict[sp.Basic, sp.Expr] = {
            number: sp.Rational(repr(float(number))) for number in expression.atoms(sp.Float)
        }
        for symbol in expression.free_symbols:
            if symbol.name in self.unknowns:
                values[symbol] = self.unknowns[symbol.name].to_sympy()[0, 0]
            elif symbol.name in self.statement.scalars:
                values[symbol] = _rational(self.statement.scalars[symbol.name])
            else:
                raise self.statement.error(f"the scalar {symbol} has no value")
        return scalar(expression.xreplace(values))

    def leaf(self, leaf: Leaf) -> MatrixPolynomial:
        """A named matrix at its instances, or its derivative along the trajectory."""
        components = self.statement.components(leaf)
        value = self.unknowns[leaf.name] if leaf.role == "unknown" else self.statement.data[leaf.name]
        allowed = {sp.Symbol(component) for component, _ in components}
        for atom in value.monomials.atoms:
            foreign = {symbol for symbol in atom.free_symbols - allowed if not is_coordinate(symbol)}
            if foreign:
                raise self.statement.error(
                    f"{leaf} depends on {min(map(str, foreign))}, which the theorem does not allow"
                )
        if leaf.derivative:
            value = _derivative(value, [component for component, _ in components])
        return value.renamed({sp.Symbol(c): instance_symbol(c, instance) for c, instance in components if instance})

    def node(self, node: Node) -> MatrixPolynomial:
        """The value of an expression."""
        size = self.statement.size
        match node:
            case Leaf():
                return self.leaf(node)
            case Identity():
                return constant(np.eye(size(node.shape[0]), dtype=int))
            case Zero():
                return constant(np.zeros((size(node.shape[0]), size(node.shape[1])), dtype=int))
            case MatrixSum():
                return reduce(operator.add, map(self.node, node.nodes))
            case MatrixProduct():
                return reduce(operator.matmul, map(self.node, node.nodes)).scaled(self.scalar(node.coefficient))
            case Transposed():
                return self.node(node.nodes[0]).T
            case Hermitian():
                inner = self.node(node.nodes[0])
                return inner + inner.T
            case Inverse():
                return self.inverse(node)
            case Kronecker():
                return _kronecker(self.node(node.nodes[0]), self.node(node.nodes[1]))
            case Trace():
                inner = self.node(node.nodes[0])
                traces = inner.coefficients.trace(axis1=1, axis2=2)
                return MatrixPolynomial(inner.monomials, traces[:, None, None])
            case Block():
                rows = [[self.node(entry) for entry in row] for row in node.grid]
                return _joined(rows, [size(s) for s in node.heights], [size(s) for s in node.widths])
        raise TypeError(f"no value for {type(node).__name__}")

    def inverse(self, node: Inverse) -> MatrixPolynomial:
        """The exact inverse; entries that are rational functions become atoms."""
        inner = self.node(node.nodes[0]).merged()
        if any(is_coordinate(symbol) for atom in inner.monomials.atoms for symbol in atom.free_symbols):
            raise self.statement.error(f"{node} inverts an unknown")
        try:
            if inner.monomials.atoms:
                return MatrixPolynomial.from_sympy(inner.to_sympy().inv().applyfunc(sp.cancel))
            return constant(from_flint(to_flint(inner.coefficients[0]).inv()))
        except (ZeroDivisionError, sp.matrices.exceptions.NonInvertibleMatrixError) as error:
            raise self.statement.error(f"{node.nodes[0]} is singular") from error


# Exact matrices and polynomials ---------------------------------------------------------------------


def fractions(matrix: Any) -> Array:
    """An array of fractions; a float is its dyadic value."""
    array = np.asarray(matrix)
    return np.array([Fraction(entry) for entry in array.ravel().tolist()], dtype=object).reshape(array.shape)


def constant(matrix: Any) -> MatrixPolynomial:
    """A constant matrix of fractions."""
    return MatrixPolynomial.constant(fractions(matrix))


def scalar(expression: sp.Expr) -> MatrixPolynomial:
    """A scalar expression as a 1 x 1 polynomial with fractions."""
    terms = scalar_terms(expression)
    values = np.array(terms.coefficients, dtype=object).reshape(-1, 1, 1)
    return MatrixPolynomial(Monomials(terms.atoms, terms.exponents), values)


def to_flint(matrix: Array) -> flint.fmpq_mat:
    """A matrix of fractions as flint's."""
    rows, cols = matrix.shape
    return flint.fmpq_mat(rows, cols, [flint.fmpq(f.numerator, f.denominator) for f in map(Fraction, matrix.ravel())])


def from_flint(matrix: flint.fmpq_mat) -> Array:
    """flint's rational matrix as an array of fractions."""
    values = [Fraction(int(entry.p), int(entry.q)) for entry in matrix.entries()]
    return np.array(values, dtype=object).reshape(matrix.nrows(), matrix.ncols())


def coordinate_symbol(number: int) -> sp.Symbol:
    """The atom of an unknown's coordinate; no parameter's component can have such a name."""
    return sp.Symbol(f"x[{number}]")


def is_coordinate(symbol: sp.Symbol) -> bool:
    """Whether a symbol is the coordinate of an unknown."""
    return str(symbol.name).startswith("x[")


def _rational(value: Fraction) -> sp.Rational:
    return sp.Rational(value.numerator, value.denominator)


def _shape(matrix: Array) -> str:
    return " x ".join(map(str, matrix.shape))


def _derivative(value: MatrixPolynomial, components: Sequence[str]) -> MatrixPolynomial:
    """Σ_c ∂/∂c · dc/dt of every monomial."""
    total = constant(np.zeros(value.shape, dtype=int))
    for powers, coefficient in zip(value.monomials.exponents, value.coefficients, strict=True):
        monomial = sp.Mul(*(a ** int(p) for a, p in zip(value.monomials.atoms, powers, strict=True)))
        rate = sp.Add(*(sp.diff(monomial, sp.Symbol(c)) * rate_symbol(c) for c in components))
        total = total + MatrixPolynomial.constant(coefficient).scaled(scalar(rate))
    return total


def _kronecker(left: MatrixPolynomial, right: MatrixPolynomial) -> MatrixPolynomial:
    product = left.coefficients[:, None, :, None, :, None] * right.coefficients[None, :, None, :, None, :]
    rows, cols = left.shape[0] * right.shape[0], left.shape[1] * right.shape[1]
    return MatrixPolynomial(left.monomials.times(right.monomials), product.reshape(-1, rows, cols)).merged()


def _nonzero(value: MatrixPolynomial) -> MatrixPolynomial:
    """Without the monomials that cancel."""
    used = (value.coefficients != 0).any(axis=(1, 2))
    used[0] |= not used.any()
    return MatrixPolynomial(
        Monomials(value.monomials.atoms, value.monomials.exponents[used]), value.coefficients[used]
    ).merged()


def _joined(
    blocks: Sequence[Sequence[MatrixPolynomial | None]], heights: Sequence[int], widths: Sequence[int]
) -> MatrixPolynomial:
    """A matrix of blocks; None is a block of zeros."""
    tops, lefts = np.cumsum([0, *heights]), np.cumsum([0, *widths])
    given = [(i, j, block) for i, row in enumerate(blocks) for j, block in enumerate(row) if block is not None]
    atoms = reduce(union, [block.monomials.atoms for _, _, block in given], ())
    stacked = Monomials(atoms, np.concatenate([block.monomials.over(atoms) for _, _, block in given]))
    monomials, place = stacked.merged()
    coefficients = np.full((len(monomials), tops[-1], lefts[-1]), Fraction(0), dtype=object)
    start = 0
    for i, j, block in given:
        mine = place[start : start + len(block.monomials)]
        start += len(mine)
        inside = coefficients[:, tops[i] : tops[i + 1], lefts[j] : lefts[j + 1]]
        if inside.shape[1:] != block.shape:
            raise CertificateError(f"a block is {block.shape[0]} x {block.shape[1]} where {inside.shape[1:]} is needed")
        np.add.at(inside, mine, block.coefficients)
    return MatrixPolynomial(monomials, coefficients)
