"""Conic Benchmark Format (.cbf), version 3: what of it is linear matrix inequalities.

    minimise Σ a_j x_j + b   subject to   Σ x_j H_kj + D_k ⪰ 0  for every k,   and linear inequalities.

A file is keywords, each on a line of its own, with the lines that belong to it; # begins a comment,
indices count from 0, and of symmetric matrices the lower triangle is given. lmic writes VAR (free), PSDCON
with HCOORD and DCOORD, and LMIs of order 1 as CON (nonnegative) with ACOORD and BCOORD, since not every
program takes matrices of order 1. It reads variables and rows that are free, nonnegative or nonpositive.
Equalities, other cones, matrix variables and integers are refused by name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.errors import FormatError
from lmic.interchange.sdp import MAX_LMIS, MAX_UNKNOWNS, SDP, check_sizes, sdp_of_entries
from lmic.interchange.text import decoded, integers, is_number, note_lines, notes_of, shown, table

Array: TypeAlias = NDArray[Any]

#: versions that are read; they differ in cones that lmic does not take
_VERSIONS = (1, 2, 3, 4)
#: a comment: the number that each LMI has, matrices first and rows after them, where that is not their order
_PLACES, _PLACES_IN_LINE = "# numbers of the LMIs: ", 40
_REFUSED: Mapping[str, str] = {
    "PSDVAR": "matrix variables",
    "INT": "integer variables",
    "POWCONES": "power cones",
    "POW*CONES": "power cones",
    "OBJFCOORD": "matrix variables",
    "FCOORD": "matrix variables",
    "CHANGE": "several problems",
}
#: sign of a linear cone's rows, 0 where they are free
_SIGNS: Mapping[str, int] = {"F": 0, "L+": 1, "L-": -1}


def write_cbf(sdp: SDP) -> bytes:
    """The file's content; numbers with all their digits. LMIs of order 1 are rows, after the others."""
    return ("\n".join(_lines(sdp)) + "\n").encode()


def _lines(sdp: SDP) -> Iterator[str]:
    single = sdp.orders == 1
    matrices, rows = np.flatnonzero(~single), np.flatnonzero(single)
    places = np.concatenate([matrices, rows])
    yield from (f"# {text}" for text in note_lines(sdp))
    if (np.diff(places) < 0).any():
        for start in range(0, len(places), _PLACES_IN_LINE):
            yield _PLACES + " ".join(map(str, (1 + places[start : start + _PLACES_IN_LINE]).tolist()))
    sign = -1.0 if sdp.maximised else 1.0
    yield from ("VER", "3", "", "OBJSENSE", "MAX" if sdp.maximised else "MIN", "")
    yield from ("VAR", f"{sdp.size} 1", f"F {sdp.size}", "")
    if len(matrices):
        yield from ("PSDCON", str(len(matrices)), *map(str, sdp.orders[matrices].tolist()), "")
    if len(rows):
        yield from ("CON", f"{len(rows)} 1", f"L+ {len(rows)}", "")
    used = np.flatnonzero(sdp.cost)
    yield from _section("OBJACOORD", used, sign * sdp.cost[used])
    yield from ("OBJBCOORD", repr(sign * sdp.constant), "")
    e = sdp.entries
    constant, row = e.unknown == 0, single[e.lmi]
    number = np.empty(len(places), dtype=np.int64)
    number[places] = np.where(single[places], np.arange(len(places)) - len(matrices), np.arange(len(places)))
    lmi, unknown, value = number[e.lmi], e.unknown - 1, e.value
    linear, constants = row & ~constant, row & constant
    yield from _section("ACOORD", lmi[linear], unknown[linear], value[linear])
    yield from _section("BCOORD", lmi[constants], value[constants])
    linear, constants = ~row & ~constant, ~row & constant
    yield from _section("HCOORD", lmi[linear], unknown[linear], e.column[linear], e.row[linear], value[linear])
    yield from _section("DCOORD", lmi[constants], e.column[constants], e.row[constants], value[constants])


def _section(name: str, *columns: Array) -> Iterator[str]:
    """A keyword and its entries, where it has any."""
    if len(columns[0]):
        yield from (name, str(len(columns[0])))
        for *indices, value in zip(*(column.tolist() for column in columns), strict=True):
            yield " ".join([*map(str, indices), repr(value)])
        yield ""


@dataclass
class _Content:
    """What was read so far."""

    maximised: bool | None = None
    variables: Array | None = None  # sign of each
    rows: Array = field(default_factory=lambda: np.zeros(0, dtype=int))  # sign of each
    orders: Array = field(default_factory=lambda: np.zeros(0, dtype=int))
    tables: dict[str, Array] = field(default_factory=dict)
    constant: float = 0.0


def read_cbf(content: bytes) -> SDP:
    """The program of a file's content; raises FormatError with the line that is wrong."""
    lines = decoded(content).splitlines()
    notes, *_ = notes_of([text.lstrip()[1:] for text in lines if text.lstrip().startswith("#")])
    reader, found, seen = _Reader(lines), _Content(), set[str]()
    while (keyword := reader.keyword()) is not None:
        if keyword in seen:
            raise FormatError(f"line {reader.position} begins {keyword} again; keep one")
        seen.add(keyword)
        if keyword in _REFUSED:
            raise FormatError(f"has {_REFUSED[keyword]} ({keyword}), which lmic does not take; use another solver")
        if keyword not in _SECTIONS:
            raise FormatError(f"line {reader.position}, '{shown(keyword)}', is no keyword of the format; correct it")
        _SECTIONS[keyword](reader, found)
    if "VER" not in seen:
        raise FormatError("states no version; a file begins with VER and 3")
    if found.variables is None or found.maximised is None:
        missing = "variables (VAR)" if found.variables is None else "sense of the objective (OBJSENSE)"
        raise FormatError(f"states no {missing}; the file is not complete")
    size = len(found.variables)
    entries = [*_matrices(found), *_linear(found, size)]
    orders = np.concatenate([found.orders, np.ones(_count(found), dtype=int)])
    check_sizes(size, orders)
    sign = -1.0 if found.maximised else 1.0
    cost = np.zeros(size)
    objective = found.tables.get("OBJACOORD", np.zeros((0, 2)))
    places = _indices(objective[:, 0], size, "a variable in OBJACOORD")
    if len(np.unique(places)) < len(places):
        raise FormatError("OBJACOORD gives a variable twice; keep one")
    cost[places] = sign * objective[:, 1]
    stacked = [np.concatenate([entry[k] for entry in entries]) for k in range(5)]
    places = _places(lines, len(orders))
    stacked[1], orders = places[stacked[1]], orders[np.argsort(places)]
    return sdp_of_entries(cost, sign * found.constant, orders, stacked, notes, found.maximised)


def _places(lines: list[str], count: int) -> Array:
    """The number of each LMI from 0, as lmic's comments say, or as they stand."""
    words = " ".join(text.removeprefix(_PLACES) for text in lines if text.startswith(_PLACES)).split()
    if all(word.isascii() and word.isdecimal() for word in words) and len(words) == count:
        places = np.array([int(word[:20]) for word in words], dtype=object) - 1
        if sorted(places) == list(range(count)):
            return places.astype(np.int64)
    return np.arange(count)


def _matrices(found: _Content) -> Sequence[Sequence[Array]]:
    """Entries of the matrix inequalities: (unknown, lmi, row, column, value)."""
    coefficients = found.tables.get("HCOORD", np.zeros((0, 5)))
    constants = found.tables.get("DCOORD", np.zeros((0, 4)))
    size = 0 if found.variables is None else len(found.variables)
    parts = []
    for values, name in ((coefficients, "HCOORD"), (constants, "DCOORD")):
        lmi = _indices(values[:, 0], len(found.orders), f"a matrix inequality in {name}")
        if name == "HCOORD":
            unknown = 1 + _indices(values[:, 1], size, "a variable in HCOORD")
        else:
            unknown = np.zeros(len(values), dtype=np.int64)
        row, column = (integers(values[:, k], f"an index in {name}") for k in (-3, -2))
        parts.append((unknown, lmi, row, column, values[:, -1]))
    return parts


def _linear(found: _Content, size: int) -> Sequence[Sequence[Array]]:
    """Entries of the linear inequalities, LMIs of order 1 after the others: signed variables, then rows."""
    assert found.variables is not None
    signed, rows = np.flatnonzero(found.variables), np.flatnonzero(found.rows)
    first = len(found.orders)
    place = np.full(len(found.rows), -1, dtype=np.int64)
    place[rows] = first + len(signed) + np.arange(len(rows))
    zeros = np.zeros(len(signed), dtype=np.int64)
    parts = [(signed + 1, first + np.arange(len(signed)), zeros, zeros, found.variables[signed].astype(float))]
    for name, width in (("ACOORD", 3), ("BCOORD", 2)):
        values = found.tables.get(name, np.zeros((0, width)))
        row = _indices(values[:, 0], len(found.rows), f"a row in {name}")
        unknown = 1 + _indices(values[:, 1], size, f"a variable in {name}") if width == 3 else np.zeros_like(row)
        used = place[row] >= 0
        zeros = np.zeros(int(used.sum()), dtype=np.int64)
        parts.append((unknown[used], place[row][used], zeros, zeros, (found.rows[row] * values[:, -1])[used]))
    return parts


def _count(found: _Content) -> int:
    assert found.variables is not None
    return int(np.count_nonzero(found.variables) + np.count_nonzero(found.rows))


def _indices(values: Array, count: int, what: str) -> Array:
    indices = integers(values, what)
    outside = (indices < 0) | (indices >= count)
    if outside.any():
        raise FormatError(f"{indices[outside][0]} stands where {what} should, of which there are {count}; correct it")
    return indices


# Sections -----------------------------------------------------------------------------------------------


class _Reader:
    """Lines without comments and blank ones; ``position`` is the number of the last one read."""

    def __init__(self, lines: list[str]) -> None:
        self.lines = [
            (k, text) for k, text in enumerate(lines, 1) if text.strip() and not text.lstrip().startswith("#")
        ]
        self.next = 0

    @property
    def position(self) -> int:
        return self.lines[self.next - 1][0] if self.next else 1

    def keyword(self) -> str | None:
        """The next line, which should be a keyword; None at the end."""
        if self.next >= len(self.lines):
            return None
        self.next += 1
        return self.lines[self.next - 1][1].strip()

    def words(self, count: int, what: str) -> list[str]:
        """The words of the next line."""
        if self.next >= len(self.lines):
            raise FormatError(f"ends before {what}; the file is not complete")
        self.next += 1
        number, text = self.lines[self.next - 1]
        words = text.split()
        if len(words) != count:
            raise FormatError(f"line {number}, '{shown(text)}', is not {what}; correct it")
        return words

    def count(self, word: str, what: str, most: int) -> int:
        """A whole number from 0."""
        if not (word.isascii() and word.isdecimal()) or int(word[:20]) > most:
            raise FormatError(f"line {self.position}: '{shown(word)}' is not {what}, up to {most}; correct it")
        return int(word)

    def table(self, width: int, what: str) -> Array:
        """A number of lines, and so many lines of numbers."""
        (word,) = self.words(1, f"the number of entries of {what}")
        count = self.count(word, f"the number of entries of {what}", len(self.lines))
        taken = self.lines[self.next : self.next + count]
        if len(taken) < count:
            raise FormatError(f"ends before the {count} entries of {what}; the file is not complete")
        self.next += count
        return table([text for _, text in taken], width, taken[0][0] if taken else 0, f"an entry of {what}")


def _version(reader: _Reader, _: _Content) -> None:
    (word,) = reader.words(1, "the version of the format")
    if word not in map(str, _VERSIONS):
        raise FormatError(f"is of version '{shown(word)}' of the format; lmic reads {', '.join(map(str, _VERSIONS))}")


def _sense(reader: _Reader, found: _Content) -> None:
    (word,) = reader.words(1, "MIN or MAX")
    if word not in ("MIN", "MAX"):
        raise FormatError(f"line {reader.position}: '{shown(word)}' is not MIN or MAX; correct it")
    found.maximised = word == "MAX"


def _cones(reader: _Reader, what: str) -> Array:
    """Sign of each of the variables or rows."""
    total, number = reader.words(2, f"the number of {what} and of their cones")
    most = {"variables": MAX_UNKNOWNS, "rows": MAX_LMIS}[what]
    count, cones = reader.count(total, f"the number of {what}", most), reader.count(number, "a number of cones", most)
    signs, lengths = [], []
    for _ in range(cones):
        cone, length = reader.words(2, f"a cone of {what} and its size")
        if cone not in _SIGNS:
            advice = "eliminate them" if cone == "L=" else "use another solver"
            raise FormatError(
                f"line {reader.position}: {what} in the cone '{shown(cone)}' are not linear inequalities, "
                f"which is all that lmic takes beside matrix inequalities; {advice}"
            )
        signs.append(_SIGNS[cone])
        lengths.append(reader.count(length, "the size of a cone", most))
    if sum(lengths) != count:
        raise FormatError(f"the cones of the {what} hold {sum(lengths)} where there are {count}; correct one")
    return np.repeat(np.array(signs, dtype=int), lengths)


def _variables(reader: _Reader, found: _Content) -> None:
    found.variables = _cones(reader, "variables")


def _rows(reader: _Reader, found: _Content) -> None:
    found.rows = _cones(reader, "rows")


def _orders(reader: _Reader, found: _Content) -> None:
    (word,) = reader.words(1, "the number of matrix inequalities")
    count = reader.count(word, "the number of matrix inequalities", min(MAX_LMIS, len(reader.lines)))
    orders = [reader.words(1, "the order of a matrix inequality")[0] for _ in range(count)]
    found.orders = np.array([reader.count(word, "an order", 10**6) for word in orders], dtype=int)


def _constant(reader: _Reader, found: _Content) -> None:
    (word,) = reader.words(1, "the constant of the objective")
    if not is_number(word):
        raise FormatError(f"line {reader.position}: '{shown(word)}' is no number; correct it")
    found.constant = float(word)


def _table(name: str, width: int) -> Callable[[_Reader, _Content], None]:
    def read(reader: _Reader, found: _Content) -> None:
        found.tables[name] = reader.table(width, name)

    return read


_WIDTHS = {"OBJACOORD": 2, "ACOORD": 3, "BCOORD": 2, "HCOORD": 5, "DCOORD": 4}
_SECTIONS: Mapping[str, Callable[[_Reader, _Content], None]] = {
    "VER": _version,
    "OBJSENSE": _sense,
    "VAR": _variables,
    "CON": _rows,
    "PSDCON": _orders,
    "OBJBCOORD": _constant,
    **{name: _table(name, width) for name, width in _WIDTHS.items()},
}
