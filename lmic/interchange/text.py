"""What the text formats share: numbers with all their digits, notes in comments, and tables of entries."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from io import StringIO
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.errors import FormatError
from lmic.interchange.sdp import SDP, Notes

Array: TypeAlias = NDArray[Any]

#: characters of a file's line that an error shows
SHOWN = 60
#: the only lines of notes that are read back
_TITLE, _SOUNDNESS, _CONSTANT, _SENSE = "title", "soundness", "constant of the objective", "sense"
_UNKNOWN, _LMI = "unknown", "LMI"
_MAXIMISED = "the negative is maximised"


def decoded(content: bytes) -> str:
    """A file's text; comments of other programs may be in any encoding."""
    if b"\0" in content:
        raise FormatError("is not a text; give a file in this format")
    return content.decode("utf-8", errors="replace")


def note_lines(sdp: SDP) -> Iterator[str]:
    """Title, soundness, names: the lines of a file's comments."""
    notes = sdp.notes
    yield f"{_TITLE}: {notes.title}"
    yield f"{_SOUNDNESS}: {notes.soundness}"
    yield f"{_CONSTANT}: {sdp.constant!r}"
    if sdp.maximised:
        yield f"{_SENSE}: {_MAXIMISED}"
    for what, names in ((_UNKNOWN, notes.unknowns), (_LMI, notes.lmis)):
        yield from (f"{what} {number}: {name}" for number, name in enumerate(names, 1))


def notes_of(lines: Sequence[str]) -> tuple[Notes, float, bool]:
    """Notes, the objective's constant and whether it is maximised, from comments; others' lines mean nothing."""
    texts: dict[str, str] = {}
    names: dict[str, list[str]] = {_UNKNOWN: [], _LMI: []}
    for text in lines:
        key, separator, value = (part.strip() for part in text.partition(":"))
        what, _, number = key.partition(" ")
        if separator and key in (_TITLE, _SOUNDNESS, _CONSTANT, _SENSE):
            texts[key] = value
        elif separator and what in names and number == str(len(names[what]) + 1):
            names[what].append(value)
    try:
        constant = float(texts.get(_CONSTANT, 0.0))
    except ValueError:
        constant = 0.0
    notes = Notes(texts.get(_TITLE, ""), texts.get(_SOUNDNESS, ""), tuple(names[_UNKNOWN]), tuple(names[_LMI]))
    return notes, constant, texts.get(_SENSE) == _MAXIMISED


def table(lines: Sequence[str], width: int, first: int, what: str) -> Array:
    """Lines of ``width`` numbers each, as an array; ``first`` is the number of the first line in the file."""
    if not lines:
        return np.zeros((0, width))
    try:
        found = np.loadtxt(StringIO("\n".join(lines)), ndmin=2, comments=None)
    except ValueError:
        found = None
    # blank lines are skipped, so that the number of rows tells nothing
    if found is not None and found.shape[1] == width:
        return found
    for number, text in enumerate(lines, first):
        words = text.split()
        if words and (len(words) != width or not all(map(is_number, words))):
            raise FormatError(f"line {number}, '{shown(text)}', does not hold {width} numbers, {what}; correct it")
    raise FormatError(f"the lines from {first} on do not hold {width} numbers each, {what}; correct them")


def integers(values: Array, what: str) -> Array:
    """Indices among numbers that were read as such."""
    wrong = (values != np.rint(values)) | ~(np.abs(values) < 2**53)
    if wrong.any():
        raise FormatError(f"{values[wrong][0]:g} stands where {what} should, which is a whole number; correct it")
    return values.astype(np.int64)


def is_number(word: str) -> bool:
    """Whether a word is a decimal number."""
    try:
        float(word)
    except ValueError:
        return False
    return "_" not in word


def shown(text: str) -> str:
    """A line as an error shows it."""
    text = "".join(c if c.isprintable() else "?" for c in text.strip())
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}…"
