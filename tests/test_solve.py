"""Solving: values against optima enclosed by exact proofs, lineality, scaling, warnings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sps
import sympy as sp
from conftest import EXAMPLE_1
from test_diagonal import LEAST, ones

from lmic import library
from lmic.algebra.polynomials import MatrixPolynomial
from lmic.dsl import PD, I, Scalar
from lmic.errors import RecoveryError
from lmic.pipeline import compile, finish, prepare, run
from lmic.plants.files import read_plant
from lmic.plants.plant import Plant, exact_array
from lmic.solve.attainment import with_attainment
from lmic.solve.clarabel import Clarabel
from lmic.solve.cone import ConeAnswer, ConeData, Status
from lmic.solve.lineality import lineality
from lmic.solve.passes import PASSES
from lmic.solve.solve import solve

# γ of Example 1, computed independently of lmic: a dense prototype of Theorem 1 solved by SDPA in
# 200-bit arithmetic, the optimum enclosed from both sides by exact rational proofs.
REFERENCE = {
    ("peixoto2025.theorem1", 1): 12.56046971834415863,
    ("peixoto2025.theorem1", 10): 1.719904163691479878,
    ("peixoto2025.theorem1", 50): 1.215248599689679686,
    ("peixoto2025.theorem1", 150): 1.213769249285198035,
    ("peixoto2025.theorem1", 1000): 1.213638820286880660,
    ("peixoto2025.corollary1", 1): 14.91287332096275712,
    ("peixoto2025.corollary1", 10): 8.318716925531442742,
    ("peixoto2025.corollary1", 50): 8.183950239239421206,
    ("peixoto2025.corollary1", 150): 8.171543751332294879,
    ("peixoto2025.corollary1", 1000): 8.167089700085760642,
}


@pytest.mark.parametrize(("name", "eps"), list(REFERENCE))
def test_example_1_to_eight_digits(name: str, eps: int, example_1: Plant) -> None:
    result = run(compile(library.theorem(name), example_1, {"eps": eps}))
    assert result.solution.trusted
    assert result.reports["gamma"] == pytest.approx(REFERENCE[name, eps], rel=1e-8)
    assert result.solution.relative_violation > -1e-12


def test_one_binding_serves_every_scalar(example_1: Plant) -> None:
    """A sweep binds once; the values are those of compiling anew."""
    binding = prepare(library.theorem("peixoto2025.theorem1"), example_1)
    for eps in (10, 150):
        swept = finish(binding, {"eps": eps})
        fresh = compile(library.theorem("peixoto2025.theorem1"), example_1, {"eps": eps})
        assert abs(swept.columns - fresh.columns).max() < 1e-13


def test_lineality_is_found_and_put_back_as_zeros(example_1: Plant) -> None:
    for name, rank in (("peixoto2025.theorem1", 96), ("peixoto2025.corollary1", 80)):
        problem = compile(library.theorem(name), example_1, {"eps": 150})
        kept = lineality(problem.matrix).kept
        assert (problem.size, len(kept)) == (rank + 1, rank)
        solution = solve(problem)
        left_out = np.setdiff1d(np.arange(problem.size), kept)
        assert solution.lineality == 1
        assert (solution.x[left_out] == 0).all()


def test_rank_of_a_tall_matrix_is_found() -> None:
    generator = np.random.default_rng(0)
    tall = generator.standard_normal((5000, 12)) @ generator.standard_normal((12, 20))
    found = lineality(sps.csc_array(tall))
    assert len(found.kept) == 12
    assert np.allclose(tall[:, found.kept] @ found.combinations, tall[:, found.left_out])


def test_values_do_not_depend_on_the_units_of_the_state() -> None:
    """x → Tx is a congruence of Theorem 1 with new unknowns T⁻ᵀXT⁻¹: γ stays, whatever the units."""
    scale = np.array([1e3, 1e-3])
    scaled = {}
    for key, value in EXAMPLE_1.items():
        array = np.array(value, dtype=float)
        array = scale[:, None] * array if key in ("A", "B_w") else array
        scaled[key] = (array / scale if key in ("A", "C_y", "C_z") else array).tolist()
    result = run(compile(library.theorem("peixoto2025.theorem1"), Plant.polytopic(**scaled), {"eps": 150}))
    assert result.solution.relative_violation > -1e-9
    assert result.reports["gamma"] == pytest.approx(REFERENCE["peixoto2025.theorem1", 150], rel=1e-6)


class WithoutEffort:
    """A solver that stops at once with a point outside the cones, calling it solved."""

    name = "lazy"

    def __call__(self, data: ConeData, rough: bool = False) -> ConeAnswer:
        answer = Clarabel(max_iter=3)(data)
        return ConeAnswer(Status.SOLVED, answer.y, answer.s, answer.z, 3, "Solved")


def test_a_wrong_number_is_called_so_whatever_the_solver_says(example_1: Plant) -> None:
    problem = compile(library.theorem("peixoto2025.corollary1"), example_1, {"eps": 150})
    solution = solve(problem, WithoutEffort(), passes=1)
    assert solution.status is Status.ALMOST
    assert not solution.trusted
    assert any("no bound" in warning or "differ" in warning for warning in solution.warnings)


def test_infeasible_is_an_answer(example_1: Plant) -> None:
    """The bounded gain cannot be negative: −δ − 1 ⪰ 0 beside the theorem leaves nothing."""
    import dataclasses

    theorem = library.theorem("peixoto2025.theorem1")
    impossible = dataclasses.replace(
        theorem, lmis={**theorem.lmis, "impossible": PD([[-Scalar("delta") * I(1) - I(1)]])}
    )
    result = run(compile(impossible, example_1, {"eps": 150}))
    assert result.solution.status is Status.INFEASIBLE
    assert result.reports == {}


def test_unbounded_is_an_answer(example_1: Plant) -> None:

    theorem = library.theorem("peixoto2025.theorem1")
    upside_down = replace(theorem, minimise=-Scalar("delta"))
    assert solve(compile(upside_down, example_1, {"eps": 150})).status is Status.UNBOUNDED
    problem = compile(theorem, example_1, {"eps": 150})
    along = np.zeros(problem.size)
    along[lineality(problem.matrix).left_out] = 1  # an objective that falls along a direction which no LMI sees
    assert solve(replace(problem, cost=along)).status is Status.UNBOUNDED


class CallsItInfeasible:
    """A solver whose first word is wrong: it calls a solvable problem infeasible."""

    name = "pessimist"

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self, data: ConeData, rough: bool = False) -> ConeAnswer:
        self.calls += 1
        answer = Clarabel()(data, rough)
        return replace(answer, status=Status.INFEASIBLE) if self.calls == 1 else answer


def test_a_false_word_of_infeasibility_is_not_repeated(example_1: Plant) -> None:
    solution = solve(compile(library.theorem("peixoto2025.theorem1"), example_1, {"eps": 150}), CallsItInfeasible())
    assert solution.trusted
    assert np.sqrt(solution.value) == pytest.approx(REFERENCE["peixoto2025.theorem1", 150], rel=1e-8)


def test_a_report_that_is_not_real_is_an_error(example_1: Plant) -> None:
    theorem = library.theorem("peixoto2025.theorem1")
    impossible = replace(theorem, reports={"gamma": sp.sqrt(-theorem.minimise)})
    with pytest.raises(RecoveryError, match=r"the report gamma = sqrt\(-delta\) .* not real"):
        run(compile(impossible, example_1, {"eps": 150}))


def test_diverging_unknowns_are_not_mistaken_for_an_infimum() -> None:
    """Example 2 with ρ = 1 has flat directions along which the unknowns grow; its optimum is attained."""
    plant = read_plant(library.root() / "peixoto2025" / "example2.toml")
    problem = compile(library.theorem("peixoto2025.theorem1"), plant, {"rho": 1, "eps": 2})
    doubted = replace(solve(problem), warnings=("as if there were something to look into",))
    assert with_attainment(problem, doubted, Clarabel(), PASSES).attained


def test_a_search_for_the_margin_that_ends_early_claims_nothing() -> None:
    """A point without a margin, and a dual that bounds none, do not show that there is no better point."""

    class Lost:
        name = "lost"

        def __call__(self, data: ConeData, rough: bool = False) -> ConeAnswer:
            y = np.zeros(len(data.cost))
            y[-1] = -1.0  # the margin
            return ConeAnswer(Status.FAILED, y, data.matrix @ y + data.offset, np.zeros(len(data.offset)), 1, "lost")

    matrices = {"A": MatrixPolynomial.constant(exact_array([[-1, 3], [0, -2]], "A"))}
    problem = compile(library.theorem("standard.stability_continuous"), Plant(matrices, name="stable"))
    assert solve(problem, Clarabel()).status is Status.SOLVED
    assert solve(problem, Lost(), passes=1).status is not Status.INFEASIBLE


def test_a_slack_that_vanishes_as_a_whole_is_survived() -> None:
    """The least trace of T ⪰ M is that of M: at the optimum every LMI is zero, and no coordinates come from it."""
    result = run(compile(LEAST.variant("full"), ones(2)))
    assert result.reports["least"] == pytest.approx(0, abs=1e-6)
