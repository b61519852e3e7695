"""S4: matrix exponentials as data, the coverings of Algorithm 1, and the examples' values."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg
import sympy as sp
from scipy.integrate import quad_vec

from lmic import library
from lmic.analysis.norms import frozen_gain, h_infinity
from lmic.analysis.sampling import Gain, cover, logarithmic_norm, sampled_gain, tolerated
from lmic.errors import PlantError
from lmic.papers.cases import select
from lmic.papers.reproduce import Verdict, reproduce
from lmic.pipeline import compile, run
from lmic.plants.files import read_plant
from lmic.plants.plant import Plant
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation


def example(number: int) -> Plant:
    return read_plant(library.root() / "mustafa" / f"example{number}.toml")


def constant(plant: Plant, name: str) -> Any:
    return plant.matrices[name].numeric().coefficients[0]


@pytest.mark.parametrize("number", [1, 2])
def test_phi_and_gamma_are_the_sampled_plant(number: int) -> None:
    plant = example(number)
    A, B = constant(plant, "A"), constant(plant, "B")
    times = np.random.default_rng(number).uniform(0.001, 0.12, 5)
    values = {sp.Symbol("h"): times}
    for phi, gamma, h in zip(
        plant.matrices["Phi"].evaluate(values), plant.matrices["Gamma"].evaluate(values), times, strict=True
    ):
        integral, _ = quad_vec(lambda eta: scipy.linalg.expm(eta * A), 0, h, epsabs=1e-15)
        np.testing.assert_allclose(phi, scipy.linalg.expm(h * A), rtol=1e-14, atol=1e-16)
        np.testing.assert_allclose(gamma, integral @ B, rtol=1e-13)


def test_the_motor_has_the_papers_matrix() -> None:
    np.testing.assert_allclose(constant(example(2), "A"), [[-10, 1], [-0.02, -2]])


@pytest.mark.parametrize("number", [1, 2])
def test_a_covering_covers_and_keeps_the_small_gain(number: int) -> None:
    """‖Σ_11(h_i)‖∞ ‖Δ(θ)‖ < 1 within every interval, by Δ itself and not by its bound."""
    plant = example(number)
    A, found = constant(plant, "A"), cover(plant)
    assert min(low for low, _ in found.intervals) < plant.domains["h"].vertices.min()
    assert max(high for _, high in found.intervals) > plant.domains["h"].vertices.max()
    for (_, left_end), (right_start, _) in zip(found.intervals[:-1], found.intervals[1:], strict=True):
        assert right_start < left_end
    for point, gain, ends in zip(found.points, found.gains, found.intervals, strict=True):
        for end in ends:
            shift, _ = quad_vec(lambda eta: scipy.linalg.expm(eta * A), 0, end - point)
            assert gain * np.linalg.norm(shift, 2) <= 1 + 1e-9


def test_a_point_reaches_as_far_as_the_bound_lets_it() -> None:
    """At the ends of H the bound on the small gain is one: (e^{θμ} − 1)/μ by quadrature."""
    A = constant(example(1), "A")
    low, high = tolerated(A, 0.05, 7.0)
    for reach, growth in ((high - 0.05, logarithmic_norm(A)), (0.05 - low, logarithmic_norm(-A))):
        integral, _ = quad_vec(lambda eta, mu=growth: np.exp(mu * eta), 0, reach)
        assert 7.0 * integral == pytest.approx(1)


@pytest.mark.parametrize(("number", "rigorous"), [(1, 7), (2, 2)])
def test_algorithm_1_ends_with_one_point_as_published_and_with_more_rigorously(number: int, rigorous: int) -> None:
    """One point, as the paper says; 7 and 2 by an independent prototype."""
    assert len(cover(example(number), Gain.PUBLISHED).points) == 1
    assert len(cover(example(number)).points) == rigorous


@pytest.mark.parametrize(("number", "alpha"), [(1, 46.80), (2, 19.03)])
def test_the_gain_at_the_middle(number: int, alpha: float) -> None:
    found = cover(example(number), Gain.PUBLISHED)
    assert found.gains[0] == pytest.approx(alpha, abs=5e-3)
    # the gain is a maximum over frequencies: a dense grid comes near it from below
    A, h = constant(example(number), "A"), found.points[0]
    phi = scipy.linalg.expm(h * A)
    z = np.exp(1j * np.linspace(0, np.pi, 20001))[:, None, None]
    gains = np.linalg.svd(A @ phi @ np.linalg.inv(z * np.eye(2) - phi), compute_uv=False)[:, 0]
    assert gains.max() <= found.gains[0] * (1 + 1e-9)
    assert gains.max() == pytest.approx(found.gains[0], rel=1e-4)


def test_an_unstable_plant_covers_nothing(tmp_path: Path) -> None:
    assert sampled_gain(np.array([[0.1]]), 0.1) == np.inf
    file = tmp_path / "unstable.toml"
    file.write_text("[parameters.h]\nbox = { h = [0.1, 0.2] }\n[matrices]\nA = [[1]]\n")
    with pytest.raises(PlantError, match=r"A is not Hurwitz, so no interval around 0\.15 is covered"):
        cover(read_plant(file))


def test_the_examples_meet_their_references() -> None:
    (table,) = select(("mustafa",))
    outcomes = {outcome.case.id: outcome for outcome in reproduce(table)}
    for number, digits in ((1, 1e-7), (2, 1e-5)):  # the infimum of Example 2 is not attained
        published = outcomes[f"mustafa.example{number}.published"]
        assert published.value == pytest.approx(float(published.case.reference), rel=digits)
        assert published.frozen.norm <= published.frozen.bound * (1 + 1e-9)
        rigorous = outcomes[f"mustafa.example{number}.rigorous"]
        assert rigorous.value > published.value
        assert rigorous.frozen.norm <= rigorous.frozen.bound * (1 + 1e-9)
    assert outcomes["mustafa.example1.published"].verdict is Verdict.REPRODUCED
    assert outcomes["mustafa.example1.published"].result.solution.attained is not False


def test_an_infimum_that_is_not_attained_is_called_so() -> None:
    """Example 2 at h = 0.05: γ falls like 1/|x| towards 0.0951207 (independent prototype, 200 bits)."""
    relaxation = Relaxation(grid={"h": Grid.at([[0.05]])})
    result = run(compile(library.theorem("mustafa.theorem3"), example(2), relaxation=relaxation))
    assert result.solution.attained is False
    assert result.solution.trusted
    assert any("infimum is not attained" in warning for warning in result.solution.warnings)
    assert 0.0951207 < result.reports["gamma"] == pytest.approx(0.0951207, rel=1e-5)
    assert np.abs(result.solution.x).max() == pytest.approx(1e6, rel=1e-2)


@pytest.mark.parametrize("name", ["theorem3", "robust_performance"])
def test_the_recovered_filter_meets_its_bound_by_an_independent_norm(name: str) -> None:
    theorem, plant = library.theorem(f"mustafa.{name}"), example(1)
    points = np.linspace(0.05, 0.08, 3)[:, None]
    result = run(compile(theorem, plant, relaxation=Relaxation(grid={"h": Grid.at(points.tolist())})))
    gains = frozen_gain(result.design, theorem.guarantees[0].system, {"h": points})
    assert gains is not None
    assert 0 < gains.max() <= result.reports["gamma"] * (1 + 1e-9)
    A, B = constant(plant, "A"), constant(plant, "B")
    augmented = np.block([[A, B], [np.zeros((1, 3))]])
    sampled = scipy.linalg.expm(points[0, 0] * augmented)
    phi, gamma = sampled[:2, :2], sampled[:2, 2:]
    design = result.design(h=points[0])
    Af, Bf, Cf = design["A_f"], design["B_f"], design["C_f"]
    C, D, L = constant(plant, "C"), constant(plant, "D"), constant(plant, "L")
    error = np.block([[phi, np.zeros((2, 2))], [Bf @ C, Af]]), np.block([[gamma], [Bf @ D]]), np.block([[L, -Cf]])
    assert h_infinity(*error, np.zeros((1, 1)), discrete=True) <= result.reports["gamma"] * (1 + 1e-9)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        ('{ exponential = "X", time = "h" }', '"X" is no matrix of this plant'),
        ('{ exponential = "B", time = "h" }', "'B' is 2 x 1; only a square matrix has an exponential"),
        ('{ exponential = "A" }', "has no time"),
        ('{ exponential = "A", time = "g" }', "g"),
        ('{ exponential = "A", time = "h", input = "C" }', "'C' has 1 rows where the exponent has 2"),
        ('{ exponential = "V", time = "h" }', '"V" is not constant'),
        ('{ exponential = "A", time = "h", power = 2 }', '"power" means nothing here'),
    ],
)
def test_wrong_exponentials_are_explained(matrix: str, message: str, tmp_path: Path) -> None:
    file = tmp_path / "plant.toml"
    file.write_text(
        "[parameters.h]\nbox = { h = [0.1, 0.2] }\n[matrices]\n"
        f'Phi = {matrix}\nA = [[0, 1], [-2, -3]]\nB = [[1], [0]]\nC = [[1, 0]]\nV = [["h", 0], [0, 1]]\n'
    )
    with pytest.raises(PlantError, match="matrix Phi") as error:
        read_plant(file)
    assert message.replace('"', "'") in str(error.value).replace('"', "'")
