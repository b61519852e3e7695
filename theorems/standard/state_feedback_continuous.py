"""Stabilising state feedback, continuous time, with bounded parameter rates.

ẋ = A x + B u, u = K x at ρ. ρ ranges over the domain and ρ̇ over its rate bounds, independently of ρ.
If the LMIs hold, the closed loop is exponentially stable along every trajectory with K(ρ) = Y(ρ)Q(ρ)⁻¹
and V = xᵀQ(ρ)⁻¹x. With Q constant the rates may be arbitrary; with Y constant as well so is K, and ρ
need not be measured (Boyd et al. 1994, Chapter 7).
"""

from lmic.dsl import *

n, nu = dims("n nu")
rho = Parameter("rho")

A, B = Data("A", n, n)(rho), Data("B", n, nu)(rho)
Q, Y = Symmetric("Q", n)(rho), Matrix("Y", nu, n)(rho)

theorem = Theorem(
    title="State feedback, continuous time",
    lmis={"decrease": ND(-dot(Q) + He(A * Q + B * Y)), "Q": PD(Q)},
    recover={"K": Y * inv(Q)},
    variants={
        "state_feedback_continuous_quadratic": Variant("State feedback, continuous time, quadratic", constant=(Q,)),
        "state_feedback_continuous_robust": Variant("State feedback, continuous time, robust", constant=(Q, Y)),
    },
    source=Source(
        authors="Wu, Yang, Packard, Becker",
        title="Induced L2-norm control for LPV systems with bounded parameter variation rates",
        venue="International Journal of Robust and Nonlinear Control",
        year=1996,
    ),
)
