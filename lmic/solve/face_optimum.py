"""The optimum on a face of the dual, and what lies strictly inside near it: points of all LMIs, and dual matrices."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.solve.cone import ConeData, ConeSolver
from lmic.solve.recession import Reduction
from lmic.solve.scaling import initial, slack_matrices

Array: TypeAlias = NDArray[Any]

#: shares of the objective at which a point well inside is looked for, in turn; thin problems have none at the larger
SHARES = (1e-5, 1e-4, 1e-6, 1e-7)
#: shares of that point which are mixed into the optimum, in turn
MIXED = tuple(10 ** (power / 2) for power in range(-8, 1))
#: a margin is at most this share of the diagonal entry, where the other matrix has none to speak of
MOST = 1e-2


@dataclass(frozen=True)
class FaceOptimum:
    """The core's ``x`` and ``dual`` (svec) at its optimum, whose objective is about ``size``.

    They miss the cones and their equalities by rounding. ``rough`` are x and dual as the first pass gave them: with
    fewer digits, and farther from the boundary, so that dual matrices inside are found from there.
    """

    reduction: Reduction
    x: Array
    dual: Array
    size: float
    rough: tuple[Array, Array]

    def points(self, share: float, solver: ConeSolver) -> Iterator[Array]:
        """Points strictly inside all cones of the whole problem, the nearest to the optimum first.

        They lie towards one that costs about ``share`` of the objective.
        """
        x = inside(self.reduction.core, self.x, self.dual, share * self.size, solver)
        for mixed in MIXED:
            try:
                yield self.reduction.lifted((1 - mixed) * self.x + mixed * x)
            except np.linalg.LinAlgError:  # outside the core's own cones: more of the other
                continue

    def dual_matrices(self, share: float, solver: ConeSolver) -> list[Array]:
        """Positive definite W on the face whose bound is about ``share`` of the objective below the optimum."""
        core, (x, dual) = self.reduction.core, self.rough
        slack = core.matrix @ x + core.offset
        return self.reduction.matrices(inside_dual(core, slack, dual, share * self.size, solver))


def inside(core: ConeData, x: Array, dual: Array, price: float, solver: ConeSolver) -> Array:
    """A point strictly inside the cones at the price of so much of the objective, from the optimum and its dual.

    It is a step from ``x``, in coordinates in which all slacks have unit diagonal: some may vanish at the optimum.
    """
    slack = core.matrix @ x + core.offset
    margin = _margin(slack, dual, core.orders, price)
    units = []
    for own, moved in zip(slack_matrices(slack, core.orders), slack_matrices(margin, core.orders), strict=True):
        root = 1 / np.sqrt(np.maximum(np.diag(own), np.diag(moved)))
        rows, cols = svec.triangle(len(root))
        units.append(root[rows] * root[cols])
    unit = np.concatenate(units)
    step = replace(core, matrix=sps.csc_array(sps.diags_array(unit) @ core.matrix), offset=unit * (slack - margin))
    scaled, transform = initial(step)
    return x + transform.x(solver(scaled).y)


def inside_dual(core: ConeData, slack: Array, dual: Array, price: float, solver: ConeSolver) -> Array:
    """svec of positive definite dual matrices whose bound is so much lower, likewise."""
    margin = _margin(dual, slack, core.orders, price)
    scaled, _ = initial(replace(core, cost=core.cost - core.matrix.T @ margin))
    return solver(scaled).z + margin


def _margin(own: Array, other: Array, orders: Array, price: float) -> Array:
    """svec of diagonal matrices to keep ``own`` away from the boundary, paid for in equal parts.

    As on the central path an entry of the one matrix is the inverse of the other's, but no more than a share of
    what it is, where the other hardly counts. That may be all of an LMI, while another vanishes altogether.
    """
    share = price / float(orders.sum())
    tiny = float(np.finfo(float).tiny)
    mine = [np.diag(matrix) for matrix in slack_matrices(own, orders)]
    theirs = [np.maximum(np.diag(matrix), tiny) for matrix in slack_matrices(other, orders)]
    most = max(tiny, *(diagonal.max() for diagonal in mine)), max(diagonal.max() for diagonal in theirs)
    parts = []
    for diagonal, opposite in zip(mine, theirs, strict=True):
        small = diagonal / most[0] < opposite / most[1]
        limit = np.maximum(MOST * diagonal, np.where(small, share / opposite.max(), 0.0))
        rows, cols = svec.triangle(len(diagonal))
        parts.append(np.where(rows == cols, np.minimum(share / opposite, limit)[rows], 0.0))
    return np.concatenate(parts)
