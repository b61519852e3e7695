"""Bases of null spaces with small integers: V in Z = V W Vᵀ, for solving and for proofs alike."""

from __future__ import annotations

from fractions import Fraction
from math import lcm
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]


def integer_complement(rows: Array, denominator: int, near: float) -> Array | None:
    """Integer columns that span the orthogonal complement of some rows, or None where these are no small fractions.

    Reduced, the rows have to be within ``near`` of fractions with denominators up to ``denominator``. In as many
    rows as there are columns, only one entry is not zero (:func:`free_rows`).
    """
    order = rows.shape[1]
    reduced = rows.copy()
    pivots: list[int] = []
    for k in range(len(reduced)):
        i, j = divmod(int(np.abs(reduced[k:]).argmax()), order)
        reduced[[k, k + i]] = reduced[[k + i, k]]
        reduced[k] /= reduced[k, j]
        others = np.arange(len(reduced)) != k
        reduced[others] -= reduced[others, j][:, None] * reduced[k]
        pivots.append(j)
    exact = [[Fraction(value).limit_denominator(denominator) for value in row] for row in reduced.tolist()]
    if np.abs(np.array(exact, dtype=float).reshape(reduced.shape) - reduced).max(initial=0.0) > near:
        return None
    free = [j for j in range(order) if j not in pivots]
    face = np.zeros((order, len(free)), dtype=int)
    for a, j in enumerate(free):
        factor = lcm(*(row[j].denominator for row in exact))
        face[j, a] = factor
        for pivot, row in zip(pivots, exact, strict=True):
            face[pivot, a] = int(-row[j] * factor)
    return face


def free_rows(base: Array) -> Array:
    """For every column of V a row in which no other column has an entry."""
    alone = np.count_nonzero(base, axis=1) == 1
    return np.array([np.flatnonzero(alone & (base[:, a] != 0))[0] for a in range(base.shape[1])], dtype=int)
