"""H∞ analysis of a given filter for a 2-D LPV system (Fornasini–Marchesini).

Plant   x_{i+1,j+1} = A_1(a) x_{i,j+1} + A_2(b) x_{i+1,j} + B_1(a) ω_{i,j+1} + B_2(b) ω_{i+1,j},
        y = C x + D ω,   z = L x   at r_{i,j};
filter  x̂_{i+1,j+1} = A_1F(a) x̂_{i,j+1} + A_2F(b) x̂_{i+1,j} + B_1F(a) y_{i,j+1} + B_2F(b) y_{i+1,j},   ẑ = C_F x̂.
The parameter is taken at three places, a = r_{i,j+1}, b = r_{i+1,j} and c = r_{i+1,j+1}, which range
independently over the domain. If the LMI holds, the error system with ξ = (x, x̂) is asymptotically
stable and the ℓ2 gain from ω to z − ẑ is below γ.

Derived: (6), lost in the scan, is the Schur complement of the proof's Π < 0 with the rows ordered as
in the printed (14).
"""

from lmic.dsl import *

n, m, q, l = dims("n m q l")
r = Parameter("r", latex="r_{i,j}")
a, b, c = r.copy("a", latex="r_{i,j+1}"), r.copy("b", latex="r_{i+1,j}"), r.copy("c", latex="r_{i+1,j+1}")

A1, A2, B1, B2 = Data("A_1", n, n), Data("A_2", n, n), Data("B_1", n, l), Data("B_2", n, l)
C, D, L = Data("C", m, n), Data("D", m, l), Data("L", q, n)
A1F, A2F, B1F, B2F = Data("A_1F", n, n), Data("A_2F", n, n), Data("B_1F", n, m), Data("B_2F", n, m)
CF = Data("C_F", q, n)

P, Q = Symmetric("P", 2 * n), Symmetric("Q", 2 * n)
gamma2 = Scalar("gamma2", latex=r"\gamma^2")

A1bar = block([[A1(a), 0], [B1F(a) * C(a), A1F(a)]])
A2bar = block([[A2(b), 0], [B2F(b) * C(b), A2F(b)]])
B1bar, B2bar = block([[B1(a)], [B1F(a) * D(a)]]), block([[B2(b)], [B2F(b) * D(b)]])
Cbar_a, Cbar_b = block([[L(a), -CF(a)]]), block([[L(b), -CF(b)]])

performance = ND([
    [-P(c), 0, 0, P(c)*A1bar, P(c)*A2bar, P(c)*B1bar, P(c)*B2bar],
    [star, -I(q), 0, 0, Cbar_b, 0, 0],
    [star, star, -I(q), Cbar_a, 0, 0, 0],
    [star, star, star, Q(a) - P(a), 0, 0, 0],
    [star, star, star, star, -Q(b), 0, 0],
    [star, star, star, star, star, -gamma2*I(l), 0],
    [star, star, star, star, star, star, -gamma2*I(l)],
])  # fmt: skip

theorem = Theorem(
    title="2-D H∞ analysis of a filter",
    minimise=gamma2,
    lmis={"performance": performance, "P": PD(P(r)), "Q": PD(Q(r))},
    reports={"gamma": sqrt(gamma2)},
    assumes=[
        Schur(A1(r) + A2(r), because="at a frozen parameter a state that depends on i + j alone moves by A_1 + A_2"),
        Schur(A1F(r) + A2F(r), because="at a frozen parameter a filter state that depends on i + j alone moves by it"),
    ],
    source=Source(
        authors="Wu, Wang, Gao, Wang",
        title="H∞ and l2–l∞ filtering for two-dimensional linear parameter-varying systems",
        venue="International Journal of Robust and Nonlinear Control",
        year=2007,
        statement="Theorem 1, (6)",
        derived="(6) from Π in the proof",
    ),
)
