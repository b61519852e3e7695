"""SDPA sparse format (.dat-s), which SDPA, CSDP, SDPT3 and the problems of SDPLIB share.

    minimise Σ c_i x_i   subject to   Σ x_i F_i − F_0 ⪰ 0

After comments, lines that begin with " or *, come the number of unknowns, the number of blocks and
their orders, negative for a diagonal block, and c. Then each line is an entry of one triangle:
matrix, block, row, column, value, counted from 1; matrix 0 is F_0. The characters , ( ) { } mean a space.
F_0 is the negative of our constant matrix. A diagonal block becomes LMIs of order 1.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.errors import FormatError
from lmic.interchange.sdp import MAX_LMIS, MAX_UNKNOWNS, SDP, check_sizes, sdp_of_entries
from lmic.interchange.text import decoded, integers, is_number, note_lines, notes_of, shown, table

Array: TypeAlias = NDArray[Any]

_PUNCTUATION = str.maketrans(",(){}", "     ")
_COMMENTS = ('"', "*")


def write_sdpa(sdp: SDP) -> bytes:
    """The file's content; numbers with all their digits."""
    return ("\n".join(_lines(sdp)) + "\n").encode()


def _lines(sdp: SDP) -> Iterator[str]:
    yield from (f'"{text}' for text in note_lines(sdp))
    yield str(sdp.size)
    yield str(len(sdp.orders))
    yield " ".join(map(str, sdp.orders.tolist()))
    yield " ".join(map(repr, sdp.cost.tolist()))
    e = sdp.entries
    signed = np.where(e.unknown == 0, -e.value, e.value)
    indices = (e.unknown, e.lmi + 1, e.row + 1, e.column + 1)
    for matrix, block, row, column, value in zip(*(part.tolist() for part in (*indices, signed)), strict=True):
        yield f"{matrix} {block} {row} {column} {value!r}"


def read_sdpa(content: bytes) -> SDP:
    """The program of a file's content; raises FormatError with the line that is wrong."""
    lines = decoded(content).splitlines()
    comments = 0
    while comments < len(lines) and (not lines[comments].strip() or lines[comments].lstrip().startswith(_COMMENTS)):
        comments += 1
    notes, constant, maximised = notes_of([text.strip()[1:] for text in lines[:comments]])
    reader = _Reader(lines, comments)
    size = reader.count("the number of unknowns", MAX_UNKNOWNS)
    blocks = reader.count("the number of blocks", MAX_LMIS)
    orders = integers(reader.numbers(blocks, "the orders of the blocks"), "the order of a block")
    if not orders.all():
        raise FormatError("has a block of order 0; every block has a row")
    # a diagonal block is as many LMIs of order 1
    counts = np.where(orders < 0, -orders, 1)
    if counts.sum() > MAX_LMIS:
        raise FormatError(f"has {counts.sum()} LMIs and diagonal entries; lmic takes up to {MAX_LMIS}")
    expanded = np.repeat(np.where(orders < 0, 1, orders), counts)
    check_sizes(size, expanded)
    cost = reader.numbers(size, "the objective")
    entries = table(
        [text.translate(_PUNCTUATION) for text in lines[reader.position :]],
        5,
        reader.position + 1,
        "matrix, block, row, column and value",
    )
    unknown, block, row, column = (integers(entries[:, k], "an index") for k in range(4))
    inside = (block >= 1) & (block <= blocks)
    if not inside.all():
        raise FormatError(f"an entry belongs to block {block[~inside][0]} of {blocks}; correct the entry")
    diagonal = orders[block - 1] < 0
    off = diagonal & (row != column)
    if off.any():
        place = f"({row[off][0]},{column[off][0]})"
        raise FormatError(f"an entry at {place} stands off the diagonal of the diagonal block {block[off][0]}; drop it")
    beyond = diagonal & ((row < 1) | (row > counts[block - 1]))
    if beyond.any():
        raise FormatError(f"an entry stands in row {row[beyond][0]}, outside its diagonal block; correct it")
    lmi = (np.cumsum(counts) - counts)[block - 1] + np.where(diagonal, row - 1, 0)
    row, column = np.where(diagonal, 0, row - 1), np.where(diagonal, 0, column - 1)
    value = np.where(unknown == 0, -entries[:, 4], entries[:, 4])
    return sdp_of_entries(cost, constant, expanded, (unknown, lmi, row, column, value), notes, maximised)


class _Reader:
    """The lines before the entries; ``position`` is the line that comes next, from 0."""

    def __init__(self, lines: list[str], position: int) -> None:
        self.lines, self.position = lines, position

    def count(self, what: str, most: int) -> int:
        """A line that begins with a whole number, whatever follows."""
        words = self._line(what).translate(_PUNCTUATION).split()
        if not words or not (words[0].isascii() and words[0].isdecimal()) or not 0 < int(words[0][:20]) <= most:
            text = shown(self.lines[self.position - 1])
            raise FormatError(f"line {self.position}, '{text}', is not {what}, from 1 to {most}; correct it")
        return int(words[0])

    def numbers(self, count: int, what: str) -> Array:
        """So many numbers, on one line or several; words after the last are a remark."""
        found: list[str] = []
        while len(found) < count:
            words = self._line(what).translate(_PUNCTUATION).split()
            end = next((k for k, word in enumerate(words) if not is_number(word)), len(words))
            found += words[:end]
            if len(found) > count or (end < len(words) and len(found) < count) or (not end and words):
                raise FormatError(
                    f"line {self.position}, '{shown(self.lines[self.position - 1])}', does not hold {what}, "
                    f"{count} numbers; correct it"
                )
        return np.array(found, dtype=float)

    def _line(self, what: str) -> str:
        if self.position >= len(self.lines):
            raise FormatError(f"ends before {what}; the file is not complete")
        self.position += 1
        return self.lines[self.position - 1]
