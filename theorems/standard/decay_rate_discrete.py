"""Decay rate of a discrete-time LPV system.

x⁺ = A(ρ) x. ρ_k and ρ_{k+1} range independently over the domain, or within the plant's step bound. If
the LMIs hold for a given β > 0, ‖x_k‖ ≤ c β^k ‖x_0‖ along every trajectory. The smallest such β is a
generalised eigenvalue problem, solved by bisection over β. The LMI is that of stability for A/β.
"""

from lmic.dsl import *

(n,) = dims("n")
rho = Parameter("rho", latex=r"\rho_k", latex_next=r"\rho_{k+1}", step="free")
beta = given("beta")

A = Data("A", n, n)(rho)
P = Symmetric("P", n)

decrease = PD([
    [beta**2*P(rho), A.T*P(rho.next)],
    [star, P(rho.next)],
])  # fmt: skip

theorem = Theorem(
    title="Decay rate, discrete time",
    lmis={"decrease": decrease},
    bisect=Bisection(beta, "minimise"),
    variants={"decay_rate_discrete_quadratic": Variant("Quadratic decay rate, discrete time", constant=(P,))},
    source=Source(
        authors="Daafouz, Bernussou",
        title="Parameter dependent Lyapunov functions for discrete time systems "
        "with time varying parametric uncertainties",
        venue="Systems & Control Letters",
        year=2001,
        derived="the stability condition for A/β",
    ),
)
