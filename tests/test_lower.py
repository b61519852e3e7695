"""Exact dual matrices: faces, bounds for bounded unknowns, balls, infeasibility, and both precisions."""

from __future__ import annotations

import json
import random
from dataclasses import replace
from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import flint
import numpy as np
import pytest
from click.testing import CliRunner

from lmic import library
from lmic.algebra.polynomials import MatrixPolynomial
from lmic.analysis.sampling import Gain, cover
from lmic.certify import certify as certifying
from lmic.certify.candidates import in_multiprecision
from lmic.certify.certificate import Certificate, Standing
from lmic.certify.certificate_file import parsed, text
from lmic.certify.certify import certify
from lmic.certify.dual import bounded_dual, exact_dual
from lmic.certify.ends import blank, exact_problems
from lmic.certify.face import compressed
from lmic.certify.finite import FiniteLMI, FiniteProblem
from lmic.certify.lower import Dual, bounded_lower_bound, lower_bound
from lmic.certify.statement import fractions
from lmic.certify.verify import verify
from lmic.cli import main
from lmic.errors import CertificateError, LmicError
from lmic.pipeline import Result, compile, run
from lmic.plants.files import read_plant
from lmic.plants.plant import Plant, exact_array
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation
from lmic.solve.cone import Status
from lmic.solve.scaling import slack_matrices

ROOT = library.root()
EXAMPLE_1 = ROOT / "peixoto2025" / "example1.toml"
needs_sdpa = pytest.mark.skipif(find_spec("sdpap") is None, reason="the extra 'multiprecision' is not installed")


def constant_plant(**matrices: Any) -> Plant:
    exact = {name: MatrixPolynomial.constant(exact_array(rows, name)) for name, rows in matrices.items()}
    return Plant(exact, name="test plant")


def problem_of(lmis: list[list[Any]], cost: list[Any]) -> FiniteProblem:
    """From [F_0, F_1, …] of each LMI."""
    found = []
    for matrices in lmis:
        arrays = [np.array(matrix, dtype=object) for matrix in matrices]
        entries = [
            (k, i, j, Fraction(matrix[i, j]))
            for k, matrix in enumerate(arrays)
            for i in range(len(matrix))
            for j in range(i, len(matrix))
            if matrix[i, j]
        ]
        columns, rows, cols, values = zip(*entries, strict=True)
        found.append(FiniteLMI(len(arrays[0]), *map(np.array, (columns, rows, cols)), np.array(values, dtype=object)))
    return FiniteProblem(tuple(found), np.array([Fraction(c) for c in cost], dtype=object), Fraction(0))


# Faces ------------------------------------------------------------------------------------------------


def receding() -> FiniteProblem:
    """minimise x with [[x, 1], [1, 2]] ⪰ 0 and diag(y, y) + [[0, 1], [1, 0]] x ⪰ 0: the optimum is 1/2.

    y grows for nothing, so that the second dual matrix W has tr W = 0: it is zero.
    """
    first = [[[0, 1], [1, 2]], [[1, 0], [0, 0]], [[0, 0], [0, 0]]]
    second = [[[0, 0], [0, 0]], [[0, 1], [1, 0]], [[1, 0], [0, 1]]]
    return problem_of([first, second], [1, 0])


def test_a_dual_that_must_vanish_is_found_on_its_face() -> None:
    problem = receding()
    near = [fractions([[1, -0.5], [-0.5, 0.25 + 1e-9]]), fractions(1e-12 * np.eye(2))]
    dual, bound = exact_dual(problem, near)
    assert dual.faces[0] is None
    assert dual.faces[1] is not None
    assert dual.faces[1].shape == (2, 0)
    assert Fraction(1, 2) - Fraction(1, 10**8) < bound <= Fraction(1, 2)
    assert lower_bound(problem, dual) == bound


def test_a_face_across_the_axes() -> None:
    """diag(y, y) + … with the direction (1, −1) growing: W must vanish on it, not on an axis."""
    first = [[[0, 1], [1, 2]], [[1, 0], [0, 0]], [[0, 0], [0, 0]]]
    second = [[[2, 1], [1, 2]], [[1, 1], [1, 1]], [[1, -1], [-1, 1]]]
    problem = problem_of([first, second], [1, 0])
    near = [fractions([[1, -0.5], [-0.5, 0.25 + 1e-9]]), fractions([[1e-6, 9.999e-7], [9.999e-7, 1e-6]])]
    dual, bound = exact_dual(problem, near)
    assert dual.faces[1] is not None
    assert dual.faces[1].tolist() == [[1], [1]]
    assert Fraction(49, 100) < bound <= Fraction(1, 2)


def test_compressed_matrices_are_congruent() -> None:
    generator = random.Random(3)
    for _ in range(50):
        order, size, width = generator.randint(1, 5), generator.randint(1, 4), generator.randint(0, 4)
        matrices = []
        for _ in range(size + 1):
            full = np.array([[generator.randint(-3, 3) for _ in range(order)] for _ in range(order)])
            matrices.append(full + full.T + 7 * np.eye(order, dtype=int))
        problem = problem_of([matrices], [0] * size)
        face = np.array([[generator.randint(-2, 2) for _ in range(width)] for _ in range(order)], dtype=object)
        x = [Fraction(generator.randint(-9, 9), 4) for _ in range(size)]
        small = compressed(problem, [face.reshape(order, width)]).lmis[0].at(x)
        assert (small == face.reshape(order, width).T @ problem.lmis[0].at(x) @ face.reshape(order, width)).all()


def test_no_claim_above_the_optimum_is_proven() -> None:
    """1,000 duals of x ≥ 1/2, nudged: what is proven never exceeds 1/2, and is what exact arithmetic gives."""
    problem = problem_of([[[[0, 1], [1, 2]], [[1, 0], [0, 0]]]], [1])
    generator = random.Random(17)
    proven = 0
    for _ in range(1000):
        a, b, c = (Fraction(generator.randint(-40, 40), 20) for _ in range(3))
        matrix = np.array([[1 + a * generator.choice([0, 1]), b], [b, c]], dtype=object)
        definite = matrix[0, 0] > 0 and matrix[0, 0] * c > b * b
        dual = Dual((matrix,), (None,), ())
        try:
            bound = lower_bound(problem, dual)
        except CertificateError:
            assert matrix[0, 0] != 1 or not definite
            continue
        proven += 1
        assert definite
        assert matrix[0, 0] == 1
        assert bound == -2 * b - 2 * c
        assert bound <= Fraction(1, 2)
    assert 50 < proven < 950


# Bounded unknowns ---------------------------------------------------------------------------------------


def test_a_miss_costs_its_share_of_the_radius() -> None:
    problem = problem_of([[[[0, 1], [1, 2]], [[1, 0], [0, 0]]]], [1])
    dual = Dual((fractions([[1 + 2.0**-20, -0.5], [-0.5, 0.5]]),), (None,), ())
    exact = 1 - Fraction(1) - Fraction(1, 2**20) * 100
    assert abs(bounded_lower_bound(problem, dual, Fraction(100)) - exact) < Fraction(1, 10**60)
    with pytest.raises(CertificateError, match="miss an equality"):
        lower_bound(problem, dual)


def test_an_lmi_that_grows_as_a_whole_needs_no_dual_matrix() -> None:
    """minimise x subject to [[x, 1], [1, 1]] ⪰ 0 and [[y, x], [x, y]] ⪰ 0: the second holds for a large y."""
    first = [[[0, 1], [1, 1]], [[1, 0], [0, 0]], [[0, 0], [0, 0]]]
    second = [[[0, 0], [0, 0]], [[0, 1], [1, 0]], [[1, 0], [0, 1]]]
    problem = problem_of([first, second], [1, 0])
    near = [fractions([[1, -1 + 1e-9], [-1 + 1e-9, 1 + 1e-9]]), fractions(np.zeros((0, 0)))]
    dual, bound = exact_dual(problem, near, (None, np.zeros((2, 0), dtype=int)))
    assert 1 - Fraction(1, 10**6) < bound < 1
    assert lower_bound(problem, dual) == bound


def test_an_irrational_face_is_bounded_for_bounded_unknowns() -> None:
    """The growing direction of y is (1, √2)(1, √2)ᵀ, known as a double: W must vanish on what is no fraction."""
    root = Fraction(2.0**0.5)
    first = [[[0, 1], [1, 2]], [[1, 0], [0, 0]], [[0, 0], [0, 0]]]
    second = [[[1, 0], [0, 1]], [[0, 0], [0, 0]], [[1, root], [root, root**2]]]
    problem = problem_of([first, second], [1, 0])
    near = [fractions([[1, -0.5], [-0.5, 0.25 + 1e-12]]), fractions(1e-14 * np.eye(2))]
    dual, bound = bounded_dual(problem, near, Fraction(1000), np.zeros(0, dtype=int))
    assert Fraction(1, 2) - Fraction(1, 10**6) < bound < Fraction(1, 2)
    assert bounded_lower_bound(problem, dual, Fraction(1000)) == bound


# Infeasibility ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "plant"),
    [
        ("standard.stability_continuous", constant_plant(A=[[1, 2], [0, -1]])),
        ("standard.stability_continuous", constant_plant(A=[["0.1", 1], [-1, "0.1"]])),
        ("standard.state_feedback_discrete", constant_plant(A=[["1.2", 0], [0, "0.5"]], B=[[0], [1]])),
    ],
)
def test_what_has_no_solution_is_proven_so(name: str, plant: Plant) -> None:
    """An unstable matrix, and one that no feedback stabilises."""
    result = run(compile(library.theorem(name), plant))
    assert result.solution.status is Status.INFEASIBLE
    found = certify(result)
    assert found.infeasible, found.notes
    # a margin that is left open is no proof that there is no solution
    assert found.standing is (Standing.NUMERICAL if found.infeasible.margin else Standing.CERTIFIED)
    assert found.infeasible.margin <= Fraction(1, 10**9)
    assert verify(parsed(text(found).encode())).holds
    # of the plant with its poles moved far to the left, or to the origin, the same matrices prove nothing
    moved = dict(found.plant.matrices)
    moved["A"] = MatrixPolynomial.constant(
        exact_array([[-9, 0], [0, -9]] if "B" not in moved else [[0, 0], [0, 0]], "A")
    )
    assert not verify(replace(found, plant=replace(found.plant, matrices=moved))).holds


def test_the_command_line_says_infeasible_only_with_a_proof(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plant = tmp_path / "unstable.toml"
    plant.write_text("[matrices]\nA = [[1, 2], [0, -1]]\n")
    command = ["solve", "standard.stability_continuous", "--plant", str(plant), "--json"]
    record = json.loads(CliRunner().invoke(main, command).output)
    assert record["status"] == "infeasible"
    assert "proven by" in record["infeasible"]

    def nothing(*_: Any) -> Any:
        raise CertificateError("no proof today")

    monkeypatch.setattr(certifying, "infeasibility", nothing)
    record = json.loads(CliRunner().invoke(main, command).output)
    assert record["status"] == "failed"
    assert record["infeasible"] == ""
    assert record["notes"] == ["that the LMIs have no solution is not proven: no proof today"]


# Balls ------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def sampled() -> tuple[Result, Relaxation]:
    """Example 1 of Mustafa, Chen and Fujioka at the one grid point of Algorithm 1 as published."""
    plant = read_plant(ROOT / "mustafa" / "example1.toml")
    relaxation = Relaxation(grid={"h": cover(plant, Gain("published"), "h").grid})
    return run(compile(library.theorem("mustafa.theorem3"), plant, relaxation=relaxation)), relaxation


def test_matrix_exponentials_are_enclosed_from_both_sides(sampled: tuple[Result, Relaxation]) -> None:
    """0.10173990 is the reference, from an independent solution in 200-bit arithmetic."""
    found = certify(*sampled)
    assert found.standing is Standing.GRID
    assert found.lower and found.upper
    assert found.lower.radius is None
    lower, upper = found.lower.reports["gamma"], found.upper.reports["gamma"]
    assert lower <= upper <= lower * (1 + Fraction(1, 10**6))
    assert abs(upper - Fraction("0.10173990")) < Fraction(1, 10**8)
    assert verify(parsed(text(found).encode())).holds
    higher = replace(found.lower, reports={"gamma": lower * (1 + Fraction(1, 10**6))})
    assert not verify(replace(found, lower=higher)).holds


def test_an_infimum_that_is_not_attained_is_enclosed() -> None:
    """Example 2 at h = 0.05: reference 0.0951207, approached as the unknowns grow."""
    plant = read_plant(ROOT / "mustafa" / "example2.toml")
    relaxation = Relaxation(grid={"h": Grid.at([[0.05]])})
    result = run(compile(library.theorem("mustafa.theorem3"), plant, relaxation=relaxation))
    assert result.solution.attained is False
    found = certify(result, relaxation)
    assert found.lower and found.upper
    assert found.lower.radius
    lower, upper = found.lower.reports["gamma"], found.upper.reports["gamma"]
    assert lower <= upper
    assert Fraction("0.0951") < lower
    assert upper < Fraction("0.09514")
    assert verify(found).holds


# 200 bits -----------------------------------------------------------------------------------------------


def _multiprecise(monkeypatch: pytest.MonkeyPatch, result: Result, given: dict[str, Any]) -> Certificate:
    monkeypatch.setattr(certifying, "affordable", lambda data: False)
    return certify(result, given=given)


@needs_sdpa
def test_two_hundred_bits_enclose_where_double_precision_is_not_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reference from an independent SDPA solution of Table 1 of Peixoto et al. (2025)."""
    result = run(compile(library.theorem("peixoto2025.theorem1"), read_plant(EXAMPLE_1), {"eps": 150}))
    found = _multiprecise(monkeypatch, result, {"eps": 150})
    assert "200 bits" in found.solver
    assert found.lower and found.upper
    lower, upper = found.lower.reports["gamma"], found.upper.reports["gamma"]
    assert lower <= Fraction("1.213769249285198035") <= upper
    assert (upper - lower) / upper < 1e-8
    assert verify(found).holds


@needs_sdpa
def test_sdpa_is_asked_for_the_same_finite_problem() -> None:
    result = run(compile(library.theorem("peixoto2025.theorem1"), read_plant(EXAMPLE_1), {"eps": 150}))
    start = blank(result, Relaxation(), {"eps": 150})
    _, exact = exact_problems(start, result, Relaxation())
    candidates = in_multiprecision(result, exact)
    x = next(candidates.points)
    assert np.sqrt(float(x @ result.problem.cost)) == pytest.approx(1.2137692492851980, rel=1e-7)
    dual = next(candidates.duals)
    assert len(dual.matrices) == len(result.problem.orders)
    own = slack_matrices(result.solution.dual, result.problem.orders)
    assert sum(float(np.trace(m)) for m in dual.matrices) == pytest.approx(sum(np.trace(m) for m in own), rel=1e-2)


def test_without_the_extra_double_precision_serves(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(*_: Any, **__: Any) -> Any:
        raise LmicError("multiprecision needs the package")

    monkeypatch.setattr("lmic.certify.candidates.solve_precisely", absent)
    result = run(compile(library.theorem("peixoto2025.theorem1"), read_plant(EXAMPLE_1), {"eps": 150}))
    found = _multiprecise(monkeypatch, result, {"eps": 150})
    assert found.lower and found.upper
    assert "double precision" in found.solver


def test_balls_hold_what_they_enclose() -> None:
    """x ≥ π with π as a ball: the bound is below π, and within the ball's width of it."""
    with flint.ctx.workprec(320):
        values = np.array([-flint.arb.pi(), flint.arb(1)], dtype=object)
    zero = np.zeros(2, dtype=int)
    lmi = FiniteLMI(1, np.array([0, 1]), zero, zero, values)
    problem = FiniteProblem((lmi,), np.array([Fraction(1)], dtype=object), Fraction(0))
    dual, bound = exact_dual(problem, [fractions([[1 + 1e-9]])])
    assert not problem.rational
    assert len(dual.pivots) == 1
    with flint.ctx.workprec(400):
        assert flint.arb(flint.fmpq(bound.numerator, bound.denominator)) < flint.arb.pi()
        assert flint.arb(flint.fmpq(bound.numerator, bound.denominator)) > flint.arb.pi() - flint.arb("1e-80")
