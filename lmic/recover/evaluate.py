"""Evaluate a matrix expression directly, node by node, from the values of its named matrices.

This is the plain reading of the statement. It shares nothing with the compiler and so serves the
recovery formulas, the closed loop, and as the yardstick of the tests.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.errors import RecoveryError
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
)

Array: TypeAlias = NDArray[Any]
Valuation: TypeAlias = Callable[[Leaf], Array]


def evaluate(node: Node, leaf: Valuation, scalars: Mapping[str, float], sizes: Mapping[sp.Symbol, int]) -> Array:
    """Value of ``node``, shape (..., rows, cols); leading axes of the leaves broadcast.

    ``leaf`` gives the value of a named matrix at its arguments, ``scalars`` the values of scalar
    unknowns and given scalars by name. Raises RecoveryError where a matrix to invert is singular.
    """

    def value(inner: Node) -> Array:
        return evaluate(inner, leaf, scalars, sizes)

    match node:
        case Leaf():
            return leaf(node)
        case Identity():
            return np.eye(_size(node.shape[0], sizes))
        case Zero():
            return np.zeros((_size(node.shape[0], sizes), _size(node.shape[1], sizes)))
        case MatrixSum():
            return sum((value(operand) for operand in node.nodes[1:]), value(node.nodes[0]))
        case MatrixProduct():
            result = value(node.nodes[0])
            for operand in node.nodes[1:]:
                result = result @ value(operand)
            return _scalar(node.coefficient, scalars) * result
        case Transposed():
            return value(node.nodes[0]).swapaxes(-1, -2)
        case Hermitian():
            inner = value(node.nodes[0])
            return inner + inner.swapaxes(-1, -2)
        case Inverse():
            return _inverse(node, value(node.nodes[0]))
        case Kronecker():
            left, right = value(node.nodes[0]), value(node.nodes[1])
            product = np.einsum("...ij,...kl->...ikjl", left, right)
            rows, cols = left.shape[-2] * right.shape[-2], left.shape[-1] * right.shape[-1]
            return product.reshape(*product.shape[:-4], rows, cols)
        case Trace():
            return np.trace(value(node.nodes[0]), axis1=-2, axis2=-1)[..., None, None]
        case Block():
            return block_array([[value(entry) for entry in row] for row in node.grid])
    raise TypeError(f"no value for {type(node).__name__}")


def block_array(rows: list[list[Array]]) -> Array:
    """A matrix of blocks whose leading axes broadcast."""
    leading = np.broadcast_shapes(*(entry.shape[:-2] for row in rows for entry in row))
    wide = [[np.broadcast_to(entry, (*leading, *entry.shape[-2:])) for entry in row] for row in rows]
    return np.concatenate([np.concatenate(row, axis=-1) for row in wide], axis=-2)


def _inverse(node: Inverse, matrix: Array) -> Array:
    if not np.isfinite(matrix).all() or np.linalg.cond(matrix).max() > 1 / np.finfo(float).eps:
        raise RecoveryError(
            f"{node.nodes[0]} is singular at the solution; ask for a larger margin or change the given scalars"
        )
    return np.linalg.inv(matrix)


def _scalar(expression: sp.Expr, scalars: Mapping[str, float]) -> float:
    if expression.is_Number:
        return float(expression)
    return float(expression.xreplace({s: sp.Float(scalars[s.name], 17) for s in expression.free_symbols}))


def _size(expression: sp.Expr, sizes: Mapping[sp.Symbol, int]) -> int:
    return int(expression.subs(sizes))
