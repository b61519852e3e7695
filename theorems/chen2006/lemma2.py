"""Robust generalised H2 analysis of a given filter for a 2-D state-delayed system with NFT uncertainty.

Plant   x(i+1, j+1) = A [x(i+1, j); x(i, j+1)] + A_d [x(i+1, j−d_1); x(i−d_2, j+1)]
                      + B_Δ [w_Δ(i+1, j); w_Δ(i, j+1)] + B [w(i+1, j); w(i, j+1)],
        z_Δ = C_Δ x + D_Δz w_Δ + D_z w,   y = C x + D_Δ w_Δ + D w,   z = L x,   w_Δ = Δ z_Δ;
filter  x_f(i+1, j+1) = A_f1 x_f(i+1, j) + A_f2 x_f(i, j+1) + B_f1 y(i+1, j) + B_f2 y(i, j+1),   z_f = C_f x_f,
with A = [A_1 A_2] and A_d, B_Δ, B alike. The plant is affine in α, which is unknown and fixed in the
unit simplex. If the LMIs hold, the error system in (x, x_f) is asymptotically stable and on every
diagonal i + j = n the squared norm of z − z_f is at most μ ‖w‖_2² (energy to peak), for every α and all
delays d_1, d_2.

The LMIs imply (25)–(28) of Theorem 3, the same condition with N⁻¹, E_i⁻¹ and F_i⁻¹ in place of the
slacks J, K_i and V_i. Its proof needs no block structure of E_3, F_3, V_3 and K_3: the variants, the
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

X1, X2 = Symmetric("X_1", 2 * nx)(alpha), Symmetric("X_2", 2 * nx)(alpha)
Y1, Y2 = Symmetric("Y_1", 2 * nx)(alpha), Symmetric("Y_2", 2 * nx)(alpha)
E2, F2, V2, K2 = Symmetric("E_2", nd)(alpha), Symmetric("F_2", nd)(alpha), Matrix("V_2", nd, nd), Matrix("K_2", nd, nd)
E3, F3 = Symmetric("E_3", 2 * nd, blocks=(nd, nd))(alpha), Symmetric("F_3", 2 * nd, blocks=(nd, nd))(alpha)
J, V3, K3 = Matrix("J", 2 * nx, 2 * nx), BlockDiagonal("V_3", nd, nd), BlockDiagonal("K_3", nd, nd)
mu, eps = Scalar("mu"), Scalar("epsilon", latex=r"\varepsilon")

Ahat = block([[A1, 0, A2, 0], [Bf1 * C, Af1, Bf2 * C, Af2]])
Adhat = block([[Ad1, zeros(nx, nx), Ad2, zeros(nx, nx)], [zeros(nx, nx), 0, 0, 0]])
Bhat, BDhat = block([[B1, B2], [Bf1 * D, Bf2 * D]]), block([[BD1, BD2], [Bf1 * DD, Bf2 * DD]])
CDhat, Chat = block([[CD, zeros(nd, nx)]]), block([[L, -Cf]])
N = X1 + X2 + Y1 + Y2

output_uncertainty = PD([
    [E2, star],
    [V2*Delta, F2 + V2 + V2.T],
])  # fmt: skip

state_uncertainty = PD([
    [E3, star],
    [V3*kron(I(2), Delta), F3 + V3 + V3.T],
])  # fmt: skip

output = ND([
    [-N, star, star, star, star],
    [0, F2, star, star, star],
    [0, 0, -eps*I(nw), star, star],
    [K2*CDhat, K2*DDz, K2*Dz, E2 - K2 - K2.T, star],
    [Chat, 0, 0, 0, -mu*I(nz)],
])  # fmt: skip

state = ND([
    [-diag(X1, X2), star, star, star, star, star],
    [0, -diag(Y1, Y2), star, star, star, star],
    [0, 0, F3, star, star, star],
    [0, 0, 0, -(1 - eps)/2*I(2*nw), star, star],
    [J*Ahat, J*Adhat, J*BDhat, J*Bhat, N - J - J.T, star],
    [K3*kron(I(2), CDhat), 0, K3*kron(I(2), DDz), K3*kron(I(2), Dz), 0, E3 - K3 - K3.T],
])  # fmt: skip

theorem = Theorem(
    title="Robust 2-D generalised H2 analysis of a filter",
    minimise=mu,
    lmis={
        "output_uncertainty": output_uncertainty,
        "state_uncertainty": state_uncertainty,
        "output": output,
        "state": state,
    },
    reports={"mu": mu},
    assumes=[
        Schur(
            A1 + A2 + Ad1 + Ad2,
            because="the LMI is for all delays; without delay, a state that depends on i + j alone moves by this sum",
        ),
        Schur(Af1 + Af2, because="a filter state that depends on i + j alone moves by this sum"),
    ],
    variants={
        "lemma2_full_EF": Variant("Robust 2-D generalised H2 analysis of a filter, E and F full", full=(E3, F3)),
        "lemma2_full": Variant(
            "Robust 2-D generalised H2 analysis of a filter, E, F, V and K full", full=(E3, F3, V3, K3)
        ),
    },
    source=Source(
        authors="Chen, Fong",
        title="Robust filtering for 2-D state-delayed systems with NFT uncertainties",
        venue="IEEE Transactions on Signal Processing",
        year=2006,
        statement="Lemma 2, (43)–(46)",
    ),
)
