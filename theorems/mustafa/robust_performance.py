"""H∞ filter with robust performance for a nonuniformly sampled system.

Plant   x_{k+1} = Φ x_k + Γ w_k,   y_k = C x_k + D w_k,   z_k = L x_k   with Φ(h_k) = e^{h_k A} and
        Γ(h_k) = ∫_0^{h_k} e^{ηA} dη B, the sampling of ẋ = A x + B w at intervals h_k;
filter  x̂_{k+1} = A_f x̂_k + B_f y_k,   ẑ_k = C_f x̂_k.
At h_k = h_i + θ_k the error system is that at h_i closed by ξ = Δ(θ_k) η, Δ(θ) = ∫_0^θ e^{ηA} dη, with
η = AΦ x + (AΓ + B) w (Lemma 2). h_i varies freely. If the LMIs hold at h_1, …, h_N, the ℓ2 gain from
(ξ, w) to (η, e), e = z − ẑ, is below γ for intervals among these; hence that from w to e is for all
intervals with ‖Δ(θ_k)‖ ≤ 1/γ.

Derived: (13), lost in the scan, is (6) for the system (7) with the two channels (ξ, w) → (η, e), under
the congruence diag{J_1, I, I, J_1, I, I} of Theorem 3's proof, where J_1ᵀP̄J_1 = [Z Z; Z Y].
"""

from lmic.dsl import *

n, m, r, s = dims("n m r s")
h = Box("h", latex="h_i")

A, B = Data("A", n, n), Data("B", n, m)
Phi, Gamma = Data("Phi", n, n)(h), Data("Gamma", n, m)(h)
C, D, L = Data("C", r, n), Data("D", r, m), Data("L", s, n)

Z, Y = Symmetric("Z", n), Symmetric("Y", n)
F, G, Q = Matrix("F", n, r), Matrix("G", s, n), Matrix("Q", n, n)
gamma2 = Scalar("gamma2", latex=r"\gamma^2")

performance = ND([
    [-Z, -Z, 0, 0, Z*Phi, Z*Phi, Z, Z*Gamma],
    [star, -Y, 0, 0, Y*Phi + F*C + Q, Y*Phi + F*C, Y, Y*Gamma + F*D],
    [star, star, -I(n), 0, A*Phi, A*Phi, 0, A*Gamma + B],
    [star, star, star, -I(s), L - G, L, 0, 0],
    [star, star, star, star, -Z, -Z, 0, 0],
    [star, star, star, star, star, -Y, 0, 0],
    [star, star, star, star, star, star, -gamma2*I(n), 0],
    [star, star, star, star, star, star, star, -gamma2*I(m)],
])  # fmt: skip

Af = -inv(Y) * Q * inv(I(n) - inv(Y) * Z)
Bf = -inv(Y) * F
Cf = G * inv(I(n) - inv(Y) * Z)

error_system = DiscreteSystem(
    A=block([[Phi, 0], [Bf * C, Af]]),
    B=block([[I(n), Gamma], [0, Bf * D]]),
    C=block([[A * Phi, zeros(n, n)], [L, -Cf]]),
    D=block([[zeros(n, n), A * Gamma + B], [zeros(s, n), 0]]),
)

theorem = Theorem(
    title="H∞ filter with robust performance under nonuniform sampling",
    minimise=gamma2,
    lmis={"performance": performance, "Z": PD(Z), "Y": PD(Y)},
    reports={"gamma": sqrt(gamma2)},
    recover={"A_f": Af, "B_f": Bf, "C_f": Cf},
    guarantees=[Bound("l2 gain", error_system, "gamma")],
    assumes=[Schur(Phi, because="the error system contains the plant")],
    source=Source(
        authors="Mustafa, Chen, Fujioka",
        title="Robust H∞ filtering for nonuniformly sampled systems",
        venue="Conference paper, 2010 or later",
        year=None,
        statement="Section V.A, (13)",
        derived="(13) by congruence from (6) for the system (7)",
    ),
)
