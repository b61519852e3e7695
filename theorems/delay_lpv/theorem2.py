"""H∞ analysis of a given filter for an LPV system with time-varying delay, with a slack matrix.

Plant   x⁺ = A x + A_d x_d + B ω,   y = C x + C_d x_d + D ω,   z = H x + H_d x_d + L ω,   x_d = x(k − d(k)),
filter  x_F⁺ = A_F x_F + B_F y,     z_F = C_F x_F + D_F y,     all at ρ_k.
The delay varies freely in d_m ≤ d(k) ≤ d_M and enters by d_Δ = d_M − d_m + 1 alone; ρ_k and ρ_{k+1}
range independently over the domain. If the LMI holds, the error system with ξ = (x, x_F) is
asymptotically stable and the ℓ2 gain from ω to e = z − z_F is below γ. The slack W parts the
Lyapunov matrix P from the error system.

The paper calls (17) equivalent to (7). It is for W = P(ρ_{k+1}); with W constant, as here and as the
filter design needs, it is sufficient.

Derived: the error system (5), lost in the scan, is (1) and (3) written in ξ.
"""

from lmic.dsl import *

n, m, p, l = dims("n m p l")
rho = Parameter("rho", latex=r"\rho_k", latex_next=r"\rho_{k+1}", step="free")
delta = given("d_Delta")

A, Ad, B = Data("A", n, n)(rho), Data("A_d", n, n)(rho), Data("B", n, l)(rho)
C, Cd, D = Data("C", m, n)(rho), Data("C_d", m, n)(rho), Data("D", m, l)(rho)
H, Hd, L = Data("H", p, n)(rho), Data("H_d", p, n)(rho), Data("L", p, l)(rho)
AF, BF = Data("A_F", n, n)(rho), Data("B_F", n, m)(rho)
CF, DF = Data("C_F", p, n)(rho), Data("D_F", p, m)(rho)

P, Q, W = Symmetric("P", 2 * n), Symmetric("Q", n), Matrix("W", 2 * n, 2 * n)
gamma2 = Scalar("gamma2", latex=r"\gamma^2")

K = block([[I(n), zeros(n, n)]])
Abar, Adbar, Bbar = block([[A, 0], [BF * C, AF]]), block([[Ad], [BF * Cd]]), block([[B], [BF * D]])
Cbar, Cdbar, Dbar = block([[H - DF * C, -CF]]), Hd - DF * Cd, L - DF * D

performance = ND([
    [-P(rho) + delta*K.T*Q*K, star, star, star, star],
    [0, -Q, star, star, star],
    [0, 0, -gamma2*I(l), star, star],
    [W.T*Abar, W.T*Adbar, W.T*Bbar, P(rho.next) - W - W.T, star],
    [Cbar, Cdbar, Dbar, 0, -I(p)],
])  # fmt: skip

theorem = Theorem(
    title="H∞ analysis of a filter under time-varying delay, with a slack matrix",
    minimise=gamma2,
    lmis={"performance": performance, "P": PD(P(rho)), "Q": PD(Q)},
    reports={"gamma": sqrt(gamma2)},
    assumes=[Schur(Abar, because="at ρ_{k+1} = ρ_k the LMI implies ĀᵀPĀ < P of the error system")],
    source=Source(
        authors="Unknown authors",
        title="[Robust H∞ filtering for LPV discrete-time systems with time-varying state delay]",
        venue="Scanned copy without title page",
        year=None,
        statement="Theorem 2, (17)",
        derived="the error system (5)",
    ),
)
