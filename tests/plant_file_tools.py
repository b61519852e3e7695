"""Plant files to begin from, and ways to write them byte by byte."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from lmic.plants.plant import Plant

# Every number is a dyadic rational, so that text and binary formats can agree.
VERTICES: dict[str, Any] = {
    "A": [[[0.5, 0.0], [1.0, -0.25]], [[0.125, 2.0], [0.0, 0.0]]],
    "B": [[[2.0], [0.5]], [[1.0], [0.5]]],
}
CONSTANT = [[1.0, -1.5]]

TOML = """
name = "two vertices"
source = "made up"
[parameters.beta]
simplex = 2
[matrices]
A = { vertices = [[[0.5, 0], [1, -0.25]], [[0.125, 2], [0.0, 0]]] }
B = { vertices = [[[2], ["1/2"]], [[1], [0.5]]], parameter = "beta" }
C = [[1, "-1 - 1/2"]]
"""


def write(path: Path, content: str | bytes) -> Path:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def write_npz(path: Path, **arrays: Any) -> Path:
    np.savez(path, **arrays)
    return path


def write_mat(path: Path, **arrays: Any) -> Path:
    scipy.io.savemat(path, arrays, do_compression=True)
    return path


def document(**tables: Any) -> dict[str, Any]:
    return {"parameters": {"beta": {"simplex": 2}}, "matrices": {"C": [[1]]}, **tables}


def described(plant: Plant) -> dict[str, Any]:
    """Everything a plant states, comparable by ==."""
    matrices = {
        name: (matrix.monomials.atoms, matrix.monomials.exponents.tolist(), matrix.coefficients.tolist())
        for name, matrix in plant.matrices.items()
    }
    return {"matrices": matrices, "domains": plant.domains, "name": plant.name, "source": plant.source}


def mat_header(order: str) -> bytes:
    return b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack(f"{order}HH", 0x0100, 0x4D49)


def mat_element(order: str, kind: int, data: bytes) -> bytes:
    if 0 < len(data) <= 4:
        return struct.pack(f"{order}I", len(data) << 16 | kind) + data.ljust(4, b"\0")
    return struct.pack(f"{order}II", kind, len(data)) + data + bytes(-len(data) % 8)


def mat_array(order: str, name: str, matlab_class: int, shape: tuple[int, ...], kind: int, data: bytes) -> bytes:
    parts = [
        mat_element(order, 6, struct.pack(f"{order}II", matlab_class, 0)),
        mat_element(order, 5, struct.pack(f"{order}{len(shape)}i", *shape)),
        mat_element(order, 1, name.encode()),
        mat_element(order, kind, data),
    ]
    return mat_element(order, 14, b"".join(parts))
