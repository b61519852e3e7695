"""A semidefinite program as files hold it: the one record that every format is written from and read into.

    minimise cost·x + constant   subject to   F_k(x) = F_k0 + Σ_i x_i F_ki ⪰ 0  for every LMI k.

Entries are kept as they are, without the √2 of svec, so that a file gives back the numbers that were
written, bit for bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.compiler.assemble import ConicProblem
from lmic.errors import FormatError

Array: TypeAlias = NDArray[Any]

#: what a file says of its soundness that says nothing
NOT_STATED = "not stated"
#: unknowns, LMIs and packed rows of all LMIs together that a file may have: some of SDPLIB's have 2.5e7 rows
MAX_UNKNOWNS, MAX_LMIS, MAX_ROWS = 10**6, 10**6, 3 * 10**7
#: characters of a note that stands in a comment of one line
MAX_NOTE = 400


@dataclass(frozen=True, eq=False)
class Entries:
    """Nonzero numbers of the upper triangles: ``value[e]`` stands in F_ki, k = lmi[e], at (row[e], column[e]).

    ``unknown`` is i, 0 for the constant matrix; ``lmi``, ``row`` and ``column`` count from 0.
    Sorted by unknown, LMI, column, row.
    """

    unknown: Array
    lmi: Array
    row: Array
    column: Array
    value: Array

    def __len__(self) -> int:
        return len(self.value)


@dataclass(frozen=True)
class Notes:
    """What a file says beside its numbers: names of unknowns and LMIs, empty where it gives none.

    ``soundness`` is what a solution of the LMIs says of the theorem on its whole domain.
    """

    title: str = ""
    soundness: str = NOT_STATED
    unknowns: tuple[str, ...] = ()
    lmis: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class SDP:
    """minimise cost·x + constant subject to the LMIs of ``entries``, of the given ``orders``.

    ``maximised`` says that the file asks for the maximum of −cost·x − constant, and its value is that.
    Make one with :func:`~lmic.interchange.sdp.sdp_of_problem` or :func:`~lmic.interchange.sdp.sdp_of_entries`, which
    check and sort.
    """

    cost: Array
    constant: float
    orders: Array
    entries: Entries
    notes: Notes = field(default_factory=Notes)
    maximised: bool = False

    @property
    def size(self) -> int:
        """Number of scalar unknowns."""
        return len(self.cost)

    @cached_property
    def starts(self) -> Array:
        """First packed row of each LMI, and the number of rows at the end."""
        return np.concatenate([[0], np.cumsum(self.orders * (self.orders + 1) // 2)])

    @cached_property
    def columns(self) -> sps.csc_array:
        """svec of all LMIs: column 0 the constant, column i the coefficient of x[i - 1]."""
        e = self.entries
        rows = self.starts[e.lmi] + svec.packed_index(e.row, e.column)
        weighted = e.value * np.where(e.row == e.column, 1.0, np.sqrt(2.0))
        return sps.coo_array((weighted, (rows, e.unknown)), shape=(int(self.starts[-1]), self.size + 1)).tocsc()

    @property
    def matrix(self) -> sps.csc_array:
        """Columns of the unknowns, rows svec of all LMIs."""
        return self.columns[:, 1:]

    @property
    def offset(self) -> Array:
        """svec of all LMIs at x = 0."""
        return self.columns[:, [0]].toarray().ravel()

    def label(self, index: int) -> str:
        """Name of the LMI number ``index``, counted from 0."""
        return self.notes.lmis[index] if self.notes.lmis else f"LMI {index + 1}"

    def name(self, column: int) -> str:
        """Name of the unknown x[column]."""
        return self.notes.unknowns[column] if self.notes.unknowns else f"x{column + 1}"

    def vectorised(self) -> sps.csc_array:
        """vec of all LMIs, every entry of every matrix: column 0 the constant, column i that of x[i - 1].

        Shape (Σ orders², size + 1); symmetric, so that rows or columns may come first.
        """
        e = self.entries
        starts = np.concatenate([[0], np.cumsum(self.orders**2)])
        upper = starts[e.lmi] + e.column * self.orders[e.lmi] + e.row
        lower = starts[e.lmi] + e.row * self.orders[e.lmi] + e.column
        off = e.row != e.column
        rows, cols = np.concatenate([upper, lower[off]]), np.concatenate([e.unknown, e.unknown[off]])
        values = np.concatenate([e.value, e.value[off]])
        return sps.coo_array((values, (rows, cols)), shape=(int(starts[-1]), self.size + 1)).tocsc()


def sdp_of_problem(problem: ConicProblem) -> SDP:
    """A compiled problem as files hold it, with its names, labels and soundness."""
    unknown, lmi, packed, value = [], [], [], []
    first = 0
    for family in problem.families:
        pattern, count = family.lmi, len(family)
        unknown.append(np.tile(pattern.columns, count))
        packed.append(np.tile(pattern.rows, count))
        lmi.append(np.repeat(np.arange(first, first + count), len(pattern.rows)))
        value.append(family.values.ravel())
        first += count
    column = _column(np.concatenate(packed))
    row = np.concatenate(packed) - svec.packed_index(np.zeros_like(column), column)
    theorem, binding = problem.binding.theorem, problem.binding
    given = "".join(f", {symbol.name} = {number:.17g}" for symbol, number in binding.values.items())
    notes = Notes(
        title=f"{theorem.name}: {theorem.title}; plant {binding.plant.name}{given}",
        soundness=problem.soundness.value,
        unknowns=tuple(problem.layout.label(k) for k in range(problem.size)),
        lmis=tuple(
            ", ".join([family.lmi.place.lmi, *family.label(k)])
            for family in problem.families
            for k in range(len(family))
        ),
    )
    entries = (np.concatenate(unknown), np.concatenate(lmi), row, column, np.concatenate(value))
    return sdp_of_entries(problem.cost, problem.constant, problem.orders, entries, notes)


def sdp_of_entries(
    cost: Array,
    constant: float,
    orders: Array,
    entries: Sequence[Array],
    notes: Notes | None = None,
    maximised: bool = False,
) -> SDP:
    """A program from its parts; ``entries`` are (unknown, lmi, row, column, value) of either triangle.

    Raises FormatError where a number is not finite, an index is outside, or an entry occurs twice.
    """
    orders = np.asarray(orders, dtype=np.int64)
    check_sizes(len(cost), orders)
    unknown, lmi, row, column = (np.asarray(part, dtype=np.int64) for part in entries[:4])
    value = np.asarray(entries[4], dtype=float)
    if not (np.isfinite(value).all() and np.isfinite(cost).all() and np.isfinite(constant)):
        raise FormatError("a number is not finite; correct it")
    for what, index, bound in (("unknown", unknown, len(cost) + 1), ("LMI", lmi, len(orders))):
        if ((index < 0) | (index >= bound)).any():
            raise FormatError(f"an entry belongs to no {what} of the file's; correct the sizes or the entry")
    outside = (np.minimum(row, column) < 0) | (np.maximum(row, column) >= orders[lmi])
    if outside.any():
        e = int(np.argmax(outside))
        raise FormatError(
            f"an entry of LMI {lmi[e] + 1} stands at ({row[e] + 1},{column[e] + 1}), outside its "
            f"{orders[lmi[e]]} rows and columns; correct one"
        )
    row, column = np.minimum(row, column), np.maximum(row, column)
    order = np.lexsort((row, column, lmi, unknown))
    order = order[value[order] != 0]
    found = Entries(unknown[order], lmi[order], row[order], column[order], value[order])
    same = np.ones(max(len(found) - 1, 0), dtype=bool)
    for part in (found.unknown, found.lmi, found.row, found.column):
        same &= part[1:] == part[:-1]
    if same.any():
        e = int(np.argmax(same))
        raise FormatError(
            f"the entry ({found.row[e] + 1},{found.column[e] + 1}) of LMI {found.lmi[e] + 1}, matrix "
            f"{found.unknown[e]}, is given twice (a triangle is enough); keep one"
        )
    tidy = _tidy(notes, len(cost), len(orders))
    # a zero has no sign in most formats
    return SDP(np.asarray(cost, dtype=float) + 0.0, float(constant) + 0.0, orders, found, tidy, maximised)


def check_sizes(unknowns: int, orders: Array) -> None:
    """Refuse, before any memory is taken, what no file of use holds."""
    if not 0 < unknowns <= MAX_UNKNOWNS:
        raise FormatError(f"has {unknowns} unknowns; lmic takes from 1 to {MAX_UNKNOWNS}")
    if not 0 < len(orders) <= MAX_LMIS:
        raise FormatError(f"has {len(orders)} LMIs; lmic takes from 1 to {MAX_LMIS}")
    sizes = np.asarray(orders, dtype=float)
    if (sizes < 1).any():
        raise FormatError("has an LMI without rows; every order is at least 1")
    if (sizes * (sizes + 1) / 2).sum() > MAX_ROWS:
        raise FormatError(f"has LMIs of more than {MAX_ROWS} entries together; lmic takes no more")


def _tidy(notes: Notes | None, unknowns: int, lmis: int) -> Notes:
    """Notes of one line each; names only where there is one for each."""
    notes = notes or Notes()
    names = [tuple(map(line, given)) for given in (notes.unknowns, notes.lmis)]
    kept = [
        given if len(given) == count and any(given) else ()
        for given, count in zip(names, (unknowns, lmis), strict=True)
    ]
    return Notes(line(notes.title), line(notes.soundness) or NOT_STATED, *kept)


def line(text: str) -> str:
    """A text as one line that fits a comment."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())[:MAX_NOTE].rstrip()


def _column(packed: Array) -> Array:
    """Column of each packed index, upper triangle column by column."""
    column = ((np.sqrt(8.0 * packed + 1) - 1) / 2).astype(np.int64)
    column += (column + 1) * (column + 2) // 2 <= packed
    return column - (column * (column + 1) // 2 > packed)
