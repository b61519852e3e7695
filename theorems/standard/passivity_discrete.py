"""Positive-real lemma, discrete time.

x⁺ = A x + B w, z = C x + D w at ρ_k, with as many outputs as inputs. ρ_k and ρ_{k+1} range independently
over the domain, or within the plant's step bound. If the LMI holds, the system is exponentially stable
and Σ zᵀw ≥ ν Σ wᵀw along every trajectory from rest: it is passive where ν ≥ 0, and strictly so where
ν > 0. Without ρ the largest ν is the least eigenvalue of (G(e^{jθ}) + G(e^{jθ})*)/2 over all θ, of the
transfer function G.
"""

from lmic.dsl import *

n, nw = dims("n nw")
rho = Parameter("rho", latex=r"\rho_k", latex_next=r"\rho_{k+1}", step="free")

A, B = Data("A", n, n)(rho), Data("B", n, nw)(rho)
C, D = Data("C", nw, n)(rho), Data("D", nw, nw)(rho)
P = Symmetric("P", n)
nu = Scalar("nu")

passivity = PD([
    [P(rho), C.T, A.T*P(rho.next)],
    [star, He(D) - 2*nu*I(nw), B.T*P(rho.next)],
    [star, star, P(rho.next)],
])  # fmt: skip

theorem = Theorem(
    title="Positive-real lemma, discrete time",
    minimise=-nu,
    lmis={"passivity": passivity},
    reports={"nu": nu},
    assumes=[Schur(A, because="at ρ_{k+1} = ρ_k the LMI implies AᵀPA < P")],
    variants={
        "passivity_discrete_quadratic": Variant("Positive-real lemma, discrete time, quadratic", constant=(P,)),
    },
    source=Source(
        authors="Hitz, Anderson",
        title="Discrete positive-real functions and their application to system stability",
        venue="Proceedings of the IEE",
        year=1969,
        derived="P dependent on ρ, and the index ν",
    ),
)
