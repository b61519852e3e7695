"""Generalised H2 norm (energy to peak), discrete time.

x⁺ = A x + B w, z = C x + D w at ρ_k. ρ_k and ρ_{k+1} range independently over the domain, or within the
plant's step bound. If the LMIs hold, the system is exponentially stable and sup ‖z_k‖ < γ ‖w‖_2, γ =
√μ, along every trajectory from rest. With P constant it is the quadratic condition.

Derived: for P dependent on ρ, the first LMI is V⁺ − V < wᵀw with V = xᵀP(ρ)x, so V_k is below the
energy of w before k; the second is zᵀz < μ (V + wᵀw).
"""

from lmic.dsl import *

n, nw, nz = dims("n nw nz")
rho = Parameter("rho", latex=r"\rho_k", latex_next=r"\rho_{k+1}", step="free")

A, B = Data("A", n, n)(rho), Data("B", n, nw)(rho)
C, D = Data("C", nz, n)(rho), Data("D", nz, nw)(rho)
P = Symmetric("P", n)
mu = Scalar("mu")

energy = PD([
    [P(rho), 0, A.T*P(rho.next)],
    [star, I(nw), B.T*P(rho.next)],
    [star, star, P(rho.next)],
])  # fmt: skip

peak = PD([
    [P(rho), 0, C.T],
    [star, I(nw), D.T],
    [star, star, mu*I(nz)],
])  # fmt: skip

theorem = Theorem(
    title="Generalised H2 norm, discrete time",
    minimise=mu,
    lmis={"energy": energy, "peak": peak},
    reports={"gamma": sqrt(mu)},
    assumes=[Schur(A, because="at ρ_{k+1} = ρ_k the LMI implies AᵀPA < P")],
    variants={
        "generalised_h2_discrete_quadratic": Variant("Generalised H2 norm, discrete time, quadratic", constant=(P,)),
    },
    source=Source(
        authors="Skelton, Iwasaki, Grigoriadis",
        title="A Unified Algebraic Approach to Linear Control Design",
        venue="Taylor & Francis",
        year=1998,
        derived="P dependent on ρ",
    ),
)
