"""H∞ filter for a discrete-time polytopic LPV system.

Plant   x⁺ = A x + B_w w,   z = C_z x + D_z w,   y = C_y x + D_y w,   all at α_k;
filter  x_f⁺ = H⁻¹A_f x_f + H⁻¹B_f y,   z_f = C_f x_f + D_f y.
α_k and α_{k+1} range independently over the unit simplex. If the LMIs hold for a given scalar ε,
the ℓ2 gain from w to e = z − z_f is below γ = √δ. Corollary 1 is the same condition with the
filter's matrices constant: a robust filter, for α that is not measured.

The paper's expanded Φ_ijl prints P_{3,j} in Φ_21; its own (8) has P_3(α_{k+1}), as here.
"""

from lmic.dsl import *

nx, nw, ny, nz = dims("nx nw ny nz")
alpha = Simplex("alpha", latex=r"\alpha_k", latex_next=r"\alpha_{k+1}", step="free")
eps = given("eps", latex=r"\epsilon")

A, Bw = Data("A", nx, nx)(alpha), Data("B_w", nx, nw)(alpha)
Cz, Dz = Data("C_z", nz, nx)(alpha), Data("D_z", nz, nw)(alpha)
Cy, Dy = Data("C_y", ny, nx)(alpha), Data("D_y", ny, nw)(alpha)

P1, P2, P3 = Symmetric("P1", nx), Symmetric("P2", nx), Matrix("P3", nx, nx)
X1, X2 = Matrix("X1", nx, nx)(alpha), Matrix("X2", nx, nx)(alpha)
X3, X4 = Matrix("X3", nx, nx)(alpha), Matrix("X4", nx, nx)(alpha)
X5, X6 = Matrix("X5", nz, nx)(alpha), Matrix("X6", nw, nx)(alpha)
H, Af, Bf = Matrix("H", nx, nx)(alpha), Matrix("A_f", nx, nx)(alpha), Matrix("B_f", nx, ny)(alpha)
Cf, Df = Matrix("C_f", nz, nx)(alpha), Matrix("D_f", nz, ny)(alpha)
delta = Scalar("delta")

Phi = ND([
    [P1(alpha.next) - He(X1), star, star, star, star, star],
    [-X2 - eps*H.T + P3(alpha.next).T, P2(alpha.next) - He(H), star, star, star, star],
    [-X3 + (X1*A + eps*Bf*Cy).T, -H + (X2*A + Bf*Cy).T, -P1(alpha) + He(X3*A + Bf*Cy), star, star, star],
    [-X4 + eps*Af.T, Af.T, X4*A + Af.T - P3(alpha).T, -P2(alpha), star, star],
    [-X5, 0, X5*A + Cz - Df*Cy, -Cf, -I(nz), star],
    [-X6 + (X1*Bw + eps*Bf*Dy).T, (X2*Bw + Bf*Dy).T, X6*A + (X3*Bw + Bf*Dy).T, Bw.T*X4.T,
     (X5*Bw - Df*Dy + Dz).T, He(X6*Bw) - delta*I(nw)],
])  # fmt: skip

error_system = DiscreteSystem(
    A=block([[A, 0], [inv(H) * Bf * Cy, inv(H) * Af]]),
    B=block([[Bw], [inv(H) * Bf * Dy]]),
    C=block([[Cz - Df * Cy, -Cf]]),
    D=Dz - Df * Dy,
)

theorem = Theorem(
    title="H∞ filter, parameter-dependent",
    minimise=delta,
    lmis={"performance": Phi, "P1": PD(P1(alpha)), "P2": PD(P2(alpha))},
    reports={"gamma": sqrt(delta)},
    recover={"A_F": inv(H) * Af, "B_F": inv(H) * Bf, "C_F": Cf, "D_F": Df},
    guarantees=[Bound("l2 gain", error_system, "gamma")],
    assumes=[Schur(A, because="the error system contains the plant")],
    variants={
        "corollary1": Variant("H∞ filter, robust", statement="Corollary 1", constant=(H, Af, Bf, Cf, Df)),
    },
    source=Source(
        authors="Peixoto, Lacerda, Guerra, Palma, Palhares",
        title="A novel H∞ filter design condition for discrete-time linear parameter-varying systems",
        venue="IFAC",
        year=2025,
        statement="Theorem 1",
    ),
)
