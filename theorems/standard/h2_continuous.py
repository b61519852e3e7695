"""H2 norm, continuous time, with bounded parameter rates.

ẋ = A x + B w, z = C x at ρ. ρ ranges over the domain and ρ̇ over its rate bounds, independently of ρ.
If the LMIs hold, the system is exponentially stable, and the energies of the responses z to an impulse
in each input, whenever it comes, add up to less than γ² = μ along every trajectory. With P constant,
dP/dt = 0 and the rates may be arbitrary; without ρ this is the H2 norm.
"""

from lmic.dsl import *

n, nw, nz = dims("n nw nz")
rho = Parameter("rho")

A, B, C = Data("A", n, n)(rho), Data("B", n, nw)(rho), Data("C", nz, n)(rho)
P, Z = Symmetric("P", n)(rho), Symmetric("Z", nw)(rho)
mu = Scalar("mu")

energy = ND([
    [dot(P) + He(P*A), C.T],
    [star, -I(nz)],
])  # fmt: skip

impulse = PD([
    [Z, B.T*P],
    [star, P],
])  # fmt: skip

theorem = Theorem(
    title="H2 norm, continuous time",
    minimise=mu,
    lmis={"energy": energy, "impulse": impulse, "trace": PD(mu * I(1) - trace(Z))},
    reports={"gamma": sqrt(mu)},
    variants={"h2_continuous_quadratic": Variant("H2 norm, continuous time, quadratic", constant=(P,))},
    source=Source(
        authors="Scherer, Gahinet, Chilali",
        title="Multiobjective output-feedback control via LMI optimization",
        venue="IEEE Transactions on Automatic Control",
        year=1997,
        derived="dP/dt for P dependent on ρ",
    ),
)
