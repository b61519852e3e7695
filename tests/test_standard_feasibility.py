"""Standard theorems on decay and feasibility: the LMIs hold up to a known border and not beyond.

Two tables: the best decay rate (DECAY), or the value of k up to which the LMIs hold (MARGINS).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from math import inf, sqrt
from typing import Any

import numpy as np
import pytest
import sympy as sp
from standard_cases import (
    CIRCLE,
    DELTA,
    ENDS,
    NAMES,
    POLYA,
    UNIT,
    Matrices,
    cases,
    closed_loops,
    feasible,
    matching,
    plant,
    scalars,
    stable,
    theorem,
)
from test_standard_norms import NORMS
from test_standard_passivity import INDICES

from lmic.pipeline import prepare
from lmic.plants.plant import Plant
from lmic.relax.relax import Relaxation
from lmic.sweeps.search import bisect

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
    patterns = [case.pattern for table in (NORMS, INDICES, DECAY, MARGINS) for case in table]
    assert {name for pattern in patterns for name in matching(pattern)} == set(NAMES)
