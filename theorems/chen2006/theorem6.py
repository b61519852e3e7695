"""Robust mixed generalised H2/H∞ filter for a 2-D state-delayed system with NFT uncertainty.

Plant   x(i+1, j+1) = A [x(i+1, j); x(i, j+1)] + A_d [x(i+1, j−d_1); x(i−d_2, j+1)]
                      + B_Δ [w_Δ(i+1, j); w_Δ(i, j+1)] + B [w(i+1, j); w(i, j+1)],
        z_Δ = C_Δ x + D_Δz w_Δ + D_z w,   y = C x + D_Δ w_Δ + D w,   z = L x,   w_Δ = Δ z_Δ;
filter  x_f(i+1, j+1) = A_f1 x_f(i+1, j) + A_f2 x_f(i, j+1) + B_f1 y(i+1, j) + B_f2 y(i, j+1),   z_f = C_f x_f,
with A = [A_1 A_2] and A_d, B_Δ, B alike. The plant is affine in α, which is unknown and fixed in the
unit simplex. If the LMIs hold, the error system is asymptotically stable, the ℓ2 gain from w to z − z_f
is at most γ, and on every diagonal i + j = n the squared norm of z − z_f is at most μ ‖w‖_2², for every
α and all delays d_1, d_2. The given ρ in [0, 1] weighs γ against μ. The LMIs are those of Theorems 4
and 5 with one filter, Ĥ = Ĵ.

The proof needs no block structure of E_i, F_i, V_i and K_i, i = 1, 3: the variants, the same theorem
with them full, are not in the paper, hold as well and are less conservative.
"""

from lmic.dsl import *

nx, nw, ny, nz, nd = dims("nx nw ny nz nd")
alpha = Simplex("alpha")
rho = given("rho")

A1, A2 = Data("A_1", nx, nx)(alpha), Data("A_2", nx, nx)(alpha)
Ad1, Ad2 = Data("A_d1", nx, nx)(alpha), Data("A_d2", nx, nx)(alpha)
B1, B2 = Data("B_1", nx, nw)(alpha), Data("B_2", nx, nw)(alpha)
BD1, BD2 = Data("B_Delta_1", nx, nd)(alpha), Data("B_Delta_2", nx, nd)(alpha)
CD, DDz, Dz = Data("C_Delta", nd, nx)(alpha), Data("D_Delta_z", nd, nd)(alpha), Data("D_z", nd, nw)(alpha)
C, DD, D = Data("C", ny, nx)(alpha), Data("D_Delta", ny, nd)(alpha), Data("D", ny, nw)(alpha)
L, Delta = Data("L", nz, nx)(alpha), Data("Delta", nd, nd)(alpha)

P1, P2 = Symmetric("Phat_1", 2 * nx)(alpha), Symmetric("Phat_2", 2 * nx)(alpha)
Q1, Q2 = Symmetric("Qhat_1", 2 * nx)(alpha), Symmetric("Qhat_2", 2 * nx)(alpha)
X1, X2 = Symmetric("Xhat_1", 2 * nx)(alpha), Symmetric("Xhat_2", 2 * nx)(alpha)
Y1, Y2 = Symmetric("Yhat_1", 2 * nx)(alpha), Symmetric("Yhat_2", 2 * nx)(alpha)
E1, F1 = Symmetric("E_1", 2 * nd, blocks=(nd, nd))(alpha), Symmetric("F_1", 2 * nd, blocks=(nd, nd))(alpha)
E2, F2 = Symmetric("E_2", nd)(alpha), Symmetric("F_2", nd)(alpha)
E3, F3 = Symmetric("E_3", 2 * nd, blocks=(nd, nd))(alpha), Symmetric("F_3", 2 * nd, blocks=(nd, nd))(alpha)
V1, V2, V3 = BlockDiagonal("V_1", nd, nd), Matrix("V_2", nd, nd), BlockDiagonal("V_3", nd, nd)
K1, K2, K3 = BlockDiagonal("K_1", nd, nd), Matrix("K_2", nd, nd), BlockDiagonal("K_3", nd, nd)
H1, H2, H3 = Matrix("Hhat_1", nx, nx), Matrix("Hhat_2", nx, nx), Matrix("Hhat_3", nx, nx)
Af1, Af2 = Matrix("Ahat_f1", nx, nx), Matrix("Ahat_f2", nx, nx)
Bf1, Bf2, Cf = Matrix("Bhat_f1", nx, ny), Matrix("Bhat_f2", nx, ny), Matrix("Chat_f", nz, nx)
gamma, mu, eps = Scalar("gamma"), Scalar("mu"), Scalar("epsilon", latex=r"\varepsilon")

Pi, Lambda = block([[I(nx)], [zeros(nx, nx)]]), block([[zeros(nx, nx)], [I(nx)]])
Phi = block([[I(nx), I(nx)]])
A, Ad, BD, B = block([[A1, A2]]), block([[Ad1, Ad2]]), block([[BD1, BD2]]), block([[B1, B2]])
Ctilde = diag(C, I(nx))
Dtilde, DDtilde = block([[D], [zeros(nx, nw)]]), block([[DD], [zeros(nx, nd)]])
G = block([[Bf1, Af1, Bf2, Af2]])
H = block([[H1, H3], [H2, H3]])
M, N = P1 + P2 + Q1 + Q2, X1 + X2 + Y1 + Y2

Psi51 = H * Pi * A * kron(I(2), Pi.T) + Phi.T * G * kron(I(2), Ctilde)
Psi52 = H * Pi * Ad * kron(I(2), Pi.T)
Psi53 = H * Pi * BD + Phi.T * G * kron(I(2), DDtilde)
Psi54 = H * Pi * B + Phi.T * G * kron(I(2), Dtilde)
Psi61 = kron(I(2), L * Pi.T) - kron(I(2), Cf * Lambda.T)
CD2, DDz2, Dz2 = kron(I(2), CD * Pi.T), kron(I(2), DDz), kron(I(2), Dz)

h_infinity_uncertainty = PD([
    [E1, star],
    [V1*kron(I(2), Delta), F1 + V1 + V1.T],
])  # fmt: skip

h_infinity = ND([
    [-diag(P1, P2), star, star, star, star, star, star],
    [0, -diag(Q1, Q2), star, star, star, star, star],
    [0, 0, F1, star, star, star, star],
    [0, 0, 0, -gamma*I(2*nw), star, star, star],
    [Psi51, Psi52, Psi53, Psi54, M - (H + H.T), star, star],
    [Psi61, 0, 0, 0, 0, -gamma*I(2*nz), star],
    [K1*CD2, 0, K1*DDz2, K1*Dz2, 0, 0, E1 - (K1 + K1.T)],
])  # fmt: skip

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
    [K2*CD*Pi.T, K2*DDz, K2*Dz, E2 - (K2 + K2.T), star],
    [L*Pi.T - Cf*Lambda.T, 0, 0, 0, -mu*I(nz)],
])  # fmt: skip

state = ND([
    [-diag(X1, X2), star, star, star, star, star],
    [0, -diag(Y1, Y2), star, star, star, star],
    [0, 0, F3, star, star, star],
    [0, 0, 0, -(1 - eps)/2*I(2*nw), star, star],
    [Psi51, Psi52, Psi53, Psi54, N - (H + H.T), star],
    [K3*CD2, 0, K3*DDz2, K3*Dz2, 0, E3 - (K3 + K3.T)],
])  # fmt: skip

# with Δ closed, (6); the record's first shift is the one along i, which the paper numbers second
Loop = Delta * inv(I(nd) - DDz * Delta)
Cy, Dy = C + DD * Loop * CD, D + DD * Loop * Dz
error_system = DelayedFornasiniMarchesini(
    A1=block([[A2 + BD2 * Loop * CD, 0], [Bf2 * Cy, Af2 * inv(H3)]]),
    A2=block([[A1 + BD1 * Loop * CD, 0], [Bf1 * Cy, Af1 * inv(H3)]]),
    A_d1=diag(Ad2, zeros(nx, nx)),
    A_d2=diag(Ad1, zeros(nx, nx)),
    B1=block([[B2 + BD2 * Loop * Dz], [Bf2 * Dy]]),
    B2=block([[B1 + BD1 * Loop * Dz], [Bf1 * Dy]]),
    C=block([[L, -Cf * inv(H3)]]),
)

theorem = Theorem(
    title="Robust 2-D mixed generalised H2/H∞ filter",
    minimise=rho * gamma + (1 - rho) * mu,
    lmis={
        "h_infinity_uncertainty": h_infinity_uncertainty,
        "h_infinity": h_infinity,
        "output_uncertainty": output_uncertainty,
        "state_uncertainty": state_uncertainty,
        "output": output,
        "state": state,
    },
    reports={"objective": rho * gamma + (1 - rho) * mu, "gamma": gamma, "mu": mu, "peak": sqrt(mu)},
    recover={"A_f1": Af1 * inv(H3), "A_f2": Af2 * inv(H3), "B_f1": Bf1, "B_f2": Bf2, "C_f": Cf * inv(H3)},
    guarantees=[Bound("l2 gain", error_system, "gamma"), Bound("energy to peak", error_system, "peak")],
    assumes=[
        Schur(
            A1 + A2 + Ad1 + Ad2,
            because="the LMI is for all delays; without delay, a state that depends on i + j alone moves by this sum",
        ),
    ],
    variants={
        "theorem6_full_EF": Variant("Robust 2-D mixed generalised H2/H∞ filter, E and F full", full=(E1, F1, E3, F3)),
        "theorem6_full": Variant(
            "Robust 2-D mixed generalised H2/H∞ filter, E, F, V and K full", full=(E1, F1, V1, K1, E3, F3, V3, K3)
        ),
    },
    source=Source(
        authors="Chen, Fong",
        title="Robust filtering for 2-D state-delayed systems with NFT uncertainties",
        venue="IEEE Transactions on Signal Processing",
        year=2006,
        statement="Theorem 6, (52)",
    ),
)
