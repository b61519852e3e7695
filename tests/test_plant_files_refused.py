"""Plant files: an error of one sentence for every mistake, and for any bytes at all."""

from __future__ import annotations

import json
import pickle
import struct
import time
import zipfile
import zlib
from collections.abc import Callable, Mapping
from fractions import Fraction
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from hypothesis import given, settings
from hypothesis import strategies as st
from plant_file_tools import CONSTANT, TOML, VERTICES, document, mat_array, mat_header, write, write_mat, write_npz

from lmic.errors import PlantError
from lmic.plants.files import MAX_BYTES, MAX_VERTICES, read_plant
from lmic.plants.plant import Plant

# What is refused -------------------------------------------------------------------------------------


def refused(path: Path, *parts: str) -> None:
    with pytest.raises(PlantError) as caught:
        read_plant(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert len(message) < 600
    for part in parts:
        assert part in message


@pytest.mark.parametrize(
    ("tables", "parts"),
    [
        ({"matrix": {}}, ["the key 'matrix' means nothing here; the keys are fractional, matrices, name"]),
        ({"name": 3}, ["name is 3; give a text"]),
        ({"source": ["a"]}, ["source is ['a']; give a text"]),
        ({"matrices": {}}, ["states no matrix"]),
        ({"matrices": [1]}, ["matrices is [1]; give a table"]),
        ({"scalars": {"c": "x"}}, ["scalar c: 'x' is unknown here"]),
        ({"scalars": {"c": "pi"}}, ["scalar c: 'pi' is not a rational number"]),
        ({"scalars": {"c": True}}, ["scalar c: True is not a real number"]),
        ({"scalars": {"c": None}}, ["scalar c: None is not a finite number"]),
        ({"scalars": {"c": [1]}}, ["scalar c: [1] is not a finite number"]),
        ({"scalars": {"c": "1/0"}}, ["scalar c: in '1/0', '0' is zero"]),
        ({"scalars": {"c d": 1}}, ["'c d' cannot be a name"]),
        ({"scalars": {"": 1}}, ["'' cannot be a name"]),
        ({"scalars": {"lambda": 1}}, ["'lambda' cannot be a name"]),
        ({"scalars": {"pi": 1}}, ["'pi' cannot be a name"]),
        ({"scalars": {"beta1": 1}}, ["beta1 is a component of beta and also of the scalars; rename one"]),
        ({"parameters": {"a": {"simplex": 11}, "a1": {"simplex": 1}}}, ["a11 is a component of a1 and also of a"]),
        ({"parameters": {"a": 2}}, ["parameter a: 2 is not a table"]),
        ({"parameters": {"a": {}}}, ["parameter a: has no domain; give either simplex"]),
        ({"parameters": {"a": {"simplex": 2, "box": {}}}}, ["parameter a: has no domain"]),
        ({"parameters": {"a": {"simplex": 0}}}, ["parameter a: has 0 vertices"]),
        ({"parameters": {"a": {"simplex": 10**9}}}, [f"a simplex has from 1 to {MAX_VERTICES}"]),
        ({"parameters": {"a": {"simplex": True}}}, ["parameter a: has no domain"]),
        ({"parameters": {"a": {"simplex": 2.0}}}, ["parameter a: has no domain"]),
        ({"parameters": {"a": {"simplx": 2}}}, ["parameter a: the key 'simplx' means nothing here"]),
        ({"parameters": {"a": {"box": {}}}}, ["parameter a: a box has no component"]),
        ({"parameters": {"a": {"box": {"r": 1}}}}, ["parameter a: component r: 1 is not an interval"]),
        ({"parameters": {"a": {"box": {"r": [1]}}}}, ["component r: [1] is not an interval"]),
        ({"parameters": {"a": {"box": {"r": [1, "z"]}}}}, ["component r: 'z' is unknown"]),
        ({"parameters": {"a": {"box": {"r": [1, 0]}}}}, ["the interval of r is empty: [1, 0]"]),
        ({"parameters": {"a": {"box": {"r": [0, 1]}, "step": "slow"}}}, ["step of r: 'slow' is unknown"]),
        ({"parameters": {"a": {"box": {"r": [0, 1]}, "rate": {"s": 1}}}}, ["rate does not bound the components r"]),
        ({"parameters": {"a": {"box": {"r": [0, 1]}, "rate": {"r": [1]}}}}, ["rate of r: [1] is not an interval"]),
        ({"matrices": {"C-1": [[1]]}}, ["'C-1' cannot be a name"]),
        ({"matrices": {"C": 1}}, ["matrix C: 1 is not a list of rows"]),
        ({"matrices": {"C": [1, 2]}}, ["matrix C: [1, 2] is not a list of rows; write [[1, 0], [0, 1]]"]),
        ({"matrices": {"C": []}}, ["matrix C: is empty"]),
        ({"matrices": {"C": [[]]}}, ["matrix C: is empty"]),
        ({"matrices": {"C": [[1, 2], [3]]}}, ["matrix C: row 2 has 1 entries where row 1 has 2"]),
        ({"matrices": {"C": [[1], []]}}, ["matrix C: row 2 has 0 entries where row 1 has 1"]),
        ({"matrices": {"C": [[1, None]]}}, ["matrix C: entry (1,2): None is not a finite number"]),
        ({"matrices": {"C": [[1], [[2]]]}}, ["matrix C: entry (2,1): [2] is not a finite number"]),
        ({"matrices": {"C": [[10**400]]}}, ["matrix C: entry (1,1): 1000", "is not a finite number"]),
        ({"matrices": {"C": [[False]]}}, ["matrix C: entry (1,1): False is not a real number"]),
        ({"matrices": {"C": [["gamma"]]}}, ["entry (1,1): 'gamma' is unknown here; use one of 'beta1, beta2, pi'"]),
        ({"matrices": {"C": [["1 +"]]}}, ["entry (1,1): '1 +' is not an expression"]),
        ({"matrices": {"C": {"vertex": []}}}, ["matrix C: the key 'vertex' means nothing here"]),
        ({"matrices": {"C": {}}}, ["matrix C: has no vertices where its parameter has 2"]),
        ({"matrices": {"C": {"vertices": [[[1]]]}}}, ["has 1 vertices where its parameter has 2"]),
        ({"matrices": {"C": {"vertices": [[[1]], [1]]}}}, ["matrix C: vertex 2: [1] is not a list of rows"]),
        ({"matrices": {"C": {"vertices": [[[1]], [[1, 2]]]}}}, ["vertex 2: is 1 x 2 where vertex 1 is 1 x 1"]),
        ({"matrices": {"C": {"vertices": [[["beta1"]], [[1]]]}}}, ["vertex 1: entry (1,1): 'beta1' is unknown here"]),
        ({"matrices": {"C": {"vertices": [[[1]]] * 2, "parameter": "rho"}}}, ["add parameter = one of: beta"]),
        ({"matrices": {"C": {"vertices": [[[1]]] * 2, "parameter": 1}}}, ["has vertices without a simplex"]),
        (
            {"parameters": {}, "matrices": {"C": {"vertices": [[[1]]]}}},
            ["has vertices without a simplex; state one under [parameters]"],
        ),
        (
            {"parameters": {"a": {"simplex": 1}, "b": {"simplex": 1}}, "matrices": {"C": {"vertices": [[[1]]]}}},
            ["add parameter = one of: a, b"],
        ),
        (
            {"parameters": {"r": {"box": {"r1": [0, 1]}}}, "matrices": {"C": {"vertices": [[[1]]], "parameter": "r"}}},
            ["has vertices without a simplex"],
        ),
        (
            {
                "parameters": {"a": {"simplex": 270}},
                "matrices": {"C": [[f"a{n}*(a1 + a2)" for n in range(1, 270)]] * 9},
            },
            ["matrix C: has more than 10000000 coefficients"],
        ),
    ],
)
def test_refuses_a_mistaken_document(tables: dict[str, Any], parts: list[str], tmp_path: Path) -> None:
    refused(write(tmp_path / "plant.json", json.dumps(document(**tables))), *parts)


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("[matrices]\nC = [[1}]\n", ["is not valid TOML", "line 2, column 8"]),
        ("[matrices]\nC = [[1]]\nC = [[2]]\n", ["is not valid TOML", "line 3, column 10"]),
        (f"parameters.a.simplex = 0x{'f' * 5000}", ["parameter a: has a number of thousands of digits vertices"]),
        ("[matrices]\nC = [[nan]]", ["matrix C: entry (1,1): 'nan' is not a decimal number"]),
        ("[matrices]\nC = [[1, -inf]]", ["matrix C: entry (1,2): '-inf' is not a decimal number"]),
        ("[matrices]\nC = [[1e999999999]]", ["entry (1,1): '1e999999999' is not a decimal number"]),
        ("[matrices]\nC = [[2020-01-01]]", ["entry (1,1): datetime.date(2020, 1, 1) is not a finite number"]),
        (f"[matrices]\nC = [[{'9' * 5000}]]", ["is not valid TOML"]),
        (f"[matrices]\nC = [[0x{'f' * 5000}]]", ["entry (1,1)", "is not a finite number"]),
        (f"C = {'[' * 100000}", ["is not valid TOML"]),
        (".".join("a" * 100000), ["line 1 has more than 32 dots"]),
        ("name = 1.5", ["name is '1.5'; give a text"]),
    ],
)
def test_refuses_mistaken_toml(text: str, parts: list[str], tmp_path: Path) -> None:
    refused(write(tmp_path / "plant.toml", text), *parts)


def test_a_long_row_of_decimals_is_no_dotted_key(tmp_path: Path) -> None:
    path = write(tmp_path / "plant.toml", f"matrices.C = [[{', '.join(['-0.5', '1.25e-3'] * 500)}]]")
    assert read_plant(path).matrices["C"].shape == (1, 1000)


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("", ["is not valid JSON", "line 1"]),
        ('{"matrices": {"C": [[1]],}}', ["is not valid JSON", "line 1"]),
        ("[]", ["[] is not a table"]),
        ('{"matrices": {"C": [[NaN]]}}', ["matrix C: entry (1,1): 'NaN' is not a decimal number"]),
        ('{"matrices": {"C": [[1], [-Infinity]]}}', ["matrix C: entry (2,1): '-Infinity' is not a decimal number"]),
        ('{"matrices": {"C": [[1e999999999]]}}', ["entry (1,1): '1e999999999' is not a decimal number"]),
        ('{"matrices": {"C": [[1]], "C": [[2]]}}', ["the key 'C' occurs twice"]),
        ("[" * 100000, ["is not valid JSON"]),
        ('{"name": "\\ud800", "matrices": {}}', ["states no matrix"]),
    ],
)
def test_refuses_mistaken_json(text: str, parts: list[str], tmp_path: Path) -> None:
    refused(write(tmp_path / "plant.json", text), *parts)


ARRAYS: list[tuple[dict[str, Any], str]] = [
    ({"C": np.array([[1.0], [np.nan]])}, "matrix C: entry (2,1) is not finite"),
    ({"C": np.array([["a", "b"]])}, "has entries of type str"),
    ({"C": np.zeros((0, 2))}, "has shape (0, 2)"),
    ({"C": np.zeros((1, 1, 1, 2))}, "has shape (1, 1, 1, 2)"),
    ({"C": np.ones((1, 1)), "parameter": "2x"}, "'2x' cannot be a name"),
    ({"name": "nothing else"}, "states no matrix"),
]


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        *(case for case in ARRAYS if "2x" not in str(case)),
        ({"C": np.ones((2, 1, 1)), "parameter": "2x"}, "'2x' cannot be a name"),
        ({"C": np.array([[1, 1j]])}, "has entries of type complex128"),
        ({"C": np.ones(3)}, "has shape (3,)"),
        ({"C": np.float64(1)}, "has shape ()"),
        ({"C": np.array([[True]])}, "has entries of type bool"),
        ({"C": np.array([[[1.0]], [[np.inf]]])}, "matrix C: vertex 2, entry (1,1) is not finite"),
        ({"C": np.array([[{}]], dtype=object)}, "'C': cannot be read (Object arrays cannot be loaded"),
        ({"C": np.array([[(1, 2)]], dtype="i4,i4")}, "has entries of type void64"),
        ({"C": np.ones((2, 1, 1)), "D": np.ones((3, 1, 1))}, "different numbers of vertices (C 2, D 3)"),
        ({"C": np.ones((MAX_VERTICES + 1, 1, 1))}, f"parameter alpha: has {MAX_VERTICES + 1} vertices"),
        ({"C-1": np.ones((1, 1))}, "'C-1' cannot be a name"),
    ],
)
def test_refuses_mistaken_npz(arrays: dict[str, Any], message: str, tmp_path: Path) -> None:
    refused(write_npz(tmp_path / "plant.npz", **arrays), message)


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        *(case for case in ARRAYS if "2x" not in str(case)),
        ({"C": np.ones((1, 1, 2)), "parameter": "2x"}, "'2x' cannot be a name"),
        ({"C": np.array([[[1.0, np.inf]]])}, "matrix C: vertex 2, entry (1,1) is not finite"),
        ({"C": np.array([[1, 1j]])}, "'C' is of class complex"),
        ({"C": {"a": 1}}, "'C' is of class struct"),
        ({"C": np.array([[1, "a"]], dtype=object)}, "'C' is of class cell"),
        ({"C": scipy.sparse.eye_array(2)}, "'C' is of class sparse"),
        ({"C": np.array([[True]])}, "'C' is of class logical"),
        ({"C": np.ones((1, 1, 2)), "D": np.ones((1, 1, 3))}, "different numbers of vertices (C 2, D 3)"),
    ],
)
def test_refuses_mistaken_mat(arrays: dict[str, Any], message: str, tmp_path: Path) -> None:
    refused(write_mat(tmp_path / "plant.mat", **arrays), message)


@pytest.mark.parametrize(
    ("header", "message"),
    [
        (b"MATLAB 7.3 MAT-file, Platform: PCWIN64", "is of version 7.3; save it in MATLAB with the option -v7"),
        (b"\x89HDF\r\n\x1a\n", "is not a MATLAB file of version 5 to 7"),
        (b"", "is not a MATLAB file of version 5 to 7"),
        (b"MATLAB 5.0 MAT-file", "states no matrix"),
        (b"MATLAB 5.0 MAT-file".ljust(140), "cannot be read"),
    ],
)
def test_refuses_other_versions_of_mat(header: bytes, message: str, tmp_path: Path) -> None:
    refused(write(tmp_path / "plant.mat", header), message)


def test_refuses_paths_that_are_no_plant_files(tmp_path: Path) -> None:
    refused(tmp_path / "plant.csv", "'.csv' is not the suffix of a plant file; use .toml, .json, .npz, .mat")
    refused(tmp_path / "plant", "'' is not the suffix")
    refused(tmp_path / ("a" * 300), "'' is not the suffix")
    refused(Path("peixoto2025.exampel1"), "did you mean the library's peixoto2025.example1 or")
    refused(write(tmp_path / "plant.toml", b"").with_suffix(""), f"did you mean {tmp_path / 'plant.toml'}?")
    refused(tmp_path / "none.toml", "no such file or directory")
    refused(tmp_path / ("a" * 300 + ".toml"), "cannot be read")
    refused(tmp_path / "a\0b.toml", "cannot be read")
    (tmp_path / "folder.toml").mkdir()
    refused(tmp_path / "folder.toml", "is not a file")
    refused(write(tmp_path / "plant.toml", b"name = '\xe9'"), "is not UTF-8 text (byte 8)")
    refused(write(tmp_path / "plant.json", b" " * (MAX_BYTES + 1)), "more than 4 MiB")


def test_does_not_unpickle(tmp_path: Path) -> None:
    class Trap:
        def __reduce__(self) -> tuple[Callable[[Path], None], tuple[Path]]:
            return Path.touch, (tmp_path / "sprung",)

    np.savez(tmp_path / "plant.npz", C=np.array([[Trap()]], dtype=object))
    refused(tmp_path / "plant.npz", "cannot be read")
    write(tmp_path / "raw.npz", pickle.dumps(Trap()))
    refused(tmp_path / "raw.npz", "cannot be read")
    assert not (tmp_path / "sprung").exists()


def test_does_not_unpack_bombs(tmp_path: Path) -> None:
    np.savez_compressed(tmp_path / "bomb.npz", C=np.zeros((2000, 2000)))
    refused(tmp_path / "bomb.npz", "more than 4 MiB")
    write_mat(tmp_path / "bomb.mat", C=np.zeros((2000, 2000)))
    refused(tmp_path / "bomb.mat", "more than 4 MiB")


def test_believes_no_declared_size(tmp_path: Path) -> None:
    buffer = BytesIO()
    np.lib.format.write_array_header_1_0(buffer, {"descr": "<f8", "fortran_order": False, "shape": (10**6, 10**6)})
    with zipfile.ZipFile(tmp_path / "plant.npz", "w") as archive:
        archive.writestr("C.npy", buffer.getvalue())
    refused(tmp_path / "plant.npz", "'C': cannot be read")
    packed = zlib.compress(struct.pack("<IIIIII", 14, 2**32 - 8, 6, 8, 6, 0))
    element = struct.pack("<II", 15, len(packed)) + packed
    refused(write(tmp_path / "plant.mat", mat_header("<") + element), "cannot be read")


def test_refuses_a_repeated_matlab_array(tmp_path: Path) -> None:
    array = mat_array("<", "C", 6, (1, 1), 9, struct.pack("<d", 1.0))
    assert read_plant(write(tmp_path / "once.mat", mat_header("<") + array)).matrices["C"].shape == (1, 1)
    refused(write(tmp_path / "twice.mat", mat_header("<") + array + array), "holds 'C' twice")


def test_refuses_repeated_and_foreign_members(tmp_path: Path) -> None:
    buffer = BytesIO()
    np.save(buffer, np.ones((1, 1)))
    with zipfile.ZipFile(tmp_path / "twice.npz", "w") as archive:
        archive.writestr("C.npy", buffer.getvalue())
        archive.writestr("C", buffer.getvalue())
    refused(tmp_path / "twice.npz", "two arrays of the same name")
    with zipfile.ZipFile(tmp_path / "lzma.npz", "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("C.npy", buffer.getvalue())
    refused(tmp_path / "lzma.npz", "'C' is packed in a foreign way")


# Any bytes at all ------------------------------------------------------------------------------------


def refused_or_read(path: Path, content: bytes) -> None:
    started = time.process_time()
    try:
        plant = read_plant(write(path, content))
    except PlantError as error:
        assert str(error).startswith(f"{path}: ")
    else:
        assert isinstance(plant, Plant)
    assert time.process_time() - started < 2


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a file of each format that reads well, for mutation."""
    folder = tmp_path_factory.mktemp("any")
    stacks = {name: np.array(vertices) for name, vertices in VERTICES.items()}
    write(folder / "seed.toml", TOML)
    write(folder / "seed.json", json.dumps(document(matrices={"A": {"vertices": VERTICES["A"]}, "C": [["beta1"]]})))
    write_npz(folder / "seed.npz", **stacks, C=np.array(CONSTANT))
    write_mat(folder / "seed.mat", C=np.array(CONSTANT), parameter="beta")
    return folder


SUFFIXES = st.sampled_from([".toml", ".json", ".npz", ".mat"])
any_bytes = settings(max_examples=150, deadline=None, derandomize=True)


@any_bytes
@given(SUFFIXES, st.binary(max_size=300))
def test_random_bytes(folder: Path, suffix: str, content: bytes) -> None:
    refused_or_read(folder / f"random{suffix}", mat_header("<") + content if suffix == ".mat" else content)


@any_bytes
@given(SUFFIXES, st.lists(st.tuples(st.floats(0, 1), st.binary(max_size=3), st.integers(0, 3)), min_size=1, max_size=4))
def test_damaged_files(folder: Path, suffix: str, cuts: list[tuple[float, bytes, int]]) -> None:
    content = (folder / f"seed{suffix}").read_bytes()
    for place, inserted, removed in cuts:
        start = int(place * len(content))
        content = content[:start] + inserted + content[start + removed :]
    refused_or_read(folder / f"damaged{suffix}", content)


values = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(),
        st.floats(),
        st.sampled_from(["beta1", "c/2", "1/3", "sin(c)", "x +", ""]),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(st.sampled_from(["vertices", "parameter", "simplex", "box", "step", "rate", "c"]), inner),
    ),
    max_leaves=12,
)


@any_bytes
@given(
    st.fixed_dictionaries(
        {}, optional=dict.fromkeys(("name", "source", "parameters", "scalars", "matrices", "fractional"), values)
    ),
    st.booleans(),
)
def test_random_documents(folder: Path, tables: Mapping[str, Any], wrapped: bool) -> None:
    if wrapped:
        tables = document(scalars={"c": 2}, matrices={"A": tables.get("matrices"), "C": [[tables.get("scalars")]]})
    refused_or_read(folder / "document.json", json.dumps(tables).encode())


@any_bytes
@given(st.lists(st.lists(st.floats(width=64), min_size=2, max_size=2), min_size=1, max_size=3))
def test_array_files_are_exact_and_agree(folder: Path, rows: list[list[float]]) -> None:
    array = np.array(rows)
    paths = [write_npz(folder / "exact.npz", C=array), write_mat(folder / "exact.mat", C=array)]
    if np.isfinite(array).all():
        expected = [[[Fraction(entry) for entry in row] for row in rows]]
        assert [read_plant(path).matrices["C"].coefficients.tolist() for path in paths] == [expected, expected]
    else:
        for path in paths:
            refused(path, "matrix C: entry (", "is not finite")
