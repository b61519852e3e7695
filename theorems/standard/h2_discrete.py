"""H2 norm, discrete time.

x⁺ = A x + B w, z = C x + D w at ρ_k. ρ_k and ρ_{k+1} range independently over the domain, or within the
plant's step bound. If the LMIs hold, the system is exponentially stable, and the energies of the
responses z to a unit pulse in each input, whenever it comes, add up to less than γ² = μ along every
trajectory. With P constant it is the quadratic condition; without ρ this is the H2 norm.
"""

from lmic.dsl import *

n, nw, nz = dims("n nw nz")
rho = Parameter("rho", latex=r"\rho_k", latex_next=r"\rho_{k+1}", step="free")

A, B = Data("A", n, n)(rho), Data("B", n, nw)(rho)
C, D = Data("C", nz, n)(rho), Data("D", nz, nw)(rho)
P, Z = Symmetric("P", n), Symmetric("Z", nw)(rho)
mu = Scalar("mu")

energy = PD([
    [P(rho), A.T*P(rho.next), C.T],
    [star, P(rho.next), 0],
    [star, star, I(nz)],
])  # fmt: skip

impulse = PD([
    [Z, B.T*P(rho.next), D.T],
    [star, P(rho.next), 0],
    [star, star, I(nz)],
])  # fmt: skip

theorem = Theorem(
    title="H2 norm, discrete time",
    minimise=mu,
    lmis={"energy": energy, "impulse": impulse, "trace": PD(mu * I(1) - trace(Z))},
    reports={"gamma": sqrt(mu)},
    assumes=[Schur(A, because="at ρ_{k+1} = ρ_k the LMI implies AᵀPA < P")],
    variants={"h2_discrete_quadratic": Variant("H2 norm, discrete time, quadratic", constant=(P,))},
    source=Source(
        authors="De Caigny, Camino, Oliveira, Peres, Swevers",
        title="Gain-scheduled H2 and H∞ control of discrete-time polytopic time-varying systems",
        venue="IET Control Theory & Applications",
        year=2010,
        derived="in terms of the observability Gramian",
    ),
)
