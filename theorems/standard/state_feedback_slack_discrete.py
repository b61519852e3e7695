"""Stabilising state feedback, discrete time, with a slack matrix.

x⁺ = A x + B u, u = K x at ρ_k. ρ_k and ρ_{k+1} range independently over the domain, or within the
plant's step bound. If the LMI holds, the closed loop is exponentially stable along every trajectory
with K(ρ) = Y(ρ)G(ρ)⁻¹ and V = xᵀQ(ρ)⁻¹x. With G and Y constant so is K, and ρ need not be measured,
while Q still depends on ρ: for a constant ρ this is the synthesis of de Oliveira, Bernussou and Geromel
(1999).
"""

from lmic.dsl import *

n, nu = dims("n nu")
rho = Parameter("rho", latex=r"\rho_k", latex_next=r"\rho_{k+1}", step="free")

A, B = Data("A", n, n)(rho), Data("B", n, nu)(rho)
Q, G, Y = Symmetric("Q", n), Matrix("G", n, n)(rho), Matrix("Y", nu, n)(rho)

decrease = PD([
    [G + G.T - Q(rho), (A*G + B*Y).T],
    [star, Q(rho.next)],
])  # fmt: skip

theorem = Theorem(
    title="State feedback with a slack matrix, discrete time",
    lmis={"decrease": decrease},
    recover={"K": Y * inv(G)},
    variants={
        "state_feedback_slack_discrete_robust": Variant(
            "State feedback with a slack matrix, discrete time, robust", constant=(G, Y)
        ),
    },
    source=Source(
        authors="De Caigny, Camino, Oliveira, Peres, Swevers",
        title="Gain-scheduled H2 and H∞ control of discrete-time polytopic time-varying systems",
        venue="IET Control Theory & Applications",
        year=2010,
        derived="stabilisation alone",
    ),
)
