"""Maps and forms read off signals, and what proofs do with them, in plain numpy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.linalg import inv
from scipy.linalg import block_diag

Array = np.ndarray[Any, Any]


# Reading maps and forms off signals ------------------------------------------------------------


def linear_map(function: Callable[..., Array], sizes: Sequence[int]) -> Array:
    """Matrix of a linear function of several vectors, by its values at unit vectors."""
    total, cuts = sum(sizes), np.cumsum(sizes)[:-1]
    return np.column_stack([function(*np.split(unit, cuts)) for unit in np.eye(total)])


def quadratic_form(function: Callable[..., float], sizes: Sequence[int]) -> Array:
    """Symmetric matrix M with function(η) = ηᵀMη, by polarisation: 2 ηᵀMζ = f(η+ζ) − f(η) − f(ζ)."""
    total, cuts = sum(sizes), np.cumsum(sizes)[:-1]

    def at(vector: Array) -> float:
        return function(*np.split(vector, cuts))

    units = np.eye(total)
    single = np.array([at(unit) for unit in units])
    return np.array(
        [[(at(u + v) - single[i] - single[j]) / 2 for j, v in enumerate(units)] for i, u in enumerate(units)]
    )


def congruence(matrix: Array, *blocks: Array) -> Array:
    """TᵀMT with T = diag(blocks)."""
    transform = block_diag(*blocks)
    return transform.T @ matrix @ transform


def reorder(matrix: Array, sizes: Sequence[int], order: Sequence[int]) -> Array:
    """Block rows and columns of a symmetric matrix in another order."""
    starts = np.concatenate([[0], np.cumsum(sizes)])
    index = np.concatenate([np.arange(starts[k], starts[k + 1]) for k in order])
    return matrix[np.ix_(index, index)]


def add(matrix: Array, sizes: Sequence[int], block: int, value: Array) -> Array:
    """The matrix with ``value`` added to a diagonal block."""
    start = sum(sizes[:block])
    result = matrix.copy()
    result[start : start + sizes[block], start : start + sizes[block]] += value
    return result


def lifted(form: Array, *maps: tuple[Array, Array]) -> Array:
    """[form, N_kᵀ …; N_k, −S_k⁻¹ …], negative definite exactly when form + Σ N_kᵀ S_k N_k is (Schur)."""
    N = np.vstack([n for n, _ in maps])
    return np.block([[form, N.T], [N, -block_diag(*(inv(s) for _, s in maps))]])


def eliminate(matrix: Array, size: int) -> Array:
    """Schur complement of the last ``size`` rows and columns."""
    head = matrix[:-size, :-size]
    return head - matrix[:-size, -size:] @ inv(matrix[-size:, -size:]) @ matrix[-size:, :-size]
