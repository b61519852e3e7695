"""Stability of a 2-D system with state delays (Fornasini–Marchesini, second model).

x(i+1, j+1) = A_1 x(i+1, j) + A_2 x(i, j+1) + A_d1 x(i+1, j−d_1) + A_d2 x(i−d_2, j+1).
If the LMI holds, the system is asymptotically stable for all delays d_1, d_2.
"""

from lmic.dsl import *

(nx,) = dims("nx")

A1, A2 = Data("A_1", nx, nx), Data("A_2", nx, nx)
Ad1, Ad2 = Data("A_d1", nx, nx), Data("A_d2", nx, nx)

P1, P2 = Symmetric("P_1", nx), Symmetric("P_2", nx)
Q1, Q2 = Symmetric("Q_1", nx), Symmetric("Q_2", nx)

Atilde = block([[A1, A2, Ad1, Ad2]])

W = PD(diag(P1, P2, Q1, Q2) - Atilde.T * (P1 + P2 + Q1 + Q2) * Atilde)

theorem = Theorem(
    title="Stability of a 2-D state-delayed system",
    lmis={"W": W, "P_1": PD(P1), "P_2": PD(P2), "Q_1": PD(Q1), "Q_2": PD(Q2)},
    assumes=[
        Schur(
            A1 + A2 + Ad1 + Ad2,
            because="the LMI is for all delays; without delay, a state that depends on i + j alone moves by this sum",
        ),
    ],
    source=Source(
        authors="Chen, Fong",
        title="Robust filtering for 2-D state-delayed systems with NFT uncertainties",
        venue="IEEE Transactions on Signal Processing",
        year=2006,
        statement="Theorem 1, (14)",
    ),
)
