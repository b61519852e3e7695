"""Packed symmetric matrices: upper triangle column by column, the one order used everywhere.

``svec`` multiplies off-diagonal entries by √2, so that ⟨A, B⟩ = svec(A)·svec(B).
"""

from __future__ import annotations

from functools import cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]


def length(order: int) -> int:
    """Number of packed entries of a symmetric matrix."""
    return order * (order + 1) // 2


def packed_index(rows: Array, cols: Array) -> Array:
    """Place of entry (row ≤ col) in the packed vector."""
    return cols * (cols + 1) // 2 + rows


@cache
def triangle(order: int) -> tuple[Array, Array]:
    """Rows and columns of the packed entries, in their order; the arrays are shared and read-only."""
    cols = np.repeat(np.arange(order), np.arange(1, order + 1))
    rows = np.arange(length(order)) - packed_index(np.zeros_like(cols), cols)
    rows.flags.writeable = cols.flags.writeable = False
    return rows, cols


@cache
def weights(order: int) -> Array:
    """1 on the diagonal and √2 off it: packed entries times weights is svec; shared and read-only."""
    rows, cols = triangle(order)
    found = np.where(rows == cols, 1.0, np.sqrt(2.0))
    found.flags.writeable = False
    return found


def identity(order: int) -> Array:
    """svec of the identity."""
    rows, cols = triangle(order)
    return (rows == cols).astype(float)


def unpack(packed: Array, order: int) -> Array:
    """Symmetric matrices of packed entries (without √2), shape (..., order, order)."""
    rows, cols = triangle(order)
    matrices = np.zeros((*packed.shape[:-1], order, order), dtype=packed.dtype)
    matrices[..., rows, cols] = packed
    matrices[..., cols, rows] = packed
    return matrices


def lower_by_columns(orders: Array) -> Array:
    """Where the packed entries of matrices, one after another, stand as lower triangles column by column.

    Solvers that take the lower triangle (SCS, MOSEK, COPT) hold entry ``e`` at place ``result[e]``.
    """
    places, start = [], 0
    for order in map(int, orders):
        small, large = triangle(order)
        places.append(start + small * order - small * (small - 1) // 2 + large - small)
        start += length(order)
    return np.concatenate(places)
