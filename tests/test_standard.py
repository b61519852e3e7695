"""Every standard theorem against optima known in closed form or from an independent formula.

Three tables, by what a theorem asks: the least norm (NORMS), the best decay rate (DECAY), or whether
the LMIs hold (MARGINS: they do below a known value of k and not above). Where a condition is sampled
at the two ends of an interval (ENDS), the expected value is that of the sampled condition.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from fnmatch import fnmatch
from functools import partial
from math import inf, sqrt
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov
from scipy.optimize import brentq, minimize_scalar

from lmic import library
from lmic.domains import BoxDomain, Motion, SimplexDomain
from lmic.dsl import PD, I
from lmic.errors import PlantError
from lmic.language.theorem import Theorem
from lmic.pipeline import Result, compile, prepare, run
from lmic.plants.plant import Plant, exact_number
from lmic.polynomials import MatrixPolynomial
from lmic.relax.relax import Relaxation
from lmic.search import bisect
from lmic.solve.cone import Status

NAMES = [name.removeprefix("standard.") for name in library.names() if name.startswith("standard.")]

#: relative distance from a border at which feasibility is tried
DELTA = 1e-4

Matrices = Mapping[str, Any]

#: the LMIs where r is at the ends of its interval; affine LMIs hold between them as well
ENDS = Relaxation(grid={"rho": 2})
#: coefficients in the barycentric coordinates of r, sufficient on the whole interval
POLYA = Relaxation(polya={"rho": 0})
#: equidistant angles, the last that of the first
CIRCLE = Relaxation(grid={"rho": 9})


def plant(
    matrices: Matrices, interval: tuple[Any, Any] | None = None, rate: Any = None, step: Any = None, simplex: int = 0
) -> Plant:
    """A plant with ρ = r in an interval, with ρ in a simplex, or time-invariant."""
    domains: dict[str, Any] = {}
    if interval:
        domains["rho"] = BoxDomain(("r",), (exact_number(interval[0]),), (exact_number(interval[1]),))
    if simplex:
        domains["rho"] = SimplexDomain.named("rho", simplex)
    components = domains["rho"].components if domains else ()
    motion = Motion(
        step=dict.fromkeys(components, step) if isinstance(step, float) else step,
        rate=None if rate is None else dict.fromkeys(components, rate),
    )
    polynomials = {name: MatrixPolynomial.from_sympy(exact(value)) for name, value in matrices.items()}
    return Plant(polynomials, domains, {"rho": motion} if domains else {}, name="case")


def exact(rows: Any) -> sp.Matrix:
    """Decimals as the rationals they are written as."""
    return sp.Matrix([[sp.sympify(str(entry), rational=True) for entry in row] for row in rows])


def scalars(**values: Any) -> Matrices:
    """Matrices of one entry."""
    return {name: [[value]] for name, value in values.items()}


def theorem(name: str) -> Theorem:
    return library.theorem(f"standard.{name}")


def matching(pattern: str) -> list[str]:
    """Theorems and variants of the standard group; a pattern without any is a mistake in a table."""
    found = [name for name in NAMES if any(fnmatch(name, one) for one in pattern.split())]
    assert found, pattern
    return found


def cases(table: Iterable[Any]) -> list[Any]:
    """Every case with each of its theorems."""
    return [pytest.param(name, case, id=f"{name}-{case.what}") for case in table for name in matching(case.pattern)]


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
UNIT = (0, 1)
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


def feasible(
    posed: Theorem, subject: Plant, relaxation: Relaxation | None = None, dependence: Mapping[str, Any] | None = None
) -> Result | None:
    """The result of a feasibility condition, None where there is none."""
    used = {name: matrix for name, matrix in subject.matrices.items() if name in posed.data}
    problem = compile(posed, replace(subject, matrices=used), dependence=dependence, relaxation=relaxation)
    try:
        result = run(problem)
    except PlantError as error:
        assert "so no solution exists" in str(error)
        return None
    assert result.solution.status in (Status.SOLVED, Status.INFEASIBLE), result.solution.warnings
    return result if result.solution.status is Status.SOLVED else None


def closed_loops(result: Result) -> list[dict[str, Any]]:
    """The plant's matrices at the ends of r with the recovered gain closed by hand."""
    subject = result.problem.binding.plant
    closed = []
    points: Any = subject.domains["rho"].vertices if subject.domains else [[]]
    for point in points:
        at = {} if not subject.domains else {"rho": point}
        symbols = {sp.Symbol("r"): np.array([v]) for v in point}
        m = {name: matrix.evaluate(symbols)[0] for name, matrix in subject.matrices.items()}
        gains = {key: np.squeeze(value, 0) if value.ndim == 3 else value for key, value in result.design(**at).items()}
        if "L" in gains:
            m["A"] = m["A"] - gains["L"] @ m["C"]
        if "K" in gains:
            m["A"] = m["A"] + m.get("B_u", m.get("B")) @ gains["K"]
        if "D_zu" in m:
            m["C_z"] = m["C_z"] + m["D_zu"] @ gains["K"]
        closed.append(m)
    return closed


def stable(A: Any, discrete: bool) -> bool:
    poles = np.linalg.eigvals(A)
    return bool(np.abs(poles).max() < 1 if discrete else poles.real.max() < 0)


# Decay rates --------------------------------------------------------------------------------------


def rotating(A0: Any) -> Matrices:
    """A(r) = R(r)ᵀ A₀ R(r), R a rotation by r."""
    r = sp.Symbol("r")
    R = sp.Matrix([[sp.cos(r), sp.sin(r)], [-sp.sin(r), sp.cos(r)]])
    return {"A": np.array((R.T * sp.Matrix(A0) * R).expand().tolist())}


#: x = R(r)ᵀy turns P(r) = RᵀMR into a constant M; averaged over the angles of a grid, every P in the span of
#: TURNING has this form, and every constant P becomes a multiple of I
TURNING = ["1", "cos(2*r)", "sin(2*r)"]
TURN = (0, 6.283185307179586)


def common_quadratic(A: Any, rate: float, decay: float = 0.0) -> bool:
    """Whether ẏ = (A₀ + decay·I + v·J)y, |v| ≤ rate, has a common xᵀMx: neither the product of the two extreme
    matrices nor that of one with the other's inverse has a negative real eigenvalue, both Hurwitz (Shorten and
    Narendra 2002, for second order). With x = R(r)ᵀy this is ẋ = A(r)x at |ṙ| ≤ rate.
    """
    J = np.array([[0.0, 1.0], [-1.0, 0.0]])
    first, second = (np.array(A, dtype=float) + decay * np.eye(2) + v * J for v in (rate, -rate))
    if not (stable(first, False) and stable(second, False)):
        return False
    poles = np.concatenate([np.linalg.eigvals(first @ second), np.linalg.eigvals(first @ np.linalg.inv(second))])
    return not bool(((np.abs(poles.imag) < 1e-12) & (poles.real < 0)).any())


def border(holds: Callable[[float], bool], low: float, high: float) -> float:
    """Largest value up to which the condition holds."""
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


SHEAR = [[-1, sp.Rational(4, 3)], [0, -2]]
# A₁ = u₁e₁ᵀ, A₂ = u₂e₂ᵀ with u = (1, ±1)/2
RANK_ONE = {"A": [["(1-r)/2", "r/2"], ["(1-r)/2", "-r/2"]]}


@dataclass(frozen=True)
class Decay:
    pattern: str
    what: str
    plant: Plant
    rate: float
    relaxation: Relaxation | None = None
    dependence: Mapping[str, Any] = field(default_factory=dict)


DECAY = [
    # spectral abscissa
    Decay("decay_rate_continuous*", "real poles", plant({"A": [[0, 1], [-2, -3]]}), 1),
    Decay("decay_rate_continuous*", "complex poles", plant({"A": [["-1/2", 3], [-2, "-1/2"]]}), 0.5),
    # between A and Aᵀ, A = [-1 1; 0 -1]: the middle has the pole -1/2, and P = I decays as fast
    Decay(
        "decay_rate_continuous*", "transposed pair", plant({"A": [[-1, "1-r"], ["r", -1]]}, UNIT, rate=1), 0.5, POLYA
    ),
    # a constant P averages to I: -λ_max(A₀ + A₀ᵀ)/2 = (3 - √(1 + 16/9))/2
    Decay("decay_rate_continuous_quadratic", "turning", plant(rotating(SHEAR), TURN), 2 / 3, CIRCLE),
    # a turn at rest decays as A₀
    Decay("decay_rate_continuous", "at rest", plant(rotating(SHEAR), TURN, rate=0), 1, CIRCLE, {"P": TURNING}),
    Decay(
        "decay_rate_continuous", "turning slowly", plant(rotating(SHEAR), TURN, rate=0.25),
        border(lambda b: common_quadratic(SHEAR, 0.25, b), 0, 1), CIRCLE, {"P": TURNING},
    ),
    # spectral radius
    Decay("decay_rate_discrete*", "real poles", plant({"A": [["1/2", 1], [0, "-1/4"]]}), 0.5),
    Decay("decay_rate_discrete*", "complex poles", plant({"A": [["3/10", "2/5"], ["-2/5", "3/10"]]}), 0.5),
    # P_i → q_i e_i e_iᵀ: β²q_i > q_j (e_jᵀu_i)², and every e_jᵀu_i is ±1/2
    Decay("decay_rate_discrete", "rank one", plant(RANK_ONE, UNIT), 0.5),
    # β² > (u_iᵀPu_i)(P⁻¹)_ii for both i: with P = [p c; c 1] one of them is at least 1/2, with equality at P = I
    Decay("decay_rate_discrete_quadratic", "rank one", plant(RANK_ONE, UNIT), sqrt(0.5)),
    # e₁e₂ᵀ and e₂e₁ᵀ in turn keep the norm, and P = I is kept by both
    Decay("decay_rate_discrete*", "exchange", plant({"A": [[0, "r"], ["1-r", 0]]}, UNIT), 1),
]  # fmt: skip


@pytest.mark.parametrize(("name", "case"), cases(DECAY))
def test_decay_rate(name: str, case: Decay) -> None:
    binding = prepare(theorem(name), case.plant, case.dependence)
    found = bisect(binding, 0.9 * case.rate, 1.1 * case.rate, relaxation=case.relaxation, tolerance=1e-7)
    assert found.value == pytest.approx(case.rate, rel=1e-6)
    assert found.other == pytest.approx(case.rate, rel=1e-6)


# Feasibility --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Margin:
    """The LMIs hold for k below ``margin`` and not above; an infinite margin is tried at k = 100."""

    pattern: str
    what: str
    plant: Callable[[float], Plant]
    margin: float
    relaxation: Relaxation | None = None
    dependence: Mapping[str, Any] = field(default_factory=dict)


def controlled(matrices: Matrices) -> Matrices:
    """With an unstable state more that alone is controlled and measured: gains change nothing else."""
    A = matrices["A"]
    last = [0] * len(A) + [1]
    return {"A": [*([*row, 0] for row in A), last], "B": [[entry] for entry in last], "C": [last]}


def stability(make: Callable[[float], Matrices], *options: Any, **motion: Any) -> Callable[[float], Plant]:
    return lambda k: plant(make(k), *options, **motion)


def feedback(make: Callable[[float], Matrices], *options: Any, **motion: Any) -> Callable[[float], Plant]:
    return lambda k: plant(controlled(make(k)), *options, **motion)


def oscillator(k: float) -> Matrices:
    return {"A": [[0, 1], [f"-1 - {k!r}*r", -1]]}


def oscillator_on_a_simplex(k: float) -> Matrices:
    return {"A": [[0, 1], [f"-rho1 - {1 + k!r}*rho2", -1]]}


def turning(k: float) -> Matrices:
    return rotating([[-1, k], [0, -2]])


def rank_one(k: float) -> Matrices:
    return {"A": [[f"{k!r}*({entry})" for entry in row] for row in RANK_ONE["A"]]}


def exchange(k: float) -> Matrices:
    return {"A": [[0, f"{k!r}*r"], [f"{k!r}*(1-r)", 0]]}


def pole(k: float) -> Matrices:
    return {"A": [[k]]}


def scheduled(k: float) -> Matrices:
    """The pole is anywhere from 0 to 2k."""
    return scalars(A=f"{2 * k!r}*r", B=1, C=1)


def signed(k: float) -> Matrices:
    """Control and measurement have the sign of r."""
    return scalars(A=k - 1, B="r", C="r")


SLOW_TURN = border(lambda k: common_quadratic([[-1, k], [0, -2]], 0.25), 0, 100)
QUADRATIC_CONTINUOUS = (
    "state_feedback_continuous_quadratic state_feedback_continuous_robust "
    "observer_continuous_quadratic observer_continuous_constant_gain"
)
QUADRATIC_DISCRETE = "state_feedback_discrete_quadratic state_feedback_discrete_robust observer_discrete_quadratic"
SCHEDULED_DISCRETE = "state_feedback_discrete state_feedback_slack_discrete observer_discrete"
ONE_GAIN_DISCRETE = "state_feedback_slack_discrete_robust observer_discrete_constant_gain"
TURNING_UNKNOWNS = {"P": TURNING, "Q": TURNING, "Y": "constant", "Z": "constant"}

MARGINS = [
    # poles of s² + (1 - k)s + 1
    Margin("stability_continuous*", "time-invariant", stability(lambda k: {"A": [[0, 1], [-1, k - 1]]}), 1),
    Margin(
        "state_feedback_continuous* observer_continuous*", "time-invariant",
        feedback(lambda k: {"A": [[0, 1], [-1, k - 1]]}), 1,
    ),
    # ẍ + ẋ + (1 + k r)x = 0, circle criterion: Re 1/(s² + s + 1) is least, -1/3, at ω² = 2
    Margin("stability_continuous_quadratic", "circle criterion", stability(oscillator, UNIT), 3),
    Margin(QUADRATIC_CONTINUOUS, "circle criterion", feedback(oscillator, UNIT), 3),
    # constant r: P = [1 + kr + 1/2, 1/2; 1/2, 1] has He(PA) = -[1 + kr, 1/2; 1/2, 1], less the rate in (1,1)
    Margin("stability_continuous", "oscillator", stability(oscillator, UNIT, rate=0), inf, POLYA),
    Margin("stability_continuous", "slow oscillator", stability(oscillator, UNIT, rate=0.001), inf, POLYA),
    Margin(
        "stability_continuous", "slow oscillator, simplex", stability(oscillator_on_a_simplex, simplex=2, rate=0.001),
        inf,
    ),
    Margin(
        "stability_continuous", "oscillator, simplex", stability(oscillator_on_a_simplex, simplex=2, rate=0), inf,
    ),
    # a constant P averages to I: A₀ + A₀ᵀ = [-2 k; k -4]
    Margin("stability_continuous_quadratic", "turning", stability(turning, TURN), sqrt(8), CIRCLE),
    Margin(QUADRATIC_CONTINUOUS, "turning", feedback(turning, TURN), sqrt(8), CIRCLE, TURNING_UNKNOWNS),
    Margin("stability_continuous", "at rest", stability(turning, TURN, rate=0), inf, CIRCLE, {"P": TURNING}),
    Margin("stability_continuous", "slow turn", stability(turning, TURN, rate=0.25), SLOW_TURN, CIRCLE, {"P": TURNING}),
    Margin(
        "state_feedback_continuous observer_continuous", "slow turn", feedback(turning, TURN, rate=0.25), SLOW_TURN,
        CIRCLE, TURNING_UNKNOWNS,
    ),
    # no constant gain stabilises both signs
    Margin(
        "state_feedback_continuous_robust observer_continuous_constant_gain", "sign", stability(signed, (-1, 1)), 1
    ),
    Margin(
        "state_feedback_continuous state_feedback_continuous_quadratic observer_continuous "
        "observer_continuous_quadratic",
        "sign", stability(signed, (-1, 1), rate=100), inf, ENDS,
    ),
    # spectral radius
    Margin("stability_discrete* stability_poly_daafouz stability_slack_deoliveira", "pole", stability(pole), 1),
    Margin(
        "state_feedback_discrete* state_feedback_slack_discrete* observer_discrete*", "pole", feedback(pole), 1
    ),
    # DECAY's pair, times k; Daafouz and Bernussou: the slack changes nothing
    Margin("stability_discrete", "rank one", stability(rank_one, UNIT), 2),
    Margin("stability_poly_daafouz", "rank one", stability(rank_one, UNIT), 2, ENDS),
    Margin(SCHEDULED_DISCRETE, "rank one", feedback(rank_one, UNIT), 2, ENDS),
    Margin("stability_discrete_quadratic", "rank one", stability(rank_one, UNIT), sqrt(2)),
    Margin(QUADRATIC_DISCRETE, "rank one", feedback(rank_one, UNIT), sqrt(2), ENDS),
    # the pair k e₁e₂ᵀ, k e₂e₁ᵀ in turn grows with k; constant r, the pole is k√(r(1 - r)) ≤ k/2. The slack attains
    # this: with G = I, P₁ = diag(p, q) and P₂ = diag(q, p) the LMIs are q(2 - p) > k², 0 < p, q < 2
    Margin("stability_discrete* stability_poly_daafouz", "exchange", stability(exchange, UNIT), 1, POLYA),
    Margin(
        "state_feedback_discrete* state_feedback_slack_discrete* observer_discrete*", "exchange",
        feedback(exchange, UNIT), 1, POLYA,
    ),
    Margin("stability_slack_deoliveira", "exchange", stability(exchange, UNIT), 2),
    Margin(ONE_GAIN_DISCRETE, "constant exchange", feedback(exchange, UNIT, step="constant"), 2),
    # |a - g| < 1 for a from 0 to 2k: g = k; a scheduled gain follows a
    Margin(
        f"state_feedback_discrete_robust {ONE_GAIN_DISCRETE}", "unknown pole", stability(scheduled, UNIT), 1
    ),
    Margin(
        f"{SCHEDULED_DISCRETE} state_feedback_discrete_quadratic observer_discrete_quadratic", "known pole",
        stability(scheduled, UNIT), inf, POLYA,
    ),
]  # fmt: skip


@pytest.mark.parametrize(("name", "case"), cases(MARGINS))
def test_margin(name: str, case: Margin) -> None:
    posed = theorem(name)
    dependence = {key: choice for key, choice in case.dependence.items() if key in posed.unknowns}
    pose = partial(feasible, posed, relaxation=case.relaxation, dependence=dependence)
    result = pose(case.plant(100.0 if case.margin == inf else case.margin * (1 - DELTA)))
    assert result is not None
    if posed.recover:
        for closed in closed_loops(result):
            assert stable(closed["A"], "discrete" in name)
    if case.margin < inf:
        assert pose(case.plant(case.margin * (1 + DELTA))) is None


def test_every_standard_theorem_has_a_case() -> None:
    patterns = [case.pattern for table in (NORMS, DECAY, MARGINS) for case in table]
    assert {name for pattern in patterns for name in matching(pattern)} == set(NAMES)
