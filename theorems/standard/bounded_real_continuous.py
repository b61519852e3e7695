"""Bounded-real lemma, continuous time, with bounded parameter rates.

ẋ = A x + B w, z = C x + D w at ρ. ρ ranges over the domain and ρ̇ over its rate bounds, independently
of ρ. If the LMIs hold, the system is exponentially stable and its L2 gain is below γ along every
trajectory. With P constant, dP/dt = 0 and the rates may be arbitrary (Boyd et al. 1994, Chapter 6);
without ρ this is the H∞ norm.
"""

from lmic.dsl import *

n, nw, nz = dims("n nw nz")
rho = Parameter("rho")

A, B = Data("A", n, n)(rho), Data("B", n, nw)(rho)
C, D = Data("C", nz, n)(rho), Data("D", nz, nw)(rho)
P = Symmetric("P", n)(rho)
gamma = Scalar("gamma")

dissipation = ND([
    [dot(P) + He(P*A), P*B, C.T],
    [star, -gamma*I(nw), D.T],
    [star, star, -gamma*I(nz)],
])  # fmt: skip

theorem = Theorem(
    title="Bounded-real lemma, continuous time",
    minimise=gamma,
    lmis={"dissipation": dissipation, "P": PD(P)},
    reports={"gamma": gamma},
    variants={
        "bounded_real_continuous_quadratic": Variant("Bounded-real lemma, continuous time, quadratic", constant=(P,)),
    },
    source=Source(
        authors="Wu, Yang, Packard, Becker",
        title="Induced L2-norm control for LPV systems with bounded parameter variation rates",
        venue="International Journal of Robust and Nonlinear Control",
        year=1996,
    ),
)
