"""MATLAB 5 to 7 files: their full arrays of numbers and their texts, and nothing else.

scipy.io.loadmat reads these files too, but a damaged one can crash it, and the interpreter with it.

A file is a header of 128 bytes and then elements, each a type, a length and data padded to eight
bytes. An array is an element made of elements: flags, sizes, name, and the numbers column by column
in any type that holds them. An element may also be an array packed by zlib.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator, Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.errors import PlantError
from lmic.plants.expressions import quoted

Array: TypeAlias = NDArray[Any]

_HEADER = b"MATLAB 5.0 MAT-file"
_HEADER_SIZE = 128
ARRAY, _PACKED = 14, 15
_NUMBERS: Mapping[int, str] = {
    1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8", 17: "u2", 18: "u4"
}  # fmt: skip
_UTF8 = 16
_TEXT, _OPAQUE = 4, 17
_REFUSED: Mapping[int, str] = {1: "cell", 2: "struct", 3: "object", 5: "sparse", 16: "function", _OPAQUE: "object"}
_LOGICAL, _COMPLEX = 0x02, 0x08


def read_arrays(content: bytes, max_bytes: int) -> dict[str, Array]:
    """Arrays by name, a text as an array of one string; more than ``max_bytes`` unpacked are refused.

    Raises PlantError for other kinds of file or array, and ValueError, struct.error or zlib.error
    for damaged data.
    """
    order = byte_order(content)
    arrays: dict[str, Array] = {}
    for data in stored_arrays(content, order, max_bytes):
        name, array = _array(data, order)
        if name in arrays:
            raise PlantError(f"holds {quoted(name)} twice; keep one")
        arrays[name] = array
    return arrays


def byte_order(content: bytes) -> str:
    """How numbers are stored, "<" or ">"; raises PlantError for other kinds of file."""
    if not content.startswith(_HEADER):
        version = "is of version 7.3" if content.startswith(b"MATLAB 7.3") else "is not a MATLAB file of version 5 to 7"
        raise PlantError(f"{version}; save it in MATLAB with the option -v7")
    return "<" if content[_HEADER_SIZE - 2 : _HEADER_SIZE] == b"IM" else ">"


def stored_arrays(content: bytes, order: str, max_bytes: int) -> Iterator[bytes]:
    """The data of every array of a file, unpacked."""
    left = max_bytes
    for kind, data in elements(content[_HEADER_SIZE:], order):
        found = [(kind, data)]
        if kind == _PACKED:
            unpacked = zlib.decompressobj().decompress(data, left + 1)
            left -= len(unpacked)
            if left < 0:
                raise PlantError(f"holds more than {max_bytes >> 20} MiB of data; a file for lmic holds less")
            found = list(elements(unpacked, order))
        for element_kind, array_data in found:
            if element_kind != ARRAY:
                raise ValueError(f"an element of type {element_kind} stands where an array should")
            yield array_data


def elements(data: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    """Types and data of consecutive elements."""
    position = 0
    while position < len(data):
        kind, length = struct.unpack_from(f"{order}II", data, position)
        start, padded = position + 8, length + -length % 8
        if kind >> 16:  # a small element: length and type share four bytes, and four of data follow
            kind, length, start, padded = kind & 0xFFFF, kind >> 16, position + 4, 4
        if start + length > len(data):
            raise ValueError("the data end within an element")
        yield kind, data[start : start + length]
        position = start + (length if kind == _PACKED else padded)


def _array(data: bytes, order: str) -> tuple[str, Array]:
    """Name and value of an array."""
    (_, flags), *parts = elements(data, order)
    (word,) = struct.unpack_from(f"{order}I", flags)
    matlab_class, attributes = word & 0xFF, word >> 8
    if matlab_class == _OPAQUE:  # has no sizes
        parts.insert(0, (0, b""))
    (_, sizes), (_, name_bytes), *values = parts
    name = name_bytes.decode()
    traits = ((attributes & _COMPLEX, "complex"), (attributes & _LOGICAL, "logical"))
    refused = _REFUSED.get(matlab_class) or next((trait for bit, trait in traits if bit), "")
    if refused:
        raise PlantError(
            f"{quoted(name)} is of class {refused}; save full matrices of real numbers, and texts in single quotes"
        )
    ((kind, stored),) = values
    if matlab_class == _TEXT:
        return name, np.array(text(kind, stored, order))
    return name, numbers(kind, stored, order).reshape(np.frombuffer(sizes, dtype=f"{order}i4"), order="F")


def numbers(kind: int, stored: bytes, order: str) -> Array:
    """The numbers of an element, in any type that holds them."""
    return np.frombuffer(stored, dtype=order + _NUMBERS[kind])


def text(kind: int, stored: bytes, order: str) -> str:
    """The text of an element."""
    return stored.decode() if kind == _UTF8 else "".join(map(chr, numbers(kind, stored, order)))
