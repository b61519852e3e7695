"""Robust generalised H2 filter for a 2-D state-delayed system with NFT uncertainty.

Plant   x(i+1, j+1) = A [x(i+1, j); x(i, j+1)] + A_d [x(i+1, j−d_1); x(i−d_2, j+1)]
                      + B_Δ [w_Δ(i+1, j); w_Δ(i, j+1)] + B [w(i+1, j); w(i, j+1)],
        z_Δ = C_Δ x + D_Δz w_Δ + D_z w,   y = C x + D_Δ w_Δ + D w,   z = L x,   w_Δ = Δ z_Δ;
filter  x_f(i+1, j+1) = A_f1 x_f(i+1, j) + A_f2 x_f(i, j+1) + B_f1 y(i+1, j) + B_f2 y(i, j+1),   z_f = C_f x_f,
with A = [A_1 A_2] and A_d, B_Δ, B alike. The plant is affine in α, which is unknown and fixed in the
unit simplex. If the LMIs hold, the error system is asymptotically stable and on every diagonal
i + j = n the squared norm of z − z_f is at most μ ‖w‖_2² (energy to peak), for every α and all delays
d_1, d_2.

The proof needs no block structure of E_3, F_3, V_3 and K_3: the variants, the same theorem with them
full, are not in the paper, hold as well and are less conservative.
In (49) the last factor of Θ_54 is D̃; the scan repeats D̃_Δ of Θ_53.
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

X1, X2 = Symmetric("Xhat_1", 2 * nx)(alpha), Symmetric("Xhat_2", 2 * nx)(alpha)
Y1, Y2 = Symmetric("Yhat_1", 2 * nx)(alpha), Symmetric("Yhat_2", 2 * nx)(alpha)
E2, F2, V2, K2 = Symmetric("E_2", nd)(alpha), Symmetric("F_2", nd)(alpha), Matrix("V_2", nd, nd), Matrix("K_2", nd, nd)
E3, F3 = Symmetric("E_3", 2 * nd, blocks=(nd, nd))(alpha), Symmetric("F_3", 2 * nd, blocks=(nd, nd))(alpha)
V3, K3 = BlockDiagonal("V_3", nd, nd), BlockDiagonal("K_3", nd, nd)
J1, J2, J3 = Matrix("Jhat_1", nx, nx), Matrix("Jhat_2", nx, nx), Matrix("Jhat_3", nx, nx)
Af1, Af2 = Matrix("Ahat_f1", nx, nx), Matrix("Ahat_f2", nx, nx)
Bf1, Bf2, Cf = Matrix("Bhat_f1", nx, ny), Matrix("Bhat_f2", nx, ny), Matrix("Chat_f", nz, nx)
mu, eps = Scalar("mu"), Scalar("epsilon", latex=r"\varepsilon")

Pi, Lambda = block([[I(nx)], [zeros(nx, nx)]]), block([[zeros(nx, nx)], [I(nx)]])
Phi = block([[I(nx), I(nx)]])
A, Ad, BD, B = block([[A1, A2]]), block([[Ad1, Ad2]]), block([[BD1, BD2]]), block([[B1, B2]])
Ctilde = diag(C, I(nx))
Dtilde, DDtilde = block([[D], [zeros(nx, nw)]]), block([[DD], [zeros(nx, nd)]])
G = block([[Bf1, Af1, Bf2, Af2]])
J = block([[J1, J3], [J2, J3]])
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
    [K2*CD*Pi.T, K2*DDz, K2*Dz, E2 - (K2 + K2.T), star],
    [L*Pi.T - Cf*Lambda.T, 0, 0, 0, -mu*I(nz)],
])  # fmt: skip

Theta51 = J * Pi * A * kron(I(2), Pi.T) + Phi.T * G * kron(I(2), Ctilde)
Theta52 = J * Pi * Ad * kron(I(2), Pi.T)
Theta53 = J * Pi * BD + Phi.T * G * kron(I(2), DDtilde)
Theta54 = J * Pi * B + Phi.T * G * kron(I(2), Dtilde)
Theta55 = N - (J + J.T)
Theta61, Theta63, Theta64 = K3 * kron(I(2), CD * Pi.T), K3 * kron(I(2), DDz), K3 * kron(I(2), Dz)

state = ND([
    [-diag(X1, X2), star, star, star, star, star],
    [0, -diag(Y1, Y2), star, star, star, star],
    [0, 0, F3, star, star, star],
    [0, 0, 0, -(1 - eps)/2*I(2*nw), star, star],
    [Theta51, Theta52, Theta53, Theta54, Theta55, star],
    [Theta61, 0, Theta63, Theta64, 0, E3 - (K3 + K3.T)],
])  # fmt: skip

# with Δ closed, (6); the record's first shift is the one along i, which the paper numbers second
Loop = Delta * inv(I(nd) - DDz * Delta)
Cy, Dy = C + DD * Loop * CD, D + DD * Loop * Dz
error_system = DelayedFornasiniMarchesini(
    A1=block([[A2 + BD2 * Loop * CD, 0], [Bf2 * Cy, Af2 * inv(J3)]]),
    A2=block([[A1 + BD1 * Loop * CD, 0], [Bf1 * Cy, Af1 * inv(J3)]]),
    A_d1=diag(Ad2, zeros(nx, nx)),
    A_d2=diag(Ad1, zeros(nx, nx)),
    B1=block([[B2 + BD2 * Loop * Dz], [Bf2 * Dy]]),
    B2=block([[B1 + BD1 * Loop * Dz], [Bf1 * Dy]]),
    C=block([[L, -Cf * inv(J3)]]),
)

theorem = Theorem(
    title="Robust 2-D generalised H2 filter",
    minimise=mu,
    lmis={
        "output_uncertainty": output_uncertainty,
        "state_uncertainty": state_uncertainty,
        "output": output,
        "state": state,
    },
    reports={"mu": mu, "peak": sqrt(mu)},
    recover={"A_f1": Af1 * inv(J3), "A_f2": Af2 * inv(J3), "B_f1": Bf1, "B_f2": Bf2, "C_f": Cf * inv(J3)},
    guarantees=[Bound("energy to peak", error_system, "peak")],
    assumes=[
        Schur(
            A1 + A2 + Ad1 + Ad2,
            because="the LMI is for all delays; without delay, a state that depends on i + j alone moves by this sum",
        ),
    ],
    variants={
        "theorem5_full_EF": Variant("Robust 2-D generalised H2 filter, E and F full", full=(E3, F3)),
        "theorem5_full": Variant("Robust 2-D generalised H2 filter, E, F, V and K full", full=(E3, F3, V3, K3)),
    },
    source=Source(
        authors="Chen, Fong",
        title="Robust filtering for 2-D state-delayed systems with NFT uncertainties",
        venue="IEEE Transactions on Signal Processing",
        year=2006,
        statement="Theorem 5, (43), (44), (47), (48) and (50)",
    ),
)
