"""Files of semidefinite programs: what is read is what was written, bit for bit, and means what was meant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.io
from hypothesis import given, settings
from interchange_tools import LAG_GAIN, SUFFIXES, identical, lag, programs

from lmic import library
from lmic.algebra import svec
from lmic.compiler.assemble import ConicProblem
from lmic.errors import LmicError
from lmic.interchange.formats import FORMATS, read_problem, write_problem
from lmic.interchange.sdp import SDP, sdp_of_entries, sdp_of_problem
from lmic.pipeline import compile
from lmic.plants.plant import Plant
from lmic.solve.cone import Status
from lmic.solve.solve import solve


@pytest.fixture
def problem(example_1: Plant) -> ConicProblem:
    return compile(library.theorem("peixoto2025.theorem1"), example_1, {"eps": 10})


@pytest.mark.parametrize("suffix", SUFFIXES)
@given(sdp=programs())
@settings(max_examples=120, deadline=None)
def test_round_trip_is_exact(suffix: str, sdp: SDP) -> None:
    found = FORMATS[suffix]
    again = found.read(found.write(sdp))
    assert identical(sdp, again)
    assert found.write(again) == found.write(sdp)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_as_many_unknowns_as_entries(suffix: str) -> None:
    """SeDuMi's At is square then."""
    sdp = sdp_of_entries(np.zeros(4), 0.0, np.array([2]), [np.array([k]) for k in (1, 0, 0, 1, 1.0)])
    assert identical(FORMATS[suffix].read(FORMATS[suffix].write(sdp)), sdp)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_compiled_problem_with_its_names_and_soundness(suffix: str, problem: ConicProblem, tmp_path: Path) -> None:
    write_problem(problem, tmp_path / f"F{suffix}")
    again = read_problem(tmp_path / f"F{suffix}")
    assert identical(again, sdp_of_problem(problem))
    assert (again.columns != problem.columns).nnz == 0
    assert again.notes.soundness == "sufficient"
    assert again.notes.title.startswith("peixoto2025.theorem1: H∞ filter")
    assert again.name(1) == "P1[1,1] * alpha1"
    assert [again.label(k) for k in range(10)] == [problem.label(k) for k in range(10)]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_soundness_stands_in_every_file(suffix: str, problem: ConicProblem, tmp_path: Path) -> None:
    import zipfile

    file = tmp_path / f"F{suffix}"
    write_problem(problem, file)
    text = zipfile.ZipFile(file).read("soundness.npy").decode("utf-32-le", "ignore") if suffix == ".npz" else ""
    plain = text + file.read_bytes().decode("latin-1")
    assert "sufficient" in plain


def sdpa_matrices(path: Path) -> tuple[np.ndarray, list[np.ndarray]]:
    """An independent reader: cost, and F as an array (blocks)[unknown, row, col]."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith('"')]
    unknowns, orders = int(lines[0]), [int(word) for word in lines[2].split()]
    matrices = [np.zeros((unknowns + 1, n, n)) for n in orders]
    for line in lines[4:]:
        k, block, i, j = map(int, line.split()[:4])
        matrices[block - 1][k, i - 1, j - 1] = matrices[block - 1][k, j - 1, i - 1] = float(line.split()[4])
    return np.array(lines[3].split(), dtype=float), matrices


def test_sdpa_file_holds_the_problem(problem: ConicProblem, tmp_path: Path) -> None:
    write_problem(problem, tmp_path / "F.dat-s")
    cost, matrices = sdpa_matrices(tmp_path / "F.dat-s")
    assert (cost == problem.cost).all()
    x = np.random.default_rng(0).standard_normal(problem.size)
    packed = problem.matrix @ x + problem.offset
    for k, (matrix, order) in enumerate(zip(matrices, problem.orders, strict=True)):
        value = np.tensordot(x, matrix[1:], axes=1) - matrix[0]
        i, j = svec.triangle(int(order))
        expected = packed[problem.starts[k] : problem.starts[k + 1]]
        assert np.allclose(value[i, j] * svec.weights(int(order)), expected, rtol=1e-14)


def test_mat_file_is_sedumis_form(tmp_path: Path) -> None:
    """scipy reads the file; c − At·y has the LMIs' matrices, column by column."""
    problem = lag()
    write_problem(problem, tmp_path / "F.mat")
    arrays = scipy.io.loadmat(tmp_path / "F.mat")
    assert (arrays["K"]["s"][0, 0].ravel() == problem.orders).all()
    assert (arrays["b"].ravel() == -problem.cost).all()
    y = np.array([0.3, -1.25, 2.0])
    vector = arrays["c"].toarray().ravel() - arrays["At"].toarray() @ y
    start = 0
    for k, order in enumerate(map(int, problem.orders)):
        matrix = vector[start : start + order**2].reshape(order, order)
        i, j = svec.triangle(order)
        expected = (problem.matrix @ y + problem.offset)[problem.starts[k] : problem.starts[k + 1]]
        assert (matrix == matrix.T).all()
        assert np.allclose(matrix[i, j] * svec.weights(order), expected, rtol=1e-14)
        start += order**2
    assert str(arrays["lmic"]["soundness"][0, 0][0]) == "exact"


def test_npz_needs_no_pickle(tmp_path: Path) -> None:
    sdp = sdp_of_problem(lag())
    write_problem(sdp, tmp_path / "F.npz")
    with np.load(tmp_path / "F.npz", allow_pickle=False) as arrays:
        assert (arrays["value"] == sdp.entries.value).all()
        assert arrays["soundness"] == "exact"


# Files of other programs ----------------------------------------------------------------------------------

# example1 of the SDPA 6 manual (Fujisawa, Kojima, Nakata, Yamashita, 2002) has the optimum −41.9;
# a block of slack bounds is added, as SDPLIB writes diagonal ones
SDPA_MANUAL = """"Example 1: mDim = 3, nBLOCK = 1, {2}
   3  =  mDIM
   2  =  nBLOCK
   (2, -2)  = bLOCKsTRUCT
{48, -8,
 20}
0 1 1 1 -11
0 1 2 2 23
1 1 1 1 10
1 1 1 2 4
2 1 2 2 -8
3 1 2 1 -8

3 1 2 2 -2
{ 0, 2, 1, 1, -1000 }
0 2 2 2 -1.0e+3
1 2 1 1 1
1 2 2 2 -1
"""


def test_a_file_in_sdplibs_style_is_solved(tmp_path: Path) -> None:
    (tmp_path / "example.dat-s").write_text(SDPA_MANUAL)
    sdp = read_problem(tmp_path / "example.dat-s")
    assert sdp.orders.tolist() == [2, 1, 1]
    solution = solve(sdp)
    assert solution.status is Status.SOLVED
    assert solution.value == pytest.approx(-41.9, rel=1e-9)
    assert solution.uncertainty < 1e-8
    assert solution.worst in ("", "LMI 1", "LMI 2", "LMI 3")


def test_cbf_of_another_program(tmp_path: Path) -> None:
    """maximise 3 − 2u − v, u ≥ 0, v ≤ 1 + u and [[u, 1], [1, v]] ⪰ 0: u = 1/√2, v = √2 (by hand)."""
    (tmp_path / "F.cbf").write_text(
        "# by hand\nVER\n3\n\nOBJSENSE\nMAX\n\nVAR\n2 2\nL+ 1\nF 1\n\nCON\n2 2\nL- 1\nF 1\n\nPSDCON\n1\n2\n\n"
        "OBJACOORD\n2\n0 -2\n1 -1\n\nOBJBCOORD\n3\n\nACOORD\n3\n0 1 1\n0 0 -1\n1 0 7\n\nBCOORD\n1\n0 -1\n\n"
        "HCOORD\n2\n0 0 0 0 1\n0 1 1 1 1\n\nDCOORD\n1\n0 1 0 1\n"
    )
    sdp = read_problem(tmp_path / "F.cbf")
    assert sdp.orders.tolist() == [2, 1, 1]
    assert sdp.maximised
    solution = solve(sdp)
    assert -solution.value == pytest.approx(3 - 2 * np.sqrt(2), rel=1e-8)
    assert solution.x == pytest.approx([np.sqrt(0.5), np.sqrt(2)], rel=1e-4)


def test_sedumis_linear_part_and_transposed_data(tmp_path: Path) -> None:
    """A for At, a full c, K.l, an unsymmetric matrix: maximise −y with y ≥ 3 and [[y, 1], [1, 1]] ⪰ 0."""
    A = np.array([[-1.0, -1.0, 0.0, 0.0, 0.0]])
    c = np.array([[-3.0, 0.0, 0.0, 2.0, 1.0]])
    fields = {"A": A, "b": np.array([[-1.0]]), "c": c, "K": {"l": 1.0, "s": 2.0, "f": 0.0, "q": np.zeros((0, 0))}}
    scipy.io.savemat(tmp_path / "F.mat", fields)
    sdp = read_problem(tmp_path / "F.mat")
    assert sdp.orders.tolist() == [1, 2]
    assert sdp.maximised
    solution = solve(sdp)
    assert -solution.value == pytest.approx(-3, rel=1e-9)


def test_solving_a_file_is_solving_its_problem(tmp_path: Path) -> None:
    problem = lag()
    write_problem(problem, tmp_path / "F.cbf")
    from_file, direct = solve(read_problem(tmp_path / "F.cbf")), solve(problem)
    assert from_file.value == pytest.approx(LAG_GAIN, rel=1e-9)
    assert direct.value == pytest.approx(LAG_GAIN, rel=1e-9)
    assert (from_file.value, from_file.bound, from_file.worst) == (direct.value, direct.bound, direct.worst)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_nothing_half_written_is_left_behind(suffix: str, tmp_path: Path) -> None:
    with pytest.raises(LmicError, match="cannot be written"):
        write_problem(lag(), tmp_path / "nowhere" / f"F{suffix}")
    assert list(tmp_path.iterdir()) == []
