"""Directions in the unknowns that no LMI sees.

They leave the conic problem singular: some solvers fail on them, all lose digits. A maximal
independent set of columns is kept; the others are put back as zeros.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg
import scipy.sparse as sps
from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]

#: a column counts as dependent when the rest reaches it to this relative distance
TOLERANCE = 1e-11


@dataclass(frozen=True)
class Lineality:
    """``kept`` are the indices of independent columns; the others are combinations of them.

    Column ``left_out[j]`` equals ``matrix[:, kept] @ combinations[:, j]``; ``norms`` are those of
    all columns, 1 for a column of zeros.
    """

    kept: Array
    left_out: Array
    combinations: Array
    norms: Array

    def unseen(self, cost: Array) -> bool:
        """Whether the objective moves along a direction that no LMI sees: then it is unbounded."""
        rest = cost[self.left_out] - cost[self.kept] @ self.combinations
        scale = np.abs(cost / self.norms).max(initial=0.0)
        return bool((np.abs(rest) / self.norms[self.left_out] > 1e-8 * scale).any())


def lineality(matrix: sps.csc_array) -> Lineality:
    """A maximal set of independent columns, by a rank-revealing factorisation of the scaled matrix."""
    rows, cols = matrix.shape
    norms = np.sqrt(np.asarray(matrix.multiply(matrix).sum(axis=0)).ravel())
    seen = np.flatnonzero(norms > 0)
    scaled = matrix[:, seen] @ sps.diags_array(1 / norms[seen])
    if rows > 4 * cols + 400:
        scaled = _sketch(rows, 2 * cols + 200) @ scaled
    triangular, order = scipy.linalg.qr(scaled.toarray(), mode="r", pivoting=True)[0:2]
    pivots = np.abs(np.diag(triangular))
    rank = int(np.sum(pivots > TOLERANCE * pivots.max(initial=1.0)))
    within = scipy.linalg.solve_triangular(triangular[:rank, :rank], triangular[:rank, rank:])
    kept, dependent = seen[order[:rank]], seen[order[rank:]]
    combinations = within * norms[dependent][None, :] / norms[kept][:, None]
    never_seen = np.flatnonzero(norms == 0)
    by_index = np.argsort(kept)
    return Lineality(
        kept[by_index],
        np.concatenate([dependent, never_seen]),
        np.concatenate([combinations, np.zeros((rank, len(never_seen)))], axis=1)[by_index],
        np.where(norms > 0, norms, 1.0),
    )


def _sketch(rows: int, target: int) -> sps.csr_array:
    """A random sparse embedding: it keeps the rank and roughly the conditioning of tall matrices."""
    generator = np.random.default_rng(0)
    per_row = 8
    signs = generator.choice([-1.0, 1.0], size=rows * per_row)
    places = generator.integers(target, size=rows * per_row)
    return sps.coo_array((signs, (places, np.repeat(np.arange(rows), per_row))), shape=(target, rows)).tocsr()
