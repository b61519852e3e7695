"""H∞ analysis of a given filter for an LPV system: Theorem 1 without delay.

Plant   x⁺ = A x + B ω,           y = C x + D ω,           z = H x + L ω,
filter  x_F⁺ = A_F x_F + B_F y,   z_F = C_F x_F + D_F y,   all at ρ_k.
ρ_k and ρ_{k+1} range independently over the domain. If the LMI holds, the error system with
ξ = (x, x_F) is asymptotically stable and the ℓ2 gain from ω to e = z − z_F is below γ.

The printed (20) repeats the row and column of the delayed state; without delay they go, and with
them Q, A_d, C_d and H_d.

Derived: the error system (5), lost in the scan, is (19) and (3) written in ξ.
"""

from lmic.dsl import *

n, m, p, l = dims("n m p l")
rho = Parameter("rho", latex=r"\rho_k", latex_next=r"\rho_{k+1}", step="free")

A, B = Data("A", n, n)(rho), Data("B", n, l)(rho)
C, D = Data("C", m, n)(rho), Data("D", m, l)(rho)
H, L = Data("H", p, n)(rho), Data("L", p, l)(rho)
AF, BF = Data("A_F", n, n)(rho), Data("B_F", n, m)(rho)
CF, DF = Data("C_F", p, n)(rho), Data("D_F", p, m)(rho)

P = Symmetric("P", 2 * n)
gamma2 = Scalar("gamma2", latex=r"\gamma^2")

Abar, Bbar = block([[A, 0], [BF * C, AF]]), block([[B], [BF * D]])
Cbar, Dbar = block([[H - DF * C, -CF]]), L - DF * D

performance = ND([
    [-P(rho), star, star, star],
    [0, -gamma2*I(l), star, star],
    [P(rho.next)*Abar, P(rho.next)*Bbar, -P(rho.next), star],
    [Cbar, Dbar, 0, -I(p)],
])  # fmt: skip

theorem = Theorem(
    title="H∞ analysis of a filter",
    minimise=gamma2,
    lmis={"performance": performance, "P": PD(P(rho))},
    reports={"gamma": sqrt(gamma2)},
    guarantees=[Bound("l2 gain", DiscreteSystem(Abar, Bbar, Cbar, Dbar), "gamma")],
    assumes=[Schur(Abar, because="at ρ_{k+1} = ρ_k the LMI asks ĀᵀPĀ < P of the error system")],
    source=Source(
        authors="Unknown authors",
        title="[Robust H∞ filtering for LPV discrete-time systems with time-varying state delay]",
        venue="Scanned copy without title page",
        year=None,
        statement="Corollary 1, (20)",
        derived="the error system (5)",
    ),
)
