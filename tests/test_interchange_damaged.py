"""Damaged and foreign files: one sentence that names the file, no traceback of a library, bounded memory."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from interchange_tools import SUFFIXES, lag

from lmic.cli import main
from lmic.errors import FormatError
from lmic.interchange.formats import FORMATS, read_problem
from lmic.interchange.sdp import sdp_of_problem

CONTENT: Mapping[str, bytes] = {suffix: found.write(sdp_of_problem(lag())) for suffix, found in FORMATS.items()}


@st.composite
def damage(draw: st.DrawFn, content: bytes) -> bytes:
    """Bytes overwritten, taken out, put in, or the end missing."""
    data = bytearray(content)
    for _ in range(draw(st.integers(1, 4))):
        place = draw(st.integers(0, max(len(data) - 1, 0)))
        length = draw(st.integers(0, 8))
        data[place : place + length] = draw(st.binary(max_size=8))
    return bytes(data[: draw(st.integers(0, len(data)))]) if draw(st.booleans()) else bytes(data)


@pytest.mark.parametrize("suffix", SUFFIXES)
@given(data=st.data())
@settings(max_examples=400, deadline=None, derandomize=True)
def test_damage_is_read_or_refused(suffix: str, data: st.DataObject) -> None:
    content = data.draw(damage(CONTENT[suffix]))
    try:
        FORMATS[suffix].read(content)
    except FormatError as error:
        message = str(error)
        assert "\n" not in message
        assert len(message) < 400


LINES = st.lists(st.sampled_from(CONTENT[".cbf"].decode().splitlines() + CONTENT[".dat-s"].decode().splitlines()))


@pytest.mark.parametrize("suffix", [".dat-s", ".cbf"])
@given(lines=LINES)
@settings(max_examples=400, deadline=None, derandomize=True)
def test_lines_in_any_order_are_read_or_refused(suffix: str, lines: list[str]) -> None:
    try:
        FORMATS[suffix].read("\n".join(lines).encode())
    except FormatError as error:
        assert len(str(error)) < 400


SDPA = {
    "unknowns": ("3\n", "x\n", "is not the number of unknowns"),
    "negative unknowns": ("3\n", "-3\n", "is not the number of unknowns"),
    "too many unknowns": ("3\n", "99999999999999999999999999\n", "is not the number of unknowns"),
    "cost too short": ("1.0 2.0 3.0", "1.0 2.0", "ends before the objective|does not hold the objective"),
    "cost too long": ("1.0 2.0 3.0", "1.0 2.0 3.0 4.0", "does not hold the objective, 3 numbers"),
    "order zero": ("2 -1\n", "0 -1\n", "order 0"),
    "huge order": ("2 -1\n", "1000000 -1\n", "more than"),
    "huge diagonal": ("2 -1\n", "2 -999999999\n", "LMIs"),
    "fractional order": ("2 -1\n", "2.5 -1\n", "whole number"),
    "block outside": ("1 1 1 1 4.0", "1 3 1 1 4.0", "block 3 of 2"),
    "matrix outside": ("1 1 1 1 4.0", "4 1 1 1 4.0", "no unknown"),
    "row outside": ("1 1 1 1 4.0", "1 1 3 1 4.0", r"stands at \(3,1\), outside"),
    "row zero": ("1 1 1 1 4.0", "1 1 0 1 4.0", "outside"),
    "twice": ("1 1 1 1 4.0", "1 1 1 1 4.0\n1 1 1 1 4.0", "given twice"),
    "twice across": ("1 1 1 2 1.0", "1 1 1 2 1.0\n1 1 2 1 1.0", "given twice"),
    "too few words": ("1 1 1 1 4.0", "1 1 1 1", "line 6, '1 1 1 1', does not hold 5 numbers"),
    "not a number": ("1 1 1 1 4.0", "1 1 1 1 4,0x", "line 6"),
    "nan": ("1 1 1 1 4.0", "1 1 1 1 nan", "not finite"),
    "infinite": ("1.0 2.0 3.0", "1.0 1e999 3.0", "not finite"),
    "off the diagonal": ("2 2 1 1 5.0", "2 2 1 2 5.0", "off the diagonal"),
    "beyond the diagonal": ("2 2 1 1 5.0", "2 2 2 2 5.0", "outside its diagonal block"),
}
GOOD_SDPA = "3\n2\n2 -1\n1.0 2.0 3.0\n0 1 1 1 -1.0\n1 1 1 1 4.0\n1 1 1 2 1.0\n3 1 2 2 1.0\n2 2 1 1 5.0\n"


def refused(path: Path, content: bytes | str, words: str) -> None:
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(FormatError, match=words) as caught:
        read_problem(path)
    assert str(caught.value).startswith(str(path))


def test_the_good_one_is_read(tmp_path: Path) -> None:
    (tmp_path / "F.dat-s").write_text(GOOD_SDPA)
    assert read_problem(tmp_path / "F.dat-s").orders.tolist() == [2, 1]


@pytest.mark.parametrize("what", SDPA)
def test_bad_sdpa(what: str, tmp_path: Path) -> None:
    old, new, words = SDPA[what]
    assert GOOD_SDPA.count(old) == 1
    refused(tmp_path / "F.dat-s", GOOD_SDPA.replace(old, new), words)


GOOD_CBF = (
    "VER\n3\nOBJSENSE\nMIN\nVAR\n2 1\nF 2\nPSDCON\n1\n2\nOBJACOORD\n1\n0 1.5\nHCOORD\n2\n0 0 0 0 1\n0 1 1 1 1\n"
    "DCOORD\n1\n0 1 0 2\n"
)
CBF = {
    "version": ("VER\n3", "VER\n9", "version '9'"),
    "no version": ("VER\n3\n", "", "no version"),
    "sense": ("MIN", "LEAST", "'LEAST' is not MIN or MAX"),
    "no variables": ("VAR\n2 1\nF 2\n", "", "states no variables|a variable in HCOORD"),
    "quadratic cone": ("F 2", "Q 2", "cone 'Q'"),
    "equalities": ("F 2", "L= 2", "eliminate"),
    "cones and count": ("F 2", "F 1", "hold 1 where there are 2"),
    "many variables": ("2 1\nF 2", "9999999999 1\nF 9999999999", "number of variables"),
    "huge order": ("PSDCON\n1\n2", "PSDCON\n1\n900000", "more than"),
    "negative order": ("PSDCON\n1\n2", "PSDCON\n1\n-2", "an order"),
    "matrix variables": ("PSDCON", "PSDVAR\n1\n2\nPSDCON", "matrix variables"),
    "integers": ("PSDCON", "INT\n1\n0\nPSDCON", "integer variables"),
    "unknown keyword": ("DCOORD", "ECOORD", "'ECOORD', is no keyword"),
    "section twice": ("OBJSENSE\nMIN", "OBJSENSE\nMIN\nOBJSENSE\nMIN", "OBJSENSE again"),
    "variable outside": ("0 1 1 1 1", "0 2 1 1 1", "2 stands where a variable in HCOORD should"),
    "inequality outside": ("0 1 0 2", "1 1 0 2", "1 stands where a matrix inequality"),
    "row outside": ("0 1 0 2", "0 2 0 2", "outside"),
    "too few entries": ("HCOORD\n2", "HCOORD\n3", "HCOORD|DCOORD"),
    "end missing": ("0 1 0 2\n", "", "ends before the 1 entries of DCOORD"),
    "fractional index": ("0 1 0 2", "0 1 0.5 2", "whole number"),
    "no number": ("0 1.5", "0 one", "OBJACOORD"),
}


@pytest.mark.parametrize("what", CBF)
def test_bad_cbf(what: str, tmp_path: Path) -> None:
    old, new, words = CBF[what]
    assert GOOD_CBF.count(old) == 1
    refused(tmp_path / "F.cbf", GOOD_CBF.replace(old, new), words)


def mat(**fields: Any) -> bytes:
    good: dict[str, Any] = {
        "At": np.array([[-1.0], [0.0], [0.0], [0.0]]),
        "b": np.array([[-1.0]]),
        "c": np.array([[0.0], [1.0], [1.0], [1.0]]),
        "K": {"s": 2.0},
    }
    file = io.BytesIO()
    scipy.io.savemat(file, {key: value for key, value in {**good, **fields}.items() if value is not None})
    return file.getvalue()


MAT: Mapping[str, tuple[dict[str, Any], str]] = {
    "no cone": ({"K": None}, "no structure K"),
    "a number for the cone": ({"K": 2.0}, "no structure K"),
    "no data": ({"At": None}, "no matrix At"),
    "equalities": ({"K": {"s": 2.0, "f": 1.0}}, "equalities"),
    "second-order cones": ({"K": {"s": 2.0, "q": 3.0}}, "second-order cones"),
    "cone and c": ({"K": {"s": 3.0}}, "c is 4 x 1 where the cone K has 9 entries"),
    "cone and At": ({"At": np.ones((3, 1))}, "At is 3 x 1 where K has 4 entries"),
    "huge order": ({"K": {"s": 1e6}}, "more than"),
    "negative order": ({"K": {"s": -2.0}}, "a size is a number from 0"),
    "fractional order": ({"K": {"s": 1.5}}, "whole number"),
    "nan": ({"b": np.array([[np.nan]])}, "not finite"),
    "complex": ({"b": np.array([[1j]])}, "complex"),
    "a text": ({"b": "one"}, "no matrix b"),
    "a cell": ({"b": np.array([[1.0]], dtype=object)}, "no matrix b"),
    "unknowns": ({"b": np.ones((2, 2))}, "b is 2 x 2"),
}


def test_the_good_mat_is_read(tmp_path: Path) -> None:
    (tmp_path / "F.mat").write_bytes(mat())
    assert read_problem(tmp_path / "F.mat").size == 1


@pytest.mark.parametrize("what", MAT)
def test_bad_mat(what: str, tmp_path: Path) -> None:
    fields, words = MAT[what]
    refused(tmp_path / "F.mat", mat(**fields), words)


def test_mat_of_another_version(tmp_path: Path) -> None:
    refused(tmp_path / "F.mat", b"MATLAB 7.3 MAT-file" + bytes(200), "-v7")
    refused(tmp_path / "F.mat", b"\x89HDF\r\n", "not a MATLAB file")


def npz(**fields: Any) -> bytes:
    good: dict[str, Any] = {
        "cost": np.array([1.0]),
        "orders": np.array([1]),
        **dict.fromkeys(("unknown", "lmi", "row", "column"), np.array([0])),
        "value": np.array([1.0]),
    }
    file = io.BytesIO()
    np.savez(file, **{key: value for key, value in {**good, **fields}.items() if value is not None})
    return file.getvalue()


NPZ: Mapping[str, tuple[dict[str, Any], str]] = {
    "no cost": ({"cost": None}, "no array cost"),
    "lengths": ({"value": np.array([1.0, 2.0])}, "not equally long"),
    "objects": ({"value": np.array([None])}, "damaged"),
    "texts": ({"cost": np.array(["a"])}, "cost is an array of"),
    "a matrix": ({"cost": np.ones((2, 2))}, "cost is an array of"),
    "complex": ({"cost": np.array([1j])}, "cost is an array of"),
    "unknown outside": ({"unknown": np.array([2])}, "no unknown"),
    "negative LMI": ({"lmi": np.array([-1])}, "no LMI"),
    "fraction": ({"row": np.array([0.5])}, "whole number"),
    "nothing": ({"cost": np.zeros(0)}, "0 unknowns"),
}


@pytest.mark.parametrize("what", NPZ)
def test_bad_npz(what: str, tmp_path: Path) -> None:
    fields, words = NPZ[what]
    refused(tmp_path / "F.npz", npz(**fields), words)


def test_no_memory_is_taken_for_what_a_header_promises(tmp_path: Path) -> None:
    """A member whose header states a terabyte, and one that unpacks to more than the limit."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (2**37,)})
    with zipfile.ZipFile(tmp_path / "F.npz", "w") as archive:
        archive.writestr("cost.npy", header.getvalue() + bytes(64))
    refused(tmp_path / "F.npz", (tmp_path / "F.npz").read_bytes(), "damaged")
    with (
        zipfile.ZipFile(tmp_path / "G.npz", "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("c.npy", "w") as member,
    ):
        for _ in range(1025):
            member.write(bytes(2**20))
    refused(tmp_path / "G.npz", (tmp_path / "G.npz").read_bytes(), "more than 1024 MiB")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_the_command_line_says_it_in_one_line(suffix: str, tmp_path: Path) -> None:
    file = tmp_path / f"F{suffix}"
    file.write_bytes(b"nonsense")
    done = CliRunner().invoke(main, ["solve", str(file)])
    assert done.exit_code == 1
    assert done.output.startswith(f"FormatError: {file}: ")
    assert done.output.count("\n") == 1
    done = CliRunner().invoke(main, ["export", str(file), "-o", str(tmp_path / "G.cbf")])
    assert done.exit_code == 1
    assert sorted(tmp_path.iterdir()) == [file]


def test_no_file_and_no_format(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="no such file"):
        read_problem(tmp_path / "nothing.cbf")
    (tmp_path / "F.cbf").mkdir()
    with pytest.raises(FormatError, match="is not a file"):
        read_problem(tmp_path / "F.cbf")
    with pytest.raises(FormatError, match=r"unknown; end the name in one of \.dat-s"):
        read_problem(tmp_path / "F.mps")
