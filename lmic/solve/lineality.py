"""Directions in the unknowns that no LMI sees.

They leave the conic problem singular: some solvers fail on them, all lose digits. A maximal
independent set of columns is kept; the others are put back as zeros.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sps
from numpy.typing import NDArray

Array = NDArray[Any]

#: a column counts as dependent when the rest reaches it to this relative distance
TOLERANCE = 1e-11


def independent_columns(matrix: sps.csc_array) -> Array:
    """Indices of a maximal set of independent columns, increasing."""
    rows, cols = matrix.shape
    norms = np.sqrt(np.asarray(matrix.multiply(matrix).sum(axis=0)).ravel())
    seen = np.flatnonzero(norms > 0)
    scaled = matrix[:, seen] @ sps.diags_array(1 / norms[seen])
    if rows > 4 * cols + 400:
        scaled = _sketch(rows, 2 * cols + 200) @ scaled
    triangular, order = scipy.linalg.qr(scaled.toarray(), mode="r", pivoting=True)[0:2]
    pivots = np.abs(np.diag(triangular))
    rank = int(np.sum(pivots > TOLERANCE * pivots.max(initial=1.0)))
    kept: Array = np.sort(seen[order[:rank]])
    return kept


def _sketch(rows: int, target: int) -> sps.csr_array:
    """A random sparse embedding: it keeps the rank and roughly the conditioning of tall matrices."""
    generator = np.random.default_rng(0)
    per_row = 8
    signs = generator.choice([-1.0, 1.0], size=rows * per_row)
    places = generator.integers(target, size=rows * per_row)
    return sps.coo_array((signs, (places, np.repeat(np.arange(rows), per_row))), shape=(target, rows)).tocsr()
