"""MATLAB files (.mat) in SeDuMi's form: At, b, c and the cone K, as SeDuMi, SDPT3 and MOSEK's toolbox take them.

    maximise bᵀy   subject to   c − At·y in K

K.s are the orders of the matrices, which stand in c and in the columns of At with all their entries,
column by column. Our unknowns are y, b is −cost, and c and −At hold F_0 and F_i. A structure ``lmic``
beside them holds the objective's constant, names and soundness. K.l, linear inequalities, is read too
and becomes LMIs of order 1; of a matrix that is not symmetric the symmetric part counts, as for SeDuMi.
K.f (equalities), K.q and K.r (second-order cones) are refused.

Files are written by scipy. They are read here: scipy's reader can crash on a damaged file.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from io import BytesIO
from typing import Any, TypeAlias, cast

import numpy as np
import scipy.io
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.errors import FormatError, PlantError
from lmic.interchange.sdp import SDP, Notes, check_sizes, line, sdp_of_entries
from lmic.interchange.text import integers, shown
from lmic.plants.expressions import quoted
from lmic.plants.matlab import ARRAY, byte_order, elements, numbers, stored_arrays, text

Array: TypeAlias = NDArray[Any]

#: bytes of a file once unpacked
MAX_UNPACKED = 2**29
_TITLE_BYTES = 116  # of a file's header
_STRUCT, _TEXT, _SPARSE = 2, 4, 5
_NUMERIC = range(6, 16)
_COMPLEX = 0x08
_REFUSED_CONES: Mapping[str, str] = {
    "f": "equalities (K.f); eliminate them",
    "q": "second-order cones (K.q); write them as LMIs",
    "r": "rotated second-order cones (K.r); write them as LMIs",
}


def write_mat(sdp: SDP) -> bytes:
    """The file's content, of MATLAB's version 5 to 7."""
    full = sdp.vectorised()
    notes = sdp.notes
    words = {
        "constant": sdp.constant,
        "maximised": float(sdp.maximised),
        "title": notes.title,
        "soundness": notes.soundness,
        "unknowns": "\n".join(notes.unknowns),
        "lmis": "\n".join(notes.lmis),
    }
    file = BytesIO()
    scipy.io.savemat(
        cast(Any, file),
        {
            "At": sps.csc_matrix(-full[:, 1:]),
            "b": -sdp.cost[:, None],
            "c": sps.csc_matrix(full[:, [0]]),
            "K": {"s": sdp.orders[None, :].astype(float)},
            "lmic": words,
        },
        do_compression=True,
    )
    # the header holds the soundness too, and not the date: equal problems make equal files
    title = f"MATLAB 5.0 MAT-file, SeDuMi's At b c K, soundness {notes.soundness}; {notes.title}"
    header = title.encode("ascii", "replace")[:_TITLE_BYTES].ljust(_TITLE_BYTES)
    return header + file.getvalue()[_TITLE_BYTES:]


def read_mat(content: bytes) -> SDP:
    """The program of a file's content; raises FormatError saying what is wrong."""
    try:
        order = byte_order(content)
        arrays = dict(_array(data, order) for data in stored_arrays(content, order, MAX_UNPACKED))
    except FormatError:
        raise
    except PlantError as error:
        raise FormatError(str(error)) from error
    except Exception as error:
        raise FormatError(f"is damaged ({shown(str(error))}); save it again with the option -v7") from error
    return _program(arrays)


# From SeDuMi's form ---------------------------------------------------------------------------------------


def _program(arrays: Mapping[str, Any]) -> SDP:
    cone = arrays.get("K")
    if not isinstance(cone, dict):
        raise FormatError("has no structure K; SeDuMi's form is At (or A), b, c and K")
    for name, what in _REFUSED_CONES.items():
        if name in cone and np.any(_vector(cone[name], f"K.{name}")):
            raise FormatError(f"has {what}; rewrite these as LMIs")
    linear = _sizes(cone.get("l"), "K.l")
    if len(linear) > 1:
        raise FormatError("K.l is not one number; it is the number of linear inequalities")
    orders = _sizes(cone.get("s"), "K.s")
    orders = orders[orders > 0]
    count = int(linear.sum())
    b = _vector(arrays.get("b"), "b")
    check_sizes(len(b), np.concatenate([np.ones(min(count, 10**7), dtype=int), orders]))
    total = count + int((orders**2).sum())
    c = _matrix(arrays.get("c"), "c")
    if 1 not in c.shape or max(c.shape) != total:
        raise FormatError(f"c is {c.shape[0]} x {c.shape[1]} where the cone K has {total} entries; correct one")
    columns = _matrix(arrays.get("At", arrays.get("A")), "At")
    # either may be given either way round, which is doubtful where it is square
    if columns.shape == (len(b), total) and ("At" not in arrays or len(b) != total):
        columns = columns.T
    if columns.shape != (total, len(b)):
        raise FormatError(
            f"At is {columns.shape[0]} x {columns.shape[1]} where K has {total} entries and b has {len(b)}; correct one"
        )
    stacked = sps.coo_array(sps.hstack([c.reshape(-1, 1) if c.shape[1] == 1 else c.T, -columns]))
    starts = np.cumsum(np.concatenate([np.ones(count, dtype=np.int64), orders**2]))
    every = np.concatenate([np.ones(count, dtype=np.int64), orders])
    place, unknown = (part.astype(np.int64) for part in stacked.coords)
    lmi = np.searchsorted(starts, place, side="right")
    within = place - (starts[lmi] - every[lmi] ** 2)
    column, row = np.divmod(within, every[lmi])
    entries = _symmetric(unknown, lmi, row, column, stacked.data.astype(float))
    words = arrays.get("lmic")
    words = words if isinstance(words, dict) else {"maximised": np.ones((1, 1))}
    notes = Notes(
        line(_word(words, "title")),
        line(_word(words, "soundness")),
        tuple(_word(words, "unknowns").split("\n")),
        tuple(_word(words, "lmis").split("\n")),
    )
    return sdp_of_entries(-b, _number(words, "constant"), every, entries, notes, bool(_number(words, "maximised")))


def _symmetric(unknown: Array, lmi: Array, row: Array, column: Array, value: Array) -> tuple[Array, ...]:
    """Half the sum of each entry and its mirror, which is exact where they are equal."""
    low, high = np.minimum(row, column), np.maximum(row, column)
    order = np.lexsort((low, high, lmi, unknown))
    key = np.stack([unknown, lmi, low, high])[:, order]
    first = np.ones(len(order), dtype=bool)
    first[1:] = (key[:, 1:] != key[:, :-1]).any(axis=0)
    with np.errstate(over="ignore"):
        sums = np.add.reduceat(value[order], np.flatnonzero(first)) if len(order) else np.zeros(0)
    unknown, lmi, low, high = key[:, first]
    return unknown, lmi, low, high, np.where(low == high, sums, sums / 2)


def _matrix(value: Any, name: str) -> Any:
    if isinstance(value, np.ndarray) and value.ndim == 2 and value.dtype.kind != "U":
        return sps.coo_array(value.astype(float))
    if isinstance(value, sps.csc_array):
        return value
    raise FormatError(f"has no matrix {name}; SeDuMi's form is At (or A), b, c and K")


def _vector(value: Any, name: str) -> Array:
    matrix = _matrix(value, name)
    if 0 not in matrix.shape and 1 not in matrix.shape:
        raise FormatError(f"{name} is {matrix.shape[0]} x {matrix.shape[1]}; it is a vector")
    if max(matrix.shape) > 10**7:
        raise FormatError(f"{name} has {max(matrix.shape)} entries, more than lmic takes; split the problem")
    vector: Array = matrix.toarray().ravel()
    return vector


def _sizes(value: Any, name: str) -> Array:
    if value is None:
        return np.zeros(0, dtype=np.int64)
    sizes = integers(_vector(value, name), f"a size in {name}")
    if (sizes < 0).any() or (sizes > 10**7).any():
        raise FormatError(f"{name} has the size {sizes.min()}; a size is a number from 0 that fits in memory")
    return sizes


def _word(words: Mapping[str, Any], name: str) -> str:
    value = words.get(name, "")
    return value if isinstance(value, str) else ""


def _number(words: Mapping[str, Any], name: str) -> float:
    value = words.get(name, np.zeros((1, 1)))
    if not isinstance(value, np.ndarray) or value.size != 1:
        raise FormatError(f"lmic.{name} is no number; save one, or leave the structure lmic out")
    return float(value.item())


# MATLAB's arrays ------------------------------------------------------------------------------------------


def _array(data: bytes, order: str) -> tuple[str, Any]:
    """Name and value: an array of numbers, a sparse one, a text, or a structure as a dictionary."""
    (_, flags), *parts = elements(data, order)
    (word,) = struct.unpack_from(f"{order}I", flags)
    matlab_class, attributes = word & 0xFF, word >> 8
    (_, stored_sizes), (_, name_bytes), *values = parts
    name, sizes = name_bytes.decode(), np.frombuffer(stored_sizes, dtype=f"{order}i4")
    if attributes & _COMPLEX:
        raise FormatError(f"{quoted(name)} is complex; lmic takes real numbers")
    if matlab_class == _TEXT:
        ((kind, stored),) = values
        return name, text(kind, stored, order)
    if matlab_class in _NUMERIC:
        ((kind, stored),) = values
        return name, numbers(kind, stored, order).reshape(sizes, order="F")
    if matlab_class == _SPARSE:
        return name, _sparse(values, sizes, order)
    if matlab_class == _STRUCT:
        return name, _structure(values, sizes, order)
    return name, None  # a cell, an object or a function means nothing here


def _sparse(values: list[tuple[int, bytes]], sizes: Array, order: str) -> sps.csc_array:
    rows, starts, stored = (numbers(kind, content, order) for kind, content in values)
    if len(sizes) != 2 or sizes.min() < 0 or len(starts) != sizes[1] + 1:
        raise ValueError("a sparse matrix whose columns are not those of its size")
    used = int(starts[-1])
    if starts[0] != 0 or (np.diff(starts) < 0).any() or not used <= min(len(rows), len(stored)):
        raise ValueError("a sparse matrix whose columns do not follow one another")
    rows = rows[:used].astype(np.int64)
    if used and (rows.min() < 0 or rows.max() >= sizes[0]):
        raise ValueError("an entry of a sparse matrix outside its size")
    return sps.csc_array(
        (stored[:used].astype(float), rows, starts.astype(np.int64)), shape=(int(sizes[0]), int(sizes[1]))
    )


def _structure(values: list[tuple[int, bytes]], sizes: Array, order: str) -> dict[str, Any]:
    (_, stored_length), (_, names), *fields = values
    if sizes.tolist() != [1, 1]:
        return {}  # an array of structures, or an empty one
    (length,) = struct.unpack_from(f"{order}i", stored_length)
    if length <= 0 or len(names) != length * len(fields):
        raise ValueError("a structure whose fields are not those of its names")
    keys = [names[k : k + length].split(b"\0")[0].decode() for k in range(0, len(names), length)]
    found = {}
    for key, (kind, data) in zip(keys, fields, strict=True):
        if kind != ARRAY:
            raise ValueError("a field of a structure that is no array")
        found[key] = _array(data, order)[1] if data else np.zeros((0, 0))
    return found
