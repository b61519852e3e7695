"""Write the rows of all LMIs into one column-compressed array, the form in which solvers take it.

All LMIs of a family share one sparsity pattern, so the places of all entries are known before any value is.
Values are written where they belong, by operations whose innermost axis runs over the family's LMIs; what is
touched more than once stays small enough for the processor's cache.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.relax.family import LMIFamily

Array: TypeAlias = NDArray[Any]

#: LMIs from which an operation per column costs less than sorting the entries
LONG = 256
#: entries computed at a time
CHUNK = 1 << 19


@dataclass(frozen=True)
class _Part:
    """A family: its entries in each column, and how to write them.

    ``write(data, indices, places)`` puts the entries of column c at places[c] and after it, rows increasing.
    """

    counts: Array
    write: Callable[[Array, Array, Array], None]


def stacked(families: Sequence[LMIFamily], width: int) -> sps.csc_array:
    """svec of every LMI, one after another: column 0 the constants, column i the coefficients of x[i - 1]."""
    heights = [svec.length(family.lmi.order) * len(family) for family in families]
    starts = np.concatenate([[0], np.cumsum(heights)]).astype(np.int64)
    parts = [_part(family, int(start), width) for family, start in zip(families, starts, strict=False)]
    pointers = np.concatenate([[0], np.cumsum(np.sum([part.counts for part in parts], axis=0))]).astype(np.int64)
    total, height = int(pointers[-1]), int(starts[-1])
    index: Any = np.int32 if max(total, height) <= np.iinfo(np.int32).max else np.int64
    data, indices = np.empty(total), np.empty(total, dtype=index)
    places = pointers[:-1].copy()
    for part in parts:
        part.write(data, indices, places)
        places += part.counts
    columns = sps.csc_array((data, indices, pointers.astype(index)), shape=(height, width))
    columns.has_canonical_format = True
    # a monomial may vanish at a point
    columns.eliminate_zeros()
    return columns


def _part(family: LMIFamily, start: int, width: int) -> _Part:
    lmi = family.lmi
    # one at most: the share of the family's pattern that its weights leave
    share = np.count_nonzero(family.weights, axis=0) @ np.diff(lmi.coefficients.indptr)
    if len(family) >= LONG and share >= len(family) * len(lmi.rows) / 2:
        return _long(family, start, width)
    return _short(family, start, width)


def _weighed(family: LMIFamily) -> sps.csr_array:
    """The pattern's coefficients times the weights of svec, monomials x pattern."""
    scale = svec.weights(family.lmi.order)[family.lmi.rows]
    return sps.csr_array(family.lmi.coefficients @ sps.diags_array(scale))


def _long(family: LMIFamily, start: int, width: int) -> _Part:
    """Many LMIs, most of the pattern in each: column by column."""
    lmi, count = family.lmi, len(family)
    edges = np.searchsorted(lmi.columns, np.arange(width + 1))

    def write(data: Array, indices: Array, places: Array) -> None:
        pattern = sps.csr_array(_weighed(family).T)
        weights = np.ascontiguousarray(family.weights.T)
        rows = lmi.rows.astype(indices.dtype)
        tops = start + svec.length(lmi.order) * np.arange(count, dtype=indices.dtype)
        begun = 0
        while begun < width:
            ended = max(int(np.searchsorted(edges, edges[begun] + CHUNK // count, side="right")) - 1, begun + 1)
            values = pattern[edges[begun] : edges[ended]] @ weights
            for column in range(begun, ended):
                first, last = int(edges[column]), int(edges[column + 1])
                taken = slice(int(places[column]), int(places[column]) + count * (last - first))
                of_column, row_of = (array[taken].reshape(count, last - first) for array in (data, indices))
                for entry in range(first, last):
                    of_column[:, entry - first] = values[entry - edges[begun]]
                    np.add(tops, rows[entry], out=row_of[:, entry - first])
            begun = ended

    return _Part(count * np.diff(edges), write)


def _short(family: LMIFamily, start: int, width: int) -> _Part:
    """Few LMIs, or little of the pattern in each: a sparse product, sorted."""
    lmi, length = family.lmi, svec.length(family.lmi.order)
    product = (sps.csr_array(family.weights) @ _weighed(family)).tocoo()
    number, entry = product.coords
    places = (start + length * number.astype(np.int64) + lmi.rows[entry], lmi.columns[entry])
    part = sps.coo_array((product.data, places), shape=(start + length * len(family), width)).tocsc()
    counts = np.diff(part.indptr).astype(np.int64)

    def write(data: Array, indices: Array, places: Array) -> None:
        target = np.repeat(places - part.indptr[:-1], counts) + np.arange(part.nnz)
        data[target], indices[target] = part.data, part.indices

    return _Part(counts, write)
