"""Diagnoses of problems whose cause is known by hand."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from interchange_tools import LAG_GAIN, lag

import lmic
from lmic.cli import main
from lmic.diagnosis.distance import distance
from lmic.diagnosis.neighbours import Chosen, neighbours
from lmic.diagnosis.unseen import unseen_directions
from lmic.dsl import PD, Data, He, I, Matrix, Scalar, Source, Symmetric, Theorem, dims, star
from lmic.pipeline import compile, run
from lmic.plants.plant import Plant
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation
from lmic.solve.clarabel import Clarabel

SOURCE = Source("nobody", "nothing", "nowhere", 2026)
(n,) = dims("n")
A = Data("A", n, n)
P, G, X, mu = Symmetric("P", n), Matrix("G", n, n), Symmetric("X", n), Scalar("mu")
STABLE = lmic.theorem("standard.stability_discrete")
LEMMA = lmic.theorem("standard.bounded_real_discrete")


def statement(minimise: Any = None, **lmis: Any) -> Theorem:
    return Theorem(lmis={name: PD(rows) for name, rows in lmis.items()}, minimise=minimise, source=SOURCE, name="made")


def switched(size: float) -> Plant:
    """Nilpotent at both vertices; the product of the two has the eigenvalue size²."""
    return Plant.polytopic("rho", A=[[[0, size], [0, 0]], [[0, 0], [size, 0]]])


def test_the_vertex_that_binds() -> None:
    """x⁺ = a x + w with a of 1/2 or 0: only the slow mode decides γ."""
    plant = Plant.polytopic("rho", A=[[["1/2"]], [[0]]], B=[[1]], C=[[1]], D=[[0]])
    found = lmic.diagnose(LEMMA, plant, patience=0)
    first = found.binding.shares[0]
    assert (first.lmi, first.points) == ("dissipation", ("rho: vertex 1", "rho+: vertex 1"))
    assert first.share == pytest.approx(1, abs=1e-3)
    assert sum(one.share for one in found.binding.shares) == pytest.approx(1)
    assert found.binding.by_point["rho: vertex 1"] == pytest.approx(1, abs=1e-3)
    assert found.result.reports["gamma"] == pytest.approx(2)
    assert len(found.trials) == 1
    assert found.untried


def test_the_unknown_that_diverges() -> None:
    """mu·X > 1 has the infimum 0, at X without bound; P lies between 0 and 1 and stays."""
    theorem = statement(mu, corner=[[mu * I(n), I(n)], [star, X]], other=[[P, 0], [star, I(n) - P]])
    found = lmic.diagnose(theorem, Plant({}), sizes={"n": 1}, patience=0)
    (worst,) = found.growth.diverging
    assert worst.unknown == "X"
    assert worst.power == pytest.approx(1, abs=0.05)
    assert worst.within == pytest.approx(found.growth.bounds, rel=0.1)
    assert found.growth.falls
    assert found.growth.objectives == pytest.approx([1 / bound for bound in found.growth.bounds], rel=0.1)
    assert any("X grow with every bound (X " in sentence for sentence in found.advice)


def test_the_direction_that_no_lmi_sees() -> None:
    """He(G) does not see the skew part of G."""
    problem = compile(statement(None, one=[[He(G) - I(n)]]), Plant({}), sizes={"n": 2})
    (direction,) = unseen_directions(problem)
    assert direction.unknowns == ("G",)
    assert direction.text in ("G[1,2] - G[2,1]", "G[2,1] - G[1,2]")


def test_ranges_are_those_of_the_data() -> None:
    plant = Plant.polytopic("rho", A=[[["1/2"]], [[-0.25]]], B=[[1000]], C=[[1]], D=[[0]])
    found = lmic.diagnose(LEMMA, plant, patience=0)
    ranges = {one.what: (one.smallest, one.largest) for one in found.data}
    assert ranges["A"] == (0.25, 0.5)
    assert ranges["B"] == (1000, 1000)
    assert found.lmis[0].largest == pytest.approx(1000 * np.sqrt(2))


def test_how_far_infeasible() -> None:
    """P > 0 and c − P > 0 in one unknown: F ⪰ t I needs t ≤ P and t ≤ c − P, in scaled units at the most c/2."""
    for c in (-2, -0.5, 0.5):
        theorem = statement(None, lower=[[P]], upper=[[He(A) - P]])
        problem = compile(theorem, Plant.polytopic(A=[[c / 2]]))
        found = distance(problem, Clarabel())
        # columns of norm 1: entries 1/√2, rows scaled to their largest entry
        p = 1 / np.sqrt(2)
        largest = max(abs(c), p)
        # t = y·p/p and t = (c − y·p)/largest
        assert found.margin == pytest.approx(c / largest / (1 + p / largest), rel=1e-4)
        assert found.bound >= found.margin - 1e-6
        assert {one.lmi for one in found.shares.shares if one.share > 0.1} == {"lower", "upper"}


def test_homogeneous_and_infeasible() -> None:
    found = lmic.diagnose(STABLE, switched(1.5))
    assert found.result.solution.status == "infeasible"
    assert found.distance is not None
    assert found.distance.margin < -0.01
    assert found.growth.growths == ()
    held = found.distance.shares.by_lmi
    assert next(iter(held)) == "decrease"
    assert found.trials[1:]
    assert not any(one.feasible for one in found.trials)
    assert "None of the" in found.advice[-1]
    nearer = lmic.diagnose(STABLE, switched(1.05), patience=0)
    assert nearer.distance is not None
    assert found.distance.margin < nearer.distance.margin < 0


def test_the_basis_that_helps() -> None:
    """Stable however ρ moves, which P that is affine in ρ shows and no constant one does."""
    plant = Plant.polytopic("rho", A=[[[0.3, -0.6], [-0.7, -0.5]], [[0.6, 0.1], [-1.2, -0.3]]])
    found = lmic.diagnose(STABLE, plant, dependence={"P": "constant"})
    assert found.result.solution.status == "infeasible"
    assert [one.option for one in found.trials if one.feasible] == ["--dependence P=1"]
    assert "--dependence P=1 has a solution (exact): take it." in found.advice
    other = lmic.diagnose(STABLE, plant)
    assert other.distance is not None
    assert other.distance.margin > 0


def chosen(relaxation: Relaxation | None = None, **dependence: Any) -> Chosen:
    plant = Plant.polytopic("alpha", **EXAMPLE)
    return Chosen(lmic.theorem("peixoto2025.theorem1"), plant, {"eps": 10}, dependence, relaxation or Relaxation())


EXAMPLE: dict[str, Any] = {
    "A": [[[0.43, 0], [1, 0.48]], [[0.1, 0.9], [0, 0.05]]],
    "B_w": [[[2], [0.1]], [[1], [0.1]]],
    "C_y": [[1, 0]],
    "D_y": [[1]],
    "C_z": [[1, 0], [0, 1]],
    "D_z": [[0], [0]],
}


def options(choice: Chosen) -> list[str]:
    return [option for option, _ in neighbours(choice, choice.compile())]


def test_neighbours_are_those_that_apply() -> None:
    found = options(chosen(Relaxation(polya={"alpha": 1}), P1="constant"))
    assert "--polya alpha=0" in found
    assert "--polya alpha=2" in found
    assert "--dependence P1=1" in found
    assert "--dependence P1=2" not in found
    assert "--dependence H=constant" in found
    assert not [option for option in found if option.startswith("--grid")]
    gridded = options(chosen(Relaxation(method={"alpha": "grid"}, grid={"alpha": Grid(5)})))
    assert {"--grid alpha=3", "--grid alpha=9", "--relax alpha=polya"} <= set(gridded)
    assert not [option for option in gridded if option.startswith("--polya")]


def test_a_neighbour_that_cannot_be_compiled_says_why() -> None:
    found = lmic.diagnose(
        LEMMA,
        Plant.polytopic("rho", A=[[["1/2"]], [[0]]], B=[[1]], C=[[1]], D=[[0]]),
        relaxation=Relaxation(polya={"rho": 50}),
    )
    assert all(one.failure or one.value for one in found.trials)


def test_the_record_is_the_solution_solve_finds() -> None:
    found = lmic.diagnose(LEMMA, lag().binding.plant)
    assert found.result.reports["gamma"] == pytest.approx(LAG_GAIN)
    assert found.trials[0].value == pytest.approx(run(lag()).reports["gamma"], rel=1e-9)
    assert found.distance is None


PLANT = """name = "lag"
[parameters.rho]
simplex = 2
[matrices]
A = { vertices = [[["1/2"]], [["-1/2"]]] }
B = [[1]]
C = [[1]]
D = [[0]]
"""


def test_the_command(tmp_path: Any) -> None:
    (tmp_path / "plant.toml").write_text(PLANT)
    words = ["diagnose", "standard.bounded_real_discrete", "--plant", str(tmp_path / "plant.toml")]
    shown = CliRunner().invoke(main, words)
    assert shown.exit_code == 0, shown.output
    for part in (
        "share of the dual",
        "largest entry",
        "data A",
        "lineality: no directions",
        "as given",
        "--dependence P",
    ):
        assert part in shown.output
    record = json.loads(CliRunner().invoke(main, [*words, "--json", "--patience", "0"]).output)
    assert record["reports"]["gamma"] == pytest.approx(LAG_GAIN)
    assert record["choices"][0]["option"] == ""
    assert record["not_tried"] == ["--dependence P=constant", "--dependence P=2"]
    assert record["conclusions"]
    bad = CliRunner().invoke(main, [*words[:3], str(tmp_path / "no.toml")])
    assert bad.exit_code == 1
    assert bad.output.count("\n") == 1
