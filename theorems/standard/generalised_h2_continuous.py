"""Generalised H2 norm (energy to peak), continuous time, with bounded parameter rates.

ẋ = A x + B w, z = C x at ρ. ρ ranges over the domain and ρ̇ over its rate bounds, independently of ρ.
If the LMIs hold, the system is exponentially stable and sup ‖z(t)‖ < γ ‖w‖_2, γ = √μ, along every
trajectory from rest. With P constant, dP/dt = 0 and the rates may be arbitrary.
"""

from lmic.dsl import *

n, nw, nz = dims("n nw nz")
rho = Parameter("rho")

A, B, C = Data("A", n, n)(rho), Data("B", n, nw)(rho), Data("C", nz, n)(rho)
P = Symmetric("P", n)(rho)
mu = Scalar("mu")

energy = ND([
    [dot(P) + He(P*A), P*B],
    [star, -I(nw)],
])  # fmt: skip

peak = PD([
    [P, C.T],
    [star, mu*I(nz)],
])  # fmt: skip

theorem = Theorem(
    title="Generalised H2 norm, continuous time",
    minimise=mu,
    lmis={"energy": energy, "peak": peak},
    reports={"gamma": sqrt(mu)},
    variants={
        "generalised_h2_continuous_quadratic": Variant(
            "Generalised H2 norm, continuous time, quadratic", constant=(P,)
        ),
    },
    source=Source(
        authors="Rotea",
        title="The generalized H2 control problem",
        venue="Automatica",
        year=1993,
        derived="dP/dt for P dependent on ρ",
    ),
)
