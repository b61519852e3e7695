"""Robust H∞ analysis of a given filter for a 2-D state-delayed system with NFT uncertainty.

Plant   x(i+1, j+1) = A [x(i+1, j); x(i, j+1)] + A_d [x(i+1, j−d_1); x(i−d_2, j+1)]
                      + B_Δ [w_Δ(i+1, j); w_Δ(i, j+1)] + B [w(i+1, j); w(i, j+1)],
        z_Δ = C_Δ x + D_Δz w_Δ + D_z w,   y = C x + D_Δ w_Δ + D w,   z = L x,   w_Δ = Δ z_Δ;
filter  x_f(i+1, j+1) = A_f1 x_f(i+1, j) + A_f2 x_f(i, j+1) + B_f1 y(i+1, j) + B_f2 y(i, j+1),   z_f = C_f x_f,
with A = [A_1 A_2] and A_d, B_Δ, B alike. The plant is affine in α, which is unknown and fixed in the
unit simplex. If the LMIs hold, the error system in (x, x_f) is asymptotically stable and the ℓ2 gain
from w to z − z_f is at most γ, for every α and all delays d_1, d_2.

The LMIs imply (21) and (22) of Theorem 2, the same condition with M⁻¹, E_1⁻¹ and F_1⁻¹ in place of the
slacks H, K_1 and V_1. Its proof needs no block structure of E_1, F_1, V_1 and K_1: the variants, the
same theorem with them full, are not in the paper, hold as well and are less conservative.
"""

from lmic.dsl import *

nx, nw, ny, nz, nd = dims("nx nw ny nz nd")
alpha = Simplex("alpha")

A1, A2 = Data("A_1", nx, nx)(alpha), Data("A_2", nx, nx)(alpha)
Ad1, Ad2 = Data("A_d1", nx, nx)(alpha), Data("A_d2", nx, nx)(alpha)
B1, B2 = Data("B_1", nx, nw)(alpha), Data("B_2", nx, nw)(alpha)
BD1, BD2 = Data("B_Delta_1", nx, nd)(alpha), Data("B_Delta_2", nx, nd)(alpha)
CD, DDz, Dz = Data("C_Delta", nd, nx)(alpha), Data("D_Delta_z", nd, nd)(alpha), Data("D_z", nd, nw)(alpha)
C, DD, D = Data("C", ny, nx)(alpha), Data("D_Delta", ny, nd)(alpha), Data("D", ny, nw)(alpha)
L, Delta = Data("L", nz, nx)(alpha), Data("Delta", nd, nd)(alpha)
Af1, Af2, Bf1, Bf2 = Data("A_f1", nx, nx), Data("A_f2", nx, nx), Data("B_f1", nx, ny), Data("B_f2", nx, ny)
Cf = Data("C_f", nz, nx)

P1, P2 = Symmetric("P_1", 2 * nx)(alpha), Symmetric("P_2", 2 * nx)(alpha)
Q1, Q2 = Symmetric("Q_1", 2 * nx)(alpha), Symmetric("Q_2", 2 * nx)(alpha)
E1, F1 = Symmetric("E_1", 2 * nd, blocks=(nd, nd))(alpha), Symmetric("F_1", 2 * nd, blocks=(nd, nd))(alpha)
H, V1, K1 = Matrix("H", 2 * nx, 2 * nx), BlockDiagonal("V_1", nd, nd), BlockDiagonal("K_1", nd, nd)
gamma = Scalar("gamma")

Ahat = block([[A1, 0, A2, 0], [Bf1 * C, Af1, Bf2 * C, Af2]])
Adhat = block([[Ad1, zeros(nx, nx), Ad2, zeros(nx, nx)], [zeros(nx, nx), 0, 0, 0]])
Bhat, BDhat = block([[B1, B2], [Bf1 * D, Bf2 * D]]), block([[BD1, BD2], [Bf1 * DD, Bf2 * DD]])
CDhat, Chat = block([[CD, zeros(nd, nx)]]), block([[L, -Cf]])
M = P1 + P2 + Q1 + Q2

uncertainty = PD([
    [E1, star],
    [V1*kron(I(2), Delta), F1 + V1 + V1.T],
])  # fmt: skip

performance = ND([
    [-diag(P1, P2), star, star, star, star, star, star],
    [0, -diag(Q1, Q2), star, star, star, star, star],
    [0, 0, F1, star, star, star, star],
    [0, 0, 0, -gamma*I(2*nw), star, star, star],
    [H*Ahat, H*Adhat, H*BDhat, H*Bhat, M - H - H.T, star, star],
    [kron(I(2), Chat), 0, 0, 0, 0, -gamma*I(2*nz), star],
    [K1*kron(I(2), CDhat), 0, K1*kron(I(2), DDz), K1*kron(I(2), Dz), 0, 0, E1 - K1 - K1.T],
])  # fmt: skip

theorem = Theorem(
    title="Robust 2-D H∞ analysis of a filter",
    minimise=gamma,
    lmis={"uncertainty": uncertainty, "performance": performance},
    reports={"gamma": gamma},
    assumes=[
        Schur(
            A1 + A2 + Ad1 + Ad2,
            because="the LMI is for all delays; without delay, a state that depends on i + j alone moves by this sum",
        ),
        Schur(Af1 + Af2, because="a filter state that depends on i + j alone moves by this sum"),
    ],
    variants={
        "lemma1_full_EF": Variant("Robust 2-D H∞ analysis of a filter, E and F full", full=(E1, F1)),
        "lemma1_full": Variant("Robust 2-D H∞ analysis of a filter, E, F, V and K full", full=(E1, F1, V1, K1)),
    },
    source=Source(
        authors="Chen, Fong",
        title="Robust filtering for 2-D state-delayed systems with NFT uncertainties",
        venue="IEEE Transactions on Signal Processing",
        year=2006,
        statement="Lemma 1, (32) and (33)",
    ),
)
