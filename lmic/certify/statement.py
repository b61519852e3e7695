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

from lmic.algebra.polynomials import MatrixPolynomial
from lmic.certify.sparse import Monomial, SparsePolynomial, Terms
from lmic.errors import CertificateError, Place
from lmic.language.lmi import LMI
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
from lmic.language.star import Star
from lmic.language.theorem import Theorem
from lmic.plants.plant import Plant
from lmic.plants.sizes import solve_sizes

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
    def data(self) -> dict[str, SparsePolynomial]:
        """The plant's matrices with its scalars put in."""
        values = {sp.Symbol(name): _rational(value) for name, value in self.scalars.items()}
        return {
            name: SparsePolynomial.from_dense(
                MatrixPolynomial.from_sympy(matrix.to_sympy().xreplace(values))
                if any(atom.free_symbols & set(values) for atom in matrix.monomials.atoms)
                else matrix
            )
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
        blocks = [] if name in self.theorem.full else leaf.block_sizes(self.size)
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
        scaled = [SparsePolynomial.constant(m).scaled(SparsePolynomial.scalar(f)) for f, m in matrices.items()]
        return reduce(operator.add, scaled).dense()

    def symbolic(self, name: str, functions: Sequence[sp.Expr], first: int) -> SparsePolynomial:
        """An unknown with its coordinates as atoms, ``first`` the number of its first one.

        Basis function b and coordinate c are atom number first + b·count + c.
        """
        self.check_dependence(name, functions)
        numbers = self.coordinates(name)
        count = int(numbers.max()) + 1
        places = [((i, j), c) for (i, j), c in np.ndenumerate(numbers) if c >= 0]
        parts = []
        for b, function in enumerate(functions):
            atoms = [frozenset([(coordinate_symbol(first + b * count + c), 1)]) for c in range(count)]
            matrix = SparsePolynomial.of(numbers.shape, ((place, atoms[c], Fraction(1)) for place, c in places))
            parts.append(matrix.scaled(SparsePolynomial.scalar(function)))
        return reduce(operator.add, parts)

    def _symmetric(self, name: str) -> bool:
        return name in self.theorem.unknowns and self.theorem.unknowns[name].symmetric

    # LMIs

    def matrix(self, name: str, unknowns: Mapping[str, MatrixPolynomial]) -> MatrixPolynomial:
        """F of the LMI ``name``, with F ≻ 0 stated; ``unknowns`` hold matrices and scalars (1 x 1) by name."""
        return self.sparse_matrix(name, _sparse(unknowns)).dense()

    def sparse_matrix(self, name: str, unknowns: Mapping[str, SparsePolynomial]) -> SparsePolynomial:
        """The same with unknowns of many monomials, such as :meth:`symbolic` makes."""
        return _Reader(self, unknowns).lmi(self.theorem.lmis[name], name)

    def expression(self, expression: sp.Expr, unknowns: Mapping[str, MatrixPolynomial]) -> MatrixPolynomial:
        """A scalar expression in the given scalars and the scalar unknowns, 1 x 1."""
        return self.sparse_expression(expression, _sparse(unknowns)).dense()

    def sparse_expression(self, expression: sp.Expr, unknowns: Mapping[str, SparsePolynomial]) -> SparsePolynomial:
        """The same with unknowns such as :meth:`symbolic` makes."""
        return _Reader(self, unknowns).scalar(sp.sympify(expression))

    def error(self, message: str, lmi: str = "") -> CertificateError:
        """The error of this theorem (and LMI) with that message."""
        return CertificateError(message, Place(self.theorem.name, lmi))


@dataclass(frozen=True)
class _Reader:
    statement: Statement
    unknowns: Mapping[str, SparsePolynomial]

    def lmi(self, lmi: LMI, name: str) -> SparsePolynomial:
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
        matrix = SparsePolynomial.joined(blocks, partition, partition)
        if not matrix.is_symmetric:
            raise self.statement.error("the matrix is not symmetric", name)
        return matrix if lmi.sense > 0 else -matrix

    def entry(self, entry: Any) -> SparsePolynomial | None:
        """A block; None for a star or a zero."""
        if isinstance(entry, Node):
            return self.node(entry)
        return None if isinstance(entry, Star) or is_zero(entry) else self.scalar(sp.sympify(entry))

    def scalar(self, expression: sp.Expr) -> SparsePolynomial:
        """A scalar expression as a 1 x 1 polynomial; floats stand for the decimals they are written as."""
        values: dict[sp.Basic, sp.Expr] = {
            number: sp.Rational(repr(float(number))) for number in expression.atoms(sp.Float)
        }
        for symbol in expression.free_symbols:
            if symbol.name in self.unknowns:
                values[symbol] = self.unknowns[symbol.name].dense().to_sympy()[0, 0]
            elif symbol.name in self.statement.scalars:
                values[symbol] = _rational(self.statement.scalars[symbol.name])
            else:
                raise self.statement.error(f"the scalar {symbol} has no value")
        return SparsePolynomial.scalar(expression.xreplace(values))

    def leaf(self, leaf: Leaf) -> SparsePolynomial:
        """A named matrix at its instances, or its derivative along the trajectory."""
        components = self.statement.components(leaf)
        value = self.unknowns[leaf.name] if leaf.role == "unknown" else self.statement.data[leaf.name]
        allowed = {sp.Symbol(component) for component, _ in components}
        for atom in value.atoms:
            foreign = {symbol for symbol in atom.free_symbols - allowed if not is_coordinate(symbol)}
            if foreign:
                raise self.statement.error(
                    f"{leaf} depends on {min(map(str, foreign))}, which the theorem does not allow"
                )
        if leaf.derivative:
            value = _derivative(value, [component for component, _ in components])
        return value.renamed({sp.Symbol(c): instance_symbol(c, instance) for c, instance in components if instance})

    def node(self, node: Node) -> SparsePolynomial:
        """The value of an expression."""
        size = self.statement.size
        match node:
            case Leaf():
                return self.leaf(node)
            case Identity():
                return SparsePolynomial.constant(np.eye(size(node.shape[0]), dtype=int))
            case Zero():
                return SparsePolynomial((size(node.shape[0]), size(node.shape[1])), {})
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
                return self.node(node.nodes[0]).kronecker(self.node(node.nodes[1]))
            case Trace():
                return self.node(node.nodes[0]).trace
            case Block():
                rows = [[self.node(entry) for entry in row] for row in node.grid]
                return SparsePolynomial.joined(rows, [size(s) for s in node.heights], [size(s) for s in node.widths])
        raise TypeError(f"no value for {type(node).__name__}")

    def inverse(self, node: Inverse) -> SparsePolynomial:
        """The exact inverse; entries that are rational functions become atoms."""
        inner = self.node(node.nodes[0])
        if any(is_coordinate(symbol) for atom in inner.atoms for symbol in atom.free_symbols):
            raise self.statement.error(f"{node} inverts an unknown")
        try:
            if inner.atoms:
                functions = inner.dense().to_sympy().inv().applyfunc(sp.cancel)
                return SparsePolynomial.from_dense(MatrixPolynomial.from_sympy(functions))
            return SparsePolynomial.constant(from_flint(to_flint(inner.dense().coefficients[0]).inv()))
        except (ZeroDivisionError, sp.matrices.exceptions.NonInvertibleMatrixError) as error:
            raise self.statement.error(f"{node.nodes[0]} is singular") from error


# Exact matrices ------------------------------------------------------------------------------------


def fractions(matrix: Any) -> Array:
    """An array of fractions; a float is its dyadic value."""
    array = np.asarray(matrix)
    return np.array([Fraction(entry) for entry in array.ravel().tolist()], dtype=object).reshape(array.shape)


def rational(value: Any) -> flint.fmpq:
    """A number as flint's; a float is its dyadic value."""
    return flint.fmpq(*value.as_integer_ratio())


def fraction(value: flint.fmpq) -> Fraction:
    """flint's rational number as a fraction."""
    return Fraction(int(value.p), int(value.q))


def to_flint(matrix: Array) -> flint.fmpq_mat:
    """A matrix of fractions as flint's."""
    rows, cols = matrix.shape
    zero = flint.fmpq(0)
    return flint.fmpq_mat(rows, cols, [rational(entry) if entry else zero for entry in matrix.ravel().tolist()])


def from_flint(matrix: flint.fmpq_mat) -> Array:
    """flint's rational matrix as an array of fractions."""
    values = [fraction(entry) for entry in matrix.entries()]
    return np.array(values, dtype=object).reshape(matrix.nrows(), matrix.ncols())


def coordinate_symbol(number: int) -> sp.Symbol:
    """The atom of an unknown's coordinate; no parameter's component can have such a name."""
    return sp.Symbol(f"x[{number}]")


def is_coordinate(atom: sp.Expr) -> bool:
    """Whether an atom is the coordinate of an unknown."""
    return isinstance(atom, sp.Symbol) and str(atom.name).startswith("x[")


def _rational(value: Fraction) -> sp.Rational:
    return sp.Rational(value.numerator, value.denominator)


def _shape(matrix: Array) -> str:
    return " x ".join(map(str, matrix.shape))


def _sparse(unknowns: Mapping[str, MatrixPolynomial]) -> dict[str, SparsePolynomial]:
    return {name: SparsePolynomial.from_dense(value) for name, value in unknowns.items()}


def _derivative(value: SparsePolynomial, components: Sequence[str]) -> SparsePolynomial:
    """Σ_c ∂/∂c · dc/dt of every monomial."""
    rates: dict[Monomial, SparsePolynomial] = {}
    found: dict[Monomial, Terms] = {}
    for monomial in value.monomials:
        coordinates = frozenset((atom, power) for atom, power in monomial if is_coordinate(atom))
        function = monomial - coordinates
        if function not in rates:
            product = sp.Mul(*(atom**power for atom, power in function))
            rate = sp.Add(*(sp.diff(product, sp.Symbol(c)) * rate_symbol(c) for c in components))
            rates[function] = SparsePolynomial.scalar(rate)
        found[monomial] = rates[function].scaled(SparsePolynomial((1, 1), {(0, 0): {coordinates: Fraction(1)}})).entry
    return value.replaced(found)
