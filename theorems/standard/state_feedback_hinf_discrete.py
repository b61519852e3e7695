"""H∞ state feedback, discrete time, with a slack matrix.

x⁺ = A x + B_w w + B_u u, z = C_z x + D_zw w + D_zu u, u = K x at ρ_k. ρ_k and ρ_{k+1} range
independently over the domain, or within the plant's step bound. If the LMI holds, the closed loop is
exponentially stable and its ℓ2 gain from w to z is below γ along every trajectory, with K(ρ) =
Y(ρ)G(ρ)⁻¹ and V = xᵀQ(ρ)⁻¹x. With Q and G constant it is the quadratic condition, for which the slack G
brings nothing; with G and Y constant so is K, and ρ need not be measured.
"""

from lmic.dsl import *

n, nw, nu, nz = dims("n nw nu nz")
rho = Parameter("rho", latex=r"\rho_k", latex_next=r"\rho_{k+1}", step="free")

A, Bw, Bu = Data("A", n, n)(rho), Data("B_w", n, nw)(rho), Data("B_u", n, nu)(rho)
Cz, Dzw, Dzu = Data("C_z", nz, n)(rho), Data("D_zw", nz, nw)(rho), Data("D_zu", nz, nu)(rho)
Q, G, Y = Symmetric("Q", n), Matrix("G", n, n)(rho), Matrix("Y", nu, n)(rho)
gamma = Scalar("gamma")

dissipation = PD([
    [Q(rho.next), A*G + Bu*Y, Bw, 0],
    [star, G + G.T - Q(rho), 0, (Cz*G + Dzu*Y).T],
    [star, star, gamma*I(nw), Dzw.T],
    [star, star, star, gamma*I(nz)],
])  # fmt: skip

K = Y * inv(G)

theorem = Theorem(
    title="H∞ state feedback, discrete time",
    minimise=gamma,
    lmis={"dissipation": dissipation},
    reports={"gamma": gamma},
    recover={"K": K},
    guarantees=[Bound("l2 gain", DiscreteSystem(A + Bu * K, Bw, Cz + Dzu * K, Dzw), "gamma")],
    variants={
        "state_feedback_hinf_discrete_quadratic": Variant(
            "H∞ state feedback, discrete time, quadratic", constant=(Q, G)
        ),
        "state_feedback_hinf_discrete_robust": Variant("H∞ state feedback, discrete time, robust", constant=(G, Y)),
    },
    source=Source(
        authors="De Caigny, Camino, Oliveira, Peres, Swevers",
        title="Gain-scheduled H2 and H∞ control of discrete-time polytopic time-varying systems",
        venue="IET Control Theory & Applications",
        year=2010,
    ),
)
