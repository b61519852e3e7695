"""SDPA at 200 bits: reference values, digits beyond double precision, and messages where it is absent."""

from __future__ import annotations

from fractions import Fraction
from importlib import metadata

import numpy as np
import pytest
from test_solve import REFERENCE

from lmic import library
from lmic.certify.definite import is_positive_definite
from lmic.certify.finite import FiniteLMI, FiniteProblem
from lmic.certify.precise import solve_precisely
from lmic.certify.statement import to_flint
from lmic.errors import LmicError
from lmic.pipeline import compile, run
from lmic.plants.plant import Plant
from lmic.solve import sdpa
from lmic.solve.cone import ConeData, Status
from lmic.solve.lineality import lineality
from lmic.solve.scaling import slack_matrices


def _installed() -> bool:
    try:
        return bool(metadata.version("sdpa-multiprecision"))
    except metadata.PackageNotFoundError:
        return False


needs_sdpa = pytest.mark.skipif(not _installed(), reason="the extra 'multiprecision' is not installed")


def hyperbola(scale: Fraction) -> FiniteProblem:
    """minimise x + 0·y with [[x, scale], [scale, 2]] ⪰ 0: the optimum is scale²/2, and no LMI sees y."""
    values = np.array([scale, Fraction(2), Fraction(1)], dtype=object)
    lmi = FiniteLMI(2, np.array([0, 0, 1]), np.array([0, 1, 0]), np.array([1, 1, 0]), values)
    return FiniteProblem((lmi,), np.array([Fraction(1), Fraction(0)], dtype=object), Fraction(0))


@needs_sdpa
@pytest.mark.parametrize("scale", [Fraction(1), Fraction(1, 3), Fraction(7, 10)])
def test_the_optimum_has_thirty_digits(scale: Fraction) -> None:
    problem = hyperbola(scale)
    answer = solve_precisely(problem)
    assert answer.status is Status.SOLVED
    assert not answer.rounded
    assert answer.x[1] == 0
    assert abs(answer.x[0] - scale**2 / 2) < Fraction(1, 10**30)
    dual = np.array([[Fraction(int(e.p), int(e.q)) for e in row] for row in answer.duals[0].tolist()], dtype=object)
    constant, coefficient, _ = problem.lmis[0].inner(dual, 2)
    assert abs(coefficient - 1) < Fraction(1, 10**30)
    assert abs(-constant - scale**2 / 2) < Fraction(1, 10**30)


@needs_sdpa
def test_data_longer_than_a_double_are_said_to_be_rounded() -> None:
    assert solve_precisely(hyperbola(Fraction(1, 3**40))).rounded


@needs_sdpa
@pytest.mark.parametrize("name", ["peixoto2025.theorem1", "peixoto2025.corollary1"])
def test_table_1_of_peixoto_without_any_rescaling(name: str, example_1: Plant) -> None:
    """The problem on which plain double precision ends at 6.409, far below the optimum."""
    problem = compile(library.theorem(name), example_1, {"eps": 150})
    kept = lineality(problem.matrix).kept
    data = ConeData(problem.cost[kept], problem.matrix[:, kept], problem.offset, problem.orders)
    answer = sdpa.SDPA()(data)
    assert answer.status is Status.SOLVED
    assert np.sqrt(data.cost @ answer.y) == pytest.approx(REFERENCE[name, 150], rel=1e-8)
    assert np.sqrt(-data.offset @ answer.z) == pytest.approx(REFERENCE[name, 150], rel=1e-7)
    residual = data.matrix.T @ answer.z - data.cost
    assert np.abs(residual).max() < 1e-8 * max(1.0, np.abs(answer.z).max())
    # what comes back as the slack is the slack, in the same order
    assert np.allclose(data.matrix @ answer.y + data.offset, answer.s, atol=1e-9 * np.abs(answer.s).max())
    assert all(np.linalg.eigvalsh(z)[0] > -1e-9 * np.abs(z).max() for z in slack_matrices(answer.z, data.orders))


@needs_sdpa
def test_it_serves_where_any_cone_solver_does(example_1: Plant) -> None:
    result = run(compile(library.theorem("peixoto2025.corollary1"), example_1, {"eps": 10}), sdpa.SDPA())
    assert result.solution.solver == "sdpa"
    assert result.reports["gamma"] == pytest.approx(REFERENCE["peixoto2025.corollary1", 10], rel=1e-8)


@needs_sdpa
def test_the_slack_a_hair_above_the_optimum_is_positive_definite() -> None:
    problem = hyperbola(Fraction(1, 3))
    x = list(solve_precisely(problem).x)
    lmi = problem.lmis[0]
    assert is_positive_definite(to_flint(lmi.at([x[0] + Fraction(1, 10**30), x[1]])))
    assert not is_positive_definite(to_flint(lmi.at([x[0] - Fraction(1, 10**30), x[1]])))


def _versions(monkeypatch: pytest.MonkeyPatch, present: set[str]) -> None:
    def version(name: str) -> str:
        if name in present:
            return "0.2.3"
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(sdpa.metadata, "version", version)


def test_without_the_extra_the_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    _versions(monkeypatch, set())
    with pytest.raises(LmicError, match=r"pip install 'lmic\[multiprecision\]'"):
        solve_precisely(hyperbola(Fraction(1)))


def test_the_other_package_of_the_same_module_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    _versions(monkeypatch, {"sdpa-multiprecision", "sdpa-python"})
    with pytest.raises(LmicError, match="sdpa-python and sdpa-multiprecision install the same module"):
        solve_precisely(hyperbola(Fraction(1)))
