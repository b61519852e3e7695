"""The names of the package, and what they do together."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lmic
from lmic.analysis.norms import frozen_gain
from lmic.library import root
from lmic.papers.cases import Case, case_tables
from lmic.papers.reproduce import Verdict, reproduce, run_simulation, verdict
from lmic.papers.signals import signal
from lmic.recover.recover import Design


def test_every_public_name_loads() -> None:
    for name in lmic._HOME:
        assert getattr(lmic, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = lmic.nothing


def test_importing_lmic_loads_nothing_heavy() -> None:
    code = "import sys, lmic.cli; print([m for m in ('sympy', 'numpy', 'scipy') if m in sys.modules])"
    assert (
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip() == "[]"
    )


def test_design_is_a_function_of_the_parameter() -> None:
    """Recovery formulas at a point: A_F = H⁻¹ A_f with the unknowns combined by hand."""
    theorem = lmic.theorem("peixoto2025.theorem1")
    result = lmic.run(lmic.compile(theorem, lmic.read_plant(root() / "peixoto2025" / "example1.toml"), {"eps": 150}))
    alpha = np.array([0.3, 0.7])
    unknowns = {n: np.tensordot(alpha, u.matrices(result.solution.x), 1) if len(u.functions) == 2 else None
                for n, u in result.problem.layout.unknowns.items()}  # fmt: skip
    design: Design = result.design
    assert np.allclose(design(alpha=alpha)["A_F"], np.linalg.solve(unknowns["H"], unknowns["A_f"]))
    assert design(alpha=np.array([alpha, alpha]))["B_F"].shape == (2, 2, 1)


def test_reproduction_of_s2_with_its_simulation() -> None:
    """Table 1, the frozen norm at the vertices and the gain along Figure 1's trajectory stay below γ."""
    (table,) = [table for table in case_tables() if table.group == "peixoto2025"]
    outcomes = {outcome.case.id: outcome for outcome in reproduce(table)}
    for outcome in outcomes.values():
        assert outcome.value == pytest.approx(float(outcome.case.reference), rel=1e-8)
        assert outcome.frozen.norm < outcome.frozen.bound == outcome.value
    assert outcomes["peixoto2025.table1.parameter_dependent"].verdict is Verdict.REPRODUCED
    assert outcomes["peixoto2025.table1.robust"].verdict is Verdict.BETTER
    for case, trajectory in run_simulation(table.simulations[0], outcomes).items():
        assert trajectory.gain < outcomes[case].value


def printed_as(text: str) -> Case:
    return next(case for table in case_tables() for case in table.cases if str(case.paper) == text)


@pytest.mark.parametrize(
    ("value", "below", "bound", "expected"),
    [
        (1.21, None, None, Verdict.REPRODUCED),
        (1.30, None, None, Verdict.WORSE),  # above the paper's value, which alone refutes nothing
        (1.30, "point", 1.2149, Verdict.WORSE),
        (1.30, "point", 1.22, Verdict.REFUTED),
        (1.10, None, None, Verdict.BETTER),
    ],
)
def test_verdicts(value: float, below: str | None, bound: float | None, expected: Verdict) -> None:
    case = printed_as("1.21")
    bounds = {} if bound is None else {"point": bound}
    assert verdict(replace(case, below=below), value, 0.0, bounds) is expected
    assert verdict(case, value, float("inf"), bounds) is Verdict.UNTRUSTED


def test_a_verdict_that_the_doubt_could_change_is_none() -> None:
    """1.21 is reproduced by 1.213 within 1e-3; within 0.01 it may as well be missed, and 1.19 may be no better."""
    case = printed_as("1.21")
    assert verdict(case, 1.213, 1e-3, {}) is Verdict.REPRODUCED
    assert verdict(case, 1.213, 1e-2, {}) is Verdict.UNTRUSTED
    assert verdict(case, 1.19, 1e-3, {}) is Verdict.BETTER
    assert verdict(case, 1.19, 5e-2, {}) is Verdict.UNTRUSTED
    assert verdict(case, 1.25, 5e-2, {}) is Verdict.UNTRUSTED


def test_frozen_gain_against_a_frequency_sweep() -> None:
    result = lmic.run(
        lmic.compile(
            lmic.theorem("peixoto2025.corollary1"),
            lmic.read_plant(root() / "peixoto2025" / "example1.toml"),
            {"eps": 150},
        )
    )
    system = result.theorem.guarantees[0].system
    (norm,) = frozen_gain(result.design, system, {"alpha": [[0.5, 0.5]]})
    m = {name: matrix[0] for name, matrix in result.design.frozen(system, {"alpha": [[0.5, 0.5]]}).items()}
    z = np.exp(1j * np.linspace(0, np.pi, 4001))[:, None, None]
    response = m["C"] @ np.linalg.solve(z * np.eye(len(m["A"])) - m["A"], m["B"]) + m["D"]
    assert norm == pytest.approx(np.linalg.svd(response, compute_uv=False).max(), rel=1e-4)


def test_signals_of_case_tables() -> None:
    assert signal(["where(k >= 2, k, 0)"], [4])[:, 0].tolist() == [0, 0, 2, 3]
    assert signal(["i + 10*j"], [2, 3])[..., 0].tolist() == [[0, 10, 20], [1, 11, 21]]


def test_plants_and_cases_of_the_library_read() -> None:
    for path in Path(root()).rglob("*.toml"):
        if path.name != "cases.toml":
            assert lmic.read_plant(path).matrices
    assert {table.group for table in case_tables()} >= {"peixoto2025", "wu2007", "delay_lpv"}


@pytest.mark.long
def test_reproduction_of_s1() -> None:
    """The three griddings of both norms; the single point refutes the printed values."""
    (table,) = [table for table in case_tables() if table.group == "wu2007"]
    for outcome in reproduce(table):
        assert outcome.verdict is (Verdict.REFUTED if outcome.case.paper else Verdict.ADDED)
        if outcome.case.reference is not None:
            assert outcome.value == pytest.approx(float(outcome.case.reference), rel=1e-5)
        if outcome.frozen is not None:
            assert outcome.frozen.norm < outcome.frozen.bound


@pytest.mark.long
def test_stand_in_of_s0_grows_with_the_delay() -> None:
    (table,) = [table for table in case_tables() if table.group == "delay_lpv"]
    outcomes = list(reproduce(table))
    assert [outcome.verdict for outcome in outcomes] == [Verdict.STAND_IN] * 4
    assert (np.diff([outcome.value for outcome in outcomes]) > 0).all()
