"""LMIs that are zero to rounding at an answer: nothing is relative to such a slack, and it has no inverse root.

Where a whole LMI vanishes at the optimum, the size of its data takes the place of its diagonal.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.solve.cone import ConeData, ConeProblem

Array: TypeAlias = NDArray[Any]


def vanishing(slack: Array, x: Array, data: ConeData | ConeProblem, rounding: float) -> Array:
    """The size of the data of every LMI whose diagonal is at most ``rounding`` times that; zero for the others."""
    sizes = abs(data.matrix) @ np.abs(x) + np.abs(data.offset)
    found, start = np.zeros(len(data.orders)), 0
    for k, order in enumerate(map(int, data.orders)):
        diagonal = start + _diagonal(order)
        end = start + order * (order + 1) // 2
        size = sizes[start:end].max()
        if np.abs(slack[diagonal]).max() <= rounding * size:
            found[k] = size
        start = end
    return found


def lifted(slack: Array, sizes: Array, orders: Array) -> Array:
    """svec of the slacks, ``sizes[k]`` times the identity in place of those that vanish."""
    result, start = slack.copy(), 0
    for size, order in zip(sizes.tolist(), map(int, orders), strict=True):
        end = start + order * (order + 1) // 2
        if size > 0:
            result[start:end] = 0.0
            result[start + _diagonal(order)] = size
        start = end
    return result


def _diagonal(order: int) -> Array:
    """Packed places of the diagonal."""
    places = np.arange(order)
    return places * (places + 3) // 2
