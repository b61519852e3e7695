"""H∞ filter for a nonuniformly sampled system.

Plant   x_{k+1} = Φ x_k + Γ w_k,   y_k = C x_k + D w_k,   z_k = L x_k   with Φ(h_k) = e^{h_k A} and
        Γ(h_k) = ∫_0^{h_k} e^{ηA} dη B, the sampling of ẋ = A x + B w at intervals h_k;
filter  x̂_{k+1} = A_f x̂_k + B_f y_k,   ẑ_k = C_f x̂_k.
h_k varies freely. If the LMIs hold at h_1, …, h_N, the ℓ2 gain from w to e = z − ẑ is below γ for
intervals among these, and the error system is asymptotically stable for all intervals in the union of
the H(h_i, α_i) of (9), where the small-gain condition (8) holds.

The paper prints F as r × n; FC and B_f = −Y⁻¹F make it n × r.
"""

from lmic.dsl import *

n, m, r, s = dims("n m r s")
h = Box("h", latex="h_i")

Phi, Gamma = Data("Phi", n, n)(h), Data("Gamma", n, m)(h)
C, D, L = Data("C", r, n), Data("D", r, m), Data("L", s, n)

Z, Y = Symmetric("Z", n), Symmetric("Y", n)
F, G, Q = Matrix("F", n, r), Matrix("G", s, n), Matrix("Q", n, n)
gamma2 = Scalar("gamma2", latex=r"\gamma^2")

performance = ND([
    [-Z, -Z, 0, Z*Phi, Z*Phi, Z*Gamma],
    [star, -Y, 0, Y*Phi + F*C + Q, Y*Phi + F*C, Y*Gamma + F*D],
    [star, star, -I(s), L - G, L, 0],
    [star, star, star, -Z, -Z, 0],
    [star, star, star, star, -Y, 0],
    [star, star, star, star, star, -gamma2*I(m)],
])  # fmt: skip

Af = -inv(Y) * Q * inv(I(n) - inv(Y) * Z)
Bf = -inv(Y) * F
Cf = G * inv(I(n) - inv(Y) * Z)

error_system = DiscreteSystem(
    A=block([[Phi, 0], [Bf * C, Af]]),
    B=block([[Gamma], [Bf * D]]),
    C=block([[L, -Cf]]),
    D=zeros(s, m),
)

theorem = Theorem(
    title="H∞ filter under nonuniform sampling",
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
        statement="Theorem 3, (10) and (11)",
    ),
)
