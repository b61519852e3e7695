"""Luenberger observer, discrete time, with a slack matrix.

x⁺ = A x, y = C x at ρ_k; observer x̂⁺ = A x̂ + L (y − C x̂). ρ_k and ρ_{k+1} range independently over
the domain, or within the plant's step bound. If the LMI holds, the error e = x − x̂, with e⁺ = (A − LC)
e, decays exponentially along every trajectory, with L(ρ) = G(ρ)⁻¹Z(ρ) and V = eᵀP(ρ)e. The slack G
keeps L free of ρ_{k+1}. With P and G constant it is the quadratic condition, for which G brings
nothing; with G and Z constant so is L. The observer needs A and C, so ρ is measured in each case.
"""

from lmic.dsl import *

n, ny = dims("n ny")
rho = Parameter("rho", latex=r"\rho_k", latex_next=r"\rho_{k+1}", step="free")

A, C = Data("A", n, n)(rho), Data("C", ny, n)(rho)
P, G, Z = Symmetric("P", n), Matrix("G", n, n)(rho), Matrix("Z", n, ny)(rho)

decrease = PD([
    [P(rho), (G*A - Z*C).T],
    [star, G + G.T - P(rho.next)],
])  # fmt: skip

theorem = Theorem(
    title="Observer, discrete time",
    lmis={"decrease": decrease},
    recover={"L": inv(G) * Z},
    variants={
        "observer_discrete_quadratic": Variant("Observer, discrete time, quadratic", constant=(P, G)),
        "observer_discrete_constant_gain": Variant("Observer, discrete time, constant gain", constant=(G, Z)),
    },
    source=Source(
        authors="Heemels, Daafouz, Millerioux",
        title="Observer-based control of discrete-time LPV systems with uncertain parameters",
        venue="IEEE Transactions on Automatic Control",
        year=2010,
    ),
)
