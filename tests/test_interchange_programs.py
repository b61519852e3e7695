"""Exported files are solved by other programs, with the same optimum; so are CVXPY's and PICOS' problems."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import scipy.io
from interchange_tools import LAG_GAIN, identical, lag

from lmic import library
from lmic.compiler.assemble import ConicProblem
from lmic.errors import LmicError
from lmic.interchange.formats import read_problem, write_problem
from lmic.interchange.models import cvxpy_problem, picos_problem
from lmic.interchange.sdp import SDP, sdp_of_problem
from lmic.pipeline import compile
from lmic.plants.plant import Plant
from lmic.solve.registry import installed
from lmic.solve.solve import solve


def h2() -> ConicProblem:
    """The H2 norm of x⁺ = x/2 + w, z = x over a segment of C: Σ 2^(−2k) = 4/3 for its square at C = 1."""
    plant = Plant.polytopic("rho", A=[[0.5]], B=[[1]], C=[[[1]], [[0.25]]], D=[[0]])
    return compile(library.theorem("standard.h2_discrete"), plant)


PROBLEMS: dict[str, Callable[[], ConicProblem]] = {"bounded real": lag, "H2": h2}


def program(name: str) -> Any:
    return pytest.mark.skipif(shutil.which(name) is None, reason=f"the program {name} is not installed (apt)")


def package(name: str) -> Any:
    return pytest.mark.skipif(not installed(name), reason=f"the package {name} is not installed")


def ran(command: list[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=100)
    return done.stdout


@pytest.fixture(params=PROBLEMS)
def problem(request: pytest.FixtureRequest) -> ConicProblem:
    return PROBLEMS[request.param]()


@pytest.fixture
def optimum(problem: ConicProblem) -> float:
    solution = solve(problem)
    assert solution.uncertainty < 1e-8
    return solution.value


@program("csdp")
def test_csdp(problem: ConicProblem, optimum: float, tmp_path: Path) -> None:
    write_problem(problem, tmp_path / "F.dat-s")
    found = re.search(r"Dual objective value: (\S+)", ran(["csdp", "F.dat-s"], tmp_path))
    assert found is not None
    assert float(found[1]) == pytest.approx(optimum - problem.constant, rel=1e-6)


@program("sdpa")
def test_sdpa(problem: ConicProblem, optimum: float, tmp_path: Path) -> None:
    write_problem(problem, tmp_path / "F.dat-s")
    ran(["sdpa", "-ds", "F.dat-s", "-o", "out"], tmp_path)
    text = (tmp_path / "out").read_text()
    assert re.search(r"phase.value  = pd(OPT|FEAS)", text)
    found = re.search(r"objValPrimal = (\S+)", text)
    assert found is not None
    assert float(found[1]) == pytest.approx(optimum - problem.constant, rel=1e-6)


def test_scs_from_sedumis_file(problem: ConicProblem, optimum: float, tmp_path: Path) -> None:
    """scipy reads the file, SCS solves SeDuMi's primal, minimise cᵀx with Aᵗᵀx = b, x in K, through CVXPY."""
    import cvxpy as cp

    write_problem(problem, tmp_path / "F.mat")
    arrays = scipy.io.loadmat(tmp_path / "F.mat")
    orders = arrays["K"]["s"][0, 0].ravel().astype(int)
    blocks = [cp.Variable((n, n), PSD=True) for n in orders]
    x = cp.hstack([cp.vec(block, order="F") for block in blocks])
    primal = cp.Problem(cp.Minimize(arrays["c"].toarray().ravel() @ x), [arrays["At"].T @ x == arrays["b"].ravel()])
    primal.solve(solver=cp.SCS, eps=1e-9)
    # the maximum of bᵀy is the minimum of −bᵀy with the sign turned
    assert -primal.value == pytest.approx(optimum - problem.constant, rel=1e-5)


@pytest.mark.parametrize("solver", ["SCS", "CLARABEL"])
def test_cvxpy(solver: str, problem: ConicProblem, optimum: float) -> None:
    options = {"eps": 1e-9} if solver == "SCS" else {}
    assert cvxpy_problem(problem).solve(solver=solver, **options) == pytest.approx(optimum, rel=1e-5)


@package("picos")
@package("cvxopt")
def test_picos(problem: ConicProblem, optimum: float) -> None:
    model = picos_problem(problem)
    model.solve(solver="cvxopt")
    assert model.value == pytest.approx(optimum, rel=1e-5)


def test_without_picos_its_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "picos", None)
    with pytest.raises(LmicError, match=r"pip install 'lmic\[picos\]'"):
        picos_problem(lag())


def test_models_keep_the_sense_and_the_constant() -> None:
    """What the file calls a maximum stays one: −(cost·x + constant)."""
    sdp = sdp_of_problem(lag())
    turned = SDP(sdp.cost, 1.5, sdp.orders, sdp.entries, sdp.notes, maximised=True)
    assert cvxpy_problem(turned).solve(solver="CLARABEL") == pytest.approx(-LAG_GAIN - 1.5, rel=1e-6)


@package("coptpy")
@pytest.mark.parametrize(("suffix", "reader"), [(".dat-s", "readSdpa"), (".cbf", "readCbf")])
def test_copt_reads_and_solves(suffix: str, reader: str, problem: ConicProblem, optimum: float, tmp_path: Path) -> None:
    from lmic.solve.copt import _environment

    write_problem(problem, tmp_path / f"F{suffix}")
    model = _environment().createModel("file")
    model.setParam("Logging", 0)
    getattr(model, reader)(str(tmp_path / f"F{suffix}"))
    model.solve()
    constant = problem.constant if suffix == ".dat-s" else 0.0
    assert model.objval == pytest.approx(optimum - constant, rel=1e-4)


@package("Mosek")
def test_mosek_reads_and_writes_the_same_cbf(problem: ConicProblem, tmp_path: Path) -> None:
    """Reading and writing need no licence; MOSEK keeps the order of the LMIs, and scales off-diagonals by √2."""
    import mosek

    sdp = sdp_of_problem(problem)
    write_problem(sdp, tmp_path / "F.cbf")
    with mosek.Task() as task:
        task.readdata(str(tmp_path / "F.cbf"))
        task.writedata(str(tmp_path / "G.cbf"))
    again = read_problem(tmp_path / "G.cbf")
    assert again.orders.tolist() == sdp.orders.tolist()
    assert (again.cost == sdp.cost).all()
    assert abs(again.columns - sdp.columns).max() < 1e-14


def test_through_every_format(tmp_path: Path) -> None:
    """A file goes through every format and comes back the same."""
    sdp = sdp_of_problem(h2())
    for suffix in (".cbf", ".mat", ".npz", ".dat-s"):
        write_problem(sdp, tmp_path / f"F{suffix}")
        again = read_problem(tmp_path / f"F{suffix}")
        assert identical(sdp, again)
        sdp = again
    assert solve(sdp).value == pytest.approx(4 / 3, rel=1e-8)
