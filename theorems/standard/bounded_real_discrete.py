"""Bounded-real lemma, discrete time.

x⁺ = A x + B w, z = C x + D w at ρ_k. ρ_k and ρ_{k+1} range independently over the domain, or within the
plant's step bound. If the LMI holds, the system is exponentially stable and its ℓ2 gain is below γ
along every trajectory. With P constant it is the quadratic lemma; without ρ this is the H∞ norm.

The paper states it in P⁻¹, by the congruence diag{P(ρ_k)⁻¹, I, P(ρ_{k+1})⁻¹, I}.
"""

from lmic.dsl import *

n, nw, nz = dims("n nw nz")
rho = Parameter("rho", latex=r"\rho_k", latex_next=r"\rho_{k+1}", step="free")

A, B = Data("A", n, n)(rho), Data("B", n, nw)(rho)
C, D = Data("C", nz, n)(rho), Data("D", nz, nw)(rho)
P = Symmetric("P", n)
gamma = Scalar("gamma")

dissipation = PD([
    [P(rho), 0, A.T*P(rho.next), C.T],
    [star, gamma*I(nw), B.T*P(rho.next), D.T],
    [star, star, P(rho.next), 0],
    [star, star, star, gamma*I(nz)],
])  # fmt: skip

theorem = Theorem(
    title="Bounded-real lemma, discrete time",
    minimise=gamma,
    lmis={"dissipation": dissipation},
    reports={"gamma": gamma},
    guarantees=[Bound("l2 gain", DiscreteSystem(A, B, C, D), "gamma")],
    assumes=[Schur(A, because="at ρ_{k+1} = ρ_k the LMI implies AᵀPA < P")],
    variants={
        "bounded_real_discrete_quadratic": Variant("Bounded-real lemma, discrete time, quadratic", constant=(P,)),
    },
    source=Source(
        authors="De Caigny, Camino, Oliveira, Peres, Swevers",
        title="Gain-scheduled H2 and H∞ control of discrete-time polytopic time-varying systems",
        venue="IET Control Theory & Applications",
        year=2010,
    ),
)
