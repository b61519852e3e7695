"""Luenberger observer, continuous time, with bounded parameter rates.

ẋ = A x, y = C x at ρ; observer x̂' = A x̂ + L (y − C x̂). ρ ranges over the domain and ρ̇ over its rate
bounds, independently of ρ. If the LMIs hold, the error e = x − x̂, with ė = (A − LC) e, decays
exponentially along every trajectory, with L(ρ) = P(ρ)⁻¹Z(ρ) and V = eᵀP(ρ)e. With P constant the rates
may be arbitrary; with Z constant as well so is L. The observer needs A and C, so ρ is measured in each
case.
"""

from lmic.dsl import *

n, ny = dims("n ny")
rho = Parameter("rho")

A, C = Data("A", n, n)(rho), Data("C", ny, n)(rho)
P, Z = Symmetric("P", n)(rho), Matrix("Z", n, ny)(rho)

theorem = Theorem(
    title="Observer, continuous time",
    lmis={"decrease": ND(dot(P) + He(P * A - Z * C)), "P": PD(P)},
    recover={"L": inv(P) * Z},
    variants={
        "observer_continuous_quadratic": Variant("Observer, continuous time, quadratic", constant=(P,)),
        "observer_continuous_constant_gain": Variant("Observer, continuous time, constant gain", constant=(P, Z)),
    },
    source=Source(
        authors="Boyd, El Ghaoui, Feron, Balakrishnan",
        title="Linear Matrix Inequalities in System and Control Theory",
        venue="SIAM",
        year=1994,
        statement="Chapter 7",
        derived="dP/dt for P dependent on ρ",
    ),
)
