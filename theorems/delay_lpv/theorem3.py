"""H∞ filter for an LPV system with time-varying delay.

Plant   x⁺ = A x + A_d x_d + B ω,   y = C x + C_d x_d + D ω,   z = H x + H_d x_d + L ω,   x_d = x(k − d(k)),
filter  x_F⁺ = A_F x_F + B_F y,     z_F = C_F x_F + D_F y,     all at ρ_k.
The delay varies freely in d_m ≤ d(k) ≤ d_M and enters by d_Δ = d_M − d_m + 1 alone; ρ_k and ρ_{k+1}
range independently over the domain. If the LMIs hold, the error system is asymptotically stable and
the ℓ2 gain from ω to e = z − z_F is below γ.

Derived: the scan shows (22) in part and has lost (23)–(25). With V = W⁻¹, both partitioned as P, and
S = V_21 V_11⁻¹, the congruence of (17) by T = [I I; 0 S] gives (22), and TᵀPT > 0 is (23), where
E = W_11, F = V_11⁻¹, U = SᵀW_21 and Â_F = W_21ᵀ A_F S, B̂_F = W_21ᵀ B_F, Ĉ_F = C_F S, D̂_F = D_F;
WV = I makes WT = [E F; W_21 0]. S is a change of the filter's coordinates, so (28) drops it.
"""

from lmic.dsl import *

n, m, p, l = dims("n m p l")
rho = Parameter("rho", latex=r"\rho_k", latex_next=r"\rho_{k+1}", step="free")
delta = given("d_Delta")

A, Ad, B = Data("A", n, n)(rho), Data("A_d", n, n)(rho), Data("B", n, l)(rho)
C, Cd, D = Data("C", m, n)(rho), Data("C_d", m, n)(rho), Data("D", m, l)(rho)
H, Hd, L = Data("H", p, n)(rho), Data("H_d", p, n)(rho), Data("L", p, l)(rho)

P1, P2, P3 = Symmetric("P_1", n), Matrix("P_2", n, n), Symmetric("P_3", n)
Q = Symmetric("Q", n)
E, F, U = Matrix("E", n, n), Matrix("F", n, n), Matrix("U", n, n)
AF, BF = Matrix("Ahat_F", n, n)(rho), Matrix("Bhat_F", n, m)(rho)
CF, DF = Matrix("Chat_F", p, n)(rho), Matrix("Dhat_F", p, m)(rho)
gamma2 = Scalar("gamma2", latex=r"\gamma^2")

performance = ND([
    [-P1(rho) + delta*Q, star, star, star, star, star, star],
    [-P2(rho).T + delta*Q, -P3(rho) + delta*Q, star, star, star, star, star],
    [0, 0, -Q, star, star, star, star],
    [0, 0, 0, -gamma2*I(l), star, star, star],
    [E.T*A + BF*C, E.T*A + BF*C + AF, E.T*Ad + BF*Cd, E.T*B + BF*D, P1(rho.next) - E - E.T, star, star],
    [F.T*A, F.T*A, F.T*Ad, F.T*B, P2(rho.next).T - E - F.T - U, P3(rho.next) - F - F.T, star],
    [H - DF*C, H - DF*C - CF, Hd - DF*Cd, L - DF*D, 0, 0, -I(p)],
])  # fmt: skip

A_F, B_F = inv(U).T * AF, inv(U).T * BF
error_dynamics = {
    "A": block([[A, 0], [B_F * C, A_F]]),
    "A_d": block([[Ad, zeros(n, n)], [B_F * Cd, zeros(n, n)]]),
    "B": block([[B], [B_F * D]]),
}

theorem = Theorem(
    title="H∞ filter under time-varying delay",
    minimise=gamma2,
    lmis={
        "performance": performance,
        "P": PD([[P1(rho), P2(rho)], [star, P3(rho)]]),
        "Q": PD(Q),
    },
    reports={"gamma": sqrt(gamma2)},
    recover={"A_F": A_F, "B_F": B_F, "C_F": CF, "D_F": DF},
    guarantees=[
        Bound(
            "l2 gain",
            DelaySystem(
                **error_dynamics,
                C=block([[H - DF * C, -CF]]),
                C_d=block([[Hd - DF * Cd, zeros(p, n)]]),
                D=L - DF * D,
            ),
            "gamma",
        ),
    ],
    signals={
        "z": DelaySystem(A=A, A_d=Ad, B=B, C=H, C_d=Hd, D=L),
        "z_F": DelaySystem(**error_dynamics, C=block([[DF * C, CF]]), C_d=block([[DF * Cd, zeros(p, n)]]), D=DF * D),
    },
    assumes=[Schur(A, because="the error system contains the plant")],
    source=Source(
        authors="Unknown authors",
        title="[Robust H∞ filtering for LPV discrete-time systems with time-varying state delay]",
        venue="Scanned copy without title page",
        year=None,
        statement="Theorem 3, (22) and (23)",
        derived="(22) and (23) by congruence from (17)",
    ),
)
