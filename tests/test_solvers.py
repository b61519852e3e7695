"""Every solver gives the same record, the same optimum and the same certificate; one that fails hands over."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from interchange_tools import LAG_GAIN, lag

from lmic import library
from lmic.algebra import svec
from lmic.certify.certify import certify
from lmic.cli import main
from lmic.errors import SolverError
from lmic.interchange.formats import read_problem
from lmic.interchange.sdp import sdp_of_problem
from lmic.pipeline import compile, run
from lmic.plants.plant import Plant
from lmic.relax.relax import Relaxation
from lmic.solve.clarabel import Clarabel
from lmic.solve.cone import ConeAnswer, ConeData, Status, no_answer
from lmic.solve.registry import DEFAULT, SOLVERS, installed, solver, solvers
from lmic.solve.solve import solve

#: what each solver reaches of the objective in lmic's coordinates, relative; MOSEK has no licence here
ACCURACY = {"clarabel": 1e-9, "scs": 1e-7, "cvxopt": 1e-7, "sdpa": 1e-9, "copt": 1e-6}


def chosen(name: str) -> Any:
    if not installed(SOLVERS[name].package):
        pytest.skip(f"the package {SOLVERS[name].package} is not installed")
    return solver(name)


@pytest.mark.parametrize("name", ACCURACY)
def test_optimum_and_record(name: str) -> None:
    solution = solve(lag(), chosen(name))
    assert solution.status is Status.SOLVED
    assert solution.value == pytest.approx(LAG_GAIN, rel=ACCURACY[name])
    assert solution.uncertainty <= ACCURACY[name]
    assert solution.relative_violation >= -1e-9
    assert solution.solver == name
    assert solution.handovers == ()
    # the dual proves the bound: its matrices are positive semidefinite and satisfy their equalities
    problem = lag()
    assert np.abs(problem.matrix.T @ solution.dual - problem.cost).max() < 1e-5
    assert -problem.offset @ solution.dual == pytest.approx(LAG_GAIN, rel=1e-5)


@pytest.mark.parametrize("name", ACCURACY)
def test_cones_of_order_one_beside_others(name: str) -> None:
    """minimise x0 + x1 + x2, [[x0, 1], [1, x1]] ⪰ 0, x2 ≥ 3: the optimum is 2 + 3, and its dual is known."""
    import scipy.sparse as sps

    root = np.sqrt(2)
    matrix = sps.csc_array(np.array([[1.0, 0, 0], [0, 0, 0], [0, 1, 0], [0, 0, 1]]))
    data = ConeData(np.ones(3), matrix, np.array([0, root, 0, -3]), np.array([2, 1]))
    answer = chosen(name)(data)
    assert answer.status in (Status.SOLVED, Status.ALMOST)
    assert answer.y == pytest.approx([1, 1, 3], abs=2e-4)
    assert answer.s == pytest.approx([1, root, 1, 0], abs=2e-4)
    assert answer.z == pytest.approx([1, -root, 1, 1], abs=2e-4)


@pytest.mark.parametrize("name", ["clarabel", "cvxopt", "copt", "sdpa"])
def test_infeasible(name: str) -> None:
    """x⁺ = 3/2 x + w is unstable at a vertex: no LMI holds there."""
    plant = Plant.polytopic("rho", A=[[[1.5]], [[-0.5]]], B=[[1]], C=[[1]], D=[[0]])
    problem = compile(library.theorem("standard.bounded_real_discrete"), plant)
    assert solve(problem, chosen(name)).status is Status.INFEASIBLE


@pytest.mark.parametrize("name", ["clarabel", "scs", "cvxopt", "copt"])
def test_certificates_do_not_depend_on_the_solver(name: str) -> None:
    result = run(lag(), chosen(name))
    certificate = certify(result, Relaxation(), {}, {})
    assert certificate.lower is not None
    assert certificate.upper is not None
    # the lemma is stated for γ itself, so that the proven interval contains the gain
    low, high = (float(bound.reports["gamma"]) for bound in (certificate.lower, certificate.upper))
    assert low <= LAG_GAIN <= high
    assert high - low < 1e-5


# Choice and handover ------------------------------------------------------------------------------------


class Broken:
    """A solver that has no licence, or gives up."""

    def __init__(self, name: str, licence: bool) -> None:
        self.name, self.licence = name, licence

    def __call__(self, data: ConeData, rough: bool = False) -> ConeAnswer:
        if not self.licence:
            raise SolverError("no licence; install one")
        return no_answer(data, "tired")


def test_the_next_takes_over_and_the_reasons_are_kept() -> None:
    solution = solve(lag(), [Broken("first", licence=False), Broken("second", licence=True), Clarabel()])
    assert solution.status is Status.SOLVED
    assert solution.value == pytest.approx(LAG_GAIN, rel=1e-9)
    assert solution.solver == "clarabel"
    assert solution.handovers == ("first: no licence; install one", "second ended with 'tired'")


def test_where_all_fail_the_first_answer_stands() -> None:
    solution = solve(lag(), [Broken("first", licence=True), Broken("second", licence=True)])
    assert solution.status is Status.FAILED
    assert solution.solver == "first"
    assert solution.handovers == ("first ended with 'tired'", "second ended with 'tired'")


def test_where_none_can_run_the_reasons_are_the_error() -> None:
    with pytest.raises(SolverError, match="no solver could run: one: no licence; install one; two: no licence"):
        solve(lag(), [Broken("one", licence=False), Broken("two", licence=False)])


def test_names() -> None:
    assert tuple(found.name for found in solvers()) == DEFAULT
    assert [found.name for found in solvers(["scs"])] == ["scs", "clarabel"]
    with pytest.raises(SolverError, match="'gurobi' is no solver; choose from clarabel, scs"):
        solver("gurobi")


def test_an_absent_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lmic.solve.registry.installed", lambda package: False)
    for name in ("cvxopt", "mosek", "copt", "sdpa"):
        extra = SOLVERS[name].extra
        with pytest.raises(SolverError, match=rf"pip install 'lmic\[{extra}\]'"):
            solver(name)


def test_the_command_line_prints_the_handover(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from lmic.interchange.formats import write_problem

    monkeypatch.setattr("lmic.solve.registry.solver", lambda name: Broken(name, False) if name == "scs" else Clarabel())
    write_problem(lag(), tmp_path / "F.dat-s")
    done = CliRunner().invoke(main, ["solve", str(tmp_path / "F.dat-s"), "--solver", "scs"])
    assert done.exit_code == 0
    assert "handed over scs: no licence; install one" in done.output
    assert "soundness: exact" in done.output
    assert "minimum     2 " in done.output


# MOSEK without a licence --------------------------------------------------------------------------------


@pytest.mark.skipif(not installed("Mosek"), reason="the package Mosek is not installed")
def test_mosek_is_handed_the_problem(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MOSEK's own writer gives back, from its task, the LMIs that the task was filled with."""
    import mosek

    from lmic.solve.mosek import Mosek

    def write(task: Any) -> None:
        task.writedata(str(tmp_path / "task.cbf"))
        raise KeyboardInterrupt

    monkeypatch.setattr(mosek.Task, "optimize", write)
    sdp = sdp_of_problem(lag())
    data = ConeData(sdp.cost, sdp.matrix, sdp.offset, sdp.orders)
    with pytest.raises(KeyboardInterrupt):
        Mosek()(data)
    again = read_problem(tmp_path / "task.cbf")
    assert sorted(again.orders.tolist()) == sorted(sdp.orders.tolist())
    scale = np.abs(sdp.cost).max()
    assert (again.cost * scale == sdp.cost).all()
    assert solve(again).value * scale == pytest.approx(LAG_GAIN, rel=1e-9)


@pytest.mark.skipif(not installed("Mosek"), reason="the package Mosek is not installed")
def test_what_mosek_answers_is_taken_as_it_is_meant(monkeypatch: pytest.MonkeyPatch) -> None:
    """A stand-in for the optimizer: Clarabel's answer in MOSEK's order of the entries, through MOSEK's calls."""
    import mosek

    from lmic.solve.mosek import Mosek

    problem = lag()
    data = ConeData(problem.cost, problem.matrix, problem.offset, problem.orders)
    answer = Clarabel()(data)
    place = svec.lower_by_columns(data.orders)
    slack, dual = np.zeros_like(answer.s), np.zeros_like(answer.z)
    slack[place], dual[place] = answer.s, answer.z
    calls = {
        "optimize": None,
        "solutiondef": True,
        "getsolsta": mosek.solsta.optimal,
        "getxx": answer.y,
        "evaluateaccs": slack,
        "getaccdotys": dual,
        "getintinf": 7,
    }
    for name, value in calls.items():
        assert hasattr(mosek.Task, name)
        monkeypatch.setattr(mosek.Task, name, lambda task, *_, value=value: value)
    found = Mosek()(data)
    assert (found.y == answer.y).all()
    assert (found.s == answer.s).all()
    assert (found.z == answer.z * np.abs(data.cost).max()).all()
    assert (found.status, found.word, found.iterations) == (Status.SOLVED, "optimal", 7)


@pytest.mark.skipif(not installed("Mosek"), reason="the package Mosek is not installed")
def test_mosek_without_a_licence_hands_over(monkeypatch: pytest.MonkeyPatch) -> None:
    import mosek

    def refuse(task: Any) -> Sequence[int]:
        raise mosek.Error(mosek.rescode.err_missing_license_file, "License cannot be located")

    monkeypatch.setattr(mosek.Task, "optimize", refuse)
    solution = solve(lag(), solvers(["mosek"]))
    assert solution.solver == "clarabel"
    assert solution.handovers[0].startswith("mosek: MOSEK has no licence")
