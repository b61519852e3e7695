"""Stability of a discrete-time LPV system.

x⁺ = A(ρ) x. ρ_k and ρ_{k+1} range independently over the domain, or within the plant's step bound. If
the LMIs hold, V = xᵀP(ρ)x decreases along every trajectory: the system is exponentially stable. On a
polytope with A and P affine this is poly-quadratic stability; with P constant it is quadratic
stability.
"""

from lmic.dsl import *

(n,) = dims("n")
rho = Parameter("rho", latex=r"\rho_k", latex_next=r"\rho_{k+1}", step="free")

A = Data("A", n, n)(rho)
P = Symmetric("P", n)

decrease = PD([
    [P(rho), A.T*P(rho.next)],
    [star, P(rho.next)],
])  # fmt: skip

theorem = Theorem(
    title="Stability, discrete time",
    lmis={"decrease": decrease},
    assumes=[Schur(A, because="at ρ_{k+1} = ρ_k the LMI is AᵀPA < P")],
    variants={"stability_discrete_quadratic": Variant("Quadratic stability, discrete time", constant=(P,))},
    source=Source(
        authors="Daafouz, Bernussou",
        title="Parameter dependent Lyapunov functions for discrete time systems "
        "with time varying parametric uncertainties",
        venue="Systems & Control Letters",
        year=2001,
    ),
)
