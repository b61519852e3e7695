"""H∞ state feedback, continuous time, with bounded parameter rates.

ẋ = A x + B_w w + B_u u, z = C_z x + D_zw w + D_zu u, u = K x at ρ. ρ ranges over the domain and ρ̇ over
its rate bounds, independently of ρ. If the LMIs hold, the closed loop is exponentially stable and its
L2 gain from w to z is below γ along every trajectory, with K(ρ) = Y(ρ)Q(ρ)⁻¹. With Q constant the rates
may be arbitrary; with Y constant as well so is K, and ρ need not be measured.
"""

from lmic.dsl import *

n, nw, nu, nz = dims("n nw nu nz")
rho = Parameter("rho")

A, Bw, Bu = Data("A", n, n)(rho), Data("B_w", n, nw)(rho), Data("B_u", n, nu)(rho)
Cz, Dzw, Dzu = Data("C_z", nz, n)(rho), Data("D_zw", nz, nw)(rho), Data("D_zu", nz, nu)(rho)
Q, Y = Symmetric("Q", n)(rho), Matrix("Y", nu, n)(rho)
gamma = Scalar("gamma")

dissipation = ND([
    [-dot(Q) + He(A*Q + Bu*Y), Bw, (Cz*Q + Dzu*Y).T],
    [star, -gamma*I(nw), Dzw.T],
    [star, star, -gamma*I(nz)],
])  # fmt: skip

theorem = Theorem(
    title="H∞ state feedback, continuous time",
    minimise=gamma,
    lmis={"dissipation": dissipation, "Q": PD(Q)},
    reports={"gamma": gamma},
    recover={"K": Y * inv(Q)},
    variants={
        "state_feedback_hinf_continuous_quadratic": Variant(
            "H∞ state feedback, continuous time, quadratic", constant=(Q,)
        ),
        "state_feedback_hinf_continuous_robust": Variant("H∞ state feedback, continuous time, robust", constant=(Q, Y)),
    },
    source=Source(
        authors="Wu, Yang, Packard, Becker",
        title="Induced L2-norm control for LPV systems with bounded parameter variation rates",
        venue="International Journal of Robust and Nonlinear Control",
        year=1996,
    ),
)
