"""Robust stability of a discrete-time system with a constant uncertain parameter, with a slack matrix.

x⁺ = A(ρ) x, ρ unknown in the domain and constant in time. If the LMI holds with the constant G, A(ρ) is
Schur stable for every ρ. G parts P from A, so that P may depend on ρ while the LMI stays affine in A.
"""

from lmic.dsl import *

(n,) = dims("n")
rho = Parameter("rho")

A = Data("A", n, n)(rho)
P, G = Symmetric("P", n)(rho), Matrix("G", n, n)

decrease = PD([
    [P, A.T*G.T],
    [star, G + G.T - P],
])  # fmt: skip

theorem = Theorem(
    title="Robust stability with a slack matrix, discrete time",
    lmis={"decrease": decrease},
    assumes=[Schur(A, because="it is the system's matrix")],
    source=Source(
        authors="de Oliveira, Bernussou, Geromel",
        title="A new discrete-time robust stability condition",
        venue="Systems & Control Letters",
        year=1999,
    ),
)
