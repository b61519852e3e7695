"""Standard theorems that bound a norm, against least norms in closed form or from an independent formula.

Where a condition is sampled at the two ends of an interval (ENDS), the expected value is that of the sampled condition.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import sqrt
from typing import Any

import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov
from scipy.optimize import brentq, minimize_scalar
from standard_cases import DELTA, ENDS, POLYA, UNIT, cases, closed_loops, feasible, plant, scalars, stable, theorem

from lmic.dsl import PD, I
from lmic.pipeline import compile, run
from lmic.plants.plant import Plant
from lmic.relax.relax import Relaxation
from lmic.solve.cone import Status

# Least norms --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Norm:
    """``gamma`` is the optimum of the theorems that match the pattern; ``gain`` the optimal feedback where unique."""

    pattern: str
    what: str
    plant: Plant
    gamma: float
    relaxation: Relaxation | None = None
    gain: float | None = None


def random_system(discrete: bool) -> dict[str, Any]:
    """Three states, two inputs and outputs; the spectral radius is 0.8, the spectral abscissa -1/2."""
    generator = np.random.default_rng(5)
    A, B, C, D = (generator.standard_normal(shape) for shape in ((3, 3), (3, 2), (2, 3), (2, 2)))
    poles = np.linalg.eigvals(A)
    A = 0.8 * A / np.abs(poles).max() if discrete else A - (poles.real.max() + 0.5) * np.eye(3)
    return {"A": A, "B": B, "C": C, **({"D": D} if discrete else {})}


def h2(discrete: bool, A: Any, B: Any, C: Any, D: Any = 0) -> tuple[float, float]:
    """H2 and generalised H2 norm: trace and largest eigenvalue of C X Cᵀ + D Dᵀ, X the reachability Gramian."""
    X = solve_discrete_lyapunov(A, B @ B.T) if discrete else solve_continuous_lyapunov(A, -B @ B.T)
    covariance = C @ X @ C.T + (D @ D.T if discrete else 0)
    return sqrt(np.trace(covariance)), sqrt(np.linalg.eigvalsh(covariance).max())


def peak_gain(s: Mapping[str, Any], discrete: bool) -> float:
    """H∞ norm by a fine frequency grid (never above the norm)."""
    frequencies = np.linspace(0, np.pi, 4001) if discrete else np.concatenate([[0], np.logspace(-3, 4, 4001)])
    points = np.exp(1j * frequencies) if discrete else 1j * frequencies
    response = s["C"] @ np.linalg.solve(points[:, None, None] * np.eye(len(s["A"])) - s["A"], s["B"] + 0j) + s["D"]
    return float(np.linalg.norm(response, 2, axis=(1, 2)).max())


def two_channels(rate: float) -> float:
    """Least γ for ẋ = -x + w, z = r x + (1 - r) w, |ṙ| ≤ rate, with V = (p₀ + (p₁ - p₀)r) x².

    The LMI is affine in r and ṙ. Its Schur complements at r = 0 and r = 1, with Δ = p₁ - p₀ ≥ 0, are
    p₀² < (γ - 1/γ)(2p₀ - rate·Δ) and φ = 2p₁ - rate·Δ - (p₁² + 1)/γ > 0: maximise the concave φ over p₀
    and the largest useful Δ. Constant p (Δ = 0): p₀ = 2(γ - 1/γ) and p₀ = γ - √(γ² - 1) give γ = 2/√3.
    """

    def best(gamma: float) -> float:
        level = gamma - 1 / gamma

        def phi(p0: float) -> float:
            difference = min((2 * p0 - p0**2 / level) / rate, max(gamma * (1 - rate / 2) - p0, 0.0))
            p1 = p0 + difference
            return 2 * p1 - rate * difference - (p1**2 + 1) / gamma

        found = minimize_scalar(lambda p0: -phi(p0), bounds=(0, 2 * level), method="bounded", options={"xatol": 1e-12})
        return -float(found.fun)

    return float(brentq(best, 1 + 1e-6, 1.3, xtol=1e-12))


# ẋ = -x + w, z = r x + (1 - r) w, and the transposed system; the discrete one has x⁺ = w
TWO_CHANNELS = scalars(A=-1, B=1, C="r", D="1 - r")
TRANSPOSED = scalars(A=-1, B_w="r", C_z=1, D_zw="1 - r", B_u=0, D_zu=0)
DELAYED = scalars(A=0, B=1, C="r", D="1 - r")
DELAYED_TRANSPOSED = scalars(A=0, B_w="r", C_z=1, D_zw="1 - r", B_u=0, D_zu=0)
# frozen, both ends have b²c²/2|a| = 1/2
SCALED_INPUT = scalars(A="-1 - 3*r", B="1 + r", C=1)
SCALED_OUTPUT = scalars(A="-1 - 3*r", B=1, C="1 + r")
# z = (x, u): the cost of feedback
FEEDBACK = {"B_w": [[1]], "B_u": [[1]], "C_z": [[1], [0]], "D_zw": [[0], [0]], "D_zu": [[0], [1]]}
RESONANCE = {"A": [[0, 1], [-1, "-1/5"]], "B": [[0], [1]], "C": [[1, 0]], "D": [[0]]}
DELAY_LINE = {"A": [[0, 0], [1, 0]], "B": [[1], [0]], "C": [[2, 3]], "D": [[1]]}
CONTINUOUS, DISCRETE = random_system(False), random_system(True)
# a constant P sees every step as the whole interval
STEPS = [("", "constant", 0), ("", 0.5, 0.5), ("", "free", 1), ("_quadratic", "constant", 1), ("_quadratic", "free", 1)]

NORMS = [
    # |G(0)| = |bc/a|
    Norm("bounded_real_continuous*", "lag", plant(scalars(A=-1, B=1, C=1, D=0)), 1),
    # G moves monotonically from G(0) = d - bc/a to d: max(2 + 3/2, 2)
    Norm("bounded_real_continuous*", "lag with throughput", plant(scalars(A=-2, B=1, C=3, D=2)), 3.5),
    # 1/(s² + 2ζs + 1) peaks at 1/(2ζ√(1 - ζ²)), ζ = 1/10
    Norm("bounded_real_continuous*", "resonance", plant(RESONANCE), 1 / (0.2 * sqrt(0.99))),
    # the slowest pole alone gives 1, and so does P = 1 for all of them, whatever the rate
    Norm(
        "bounded_real_continuous*", "pole", plant(scalars(A="r", B=1, C=1, D=0), (-3, -1), rate=100), 1, POLYA
    ),
    # max over the ends of (b²p + c²/p)/2 with (b, c) = (1, 4), (4, 1) is least at p = 1
    Norm("bounded_real_continuous_quadratic", "b and c", plant(scalars(A=-1, B="1+3*r", C="4-3*r", D=0), UNIT), 8.5),
    # see two_channels; constant r: the larger of |G(0)| = 1 and |G(∞)| = 1 - r, by p₀ → 0
    Norm("bounded_real_continuous", "constant", plant(TWO_CHANNELS, UNIT, rate=0), 1),
    Norm("bounded_real_continuous", "slow", plant(TWO_CHANNELS, UNIT, rate=0.25), two_channels(0.25)),
    # for rates above 2/3 the gradient of φ in Δ is not positive at Δ = 0: constant p is optimal
    Norm("bounded_real_continuous", "fast", plant(TWO_CHANNELS, UNIT, rate=1), 2 / sqrt(3)),
    Norm("bounded_real_continuous_quadratic", "any rate", plant(TWO_CHANNELS, UNIT), 2 / sqrt(3)),
    # 1/(1 - |a|)
    Norm("bounded_real_discrete*", "lag", plant(scalars(A="1/2", B=1, C=1, D=0)), 2),
    # the larger of |d + bc/(±1 - a)|: |-1 - 3·2/(1 - 1/2)| at z = -1
    Norm("bounded_real_discrete*", "alternating", plant(scalars(A="-1/2", B=2, C=3, D=-1)), 13),
    # z_k = w_k + 2 w_{k-1} + 3 w_{k-2}: the sum of the taps, at frequency 0
    Norm("bounded_real_discrete*", "delay line", plant(DELAY_LINE), 6),
    # an end alone gives 2, and so does P = 1 for a free r
    Norm("bounded_real_discrete*", "switched pole", plant(scalars(A="r", B=1, C=1, D=0), ("-1/2", "1/2")), 2),
    # z_k = r_k w_{k-1} + (1 - r_k) w_k, |r_{k+1} - r_k| ≤ δ, P = p₀ + (p₁ - p₀)r. The Schur complements need
    # p₁ > 1/γ at r = 1 and p(δ) < γ - 1/γ at r = 0, so γ² > 1 + δ; p₀ → 0, p₁ → 1/γ attains it at all vertices
    # of (r, r⁺)
    *(
        Norm(f"bounded_real_discrete{variant}", f"step {step}", plant(DELAYED, UNIT, step=step), sqrt(1 + delta))
        for variant, step, delta in STEPS
    ),
    # b²c²/2|a|
    Norm("h2_continuous* generalised_h2_continuous*", "lag", plant(scalars(A=-2, B=3, C=1)), 1.5),
    Norm("h2_continuous*", "Gramian", plant(CONTINUOUS), h2(False, **CONTINUOUS)[0]),
    Norm(
        "generalised_h2_continuous*", "Gramian", plant(CONTINUOUS),
        h2(False, **CONTINUOUS)[1],
    ),
    # 2p₀ - ν(p₀ - p₁) > 1, 8p₁ - ν(p₀ - p₁) > 1, μ > p₀, 4p₁: all tight at p₀ = 4p₁ = 1/(2 - 3ν/4) for ν ≤ 2;
    # a constant p = 1/2 has μ = 4p = 2
    *(
        Norm("h2_continuous", f"rate {nu}", plant(SCALED_INPUT, UNIT, rate=nu), 1 / sqrt(2 - 0.75 * nu), ENDS)
        for nu in (0, 1, 1.5)
    ),
    Norm("h2_continuous", "rate 10", plant(SCALED_INPUT, UNIT, rate=10), sqrt(2), ENDS),
    Norm("h2_continuous_quadratic", "any rate", plant(SCALED_INPUT, UNIT), sqrt(2)),
    # p₀² < 2p₀ - ν(p₁ - p₀), p₁² < 8p₁ - ν(p₁ - p₀), μ > 1/p₀, 4/p₁. Up to ν = 2/7, p₁ = 4p₀ = 4(2 - 3ν);
    # then p₀ = 1 + ν/2 is best, μ = 4/p₁ = 16ν/(2 + ν)², until p₁ = p₀ = 2 at ν = 2
    *(
        Norm("generalised_h2_continuous", f"rate {nu}", plant(SCALED_OUTPUT, UNIT, rate=nu), sqrt(mu), ENDS)
        for nu, mu in ((0, 1 / 2), (0.25, 1 / 1.25), (0.5, 8 / 6.25), (1, 16 / 9), (10, 2))
    ),
    Norm("generalised_h2_continuous_quadratic", "any rate", plant(SCALED_OUTPUT, UNIT), sqrt(2)),
    # b²c²/(1 - a²) + d² = 9·4/3 + 4
    Norm("h2_discrete* generalised_h2_discrete*", "lag", plant(scalars(A="1/2", B=3, C=1, D=2)), 4),
    Norm("h2_discrete*", "Gramian", plant(DISCRETE), h2(True, **DISCRETE)[0]),
    Norm(
        "generalised_h2_discrete*", "Gramian", plant(DISCRETE), h2(True, **DISCRETE)[1]
    ),
    # P(r) > r², Z(r) > P(r⁺) + (1 - r)²: at r = 0, μ > p(δ) + 1 ≥ δp₁ + 1, attained by p₀ → 0, p₁ → 1
    *(
        Norm(f"h2_discrete{variant}", f"step {step}", plant(DELAYED, UNIT, step=step), sqrt(1 + delta))
        for variant, step, delta in STEPS
    ),
    # |z_k| = |c_k b_{k-1} w_{k-1}|, (b, c) = (1, 4), (4, 1): max b · max c, for a constant r max bc of the ends
    Norm("generalised_h2_discrete*", "b and c", plant(scalars(A=0, B="1+3*r", C="4-3*r", D=0), UNIT), 16),
    Norm(
        "generalised_h2_discrete", "b and c constant",
        plant(scalars(A=0, B="1+3*r", C="4-3*r", D=0), UNIT, step="constant"), 4, ENDS,
    ),
    # without control: the transposed systems have the optima of the bounded-real lemma (1 - r for r, and Q for P
    # up to γ - P in discrete time)
    Norm("state_feedback_hinf_continuous", "constant", plant(TRANSPOSED, UNIT, rate=0), 1, ENDS),
    Norm("state_feedback_hinf_continuous", "slow", plant(TRANSPOSED, UNIT, rate=0.25), two_channels(0.25), ENDS),
    Norm("state_feedback_hinf_continuous", "fast", plant(TRANSPOSED, UNIT, rate=1), 2 / sqrt(3), ENDS),
    Norm("state_feedback_hinf_continuous_[qr]*", "any rate", plant(TRANSPOSED, UNIT), 2 / sqrt(3), ENDS),
    *(
        Norm(
            f"state_feedback_hinf_discrete{variant}", f"step {step}", plant(DELAYED_TRANSPOSED, UNIT, step=step),
            gamma, ENDS,
        )
        for variant, step, gamma in (
            ("", "constant", 1), ("", 0.5, sqrt(1.5)), ("", "free", sqrt(2)),
            ("_quadratic", "constant", sqrt(2)), ("_quadratic", "free", sqrt(2)), ("_robust", "free", sqrt(2)),
            # G = g/γ constant and q₀ → 0, q₁ = 1/γ: g/2 < γ² - 1 at r = 0 and g² < γ²(2g - 1) at r = 1 meet at γ² = 4/3
            ("_robust", "constant", 2 / sqrt(3)),
        )
    ),
    # ẋ = ax + w + u, a < 0: √(1 + k²)/|a + k| is least at k = 1/a, 1/√(1 + a²); the slowest pole decides
    Norm(
        "state_feedback_hinf_continuous*", "control", plant({"A": [[-1]], **FEEDBACK}), 1 / sqrt(2), gain=-1
    ),
    Norm(
        "state_feedback_hinf_continuous*", "pole",
        plant({"A": [["r"]], **FEEDBACK}, (-3, -1), rate=100), 1 / sqrt(2), POLYA,
    ),
    # the sign of the control is that of r: a constant gain can do nothing
    Norm(
        "state_feedback_hinf_continuous state_feedback_hinf_continuous_quadratic", "sign",
        plant({"A": [[-1]], **FEEDBACK, "B_u": [["r"]]}, (-1, 1), rate=100), 1 / sqrt(2), ENDS,
    ),
    Norm(
        "state_feedback_hinf_continuous_robust", "sign", plant({"A": [[-1]], **FEEDBACK, "B_u": [["r"]]}, (-1, 1)), 1,
        gain=0,
    ),
    # x⁺ = ax + w + u, a ≥ 0: √(1 + k²)/(1 - |a + k|) is least at k = -a, √(1 + a²)
    Norm("state_feedback_hinf_discrete*", "control", plant({"A": [[2]], **FEEDBACK}), sqrt(5), gain=-2),
    # scheduled k = -a makes x⁺ = w; a constant gain is best at k = -1/2, √(1 + k²)/(1 - 1/2)
    Norm(
        "state_feedback_hinf_discrete state_feedback_hinf_discrete_quadratic", "pole",
        plant({"A": [["r"]], **FEEDBACK}, UNIT), sqrt(2), POLYA,
    ),
    Norm("state_feedback_hinf_discrete_robust", "pole", plant({"A": [["r"]], **FEEDBACK}, UNIT), sqrt(5), gain=-0.5),
]  # fmt: skip

NORM_CASES = cases(NORMS)


@pytest.mark.parametrize(("name", "case"), NORM_CASES)
def test_least_norm(name: str, case: Norm) -> None:
    result = run(compile(theorem(name), case.plant, relaxation=case.relaxation))
    assert result.solution.status is Status.SOLVED, result.solution.warnings
    assert result.reports["gamma"] == pytest.approx(case.gamma, rel=1e-6)
    if case.gain is not None:
        points = np.array([[-1.0], [0.0], [1.0]]) if case.plant.domains else None
        gains = result.design(**({} if points is None else {"rho": points}))["K"]
        assert np.allclose(gains, case.gain, atol=1e-3)
    if "K" in result.theorem.recover:
        for closed in closed_loops(result):
            bounded = {"A": closed["A"], "B": closed["B_w"], "C": closed["C_z"], "D": closed["D_zw"]}
            assert stable(closed["A"], "discrete" in name)
            assert peak_gain(bounded, "discrete" in name) <= case.gamma * (1 + 1e-6)


@pytest.mark.parametrize("side", [1, -1], ids=["above", "below"])
@pytest.mark.parametrize(("name", "case"), NORM_CASES)
def test_least_norm_is_the_border_of_feasibility(name: str, case: Norm, side: int) -> None:
    posed = theorem(name)
    assert posed.minimise is not None
    power = 1 if posed.minimise == posed.reports["gamma"] else 2
    level = (case.gamma * (1 + side * DELTA)) ** power
    bounded = {**posed.lmis, "level": PD(level * I(1) - posed.minimise * I(1))}
    result = feasible(replace(posed, lmis=bounded, minimise=None), case.plant, case.relaxation)
    assert (result is not None) == (side > 0)
