"""Stability of a continuous-time LPV system with bounded parameter rates.

ẋ = A(ρ) x. ρ ranges over the domain and ρ̇ over its rate bounds, independently of ρ. If the LMIs hold,
V = xᵀP(ρ)x decreases along every trajectory: the system is exponentially stable. With P constant, dP/dt
= 0 and the rates may be arbitrary: quadratic stability (Boyd et al. 1994, Chapter 5).
"""

from lmic.dsl import *

(n,) = dims("n")
rho = Parameter("rho")

A = Data("A", n, n)(rho)
P = Symmetric("P", n)(rho)

theorem = Theorem(
    title="Stability, continuous time",
    lmis={"decrease": ND(dot(P) + He(P * A)), "P": PD(P)},
    variants={
        "stability_continuous_quadratic": Variant("Quadratic stability, continuous time", constant=(P,)),
    },
    source=Source(
        authors="Gahinet, Apkarian, Chilali",
        title="Affine parameter-dependent Lyapunov functions and real parametric uncertainty",
        venue="IEEE Transactions on Automatic Control",
        year=1996,
    ),
)
