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
#: relative distance from which on rounding in squares does no harm
FAR = 1e-4
#: steps in which a projection by the Gram matrix gets all its digits back
REFINED = 3


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
    """A maximal set of independent columns.

    A factorisation of the Gram matrix of the scaled columns, in which distances are squared, finds those that are
    far from one another. Of the few others what these leave is factorised itself.
    """
    norms = np.sqrt(np.asarray(matrix.multiply(matrix).sum(axis=0)).ravel())
    seen = np.flatnonzero(norms > 0)
    scaled = sps.csc_array(matrix[:, seen] @ sps.diags_array(1 / norms[seen]))
    factor, order, rank = _cholesky((scaled.T @ scaled).toarray())
    far, near = order[:rank], order[rank:]
    basis, others = scaled[:, far], scaled[:, near]
    combined, rest = _projected(factor, basis, others)
    triangular, order = scipy.linalg.qr(_short(rest), mode="r", pivoting=True)[0:2]
    more = int(np.sum(np.abs(np.diag(triangular)) > TOLERANCE))
    within = scipy.linalg.solve_triangular(triangular[:more, :more], triangular[:more, more:])
    also, out = order[:more], order[more:]
    kept, dependent = seen[np.concatenate([far, near[also]])], seen[near[out]]
    combinations = np.concatenate([combined[:, out] - combined[:, also] @ within, within])
    combinations *= norms[dependent][None, :] / norms[kept][:, None]
    never_seen = np.flatnonzero(norms == 0)
    by_index = np.argsort(kept)
    return Lineality(
        kept[by_index],
        np.concatenate([dependent, never_seen]),
        np.concatenate([combinations, np.zeros((len(kept), len(never_seen)))], axis=1)[by_index],
        np.where(norms > 0, norms, 1.0),
    )


def _cholesky(gram: Array) -> tuple[Array, Array, int]:
    """Upper factor, order of the columns and number of those whose distance from the ones before is above FAR."""
    if not len(gram):
        return gram, np.zeros(0, dtype=int), 0
    factor, order, rank, _ = scipy.linalg.lapack.dpstrf(gram, tol=FAR**2)
    return np.triu(factor[:rank, :rank]), order - 1, rank


def _projected(factor: Array, basis: sps.csc_array, others: sps.csc_array) -> tuple[Array, Array]:
    """Combinations of the basis nearest to the others, and what they leave."""
    combined = np.zeros((basis.shape[1], others.shape[1]))
    rest = others.toarray()
    for _ in range(REFINED):
        step = scipy.linalg.cho_solve((factor, False), basis.T @ rest)
        combined += step
        rest = others.toarray() - basis @ combined
    return combined, rest


def _short(columns: Array) -> Array:
    """Columns of the same inner products with as few rows as can be."""
    rows, cols = columns.shape
    return np.asarray(np.linalg.qr(columns, mode="r")) if rows > cols else columns
