"""NumPy archives (.npz) of plain arrays, which numpy.load reads without pickle.

``cost`` (N), ``constant``, ``orders`` (K), and the nonzero entries of the upper triangles as five
arrays of equal length: ``value[e]`` stands in F_ki with k = ``lmi[e]`` and i = ``unknown[e]``, 0 for the
constant matrix, at (``row[e]``, ``column[e]``); ``lmi``, ``row`` and ``column`` count from 0. The problem is

    minimise cost·x + constant   subject to   F_k0 + Σ_i x_i F_ki ⪰ 0  for every k.

``title``, ``soundness``, ``unknowns`` (N) and ``lmis`` (K) are texts; ``maximised`` says that the origin
maximises the negative.
"""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from io import BytesIO
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.errors import FormatError
from lmic.interchange.sdp import SDP, Notes, check_sizes, sdp_of_entries
from lmic.interchange.text import integers, shown
from lmic.plants.expressions import quoted

Array: TypeAlias = NDArray[Any]

#: bytes of a file once unpacked
MAX_UNPACKED = 2**30
_ENTRIES = ("unknown", "lmi", "row", "column", "value")


def write_npz(sdp: SDP) -> bytes:
    """The file's content."""
    e, notes = sdp.entries, sdp.notes
    file = BytesIO()
    np.savez_compressed(
        file,
        allow_pickle=False,
        cost=sdp.cost,
        constant=np.array(sdp.constant),
        orders=sdp.orders,
        unknown=e.unknown,
        lmi=e.lmi,
        row=e.row,
        column=e.column,
        value=e.value,
        maximised=np.array(sdp.maximised),
        title=np.array(notes.title),
        soundness=np.array(notes.soundness),
        unknowns=np.array(notes.unknowns, dtype=str),
        lmis=np.array(notes.lmis, dtype=str),
    )
    return file.getvalue()


def read_npz(content: bytes) -> SDP:
    """The program of a file's content; raises FormatError saying what is wrong."""
    arrays = _arrays(content)
    cost, orders = _vector(arrays, "cost").astype(float), integers(_vector(arrays, "orders"), "an order")
    check_sizes(len(cost), orders)
    parts = [_vector(arrays, name) for name in _ENTRIES]
    if len({len(part) for part in parts}) > 1:
        raise FormatError(f"{', '.join(_ENTRIES)} are not equally long; they belong together")
    unknown, lmi, row, column = (
        integers(part, f"an index in {name}") for part, name in zip(parts[:4], _ENTRIES[:4], strict=True)
    )
    notes = Notes(
        _text(arrays, "title"), _text(arrays, "soundness"), _texts(arrays, "unknowns"), _texts(arrays, "lmis")
    )
    entries = (unknown, lmi, row, column, parts[4].astype(float))
    constant, maximised = (_vector(arrays, name)[0] if name in arrays else 0.0 for name in ("constant", "maximised"))
    return sdp_of_entries(cost, float(constant), orders, entries, notes, bool(maximised))


def _arrays(content: bytes) -> dict[str, Array]:
    """All arrays by name; nothing larger than the limit is unpacked, and no object is made."""
    arrays: dict[str, Array] = {}
    try:
        with zipfile.ZipFile(BytesIO(content)) as archive:
            if sum(member.file_size for member in archive.infolist()) > MAX_UNPACKED:
                raise FormatError(f"holds more than {MAX_UNPACKED >> 20} MiB of data, more than lmic takes; split it")
            for member in archive.infolist():
                if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
                    raise FormatError("is packed in a foreign way; write it by numpy.savez_compressed")
                name = member.filename.removesuffix(".npy")
                if name in arrays:
                    raise FormatError(f"holds {quoted(name)} twice; keep one")
                with archive.open(member) as stream:
                    arrays[name] = np.lib.format.read_array(_Bounded(stream, member.file_size), allow_pickle=False)
    except FormatError:
        raise
    except Exception as error:
        raise FormatError(f"is damaged ({shown(str(error))}); write it by numpy.savez_compressed") from error
    return arrays


class _Bounded:
    """A stream from which no more is read than the archive says there is, whatever an array's header says."""

    def __init__(self, stream: Any, size: int) -> None:
        self.stream, self.left = stream, size

    def read(self, count: int = -1) -> bytes:
        """Up to ``count`` bytes."""
        if count > self.left or count < 0:
            count = self.left
        found: bytes = self.stream.read(count)
        self.left -= len(found)
        return found


def _vector(arrays: Mapping[str, Array], name: str) -> Array:
    if name not in arrays:
        raise FormatError(f"has no array {name}; see the description of the format")
    array = arrays[name]
    if array.dtype.kind not in "biuf" or array.dtype.itemsize > np.dtype(float).itemsize or array.ndim > 1:
        raise FormatError(f"{name} is an array of {array.dtype.name}, shape {array.shape}; store a vector of numbers")
    return np.atleast_1d(array)


def _text(arrays: Mapping[str, Array], name: str) -> str:
    array = arrays.get(name)
    return str(array.item()) if array is not None and array.dtype.kind == "U" and array.size == 1 else ""


def _texts(arrays: Mapping[str, Array], name: str) -> tuple[str, ...]:
    array = arrays.get(name)
    return tuple(array.tolist()) if array is not None and array.dtype.kind == "U" and array.ndim == 1 else ()
