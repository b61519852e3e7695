"""Matrix expressions over symbolic dimensions, kept as written.

These are sympy matrix expressions that neither reorder nor simplify: a sum prints in the order
of the paper, a product stays a product. Shapes are not checked here but in :mod:`lmic.compiler.lower`,
where the theorem, LMI and block can be named.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NoReturn

import numpy as np
import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr
from sympy.printing.precedence import PRECEDENCE

from lmic.errors import DefinitionError
from lmic.language.parameters import Parameter
from lmic.language.star import Star


def exact(value: Any) -> sp.Expr:
    """A scalar as written: the float 0.1 stands for the rational 1/10."""
    if isinstance(value, float):
        return sp.Rational(repr(value))
    return sp.sympify(value)


def as_size(value: Any) -> sp.Expr:
    """The value as a dimension: an expression in dimensions, or a whole number; or DefinitionError."""
    if isinstance(value, (tuple, list)):
        raise DefinitionError(
            f"{value} are several dimensions where one is needed; a single one is declared with a comma, n, = dims('n')"
        )
    size = None if isinstance(value, (str, Node)) else sp.sympify(value)
    if not isinstance(size, sp.Expr) or (size.is_number and not (size.is_integer and size >= 0)):
        raise DefinitionError(f"{value!r} is no dimension; give one of dims(...), an expression in them or a number")
    return size


class Node(MatrixExpr):
    """A matrix expression. Operators build larger ones without evaluating anything."""

    _op_priority = 20.0

    def __add__(self, other: Any) -> Node:
        return MatrixSum.of(self, other)

    def __radd__(self, other: Any) -> Node:
        return MatrixSum.of(other, self)

    def __sub__(self, other: Any) -> Node:
        return self if is_zero(other) else MatrixSum.of(self, MatrixProduct.of(-1, as_node(other)))

    def __rsub__(self, other: Any) -> Node:
        return MatrixSum.of(other, -self)

    def __neg__(self) -> Node:
        return MatrixProduct.of(-1, self)

    def __mul__(self, other: Any) -> Node:
        return MatrixProduct.of(self, other)

    def __rmul__(self, other: Any) -> Node:
        return MatrixProduct.of(other, self)

    __matmul__ = __mul__
    __rmatmul__ = __rmul__

    def __truediv__(self, other: Any) -> Node:
        if isinstance(other, (MatrixExpr, str)) or exact(other) == 0:
            raise DefinitionError(f"{self} is divided by {other}; divide by a scalar, and write inv(X) for an inverse")
        return MatrixProduct.of(1 / exact(other), self)

    def __rtruediv__(self, other: Any) -> NoReturn:
        raise DefinitionError(f"{other} is divided by the matrix {self}; write inv({self})")

    def __pow__(self, exponent: Any, modulo: Any = None) -> NoReturn:
        raise DefinitionError(f"{self} is raised to a power; write the product, or inv({self})")

    def __rpow__(self, base: Any) -> NoReturn:
        raise DefinitionError(f"the matrix {self} is used as an exponent; give such a function as data of the plant")

    def __getitem__(self, key: Any) -> NoReturn:
        raise DefinitionError(f"an entry of {self} is asked for; sizes are symbols here, so write blocks as matrices")

    def __floordiv__(self, other: Any) -> NoReturn:
        raise DefinitionError(f"{self} is divided by //; write / and a scalar")

    def __gt__(self, other: Any) -> NoReturn:
        raise DefinitionError(f"{self} is compared with {other}; write PD(...) or ND(...) of the difference")

    __ge__ = __lt__ = __le__ = __rshift__ = __lshift__ = __rrshift__ = __rlshift__ = __gt__

    def __mod__(self, other: Any) -> NoReturn:
        raise DefinitionError(f"{self} is reduced by %; only + - * and / by a scalar are defined of matrices")

    def dot(self) -> Leaf:
        """Refused of all but a named matrix."""
        raise DefinitionError(
            f"dot({self}) is the derivative of an expression; write it out by the product rule, with dot(...) of each "
            "matrix that moves"
        )

    @property
    def T(self) -> Node:
        return Transposed.of(self)

    @property
    def I(self) -> Node:  # noqa: E743
        return Inverse(self)

    @property
    def nodes(self) -> tuple[Node, ...]:
        """The matrix operands, left to right."""
        return tuple(arg for arg in self.args if isinstance(arg, Node))

    def replaced(self, new: Mapping[Leaf, Leaf]) -> Node:
        """The expression with named matrices replaced by others."""
        args = [
            arg.replaced(new)
            if isinstance(arg, Node)
            else sp.Tuple(*(entry.replaced(new) for entry in arg))
            if isinstance(arg, sp.Tuple)
            else arg
            for arg in self.args
        ]
        result: Node = sp.Basic.__new__(type(self), *args)
        return result

    def leaves(self) -> dict[Leaf, None]:
        """Every named matrix that occurs, with its arguments, in the order of appearance."""
        return {leaf: None for node in self.nodes for leaf in node.leaves()}

    def scalars(self) -> set[sp.Symbol]:
        """Every scalar symbol in a coefficient (scalar unknowns and given scalars)."""
        return set().union(*(node.scalars() for node in self.nodes))


def as_node(value: Any) -> Node:
    """The value as a matrix expression, or DefinitionError."""
    if isinstance(value, Node):
        return value
    if isinstance(value, Star):
        value.refuse()
    if isinstance(value, (MatrixExpr, sp.MatrixBase, np.ndarray)):
        raise DefinitionError(
            f"a matrix of type {type(value).__name__} stands among those of lmic.dsl; write X.T, inv(X), trace(X), "
            "I(n) or zeros(n, m), and give numbers as data of the plant"
        )
    raise DefinitionError(
        f"'{value}' is used as a matrix but is of type {type(value).__name__}; write {value}*I(n) for a multiple "
        "of the identity, or a bare 0 or star as a block"
    )


class Leaf(Node):
    """A named matrix at given parameters: ``A``, ``A(alpha)``, ``P(alpha.next)``.

    ``role`` is "data" or "unknown". ``blocks`` lists the sizes of a block-diagonal unknown, each with how often it
    comes.
    ``derivative`` marks dP/dt along a continuous-time trajectory.
    """

    name: str
    rows: sp.Expr
    cols: sp.Expr
    role: str
    symmetric: bool
    blocks: tuple[tuple[sp.Expr, sp.Expr], ...]
    arguments: tuple[Parameter, ...]
    derivative: bool

    def __new__(
        cls,
        name: str,
        rows: Any,
        cols: Any,
        role: str,
        symmetric: bool = False,
        blocks: Sequence[tuple[Any, Any]] = (),
        arguments: tuple[Parameter, ...] = (),
        derivative: bool = False,
    ) -> Leaf:
        leaf: Leaf = sp.Basic.__new__(cls)
        leaf.name, leaf.role, leaf.symmetric = name, role, symmetric
        leaf._size = (as_size(rows), as_size(cols))
        leaf.blocks = tuple((as_size(size), as_size(count)) for size, count in blocks)
        leaf.arguments, leaf.derivative = arguments, derivative
        return leaf

    def __getnewargs__(self) -> tuple[Any, ...]:
        """What pickle makes the matrix from again: it has no sympy arguments."""
        rows, cols = self._size
        return (self.name, rows, cols, self.role, self.symmetric, self.blocks, self.arguments, self.derivative)

    def _hashable_content(self) -> tuple[Any, ...]:
        return (self.name, self._size, self.role, self.symmetric, self.blocks, self.arguments, self.derivative)

    @property
    def shape(self) -> tuple[sp.Expr, sp.Expr]:
        return self._size

    def __call__(self, *arguments: Parameter) -> Leaf:
        """The matrix at the given parameters."""
        for argument in arguments:
            if not isinstance(argument, Parameter):
                raise DefinitionError(
                    f"{self.name}({argument}): the argument is no parameter; give one that Simplex or Box made"
                )
        return self._with(arguments=arguments)

    def block_sizes(self, value: Callable[[sp.Expr], int]) -> list[int]:
        """The sizes of all blocks, with the values of the dimensions."""
        return [value(size) for size, count in self.blocks for _ in range(value(count))]

    def _with(self, **changes: Any) -> Leaf:
        fields = {
            "symmetric": self.symmetric,
            "blocks": self.blocks,
            "arguments": self.arguments,
            "derivative": self.derivative,
            **changes,
        }
        rows, cols = self._size
        return Leaf(self.name, rows, cols, self.role, **fields)

    @property
    def declaration(self) -> Leaf:
        """The matrix without arguments: what A(alpha) and A(alpha.next) share."""
        return self._with(arguments=(), derivative=False)

    def dot(self) -> Leaf:
        """Time derivative along the parameter's trajectory (continuous time)."""
        if not self.arguments:
            raise DefinitionError(f"{self.name} has no parameter to differentiate along: write dot({self.name}(rho))")
        return self._with(derivative=True)

    def leaves(self) -> dict[Leaf, None]:
        return {self: None}

    def replaced(self, new: Mapping[Leaf, Leaf]) -> Node:
        return new.get(self, self)

    def _sympystr(self, printer: Any) -> str:
        argument = f"({', '.join(map(str, self.arguments))})" if self.arguments else ""
        return f"dot({self.name}{argument})" if self.derivative else self.name + argument

    def _latex(self, printer: Any) -> str:
        name = sp.latex(sp.Symbol(self.name))
        name = rf"\dot{{{name}}}" if self.derivative else name
        argument = ", ".join(parameter.to_latex() for parameter in self.arguments)
        return f"{name}({argument})" if argument else name


class Identity(Node):
    def __new__(cls, size: Any) -> Identity:
        node: Identity = sp.Basic.__new__(cls, as_size(size))
        return node

    @property
    def shape(self) -> tuple[sp.Expr, sp.Expr]:
        return (self.args[0], self.args[0])

    def _sympystr(self, printer: Any) -> str:
        return f"I({self.args[0]})"

    def _latex(self, printer: Any) -> str:
        return f"I_{{{printer._print(self.args[0])}}}"


class Zero(Node):
    def __new__(cls, rows: Any, cols: Any) -> Zero:
        node: Zero = sp.Basic.__new__(cls, as_size(rows), as_size(cols))
        return node

    @property
    def shape(self) -> tuple[sp.Expr, sp.Expr]:
        return self.args

    def _sympystr(self, printer: Any) -> str:
        return "0"

    _latex = _sympystr


class MatrixSum(Node):
    precedence = PRECEDENCE["Add"]

    @staticmethod
    def of(*operands: Any) -> Node:
        """The sum, in the order written; a literal 0 is left out."""
        parts: list[Node] = []
        for operand in operands:
            if isinstance(operand, (int, sp.Integer)) and operand == 0:
                continue
            node = as_node(operand)
            parts.extend(node.nodes if isinstance(node, MatrixSum) else [node])
        if len(parts) == 1:
            return parts[0]
        result: MatrixSum = sp.Basic.__new__(MatrixSum, *parts)
        return result

    @property
    def shape(self) -> tuple[sp.Expr, sp.Expr]:
        return self.nodes[0].shape

    def _sympystr(self, printer: Any) -> str:
        return _signed_sum([printer._print(node) for node in self.nodes])

    _latex = _sympystr


class MatrixProduct(Node):
    """scalar · factor · factor …; the scalar is the first argument, 1 if none was written."""

    precedence = PRECEDENCE["Mul"]

    @staticmethod
    def of(*operands: Any) -> Node:
        coefficient: sp.Expr = sp.Integer(1)
        factors: list[Node] = []
        for operand in operands:
            if isinstance(operand, MatrixProduct):
                coefficient *= operand.coefficient
                factors.extend(operand.nodes)
            elif isinstance(operand, Node):
                factors.append(operand)
            elif isinstance(operand, (MatrixExpr, sp.MatrixBase, np.ndarray, str)):
                as_node(operand)
            else:
                try:
                    coefficient *= exact(operand)
                except (sp.SympifyError, TypeError):
                    as_node(operand)
        if coefficient == 1 and len(factors) == 1:
            return factors[0]
        result: MatrixProduct = sp.Basic.__new__(MatrixProduct, coefficient, *factors)
        return result

    @property
    def coefficient(self) -> sp.Expr:
        return self.args[0]

    @property
    def shape(self) -> tuple[sp.Expr, sp.Expr]:
        return (self.nodes[0].shape[0], self.nodes[-1].shape[1])

    def scalars(self) -> set[sp.Symbol]:
        return super().scalars() | self.coefficient.free_symbols

    def _print_with(self, printer: Any, times: str) -> str:
        factors = [printer.parenthesize(node, PRECEDENCE["Mul"]) for node in self.nodes]
        negative = self.coefficient.could_extract_minus_sign() and not self.coefficient.is_Add
        size = -self.coefficient if negative else self.coefficient
        if size != 1:
            factors = [printer.parenthesize(size, PRECEDENCE["Mul"], strict=True), *factors]
        return "-" * negative + times.join(factors)

    def _sympystr(self, printer: Any) -> str:
        return self._print_with(printer, "*")

    def _latex(self, printer: Any) -> str:
        return self._print_with(printer, " ")


class Transposed(Node):
    precedence = PRECEDENCE["Pow"]

    @staticmethod
    def of(operand: Any) -> Node:
        node = as_node(operand)
        if isinstance(node, Transposed):
            return node.nodes[0]
        if isinstance(node, Identity) or (isinstance(node, Leaf) and node.symmetric):
            return node
        result: Transposed = sp.Basic.__new__(Transposed, node)
        return result

    @property
    def shape(self) -> tuple[sp.Expr, sp.Expr]:
        rows, cols = self.nodes[0].shape
        return (cols, rows)

    def _sympystr(self, printer: Any) -> str:
        return printer.parenthesize(self.nodes[0], PRECEDENCE["Pow"]) + ".T"

    def _latex(self, printer: Any) -> str:
        (node,) = self.nodes
        if isinstance(node, Leaf):
            name = printer._print(node.declaration)
            argument = printer._print(node)[len(name) :]
            return f"{name}^{{\\top}}{argument}"
        return printer.parenthesize(node, PRECEDENCE["Pow"]) + r"^{\top}"


class Hermitian(Node):
    """He(X) = X + Xᵀ."""

    def __new__(cls, operand: Any) -> Hermitian:
        node: Hermitian = sp.Basic.__new__(cls, as_node(operand))
        return node

    @property
    def shape(self) -> tuple[sp.Expr, sp.Expr]:
        return self.nodes[0].shape

    def _sympystr(self, printer: Any) -> str:
        return f"He({printer._print(self.nodes[0])})"

    def _latex(self, printer: Any) -> str:
        return rf"\operatorname{{He}}\{{{printer._print(self.nodes[0])}\}}"


class Inverse(Node):
    """The inverse of a square expression: in data, or in recovery formulas."""

    precedence = PRECEDENCE["Pow"]

    def __new__(cls, operand: Any) -> Inverse:
        node: Inverse = sp.Basic.__new__(cls, as_node(operand))
        return node

    @property
    def shape(self) -> tuple[sp.Expr, sp.Expr]:
        return self.nodes[0].shape

    def _sympystr(self, printer: Any) -> str:
        return f"inv({printer._print(self.nodes[0])})"

    def _latex(self, printer: Any) -> str:
        (node,) = self.nodes
        if isinstance(node, Leaf):
            name = printer._print(node.declaration)
            return f"{name}^{{-1}}{printer._print(node)[len(name) :]}"
        return printer.parenthesize(node, PRECEDENCE["Pow"]) + "^{-1}"


class Kronecker(Node):
    """Kronecker product, ``kron(I(2), X)``."""

    precedence = PRECEDENCE["Mul"]

    def __new__(cls, left: Any, right: Any) -> Kronecker:
        node: Kronecker = sp.Basic.__new__(cls, as_node(left), as_node(right))
        return node

    @property
    def shape(self) -> tuple[sp.Expr, sp.Expr]:
        (left, right) = self.nodes
        return (left.shape[0] * right.shape[0], left.shape[1] * right.shape[1])

    def _sympystr(self, printer: Any) -> str:
        return f"kron({', '.join(printer._print(node) for node in self.nodes)})"

    def _latex(self, printer: Any) -> str:
        return r" \otimes ".join(printer.parenthesize(node, PRECEDENCE["Mul"]) for node in self.nodes)


class Trace(Node):
    """Sum of the diagonal of a square expression, a 1 x 1 matrix."""

    def __new__(cls, operand: Any) -> Trace:
        node: Trace = sp.Basic.__new__(cls, as_node(operand))
        return node

    @property
    def shape(self) -> tuple[sp.Expr, sp.Expr]:
        return (sp.Integer(1), sp.Integer(1))

    def _sympystr(self, printer: Any) -> str:
        return f"trace({printer._print(self.nodes[0])})"

    def _latex(self, printer: Any) -> str:
        return rf"\operatorname{{tr}}({printer._print(self.nodes[0])})"


class Block(Node):
    """A matrix of blocks; an entry may be a literal 0."""

    def __new__(cls, rows: Sequence[Sequence[Any]]) -> Block:
        if not rows or any(len(row) != len(rows[0]) for row in rows):
            raise DefinitionError(
                "the rows of a Block have different lengths; give every row the same number of blocks"
            )
        entries = [[None if is_zero(entry) else as_node(entry) for entry in row] for row in rows]
        columns = [[row[j] for row in entries] for j in range(len(rows[0]))]
        heights = [_common_size(row, 0, f"row {i + 1}") for i, row in enumerate(entries)]
        widths = [_common_size(column, 1, f"column {j + 1}") for j, column in enumerate(columns)]
        filled = [
            [entry or Zero(height, width) for entry, width in zip(row, widths, strict=True)]
            for row, height in zip(entries, heights, strict=True)
        ]
        node: Block = sp.Basic.__new__(cls, *(sp.Tuple(*row) for row in filled))
        return node

    def __getnewargs__(self) -> tuple[Any, ...]:
        return (self.args,)

    @property
    def grid(self) -> tuple[tuple[Node, ...], ...]:
        return tuple(tuple(row) for row in self.args)

    @property
    def nodes(self) -> tuple[Node, ...]:
        return tuple(node for row in self.grid for node in row)

    @property
    def heights(self) -> tuple[sp.Expr, ...]:
        return tuple(row[0].shape[0] for row in self.grid)

    @property
    def widths(self) -> tuple[sp.Expr, ...]:
        return tuple(node.shape[1] for node in self.grid[0])

    @property
    def shape(self) -> tuple[sp.Expr, sp.Expr]:
        return (sp.Add(*self.heights), sp.Add(*self.widths))

    def _sympystr(self, printer: Any) -> str:
        return "[" + "; ".join(", ".join(printer._print(node) for node in row) for row in self.grid) + "]"

    def _latex(self, printer: Any) -> str:
        rows = r" \\ ".join(" & ".join(printer._print(node) for node in row) for row in self.grid)
        return rf"\begin{{bmatrix}} {rows} \end{{bmatrix}}"


def is_zero(entry: Any) -> bool:
    """Whether a block is a literal zero."""
    return isinstance(entry, (int, float, sp.Number)) and entry == 0


def _common_size(entries: Sequence[Node | None], axis: int, what: str) -> sp.Expr:
    """Size of a block row or column, from its first matrix."""
    for entry in entries:
        if entry is not None:
            return entry.shape[axis]
    raise DefinitionError(f"{what} of a Block holds only literal zeros, so its size is unknown; use zeros(n, m) once")


def _signed_sum(texts: Sequence[str]) -> str:
    head, *tail = texts
    return head + "".join(f" - {text[1:]}" if text.startswith("-") else f" + {text}" for text in tail)
