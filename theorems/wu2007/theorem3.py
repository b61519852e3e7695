"""H∞ filter for a 2-D LPV system (Fornasini–Marchesini).

Plant   x_{i+1,j+1} = A_1(a) x_{i,j+1} + A_2(b) x_{i+1,j} + B_1(a) ω_{i,j+1} + B_2(b) ω_{i+1,j},
        y = C x + D ω,   z = L x   at r_{i,j};
filter  x̂_{i+1,j+1} = A_1F(a) x̂_{i,j+1} + A_2F(b) x̂_{i+1,j} + B_1F(a) y_{i,j+1} + B_2F(b) y_{i+1,j},   ẑ = C_F x̂.
The parameter is taken at three places, a = r_{i,j+1}, b = r_{i+1,j} and c = r_{i+1,j+1}, which range
independently over the domain. If the LMIs hold, the error system is asymptotically stable and the
ℓ2 gain from ω to z − ẑ is below γ.

Derived: (16)–(18), lost in the scan, are the proof's congruence of (14) by diag{Γ, I, I, Γ, Γ, I, I},
Γ = diag{I, X_3⁻¹X_4}, with the products (24) and the new unknowns (21)–(22). In these
T = ΓᵀXΓ = [U V; W W].
"""

from lmic.dsl import *

n, m, q, l = dims("n m q l")
r = Parameter("r", latex="r_{i,j}")
a, b, c = r.copy("a", latex="r_{i,j+1}"), r.copy("b", latex="r_{i+1,j}"), r.copy("c", latex="r_{i+1,j+1}")

A1, A2, B1, B2 = Data("A_1", n, n), Data("A_2", n, n), Data("B_1", n, l), Data("B_2", n, l)
C, D, L = Data("C", m, n), Data("D", m, l), Data("L", q, n)

P, Q = Symmetric("Pbar", 2 * n), Symmetric("Qbar", 2 * n)
U, V, W = Matrix("U", n, n), Matrix("V", n, n), Matrix("W", n, n)
A1F, A2F = Matrix("Abar_1F", n, n), Matrix("Abar_2F", n, n)
B1F, B2F = Matrix("Bbar_1F", n, m), Matrix("Bbar_2F", n, m)
CF = Matrix("Cbar_F", q, n)
gamma2 = Scalar("gamma2", latex=r"\gamma^2")

T = block([[U, V], [W, W]])
XA1 = block([[U.T * A1(a) + B1F(a) * C(a), A1F(a)], [V.T * A1(a) + B1F(a) * C(a), A1F(a)]])
XA2 = block([[U.T * A2(b) + B2F(b) * C(b), A2F(b)], [V.T * A2(b) + B2F(b) * C(b), A2F(b)]])
XB1 = block([[U.T * B1(a) + B1F(a) * D(a)], [V.T * B1(a) + B1F(a) * D(a)]])
XB2 = block([[U.T * B2(b) + B2F(b) * D(b)], [V.T * B2(b) + B2F(b) * D(b)]])
C_a, C_b = block([[L(a), -CF(a)]]), block([[L(b), -CF(b)]])

performance = ND([
    [P(c) - T - T.T, 0, 0, XA1, XA2, XB1, XB2],
    [star, -I(q), 0, 0, C_b, 0, 0],
    [star, star, -I(q), C_a, 0, 0, 0],
    [star, star, star, Q(a) - P(a), 0, 0, 0],
    [star, star, star, star, -Q(b), 0, 0],
    [star, star, star, star, star, -gamma2*I(l), 0],
    [star, star, star, star, star, star, -gamma2*I(l)],
])  # fmt: skip

error_system = FornasiniMarchesini(
    A1=block([[A1(r), 0], [inv(W).T * B1F(r) * C(r), inv(W).T * A1F(r)]]),
    A2=block([[A2(r), 0], [inv(W).T * B2F(r) * C(r), inv(W).T * A2F(r)]]),
    B1=block([[B1(r)], [inv(W).T * B1F(r) * D(r)]]),
    B2=block([[B2(r)], [inv(W).T * B2F(r) * D(r)]]),
    C=block([[L(r), -CF(r)]]),
)

theorem = Theorem(
    title="2-D H∞ filter",
    minimise=gamma2,
    lmis={"performance": performance, "P": PD(P(r)), "Q": PD(Q(r))},
    reports={"gamma": sqrt(gamma2)},
    recover={
        "A_1F": inv(W).T * A1F(r),
        "A_2F": inv(W).T * A2F(r),
        "B_1F": inv(W).T * B1F(r),
        "B_2F": inv(W).T * B2F(r),
        "C_F": CF(r),
    },
    guarantees=[Bound("l2 gain", error_system, "gamma")],
    assumes=[
        Schur(A1(r) + A2(r), because="at a frozen parameter a state that depends on i + j alone moves by A_1 + A_2"),
    ],
    source=Source(
        authors="Wu, Wang, Gao, Wang",
        title="H∞ and l2–l∞ filtering for two-dimensional linear parameter-varying systems",
        venue="International Journal of Robust and Nonlinear Control",
        year=2007,
        statement="Theorem 3, (16)–(19)",
        derived="(16)–(18) by congruence from (14)",
    ),
)
