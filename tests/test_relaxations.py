"""Relaxations: what `auto` chooses and how sound it is, S1's griddings, exchange, monotonicity, searches."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from lmic import library
from lmic.algebra.polynomials import MatrixPolynomial
from lmic.compiler.assemble import ConicProblem
from lmic.dsl import PD, Bisection, Data, I, Scalar, Simplex, Source, Theorem, given, star
from lmic.errors import DomainError, LmicError, RelaxationError
from lmic.pipeline import finish, prepare, run
from lmic.plants.domains import BoxDomain, Motion
from lmic.plants.files import read_plant
from lmic.plants.plant import Plant
from lmic.plants.random import random_plant
from lmic.relax.family import Soundness
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation
from lmic.solve.clarabel import Clarabel
from lmic.solve.cone import Status
from lmic.solve.exchange import complete, solve_by_exchange
from lmic.solve.scaling import slack_matrices
from lmic.solve.solve import EXCHANGE_FROM
from lmic.solve.whole import solve_whole
from lmic.sweeps.search import bisect, line_search

WU = Path(__file__).parents[1] / "theorems" / "wu2007"
BOUNDED_REAL = library.theorem("standard.bounded_real_discrete")
BOX = BoxDomain(("r1", "r2"), (Fraction(-1), Fraction(0)), (Fraction(1), Fraction(1)))

#: rounding allowed where one optimum may not exceed another
SLACK = 1e-7

#: affine data on a box, and data whose gain is greatest inside it
AFFINE = {"A": [["r1/3", "0.1"], ["r2/4", "0.2"]], "B": [[1], [0]], "C": [[1, 0]], "D": [[0]]}
WAVY = {
    "A": [["0.3 + 0.2*r1", "0.4"], ["-0.3*r2", "0.2 + 0.1*r1*r2"]],
    "B": [["r2"], ["r1"]],
    "C": [["sin(3*r1)", "r2*(1 - r2)"]],
    "D": [[0]],
}


def matrices(texts: Mapping[str, Sequence[Sequence[Any]]]) -> dict[str, MatrixPolynomial]:
    """Decimals as the rationals they are written as."""
    return {
        name: MatrixPolynomial.from_sympy(sp.Matrix([[sp.sympify(str(e), rational=True) for e in row] for row in rows]))
        for name, rows in texts.items()
    }


def on_box(texts: Mapping[str, Any], step: Any = "free") -> Plant:
    return Plant(matrices(texts), {"rho": BOX}, {"rho": Motion(step=step)}, name="on a box")


def on_simplex(step: Any = "free") -> Plant:
    return replace(random_plant(BOUNDED_REAL, vertices=3, seed=1), motions={"rho": Motion(step=step)})


def problem_of(plant: Plant, dependence: Any, choice: Relaxation) -> ConicProblem:
    return finish(prepare(BOUNDED_REAL, plant, {"P": dependence}), {}, choice)


def gamma(plant: Plant, dependence: Any, choice: Relaxation) -> float:
    result = run(problem_of(plant, dependence, choice))
    assert result.solution.trusted
    return result.reports["gamma"]


def wu(number: int, choice: Relaxation) -> ConicProblem:
    return finish(prepare(library.theorem(f"wu2007.theorem{number}"), read_plant(WU / "example.toml")), {}, choice)


# What `auto` chooses ---------------------------------------------------------------------------------


def test_auto_grids_two_components_and_takes_the_vertices_of_the_others() -> None:
    problem = wu(3, Relaxation(grid={"r": 5}, ties={"b": "a"}))
    families = {family.lmi.place.lmi: family for family in problem.families}
    assert {name: len(family) for name, family in families.items()} == {"performance": 100, "P": 4, "Q": 4}
    performance = families["performance"]
    assert performance.methods == ("grid of 5 points", "grid of 5 points", "vertices", "vertices")
    assert [axis.soundness.value for axis in performance.axes] == ["sampled", "sampled", "exact", "exact"]
    assert performance.soundness is Soundness.SAMPLED
    for name in ("P", "Q"):
        assert families[name].methods == ("vertices", "vertices")
        assert families[name].soundness is Soundness.EXACT
    assert problem.soundness is Soundness.SAMPLED


def test_every_lmi_of_a_family_has_its_own_label() -> None:
    family = wu(3, Relaxation(grid={"r": 5}, ties={"b": "a"})).families[0]
    labels = [family.label(k) for k in range(len(family))]
    assert len(set(labels)) == 100
    assert labels[0] == ("r1@a = -1", "r2@a = 0", "r1@c: vertex 1", "r2@c: vertex 1")
    assert labels[-1][2:] == ("r1@c: vertex 2", "r2@c: vertex 2")


GRID = Relaxation(grid={"rho": 3})
#: plant, dependence of P, LMIs, methods and soundness
CHOSEN: dict[str, tuple[Plant, Any, int, set[str], str]] = {
    "simplex, constant": (on_simplex(), "constant", 3, {"vertices"}, "exact"),
    "simplex, affine": (on_simplex(), 1, 9, {"vertices"}, "exact"),
    "simplex, quadratic": (on_simplex(), 2, 36, {"Pólya degree 0"}, "sufficient"),
    "box, constant": (on_box(AFFINE), "constant", 4, {"vertices"}, "exact"),
    "box, affine": (on_box(AFFINE), 1, 16, {"vertices"}, "exact"),
    "box, quadratic": (on_box(AFFINE), 2, 81, {"grid of 3 points"}, "sampled"),
    "box, wavy data": (on_box(WAVY), 1, 36, {"vertices", "grid of 3 points"}, "sampled"),
    "box, bounded step": (on_box(AFFINE, {"r1": 0.5, "r2": 0.2}), 1, 21**2, {"Pólya degree 0"}, "sufficient"),
}


@pytest.mark.parametrize("name", CHOSEN)
def test_the_choice_and_its_soundness(name: str) -> None:
    plant, dependence, count, methods, soundness = CHOSEN[name]
    problem = problem_of(plant, dependence, GRID)
    (family,) = problem.families
    assert (len(family), set(family.methods)) == (count, methods)
    assert str(family.soundness) == str(problem.soundness) == soundness


def test_the_most_special_key_decides() -> None:
    choice = Relaxation(method={"rho": "polya", "rho+": "auto", "r2": "grid"}, grid={"rho": 3, "r2": 4})
    (family,) = problem_of(on_box(AFFINE), 1, choice).families
    assert family.methods == ("Pólya degree 0", "grid of 4 points", "vertices", "vertices")


# What does not fit -----------------------------------------------------------------------------------

UNFIT: dict[str, tuple[Any, Relaxation, str]] = {
    "vertices of a square": (
        2,
        Relaxation(method={"rho": "vertices"}),
        "dependence on r1 is of degree 2, so 'vertices' does not apply; what fits: --polya rho=0 or --grid rho=5",
    ),
    "no grid given": (
        2,
        Relaxation(),
        "dependence on r1 is of degree 2, but no grid is given; what fits: --polya rho=0 or --grid rho=5",
    ),
    "a grid without points": (
        1,
        Relaxation(method={"rho": "grid"}),
        "dependence on r1 is affine, but no grid is given; "
        "what fits: --relax rho=vertices or --polya rho=0 or --grid rho=5",
    ),
    "coefficients of a sine": (
        ["1", "sin(r1)"],
        Relaxation(method={"rho": "polya"}, grid={"rho": 3}),
        "dependence on r1 is not polynomial, so 'polya' does not apply; what fits: --grid rho=5",
    ),
    "a sine of a product": (
        ["1", "sin(r1*r2)"],
        Relaxation(grid={"rho": 3}),
        r"sin\(r1\*r2\) mixes symbols that vary independently.* joint grid \(random or points\)",
    ),
    "unknown method": (1, Relaxation(method={"rho": "sos"}), "'sos' is no relaxation; use auto, vertices, polya, grid"),
    "unknown parameter of a method": (1, Relaxation(method={"x": "grid"}), r"'x' is no parameter here; .* rho, rho\+"),
    "unknown parameter of a degree": (1, Relaxation(polya={"x": 1}), r"'x' is no parameter here; .* rho, rho\+"),
    "unknown parameter of a grid": (1, Relaxation(grid={"x": 3}), r"'x' is no parameter here; .* rho, rho\+"),
    "negative degree": (1, Relaxation(polya=-1), "Pólya degrees go from 0 to 50"),
    "enormous degree": (1, Relaxation(polya={"rho": 51}), "Pólya degrees go from 0 to 50"),
}


@pytest.mark.parametrize("name", UNFIT)
def test_a_relaxation_that_does_not_fit_says_what_does(name: str) -> None:
    dependence, choice, message = UNFIT[name]
    with pytest.raises(RelaxationError, match=message):
        problem_of(on_box(AFFINE), dependence, choice)


def test_an_option_without_any_parameter_is_refused() -> None:
    theorem, point = library.theorem("standard.stability_continuous"), Plant.polytopic(A=[[-1]])
    with pytest.raises(RelaxationError, match="'rho' is no parameter here; leave the option out, as there is none"):
        finish(prepare(theorem, replace(point, domains={}, motions={})), None, Relaxation(polya={"rho": 1}))


def test_a_joint_grid_fits_what_mixes_components() -> None:
    choice = Relaxation(method={"rho": "grid"}, grid={"rho": Grid(5, "random", seed=1)})
    (family,) = problem_of(on_box(AFFINE), ["1", "sin(r1*r2)"], choice).families
    assert (len(family), family.methods) == (25, ("grid of 5 points",) * 2)


def test_ties() -> None:
    with pytest.raises(DomainError, match="'q' is no instance of a parameter; the instances are a, b, c"):
        wu(3, Relaxation(grid={"r": 2}, ties={"q": "a"}))
    both = wu(3, Relaxation(grid={"r": 3}, ties={"b": "a", "c": "a"}))
    assert [len(family) for family in both.families] == [9, 4, 4]


def test_a_chain_of_ties_is_the_same_as_ties_to_one() -> None:
    chain = wu(3, Relaxation(grid={"r": 3}, ties={"b": "a", "c": "b"}))
    assert [len(family) for family in chain.families] == [9, 4, 4]


@pytest.mark.parametrize("ties", [{"a": "a"}, {"a": "b", "b": "a"}])
def test_ties_in_a_circle_are_an_error_of_ties(ties: dict[str, str]) -> None:
    with pytest.raises(LmicError) as caught:
        wu(3, Relaxation(grid={"r": 3}, ties=ties))
    assert "mixes symbols" not in str(caught.value)


TOO_LARGE = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
from lmic import library
from lmic.errors import RelaxationError
from lmic.pipeline import finish, prepare
from lmic.plants.files import read_plant
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation
binding = prepare(library.theorem("wu2007.theorem3"), read_plant(sys.argv[1]))
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
try:
    finish(binding, {}, Relaxation(grid={"r": Grid(int(sys.argv[2]), sys.argv[3])}))
except RelaxationError as error:
    print(error)
    print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024, "MiB")
"""


@pytest.mark.parametrize(("count", "kind"), [(10**5, "uniform"), (10**9, "uniform"), (10**9, "random")])
def test_too_large_a_grid_is_refused_before_it_is_written_down(count: int, kind: str) -> None:
    """In a process of its own, whose memory is bounded: a grid that is written down first must not hurt."""
    command = [sys.executable, "-c", TOO_LARGE, str(WU / "example.toml"), str(count), kind]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}  # each of its threads takes some, on many cores all
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, env=environment)
    assert done.returncode == 0, done.stderr[-500:]
    message, used = done.stdout.splitlines()
    assert "GB" in message
    assert "take fewer grid points" in message
    assert float(used.split()[0]) < 8


# S1 --------------------------------------------------------------------------------------------------

FROZEN, TIED, VERTICES = (
    Relaxation(grid={"r": 5}, ties={"b": "a", "c": "a"}),
    Relaxation(grid={"r": 5}, ties={"b": "a"}),
    Relaxation(grid={"r": 2}),
)


@pytest.mark.long
@pytest.mark.parametrize(
    ("number", "choice", "value"),
    [
        (3, FROZEN, 2.16999),
        (3, TIED, 2.324178),
        (3, VERTICES, 2.35916),
        (6, FROZEN, 1.52592),
        (6, TIED, 1.56285),
        (6, VERTICES, 1.61784),
    ],
)
def test_the_griddings_of_s1(number: int, choice: Relaxation, value: float) -> None:
    result = run(wu(number, choice))
    assert result.solution.trusted
    assert result.reports["gamma"] == pytest.approx(value, abs=1e-4)


@pytest.mark.long
def test_a_grid_and_the_vertices_of_what_is_affine_agree() -> None:
    """25 x 25 points and 25 x 4 vertices."""
    problems = wu(3, replace(TIED, method={"r[c]": "grid"})), wu(3, TIED)
    assert [len(problem.families[0]) for problem in problems] == [625, 100]
    grid, vertices = (run(problem).reports["gamma"] for problem in problems)
    assert grid == pytest.approx(vertices, abs=1e-5)
    assert vertices == pytest.approx(2.324178, abs=1e-5)


@pytest.mark.long
def test_exchange_on_15625_points() -> None:
    problem = wu(3, Relaxation(method={"r[c]": "grid"}, grid={"r": 5}))
    assert len(problem.families[0]) == 15_625
    result = run(problem)
    assert result.solution.trusted
    assert result.reports["gamma"] == pytest.approx(2.36326, abs=1e-5)


# Exchange --------------------------------------------------------------------------------------------

MANY = Relaxation(grid={"rho": 12})


def test_exchange_finds_the_optimum_of_all_points() -> None:
    problem = problem_of(on_box(WAVY, "constant"), 2, MANY)
    assert len(problem.orders) == 144 >= EXCHANGE_FROM
    whole, exchanged = solve_whole(problem, Clarabel()), solve_by_exchange(problem, Clarabel())
    assert whole.trusted
    assert exchanged.trusted
    assert exchanged.value == pytest.approx(whole.value, rel=1e-6)
    # measured on every point, not only on those that were solved
    packed = problem.matrix @ exchanged.x + problem.offset
    assert min(np.linalg.eigvalsh(m)[0] for m in slack_matrices(packed, problem.orders)) > -1e-9


def test_the_dual_of_an_exchange_bounds_the_whole_problem() -> None:
    problem = problem_of(on_box(WAVY, "constant"), 2, MANY)
    found = solve_by_exchange(problem, Clarabel())
    assert found.dual.shape == problem.offset.shape
    assert np.allclose(problem.matrix.T @ found.dual, problem.cost, atol=1e-7)
    duals = list(slack_matrices(found.dual, problem.orders))
    assert min(np.linalg.eigvalsh(dual)[0] for dual in duals) > -1e-9
    assert problem.constant - problem.offset @ found.dual == pytest.approx(found.value, rel=1e-6)
    assert found.bound == pytest.approx(found.value, rel=1e-6)
    assert sum(bool(np.any(dual)) for dual in duals) < len(duals) / 2


def test_exchange_finds_that_nothing_is_feasible() -> None:
    """At r = (1, 0), for one, the plant is unstable."""
    unstable = on_box({**WAVY, "A": [["1.5 + 0.2*r1", "0.4"], ["-0.3*r2", "0.2"]]}, "constant")
    found = solve_by_exchange(problem_of(unstable, 2, MANY), Clarabel())
    assert found.status is Status.INFEASIBLE
    assert found.value == np.inf


# Monotonicity ----------------------------------------------------------------------------------------


def non_increasing(values: Sequence[float]) -> bool:
    return all(b <= a + SLACK for a, b in pairwise(values))


def test_a_higher_polya_degree_is_never_worse() -> None:
    """γ ≥ |D| alone. By hand for D = ρ1² − 10 ρ1 ρ2 + ρ2², |D| ≤ 2: degrees 0 to 3 give 5, 3, 3, 2.6."""
    texts = {"A": [["0.1*rho1"]], "B": [[0]], "C": [[0]], "D": [["rho1**2 - 10*rho1*rho2 + rho2**2"]]}
    plant = replace(on_simplex(), matrices=matrices(texts))
    values = [gamma(plant, "constant", Relaxation(polya=degree)) for degree in range(4)]
    assert non_increasing(values)
    assert values == pytest.approx([5, 3, 3, 2.6], rel=1e-6)


def test_a_higher_polya_degree_is_never_worse_with_quadratic_unknowns() -> None:
    assert non_increasing([gamma(on_simplex(), 2, Relaxation(polya=degree)) for degree in range(3)])


def test_a_richer_basis_is_never_worse() -> None:
    values = [gamma(on_simplex(), degree, Relaxation(polya=1)) for degree in range(3)]
    assert non_increasing(values)
    assert values[1] < values[0] - 1e-5
    bases: list[Any] = ["constant", ["1", "r1"], 1, ["1", "r1", "r2", "sin(3*r1)"]]
    assert non_increasing([gamma(on_box(WAVY), basis, Relaxation(grid={"rho": 3})) for basis in bases])


def test_a_finer_nested_grid_is_never_better() -> None:
    values = [gamma(on_box(WAVY, "constant"), 1, Relaxation(grid={"rho": count})) for count in (3, 5, 9)]
    assert non_increasing(values[::-1])
    assert values[1] > values[0] + 0.1


def test_a_bounded_step_lies_between_constant_and_free() -> None:
    bounds = [dict.fromkeys(("rho1", "rho2", "rho3"), bound) for bound in (0.1, 0.4)]
    values = [gamma(on_simplex(step), 1, Relaxation(polya=1)) for step in ("constant", *bounds, "free")]
    assert non_increasing(values[::-1])
    assert values[0] < values[1] < values[2] < values[3]


# Searches --------------------------------------------------------------------------------------------

eps, level = given("eps"), Scalar("level")
PARABOLA = Theorem(
    title="level ≥ 1 + (eps − 2)²",
    minimise=level,
    lmis={"parabola": PD([[level - 1, eps - 2], [star, 1]])},
    source=Source("", "", "", 2024),
)


def test_line_search_finds_a_minimum_inside() -> None:
    found = line_search(prepare(PARABOLA, Plant({})), "eps", -3, 11, tolerance=1e-3)
    assert found.value == pytest.approx(2, abs=2 * 1e-3 * 14)
    assert found.result.solution.value == pytest.approx(1, abs=1e-3)
    assert found.other <= 1e-3 * 14


def test_line_search_reaches_the_best_of_a_dense_sweep(example_1: Plant) -> None:
    binding = prepare(library.theorem("peixoto2025.theorem1"), example_1)
    sweep = [run(finish(binding, {"eps": value})).reports["gamma"] for value in np.linspace(1, 61, 15).tolist()]
    found = line_search(binding, "eps", 1, 61, tolerance=0.1, samples=5)
    assert found.solves < len(sweep)
    assert found.result.reports["gamma"] <= min(sweep) + SLACK
    assert 1 <= found.value <= 61


def test_bisection_finds_the_spectral_radius() -> None:
    A = [[Fraction(1, 2), Fraction(2, 5)], [Fraction(-3, 10), Fraction(3, 5)]]
    binding = prepare(library.theorem("standard.decay_rate_discrete"), Plant(matrices({"A": A})))
    found = bisect(binding, 0.1, 2, tolerance=1e-6)
    radius = max(abs(np.linalg.eigvals(np.array(A, dtype=float))))
    assert found.value == pytest.approx(radius, rel=1e-5)
    assert found.other <= radius * (1 + 1e-9) <= found.value * (1 + 1e-9)
    with pytest.raises(LmicError, match=r"no solution at beta = 0\.2; widen the bracket"):
        bisect(binding, 0.1, 0.2)


def test_searches_that_cannot_be_done(example_1: Plant) -> None:
    with pytest.raises(LmicError, match="nothing is declared to be bisected; use a line search"):
        bisect(prepare(library.theorem("peixoto2025.theorem1"), example_1), 1, 2)


def test_a_bisection_towards_zero_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """Feasible at every positive value, or at zero alone: no bracket is ever narrow beside its own ends."""
    for goal, holds in (("minimise", lambda beta: beta > 0), ("maximise", lambda beta: beta <= 0)):
        calls: list[float] = []

        def solved(values: dict[str, float], *_: Any, holds: Any = holds, calls: list[float] = calls) -> Any:
            calls.append(values["beta"])
            assert len(calls) < 100
            status = Status.SOLVED if holds(values["beta"]) else Status.INFEASIBLE
            return SimpleNamespace(solution=SimpleNamespace(status=status))

        monkeypatch.setattr("lmic.sweeps.search.finish", lambda binding, values, relaxation: values)
        monkeypatch.setattr("lmic.sweeps.search.run", solved)
        binding: Any = SimpleNamespace(theorem=SimpleNamespace(name="t", bisect=Bisection(given("beta"), goal)))
        assert abs(bisect(binding, 0, 2).value) <= 1e-11


def test_violations_are_those_of_all_lmis() -> None:
    """mu ≥ 1, solved alone, is missed by mu ≥ 3 by two, and by mu ≥ 2 by one."""
    mu, alpha = Scalar("mu"), Simplex("alpha")
    lmis = {"above": PD(mu * I(1) - Data("A", 1, 1)(alpha))}
    theorem = Theorem(lmis=lmis, source=Source("N. N.", "A test", "unpublished", 2026), minimise=mu, name="above")
    problem = finish(prepare(theorem, Plant.polytopic(A=[[[1]], [[3]], [[2]]])))
    active = np.array([0])
    found = complete(problem, active, solve_whole(problem.restricted(active), Clarabel()))
    assert found.violation == pytest.approx(-2, abs=1e-6)
    assert found.relative_violation == pytest.approx(-1)
    assert found.worst == problem.label(1) or found.worst == problem.label(2)
