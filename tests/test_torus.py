"""Norms of 2-D systems over the frequency torus, with and without delays, and the designs they judge."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.linalg import solve_discrete_lyapunov

import lmic
from lmic.analysis.norms import diagonal_peak, frozen_gain, frozen_magnitude, frozen_peak, torus_norm
from lmic.library import root
from lmic.pipeline import Result
from lmic.plants.plant import Plant
from lmic.recover.recover import recover

Matrices = dict[str, Any]
VERTICES_AND_MIXTURES = [[k / 10, 1 - k / 10] for k in range(11)]


def random_system(seed: int, size: float, delayed: Sequence[str] = ("A_d1", "A_d2")) -> Matrices:
    """Two states, two inputs, two outputs; the sum of the norms of the dynamics is ``size``."""
    random = np.random.default_rng(seed)
    dynamics = {name: random.standard_normal((2, 2)) for name in ("A1", "A2", "A_d1", "A_d2")}
    dynamics |= {name: np.zeros((2, 2)) for name in {"A_d1", "A_d2"} - set(delayed)}
    total = sum(np.linalg.norm(matrix, 2) for matrix in dynamics.values())
    others = {name: random.standard_normal((2, 2)) for name in ("B1", "B2", "C")}
    return {name: size * matrix / total for name, matrix in dynamics.items()} | others


def gain_by_brute_force(m: Matrices, delay: Sequence[int], count: int) -> float:
    """The largest gain on a grid of frequencies, straight from the difference equation with its delays."""
    z1, z2 = np.meshgrid(*[np.exp(-1j * np.linspace(-np.pi, np.pi, count))] * 2)
    z1, z2 = z1[..., None, None], z2[..., None, None]
    moved = z1 * m["A1"] + z2 * m["A2"] + z1 ** (delay[0] + 1) * m["A_d1"] + z2 ** (delay[1] + 1) * m["A_d2"]
    response = m["C"] @ np.linalg.solve(np.eye(2) - moved, z1 * m["B1"] + z2 * m["B2"])
    return float(np.linalg.norm(response, 2, axis=(-2, -1)).max())


@pytest.mark.parametrize("delayed", [("A_d1", "A_d2"), ("A_d1",), ("A_d2",)])
@pytest.mark.parametrize("seed", range(3))
def test_no_delay_exceeds_the_norm_and_some_come_close(seed: int, delayed: Sequence[str]) -> None:
    m = random_system(seed, 0.8, delayed)
    norm = torus_norm(**m)
    gains = [gain_by_brute_force(m, (d1, d2), 160) for d1 in (0, 1, 2, 5, 11) for d2 in (0, 1, 2, 5, 11)]
    assert max(gains) <= norm * (1 + 1e-9)
    assert max(gains) >= 0.97 * norm


@pytest.mark.parametrize("seed", range(3))
def test_without_delays_the_norm_is_that_of_the_frequencies(seed: int) -> None:
    m = random_system(seed, 0.8, ())
    plain = {name: matrix for name, matrix in m.items() if not name.startswith("A_d")}
    assert torus_norm(**m) == torus_norm(**plain) == pytest.approx(gain_by_brute_force(m, (0, 0), 401), rel=1e-3)
    assert torus_norm(**m) >= gain_by_brute_force(m, (0, 0), 401) * (1 - 1e-9)


def test_norm_of_scalar_systems_by_hand() -> None:
    """b / (1 − Σ|a|) if Σ|a| < 1: the phases can align every term. Otherwise some delay is unstable."""
    a = {"A1": 0.3, "A2": -0.2, "A_d1": -0.1, "A_d2": 0.25, "B1": 1.0, "B2": 0.0, "C": 2.0}
    m = {name: np.array([[value]]) for name, value in a.items()}
    assert torus_norm(**m) == pytest.approx(2 / 0.15, rel=1e-8)
    assert torus_norm(**(m | {"A_d1": np.array([[-0.26]])})) == np.inf


def test_instability_is_seen_where_the_resolvent_is_bounded() -> None:
    """Every root lies well inside the disc, so that on the torus the response is finite."""
    zero, one = np.zeros((1, 1)), np.eye(1)
    assert torus_norm(A1=2 * one, A2=zero, B1=one, B2=zero, C=one) == np.inf
    assert torus_norm(A1=zero, A2=0.1 * one, B1=one, B2=zero, C=one, A_d1=2 * one, A_d2=zero) == np.inf


@pytest.mark.parametrize("seed", range(4))
def test_the_norm_is_infinite_if_and_only_if_some_delay_is_unstable(seed: int) -> None:
    """States that depend on i only move by A1 and A_d1 with delay d1, which a matrix of more states lifts."""
    seen = set()
    for size in (0.9, 1.5, 3, 6):
        m = random_system(seed, size) | {"A2": np.zeros((2, 2)), "A_d2": np.zeros((2, 2))}
        unstable = any(np.abs(np.linalg.eigvals(lifted(m, d))).max() >= 1 for d in range(16))
        assert (torus_norm(**m) == np.inf) == unstable
        seen.add(unstable)
    assert seen == {True, False}


def lifted(m: Matrices, delay: int) -> Any:
    """One step of (x(i), …, x(i − d))."""
    matrix = np.eye(2 * (delay + 1), k=-2)
    matrix[:2, :2] += m["A1"]
    matrix[:2, -2:] += m["A_d1"]
    return matrix


# Chen and Fong's designs ------------------------------------------------------------------------------


@cache
def solved(theorem: str, plant: str) -> Result:
    return lmic.run(lmic.compile(lmic.theorem(theorem), lmic.read_plant(root() / "chen2006" / f"{plant}.toml")))


def test_example_2_meets_its_bound_at_vertices_and_mixtures() -> None:
    """For every delay by the norm, and for the paper's delay by the response of Figure 1."""
    result = solved("chen2006.theorem4", "example2")
    system, points = result.theorem.guarantees[0].system, {"alpha": VERTICES_AND_MIXTURES}
    gains = frozen_gain(result.design, system, points)
    assert (gains > 0).all()
    assert (gains <= result.reports["gamma"]).all()
    axis = np.linspace(-np.pi, np.pi, 61)
    frequencies = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    response = frozen_magnitude(result.design, system, points, frequencies, (1, 0))
    assert (response.max(axis=1) <= gains * (1 + 1e-9)).all()


@pytest.mark.parametrize(
    ("model", "weights"),
    [("example2", [0.35, 0.65]), ("example1_nft", [0.2, 0.5, 0.3]), ("example1_lft", [0.2, 0.5, 0.3])],
)
def test_the_error_system_is_plant_and_filter_side_by_side(model: str, weights: list[float]) -> None:
    """The transfer function of (1) and (7) with w_Δ kept as a signal, at random frequencies and delays."""
    plant = lmic.read_plant(root() / "chen2006" / f"{model}.toml")
    theorem = lmic.theorem("chen2006.theorem4")
    problem = lmic.compile(theorem, plant)
    random = np.random.default_rng(7)
    design = recover(problem, random.standard_normal(problem.size))
    f = design(alpha=weights)
    p = {name: plant_matrix(plant, name, weights) for name in theorem.data}
    for delay in [(0, 0), (1, 3)]:
        omega = random.uniform(-np.pi, np.pi, 2)
        i, j = np.exp(-1j * omega)  # one step along i, along j
        channel = p["Delta"].shape[0]
        state = (
            np.eye(2) - j * p["A_1"] - i * p["A_2"] - j ** (delay[1] + 1) * p["A_d1"] - i ** (delay[0] + 1) * p["A_d2"]
        )
        uncertain = -(j * p["B_Delta_1"] + i * p["B_Delta_2"])
        loop = [-p["Delta"] @ p["C_Delta"], np.eye(channel) - p["Delta"] @ p["D_Delta_z"]]
        driven = np.vstack([j * p["B_1"] + i * p["B_2"], p["Delta"] @ p["D_z"]])
        x_and_w = np.linalg.solve(np.block([[state, uncertain], loop]), driven)
        y = np.hstack([p["C"], p["D_Delta"]]) @ x_and_w + p["D"]
        filtered = np.linalg.solve(np.eye(2) - j * f["A_f1"] - i * f["A_f2"], (j * f["B_f1"] + i * f["B_f2"]) @ y)
        expected = np.linalg.norm(p["L"] @ x_and_w[:2] - f["C_f"] @ filtered, 2)
        system = theorem.guarantees[0].system
        (found,) = frozen_magnitude(design, system, {"alpha": [weights]}, omega[None], delay)
        assert found == pytest.approx(expected, rel=1e-9)


def plant_matrix(plant: Plant, name: str, weights: list[float]) -> Any:
    values = {sp.Symbol(f"alpha{k + 1}"): np.array([weight]) for k, weight in enumerate(weights)}
    return plant.matrices[name].evaluate(values)[0]


@pytest.mark.parametrize("model", ["example1_no_delay", "example1_nft"])
def test_the_peak_of_the_h2_filter_stays_below_its_bound(model: str) -> None:
    """The largest ‖output‖ of a diagonal over ‖w‖₂ is the largest (C W C*)^{1/2} with the Gramian W of a wave.

    Without delays, a wave of phase θ along the diagonals moves by A1 e^{−iθ} + A2 from one to the next.
    """
    result = solved("chen2006.theorem5", model)
    (bound,) = result.theorem.guarantees
    assert result.reports[bound.report] == pytest.approx(np.sqrt(result.reports["mu"]))
    alpha = np.vstack([np.eye(3), np.full(3, 1 / 3)])
    m = result.design.frozen(bound.system, {"alpha": alpha})
    found = frozen_peak(result.design, bound.system, {"alpha": alpha})
    assert found is not None
    for k, peak in enumerate(found):
        A1, A2 = m["A1"][k] + m["A_d1"][k], m["A2"][k] + m["A_d2"][k]
        waves = []
        for wave in np.exp(-1j * np.linspace(0, np.pi, 361)):
            entry = wave * m["B1"][k] + m["B2"][k]
            gramian = solve_discrete_lyapunov(wave * A1 + A2, entry @ entry.conj().T)
            waves.append(np.sqrt(np.linalg.norm(m["C"][k] @ gramian @ m["C"][k].T, 2)))
        assert max(waves) * (1 - 1e-9) <= peak == pytest.approx(max(waves), rel=1e-4)
    assert 0.5 * result.reports["peak"] < found.max() <= result.reports["peak"]


def test_a_diagonal_never_holds_more_than_the_peak() -> None:
    """Random disturbances from rest, place by place; and a system by hand: x = w of the last diagonal, twice."""
    generator = np.random.default_rng(3)
    A1, A2 = (a / (4 * np.linalg.norm(a, 2)) for a in generator.standard_normal((2, 2, 2)))
    B1, B2 = generator.standard_normal((2, 2, 1))
    C = generator.standard_normal((1, 2))
    peak = diagonal_peak(A1, A2, B1, B2, C)
    assert np.isfinite(peak)
    for _ in range(5):
        w, x = generator.standard_normal((12, 12, 1)), np.zeros((13, 13, 2))
        for i in range(12):
            for j in range(12):
                before = [(i, j + 1), (i + 1, j)]
                w_before = [w[place] if max(place) < 12 else np.zeros(1) for place in before]
                x[i + 1, j + 1] = A1 @ x[before[0]] + A2 @ x[before[1]] + B1 @ w_before[0] + B2 @ w_before[1]
        z = np.square(x @ C.T)[..., 0]
        diagonals = [np.trace(z[:, ::-1], offset) for offset in range(-12, 13)]
        assert np.sqrt(max(diagonals)) <= peak * np.linalg.norm(w)
    zero, one = np.zeros((1, 1)), np.ones((1, 1))
    assert diagonal_peak(zero, zero, one, one, one) == pytest.approx(2)
    assert diagonal_peak(one, zero, one, one, one) == np.inf
