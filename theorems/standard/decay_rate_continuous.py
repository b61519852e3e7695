"""Decay rate of a continuous-time LPV system with bounded parameter rates.

ẋ = A(ρ) x. ρ ranges over the domain and ρ̇ over its rate bounds, independently of ρ. If the LMIs hold
for a given β, ‖x(t)‖ ≤ c e^{−βt} ‖x(0)‖ along every trajectory. The largest such β is a generalised
eigenvalue problem, solved by bisection over β. With P constant, dP/dt = 0 and the rates may be
arbitrary (Boyd et al. 1994, Chapter 5).
"""

from lmic.dsl import *

(n,) = dims("n")
rho = Parameter("rho")
beta = given("beta")

A = Data("A", n, n)(rho)
P = Symmetric("P", n)(rho)

theorem = Theorem(
    title="Decay rate, continuous time",
    lmis={"decrease": ND(dot(P) + He(P * A) + 2 * beta * P), "P": PD(P)},
    bisect=Bisection(beta, "maximise"),
    variants={
        "decay_rate_continuous_quadratic": Variant("Quadratic decay rate, continuous time", constant=(P,)),
    },
    source=Source(
        authors="Boyd, El Ghaoui, Feron, Balakrishnan",
        title="Linear Matrix Inequalities in System and Control Theory",
        venue="SIAM",
        year=1994,
        statement="Chapter 5",
        derived="dP/dt for P dependent on ρ",
    ),
)
