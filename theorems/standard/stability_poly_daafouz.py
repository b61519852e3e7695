"""Poly-quadratic stability of a discrete-time LPV system, with a slack matrix.

x⁺ = A(ρ) x. ρ_k and ρ_{k+1} range independently over the domain, or within the plant's step bound. If
the LMI holds, V = xᵀS(ρ)⁻¹x decreases along every trajectory: the system is exponentially stable.

The paper is on a polytope and asks the LMI at its vertices ρ_k = i, ρ_{k+1} = j only, with S_i, G_i and
A_i. Here it is asked at all ρ_k, ρ_{k+1}, which includes those; A(ρ)G(ρ) is then quadratic in ρ, and the
coefficients that replace it are more conservative than the paper's vertices. stability_discrete, whose
vertices are exact, is equivalent to the paper's condition.
"""

from lmic.dsl import *

(n,) = dims("n")
rho = Parameter("rho", latex=r"\rho_k", latex_next=r"\rho_{k+1}", step="free")

A = Data("A", n, n)(rho)
S, G = Symmetric("S", n), Matrix("G", n, n)(rho)

decrease = PD([
    [G + G.T - S(rho), G.T*A.T],
    [star, S(rho.next)],
])  # fmt: skip

theorem = Theorem(
    title="Poly-quadratic stability with a slack matrix, discrete time",
    lmis={"decrease": decrease},
    assumes=[Schur(A, because="at ρ_{k+1} = ρ_k the LMI implies ASAᵀ < S")],
    source=Source(
        authors="Daafouz, Bernussou",
        title="Parameter dependent Lyapunov functions for discrete time systems "
        "with time varying parametric uncertainties",
        venue="Systems & Control Letters",
        year=2001,
    ),
)
