"""Positive-real lemma, continuous time, with bounded parameter rates.

ẋ = A x + B w, z = C x + D w at ρ, with as many outputs as inputs. ρ ranges over the domain and ρ̇ over its
rate bounds, independently of ρ. If the LMIs hold, the system is exponentially stable and
∫ zᵀw dt ≥ ν ∫ wᵀw dt along every trajectory from rest: it is passive where ν ≥ 0, and strictly so where
ν > 0. With P constant, dP/dt = 0 and the rates may be arbitrary; without ρ the largest ν is the least
eigenvalue of (G(jω) + G(jω)*)/2 over all frequencies, of the transfer function G.
"""

from lmic.dsl import *

n, nw = dims("n nw")
rho = Parameter("rho")

A, B = Data("A", n, n)(rho), Data("B", n, nw)(rho)
C, D = Data("C", nw, n)(rho), Data("D", nw, nw)(rho)
P = Symmetric("P", n)(rho)
nu = Scalar("nu")

passivity = ND([
    [dot(P) + He(P*A), P*B - C.T],
    [star, 2*nu*I(nw) - He(D)],
])  # fmt: skip

theorem = Theorem(
    title="Positive-real lemma, continuous time",
    minimise=-nu,
    lmis={"passivity": passivity, "P": PD(P)},
    reports={"nu": nu},
    assumes=[Hurwitz(A, because="at ρ̇ = 0 the LMI implies AᵀP + PA < 0")],
    variants={
        "passivity_continuous_quadratic": Variant("Positive-real lemma, continuous time, quadratic", constant=(P,)),
    },
    source=Source(
        authors="Boyd, El Ghaoui, Feron, Balakrishnan",
        title="Linear Matrix Inequalities in System and Control Theory",
        venue="SIAM",
        year=1994,
        statement="Section 6.3.3",
        derived="dP/dt for P dependent on ρ",
    ),
)
