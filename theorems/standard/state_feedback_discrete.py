"""Stabilising state feedback, discrete time.

x⁺ = A x + B u, u = K x at ρ_k. ρ_k and ρ_{k+1} range independently over the domain, or within the
plant's step bound. If the LMI holds, the closed loop is exponentially stable along every trajectory
with K(ρ) = Y(ρ)Q(ρ)⁻¹ and V = xᵀQ(ρ)⁻¹x. With Q constant the closed loop is quadratically stable; with
Y constant as well so is K, and ρ need not be measured.
"""

from lmic.dsl import *

n, nu = dims("n nu")
rho = Parameter("rho", latex=r"\rho_k", latex_next=r"\rho_{k+1}", step="free")

A, B = Data("A", n, n)(rho), Data("B", n, nu)(rho)
Q, Y = Symmetric("Q", n), Matrix("Y", nu, n)(rho)

decrease = PD([
    [Q(rho), (A*Q(rho) + B*Y).T],
    [star, Q(rho.next)],
])  # fmt: skip

theorem = Theorem(
    title="State feedback, discrete time",
    lmis={"decrease": decrease},
    recover={"K": Y * inv(Q(rho))},
    variants={
        "state_feedback_discrete_quadratic": Variant("State feedback, discrete time, quadratic", constant=(Q,)),
        "state_feedback_discrete_robust": Variant("State feedback, discrete time, robust", constant=(Q, Y)),
    },
    source=Source(
        authors="De Caigny, Camino, Oliveira, Peres, Swevers",
        title="Gain-scheduled H2 and H∞ control of discrete-time polytopic time-varying systems",
        venue="IET Control Theory & Applications",
        year=2010,
        derived="stabilisation alone, with the slack G = Q",
    ),
)
