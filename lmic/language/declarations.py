"""Declaring the names of a theorem: dimensions, data, unknowns, scalars, and the small words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NoReturn, Self

import sympy as sp

from lmic.errors import DefinitionError
from lmic.language.nodes import Block, Hermitian, Identity, Inverse, Kronecker, Leaf, Trace, Zero, as_size


class SymbolicSize(sp.Symbol):
    """A symbolic dimension; ``nx`` prints as n_x in LaTeX."""

    def __new__(cls, name: str) -> Self:
        symbol: Self = sp.Symbol.__new__(cls, name, integer=True, positive=True)
        return symbol

    def __getnewargs_ex__(self) -> tuple[tuple[str], dict[str, bool]]:
        """What pickle makes the symbol from again."""
        return (self.name,), {}

    def _latex(self, printer: Any) -> str:
        name = str(self.name)
        return f"{name[0]}_{{{name[1:]}}}" if len(name) > 1 and name.isalpha() else sp.latex(sp.Symbol(name))


def dims(names: str) -> tuple[SymbolicSize, ...]:
    """Symbolic dimensions, ``nx, nw = dims("nx nw")``; the plant's matrices fix their values."""
    return tuple(SymbolicSize(name) for name in names.split())


def Data(name: str, rows: Any, cols: Any, symmetric: bool = False) -> Leaf:
    """A rows x cols matrix that the plant gives under this name; ``Data("A", n, n)(alpha)`` may depend on alpha.

    ``symmetric`` states that it is, so that it may stand on a diagonal.
    """
    return Leaf(name, rows, cols, "data", symmetric=symmetric)


def Matrix(name: str, rows: Any, cols: Any) -> Leaf:
    """A rectangular unknown, rows x cols; ``Matrix("G", n, n)(alpha)`` is looked for among functions of alpha."""
    return Leaf(name, rows, cols, "unknown")


def Symmetric(name: str, size: Any, blocks: Sequence[Any] = ()) -> Leaf:
    """A symmetric unknown, size x size; ``blocks=(n, m)`` makes it block diagonal, where n + m is the size."""
    return Leaf(name, size, size, "unknown", symmetric=True, blocks=[(block, 1) for block in blocks])


def Diagonal(name: str, size: Any) -> Leaf:
    """A diagonal unknown, size x size: a multiplier for each of several nonlinearities, a positive system's xᵀPx."""
    return Leaf(name, size, size, "unknown", symmetric=True, blocks=[(1, size)])


def BlockDiagonal(name: str, *blocks: Any) -> Leaf:
    """A block-diagonal unknown with square blocks of the given sizes; its own size is their sum."""
    size = sp.Add(*map(as_size, blocks))
    return Leaf(name, size, size, "unknown", blocks=[(block, 1) for block in blocks])


class NamedScalar(sp.Symbol):
    """A scalar symbol with its own LaTeX name."""

    __slots__ = ("latex_name",)

    def __new__(cls, name: str, latex: str = "") -> Self:
        # past sympy's cache of symbols, which would share the LaTeX name between theorems
        symbol: Self = sp.Symbol.__xnew__(cls, name)
        symbol.latex_name = latex or sp.latex(sp.Symbol(name))
        return symbol

    def __getnewargs_ex__(self) -> tuple[tuple[str, str], dict[str, bool]]:
        """What pickle makes the symbol from again."""
        return (self.name, self.latex_name), {}

    def __call__(self, *arguments: Any) -> NoReturn:
        raise DefinitionError(
            f"the scalar {self} is taken at a parameter; declare it as Symmetric({self.name!r}, 1), "
            f"and kron({self}(...), I(n)) is a block"
        )

    def dot(self) -> NoReturn:
        """Refused: a scalar does not move."""
        raise DefinitionError(f"dot({self}) is zero, as a scalar depends on no parameter; leave it out")

    def _latex(self, printer: Any) -> str:
        return self.latex_name


class ScalarUnknown(NamedScalar):
    """A scalar unknown of the LMIs."""


class Given(NamedScalar):
    """A scalar fixed when compiling (ε, ρ, dΔ); a sweep re-binds it without compiling again."""


def Scalar(name: str, latex: str = "") -> ScalarUnknown:
    """A scalar unknown, ``mu = Scalar("mu")``; ``mu*I(n)`` is a block. ``latex`` is how it prints."""
    return ScalarUnknown(name, latex)


def given(name: str, latex: str = "") -> Given:
    """A scalar whose value is given when compiling, ``eps = given("eps")``; it may multiply unknowns.

    ``latex`` is how it prints.
    """
    return Given(name, latex)


def I(size: Any) -> Identity:  # noqa: E743
    """Identity, size x size."""
    return Identity(size)


def zeros(rows: Any, cols: Any) -> Zero:
    """Zero matrix, rows x cols; a bare 0 does where the size follows from the row and column."""
    return Zero(rows, cols)


def He(matrix: Any) -> Hermitian:
    """He(X) = X + Xᵀ of a square expression."""
    return Hermitian(matrix)


def inv(matrix: Any) -> Inverse:
    """Inverse of a square expression without unknowns (or in a recovery formula)."""
    return Inverse(matrix)


def kron(left: Any, right: Any) -> Kronecker:
    """Kronecker product: of p x q and r x s, pr x qs. At most one operand holds unknowns."""
    return Kronecker(left, right)


def trace(matrix: Any) -> Trace:
    """Sum of the diagonal, as a 1 x 1 matrix: ``mu*I(1) - trace(Z)``."""
    return Trace(matrix)


def block(rows: Sequence[Sequence[Any]]) -> Block:
    """A matrix of blocks, ``block([[A, B], [0, C]])``; an entry may be a bare 0, but no star.

    Raises DefinitionError where rows have different lengths or the size of one is unknown.
    """
    return Block(rows)


def diag(*blocks: Any) -> Block:
    """Block-diagonal matrix of the given expressions."""
    return Block([[entry if i == j else 0 for j in range(len(blocks))] for i, entry in enumerate(blocks)])


def dot(matrix: Leaf) -> Leaf:
    """dX/dt along the parameter's trajectory, Σ ∂X/∂ρᵢ ρ̇ᵢ (continuous time)."""
    return matrix.dot()
