"""H∞ analysis of a given filter for a nonuniformly sampled system.

Plant   x_{k+1} = Φ x_k + Γ w_k,   y_k = C x_k + D w_k,   z_k = L x_k   with Φ(h_k) = e^{h_k A} and
        Γ(h_k) = ∫_0^{h_k} e^{ηA} dη B, the sampling of ẋ = A x + B w at intervals h_k;
filter  x̂_{k+1} = A_f x̂_k + B_f y_k,   ẑ_k = C_f x̂_k.
h_k varies freely in [h_l, h_u]. If the LMI holds there, the error system with x̄ = (x, x̂) is
asymptotically stable and the ℓ2 gain from w to e = z − ẑ is below γ.
"""

from lmic.dsl import *

n, m, r, s = dims("n m r s")
h = Box("h", latex="h_k")

Phi, Gamma = Data("Phi", n, n)(h), Data("Gamma", n, m)(h)
C, D, L = Data("C", r, n), Data("D", r, m), Data("L", s, n)
Af, Bf, Cf = Data("A_f", n, n), Data("B_f", n, r), Data("C_f", s, n)

P = Symmetric("Pbar", 2 * n)
gamma2 = Scalar("gamma2", latex=r"\gamma^2")

Abar, Bbar, Cbar = block([[Phi, 0], [Bf * C, Af]]), block([[Gamma], [Bf * D]]), block([[L, -Cf]])

performance = ND([
    [-P, 0, Abar*P, Bbar],
    [star, -I(s), Cbar*P, 0],
    [star, star, -P, 0],
    [star, star, star, -gamma2*I(m)],
])  # fmt: skip

theorem = Theorem(
    title="H∞ analysis of a filter under nonuniform sampling",
    minimise=gamma2,
    lmis={"performance": performance, "P": PD(P)},
    reports={"gamma": sqrt(gamma2)},
    guarantees=[Bound("l2 gain", DiscreteSystem(Abar, Bbar, Cbar, zeros(s, m)), "gamma")],
    assumes=[Schur(Abar, because="it is the error system's matrix")],
    source=Source(
        authors="Mustafa, Chen, Fujioka",
        title="Robust H∞ filtering for nonuniformly sampled systems",
        venue="Conference paper, 2010 or later",
        year=None,
        statement="Lemma 1, (6)",
    ),
)
