"""Independent dense formulas of the papers' LMIs, in plain numpy.

No block of a theorem file is typed again here. An analysis LMI starts from one step of the plant and the
filter, written as the papers write them, signal by signal: its maps are read off with unit vectors, its
quadratic forms by polarisation. What the papers' proofs then do, Schur complement, slack and congruence,
is done with numbers. A synthesis LMI is the congruence of its analysis LMI at a random filter; the
function returns, with the matrix, the values that the new unknowns take there.

Every LMI is returned with the sign and the block order of the theorem.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import SimpleNamespace as Values
from typing import Any

import numpy as np
from dense_maps import Array, add, congruence, lifted, linear_map, quadratic_form, reorder
from numpy.linalg import inv
from scipy.linalg import block_diag

# delay_lpv: LPV systems with time-varying delay ------------------------------------------------------


def delay_step(p: Values, f: Values, xi: Array, x_d: Array, w: Array) -> tuple[Array, Array]:
    """One step of plant (1) and filter (3): the next (x, x_F) and the error z − z_F."""
    x, x_F = np.split(xi, 2)
    y = p.C @ x + p.C_d @ x_d + p.D @ w
    z = p.H @ x + p.H_d @ x_d + p.L @ w
    following = np.concatenate([p.A @ x + p.A_d @ x_d + p.B @ w, f.A_F @ x_F + f.B_F @ y])
    return following, z - (f.C_F @ x_F + f.D_F @ y)


def delay_sizes(p: Values) -> tuple[int, int, int]:
    """Sizes of ξ, x_d and ω."""
    n = p.A.shape[0]
    return 2 * n, n, p.B.shape[1]


def delay_dissipation(p: Values, f: Values, P: Array, P_next: Array, Q: Array, d_Delta: float, gamma2: float) -> Array:
    """Ξ of Theorem 1's proof: ΔV₁ + (bound of ΔV₂ + ΔV₃) + eᵀe − γ²ωᵀω as a form in (ξ, x_d, ω).

    ΔV₂ + ΔV₃ ≤ d_Δ xᵀQx − x_dᵀQx_d for every delay within its bounds.
    """

    def value(xi: Array, x_d: Array, w: Array) -> float:
        following, e = delay_step(p, f, xi, x_d, w)
        x = xi[: len(xi) // 2]
        storage = following @ P_next @ following - xi @ P @ xi + d_Delta * x @ Q @ x - x_d @ Q @ x_d
        return float(storage + e @ e - gamma2 * w @ w)

    return quadratic_form(value, delay_sizes(p))


def delay_theorem1(p: Values, f: Values, P: Array, P_next: Array, Q: Array, d_Delta: float, gamma2: float) -> Array:
    """(7): the Schur complement of Ξ < 0 in ξ⁺ and e, congruent by P⁺ in the block of ξ⁺."""
    matrix = _delay_lifted(p, f, P, P_next, Q, d_Delta, gamma2)
    head = sum(delay_sizes(p))
    return congruence(matrix, np.eye(head), P_next, np.eye(p.H.shape[0]))


def delay_theorem2(
    p: Values, f: Values, P: Array, P_next: Array, Q: Array, W: Array, d_Delta: float, gamma2: float
) -> Array:
    """(17): congruence by W leaves −WᵀP⁺⁻¹W in the block of ξ⁺, which (17) bounds by P⁺ − W − Wᵀ."""
    head, tail = sum(delay_sizes(p)), p.H.shape[0]
    matrix = congruence(_delay_lifted(p, f, P, P_next, Q, d_Delta, gamma2), np.eye(head), W, np.eye(tail))
    return add(matrix, [head, len(P), tail], 1, W.T @ inv(P_next) @ W + P_next - W - W.T)


def delay_theorem3(
    p: Values, f: Values, P: Array, P_next: Array, Q: Array, W: Array, d_Delta: float, gamma2: float
) -> tuple[Array, Values]:
    """(22) and its unknowns: (17) congruent by T = [I I; 0 S], S = V₂₁V₁₁⁻¹, V = W⁻¹, in ξ and ξ⁺.

    The new unknowns are E = W₁₁, F = V₁₁⁻¹, U = SᵀW₂₁, Â_F = W₂₁ᵀA_F S, B̂_F = W₂₁ᵀB_F, Ĉ_F = C_F S, and the
    blocks of TᵀPT.
    """
    n, (_, _, nw) = len(W) // 2, delay_sizes(p)
    V = inv(W)
    S = V[n:, :n] @ inv(V[:n, :n])
    T = np.block([[np.eye(n), np.eye(n)], [np.zeros((n, n)), S]])
    matrix = delay_theorem2(p, f, P, P_next, Q, W, d_Delta, gamma2)
    matrix = congruence(matrix, T, np.eye(n), np.eye(nw), T, np.eye(p.H.shape[0]))
    now, following, W21 = T.T @ P @ T, T.T @ P_next @ T, W[n:, :n]
    unknowns = Values(
        P_1=now[:n, :n], P_2=now[:n, n:], P_3=now[n:, n:],
        P_1_next=following[:n, :n], P_2_next=following[:n, n:], P_3_next=following[n:, n:],
        E=W[:n, :n], F=inv(V[:n, :n]), U=S.T @ W21,
        Ahat_F=W21.T @ f.A_F @ S, Bhat_F=W21.T @ f.B_F, Chat_F=f.C_F @ S, Dhat_F=f.D_F, S=S,
    )  # fmt: skip
    return matrix, unknowns


def _delay_lifted(p: Values, f: Values, P: Array, P_next: Array, Q: Array, d_Delta: float, gamma2: float) -> Array:
    sizes = delay_sizes(p)

    def storage(xi: Array, x_d: Array, w: Array) -> float:
        x = xi[: len(xi) // 2]
        return float(-xi @ P @ xi + d_Delta * x @ Q @ x - x_d @ Q @ x_d - gamma2 * w @ w)

    N = linear_map(lambda *s: delay_step(p, f, *s)[0], sizes)
    M = linear_map(lambda *s: delay_step(p, f, *s)[1], sizes)
    return lifted(quadratic_form(storage, sizes), (N, P_next), (M, np.eye(len(M))))


def no_delay_theorem(p: Values, f: Values, P: Array, P_next: Array, gamma2: float, W: Array | None = None) -> Array:
    """(20), or (21) with a slack W: the delay case with the delayed state and its terms left out."""
    n, nw, tail = len(P), p.B.shape[1], p.H.shape[0]

    def step(xi: Array, w: Array) -> tuple[Array, Array]:
        x, x_F = np.split(xi, 2)
        y = p.C @ x + p.D @ w
        return (
            np.concatenate([p.A @ x + p.B @ w, f.A_F @ x_F + f.B_F @ y]),
            p.H @ x + p.L @ w - f.C_F @ x_F - f.D_F @ y,
        )

    form = quadratic_form(lambda xi, w: float(-xi @ P @ xi - gamma2 * w @ w), (n, nw))
    N, M = (linear_map(lambda *s, k=k: step(*s)[k], (n, nw)) for k in (0, 1))
    matrix = lifted(form, (N, P_next), (M, np.eye(tail)))
    if W is None:
        return congruence(matrix, np.eye(n + nw), P_next, np.eye(tail))
    matrix = congruence(matrix, np.eye(n + nw), W, np.eye(tail))
    return add(matrix, [n + nw, n, tail], 1, W.T @ inv(P_next) @ W + P_next - W - W.T)


# wu2007: 2-D LPV systems ---------------------------------------------------------------------------------
# a, b: namespaces with the plant's and the filter's matrices at r_{i,j+1} and r_{i+1,j}.


def fm_step(a: Values, b: Values, xi_a: Array, xi_b: Array, w_a: Array, w_b: Array) -> tuple[Array, Array, Array]:
    """One step of plant (1) and filter (3): ξ_{i+1,j+1}, and the errors at (i, j+1) and (i+1, j)."""
    (x_a, f_a), (x_b, f_b) = np.split(xi_a, 2), np.split(xi_b, 2)
    y_a, y_b = a.C @ x_a + a.D @ w_a, b.C @ x_b + b.D @ w_b
    x = a.A_1 @ x_a + b.A_2 @ x_b + a.B_1 @ w_a + b.B_2 @ w_b
    f = a.A_1F @ f_a + b.A_2F @ f_b + a.B_1F @ y_a + b.B_2F @ y_b
    return np.concatenate([x, f]), a.L @ x_a - a.C_F @ f_a, b.L @ x_b - b.C_F @ f_b


def fm_sizes(a: Values) -> tuple[int, int, int, int]:
    """Sizes of ξ_a, ξ_b, ω_a and ω_b."""
    n, nw = a.B_1.shape
    return 2 * n, 2 * n, nw, nw


def fm_dissipation(a: Values, b: Values, P_a: Array, P_c: Array, Q_a: Array, Q_b: Array, gamma2: float) -> Array:
    """Π of Theorem 1's proof: zᵀz − γ²ωᵀω + I_{i,j} as a form in (ξ_a, ξ_b, ω_a, ω_b)."""

    def value(xi_a: Array, xi_b: Array, w_a: Array, w_b: Array) -> float:
        following, e_a, e_b = fm_step(a, b, xi_a, xi_b, w_a, w_b)
        index = following @ P_c @ following - xi_a @ (P_a - Q_a) @ xi_a - xi_b @ Q_b @ xi_b
        return float(index + e_a @ e_a + e_b @ e_b - gamma2 * (w_a @ w_a + w_b @ w_b))

    return quadratic_form(value, fm_sizes(a))


def fm_theorem1(
    a: Values, b: Values, P_a: Array, P_c: Array, Q_a: Array, Q_b: Array, gamma2: float, X: Array | None = None
) -> Array:
    """(6): the Schur complement of Π < 0 in ξ⁺, z_b and z_a, in the row order of (14), congruent by P(c).

    With a slack X, (14): congruence by X and −XᵀP(c)⁻¹X replaced by its bound P(c) − X − Xᵀ, see (15).
    """
    form, N, M_a, M_b = _fm_maps(a, b, P_a, Q_a, Q_b, gamma2)
    q = len(M_a)
    matrix = lifted(form, (N, P_c), (M_b, np.eye(q)), (M_a, np.eye(q)))
    matrix = reorder(matrix, [*fm_sizes(a), len(P_c), q, q], [4, 5, 6, 0, 1, 2, 3])
    return _fm_slack(matrix, P_c, X)


def fm_theorem4(a: Values, b: Values, P_a: Array, P_c: Array, Q_a: Array, Q_b: Array, X: Array | None = None) -> Array:
    """(28): the Schur complement of Σ < 0, the dissipation without z and with γ = 1; with X, (37)."""
    form, N, _, _ = _fm_maps(a, b, P_a, Q_a, Q_b, 1.0)
    matrix = reorder(lifted(form, (N, P_c)), [*fm_sizes(a), len(P_c)], [4, 0, 1, 2, 3])
    return _fm_slack(matrix, P_c, X)


def fm_peak(a: Values, b: Values, P_a: Array, P_b: Array, gamma2: float) -> Array:
    """(29): its Schur complements in the first two blocks are (34), (35), −P + 2γ⁻² C̄ᵀC̄ < 0."""
    sizes = fm_sizes(a)
    M = [linear_map(lambda *s, k=k: fm_step(a, b, *s)[k], sizes)[:, : sizes[0] + sizes[1]] for k in (1, 2)]
    q = len(M[0])
    form = quadratic_form(lambda u, v: float(-u @ P_a @ u - v @ P_b @ v), sizes[:2])
    matrix = lifted(form, *((m, 2 / gamma2 * np.eye(q)) for m in M))
    return reorder(matrix, [*sizes[:2], q, q], [2, 3, 0, 1])


def fm_congruence(X: Array) -> Array:
    """Γ = diag{I, X₃⁻¹X₄} for X = [X₁ X₂; X₄ X₃], (20) and (21)."""
    n = len(X) // 2
    return block_diag(np.eye(n), inv(X[n:, n:]) @ X[n:, :n])


def fm_unknowns(a: Values, b: Values, X: Array) -> Values:
    """The new unknowns (21), (22) of Theorems 3 and 6 at the filter (a, b) and slack X."""
    n = len(X) // 2
    X1, X2, X4, X3 = X[:n, :n], X[:n, n:], X[n:, :n], X[n:, n:]
    S = inv(X3) @ X4
    return Values(
        U=X1, V=X2 @ S, W=X4.T @ inv(X3).T @ X4,
        Abar_1F=X4.T @ a.A_1F @ S, Abar_2F=X4.T @ b.A_2F @ S, Bbar_1F=X4.T @ a.B_1F, Bbar_2F=X4.T @ b.B_2F,
        Cbar_F_a=a.C_F @ S, Cbar_F_b=b.C_F @ S, S=S,
    )  # fmt: skip


def fm_theorem3(a: Values, b: Values, P_a: Array, P_c: Array, Q_a: Array, Q_b: Array, gamma2: float, X: Array) -> Array:
    """(16): (14) congruent by diag{Γ, I, I, Γ, Γ, I, I}, (23)."""
    G, (q, nw) = fm_congruence(X), (a.L.shape[0], a.B_1.shape[1])
    matrix = fm_theorem1(a, b, P_a, P_c, Q_a, Q_b, gamma2, X)
    return congruence(matrix, G, np.eye(2 * q), G, G, np.eye(2 * nw))


def fm_theorem6(
    a: Values, b: Values, P_a: Array, P_b: Array, P_c: Array, Q_a: Array, Q_b: Array, gamma2: float, X: Array
) -> tuple[Array, Array]:
    """(38) and (39): (37) congruent by diag{Γ, Γ, Γ, I, I} and (29) by diag{I, I, Γ, Γ} (Remark 4)."""
    G, (q, nw) = fm_congruence(X), (a.L.shape[0], a.B_1.shape[1])
    energy = congruence(fm_theorem4(a, b, P_a, P_c, Q_a, Q_b, X), G, G, G, np.eye(2 * nw))
    return energy, congruence(fm_peak(a, b, P_a, P_b, gamma2), np.eye(2 * q), G, G)


def _fm_maps(a: Values, b: Values, P_a: Array, Q_a: Array, Q_b: Array, gamma2: float) -> tuple[Array, ...]:
    sizes = fm_sizes(a)

    def storage(xi_a: Array, xi_b: Array, w_a: Array, w_b: Array) -> float:
        return float(-xi_a @ (P_a - Q_a) @ xi_a - xi_b @ Q_b @ xi_b - gamma2 * (w_a @ w_a + w_b @ w_b))

    N, M_a, M_b = (linear_map(lambda *s, k=k: fm_step(a, b, *s)[k], sizes) for k in range(3))
    return quadratic_form(storage, sizes), N, M_a, M_b


def _fm_slack(matrix: Array, P_c: Array, X: Array | None) -> Array:
    rest = np.eye(len(matrix) - len(P_c))
    if X is None:
        return congruence(matrix, P_c, rest)
    return add(congruence(matrix, X, rest), [len(P_c)], 0, X.T @ inv(P_c) @ X + P_c - X - X.T)


# chen2006: 2-D state-delayed systems with NFT uncertainty -------------------------------------------------


def nft_sizes(p: Values) -> tuple[int, ...]:
    """Sizes of x̂(i+1,j), x̂(i,j+1), their delayed copies, w_Δ twice and w twice."""
    nx, nd, nw = p.A_1.shape[0], p.Delta.shape[0], p.B_1.shape[1]
    return (2 * nx,) * 4 + (nd,) * 2 + (nw,) * 2


def nft_step(p: Values, f: Values, u: Array, v: Array, ud: Array, vd: Array, *inputs: Array) -> tuple[Array, ...]:
    """One step of (1) and (7): x̂(i+1, j+1), and the stacked ẑ and z_Δ at (i+1, j) and (i, j+1)."""
    wd_u, wd_v, w_u, w_v = inputs
    (x_u, f_u), (x_v, f_v) = np.split(u, 2), np.split(v, 2)
    n = len(x_u)
    x = p.A_1 @ x_u + p.A_2 @ x_v + p.A_d1 @ ud[:n] + p.A_d2 @ vd[:n]
    x = x + p.B_Delta_1 @ wd_u + p.B_Delta_2 @ wd_v + p.B_1 @ w_u + p.B_2 @ w_v
    y_u, y_v = (p.C @ x + p.D_Delta @ wd + p.D @ w for x, wd, w in ((x_u, wd_u, w_u), (x_v, wd_v, w_v)))
    following = f.A_f1 @ f_u + f.A_f2 @ f_v + f.B_f1 @ y_u + f.B_f2 @ y_v
    error = [p.L @ x - f.C_f @ xf for x, xf in ((x_u, f_u), (x_v, f_v))]
    z_D = [p.C_Delta @ x + p.D_Delta_z @ wd + p.D_z @ w for x, wd, w in ((x_u, wd_u, w_u), (x_v, wd_v, w_v))]
    return np.concatenate([x, following]), np.concatenate(error), np.concatenate(z_D)


def nft_storage(P1: Array, P2: Array, Q1: Array, Q2: Array, F: Array, supply: float) -> Callable[..., float]:
    """−x̂ᵀPx̂ − x̂_dᵀQx̂_d + w_ΔᵀFw_Δ − supply·wᵀw over the two shifted copies."""

    def value(u: Array, v: Array, ud: Array, vd: Array, wd_u: Array, wd_v: Array, w_u: Array, w_v: Array) -> float:
        wd = np.concatenate([wd_u, wd_v])
        kept = u @ P1 @ u + v @ P2 @ v + ud @ Q1 @ ud + vd @ Q2 @ vd
        return float(-kept + wd @ F @ wd - supply * (w_u @ w_u + w_v @ w_v))

    return value


def nft_theorem1(p: Values, P1: Array, P2: Array, Q1: Array, Q2: Array) -> Array:
    """(14): −(V(i+1,j+1) − V) as a form in x(i+1,j), x(i,j+1) and the delayed states, V by P₁+P₂+Q₁+Q₂."""

    def value(u: Array, v: Array, ud: Array, vd: Array) -> float:
        x = p.A_1 @ u + p.A_2 @ v + p.A_d1 @ ud + p.A_d2 @ vd
        return float(u @ P1 @ u + v @ P2 @ v + ud @ Q1 @ ud + vd @ Q2 @ vd - x @ (P1 + P2 + Q1 + Q2) @ x)

    return quadratic_form(value, (p.A_1.shape[0],) * 4)


def nft_uncertainty(Delta: Array, E: Array, F: Array, V: Array) -> Array:
    """(32), (43), (44): (21) congruent by diag(I, Vᵀ), −VF⁻¹Vᵀ replaced by its bound F + V + Vᵀ, (34)–(36)."""
    copies = len(E) // len(Delta)
    step = linear_map(lambda *z: np.concatenate([Delta @ one for one in z]), (len(Delta),) * copies)
    matrix = congruence(np.block([[E, step.T], [step, -inv(F)]]), np.eye(len(E)), V.T)
    return add(matrix, [len(E), len(F)], 1, V @ inv(F) @ V.T + F + V + V.T)


def nft_performance(
    p: Values, f: Values, P1: Array, P2: Array, Q1: Array, Q2: Array, E: Array, F: Array, H: Array, K: Array,
    supply: float, gamma: float | None,
) -> Array:  # fmt: skip
    """(33) with supply = γ, (46) with supply (1 − ε)/2 and no error rows (gamma None).

    Starts at (22): the lifted dissipation in x̂⁺ by M, ẑ by γ⁻¹I and z_Δ by E. Congruence by Hᵀ and Kᵀ, then
    −HM⁻¹Hᵀ and −KE⁻¹Kᵀ replaced by their bounds M − H − Hᵀ and E − K − Kᵀ (proof of Lemma 1).
    """
    sizes, M = nft_sizes(p), P1 + P2 + Q1 + Q2
    form = quadratic_form(nft_storage(P1, P2, Q1, Q2, F, supply), sizes)
    N, Z, ZD = (linear_map(lambda *s, k=k: nft_step(p, f, *s)[k], sizes) for k in range(3))
    maps = [(N, M), *([(Z, np.eye(len(Z)) / gamma)] if gamma else []), (ZD, E)]
    middle = [np.eye(len(Z))] if gamma else []
    matrix = congruence(lifted(form, *maps), np.eye(len(form)), H.T, *middle, K.T)
    parts = [len(form), *(len(m) for m, _ in maps)]
    matrix = add(matrix, parts, 1, H @ inv(M) @ H.T + M - H - H.T)
    return add(matrix, parts, len(parts) - 1, K @ inv(E) @ K.T + E - K - K.T)


def nft_output(
    p: Values,
    f: Values,
    X1: Array,
    X2: Array,
    Y1: Array,
    Y2: Array,
    E: Array,
    F: Array,
    K: Array,
    eps: float,
    mu: float,
) -> Array:
    """(45): (27), the lifted −x̂ᵀNx̂ + w_ΔᵀF₂w_Δ − ε wᵀw + z_ΔᵀE₂z_Δ + ẑᵀẑ/μ at one point, with slack K₂."""
    nx, nd, nw = p.A_1.shape[0], p.Delta.shape[0], p.B_1.shape[1]
    sizes, N = (2 * nx, nd, nw), X1 + X2 + Y1 + Y2

    def maps(x: Array, wd: Array, w: Array) -> tuple[Array, Array]:
        return p.C_Delta @ x[:nx] + p.D_Delta_z @ wd + p.D_z @ w, p.L @ x[:nx] - f.C_f @ x[nx:]

    form = quadratic_form(lambda x, wd, w: float(-x @ N @ x + wd @ F @ wd - eps * w @ w), sizes)
    ZD, Z = (linear_map(lambda *s, k=k: maps(*s)[k], sizes) for k in (0, 1))
    matrix = lifted(form, (ZD, E), (Z, np.eye(len(Z)) / mu))
    matrix = congruence(matrix, np.eye(len(form)), K.T, np.eye(len(Z)))
    return add(matrix, [len(form), nd, len(Z)], 1, K @ inv(E) @ K.T + E - K - K.T)


def nft_unknowns(H1: Array, H2: Array, H3: Array, hats: Values) -> tuple[Values, Array, Array]:
    """The filter (41), slack (39) and Ω = diag(I, Ĥ₃ᵀ) that belong to Ĥ and the hatted filter."""
    n = len(H1)
    filt = Values(
        A_f1=hats.Ahat_f1 @ inv(H3), A_f2=hats.Ahat_f2 @ inv(H3), B_f1=hats.Bhat_f1, B_f2=hats.Bhat_f2,
        C_f=hats.Chat_f @ inv(H3),
    )  # fmt: skip
    slack = np.block([[H1, np.eye(n)], [inv(H3).T @ H2, inv(H3).T]])
    return filt, slack, block_diag(np.eye(n), H3.T)


def nft_synthesis(
    p: Values, hats: Values, P1: Array, P2: Array, Q1: Array, Q2: Array, E: Array, F: Array,
    H: tuple[Array, Array, Array], K: Array, supply: float, gamma: float | None,
) -> Array:  # fmt: skip
    """(37) and (48): (33) and (46) at P = Ω⁻¹P̂Ω⁻ᵀ …, congruent by Ωᵀ in every copy of the state, see (39)–(41)."""
    filt, slack, Omega = nft_unknowns(*H, hats)
    plain: Any = [inv(Omega) @ M @ inv(Omega).T for M in (P1, P2, Q1, Q2)]
    matrix = nft_performance(p, filt, *plain, E, F, slack, K, supply, gamma)
    head = sum(nft_sizes(p)[4:])
    tail = len(matrix) - 5 * len(Omega) - head
    return congruence(matrix, *[Omega.T] * 4, np.eye(head), Omega.T, np.eye(tail))


def nft_synthesis_output(
    p: Values, hats: Values, X1: Array, X2: Array, Y1: Array, Y2: Array, E: Array, F: Array,
    H: tuple[Array, Array, Array], K: Array, eps: float, mu: float,
) -> Array:  # fmt: skip
    """(47): (45) at X = Ω⁻¹X̂Ω⁻ᵀ …, congruent by Ωᵀ in the state."""
    filt, _, Omega = nft_unknowns(*H, hats)
    plain: Any = [inv(Omega) @ M @ inv(Omega).T for M in (X1, X2, Y1, Y2)]
    matrix = nft_output(p, filt, *plain, E, F, K, eps, mu)
    return congruence(matrix, Omega.T, np.eye(len(matrix) - len(Omega)))


# mustafa: nonuniform sampling ------------------------------------------------------------------------------


def sampled_step(p: Values, f: Values, xbar: Array, w: Array) -> tuple[Array, Array]:
    """One step of plant (3) and filter (4): the next (x, x̂) and the error."""
    x, xf = np.split(xbar, 2)
    y = p.C @ x + p.D @ w
    return np.concatenate([p.Phi @ x + p.Gamma @ w, f.A_f @ xf + f.B_f @ y]), p.L @ x - f.C_f @ xf


def sampled_step_uncertain(p: Values, f: Values, xbar: Array, xi: Array, w: Array) -> tuple[Array, Array]:
    """One step of Lemma 2's Σ(h₀): ξ enters the plant's state; the outputs are η = AΦx + (AΓ + B)w and e."""
    following, e = sampled_step(p, f, xbar, w)
    n = len(xi)
    eta = p.A @ (p.Phi @ xbar[:n] + p.Gamma @ w) + p.B @ w
    return following + np.concatenate([xi, np.zeros(n)]), np.concatenate([eta, e])


def sampled_analysis(step: Callable[..., tuple[Array, Array]], sizes: Sequence[int], P: Array, gamma2: float) -> Array:
    """(6) for any one-step map: Schur complement with the Lyapunov matrix P̄⁻¹, congruent by P̄ in x̄."""
    form = quadratic_form(lambda x, *w: float(-x @ inv(P) @ x - gamma2 * sum(v @ v for v in w)), sizes)
    N, M = (linear_map(lambda *s, k=k: step(*s)[k], sizes) for k in (0, 1))
    inputs = sum(sizes[1:])
    matrix = lifted(form, (N, inv(P)), (M, np.eye(len(M))))
    matrix = congruence(matrix, P, np.eye(inputs + len(N) + len(M)))
    return reorder(matrix, [sizes[0], inputs, len(N), len(M)], [2, 3, 0, 1])


def sampled_unknowns(f: Values, P: Array) -> tuple[Array, Values]:
    """J₁ = [X⁻¹ Y; 0 Vᵀ] and the new unknowns of Theorem 3's proof, at the filter and P̄ = [X U; Uᵀ X̂]."""
    n = len(P) // 2
    R = inv(P)
    X, U, Y, V = P[:n, :n], P[:n, n:], R[:n, :n], R[:n, n:]
    J1 = np.block([[inv(X), Y], [np.zeros((n, n)), V.T]])
    Z = inv(X)
    return J1, Values(Z=Z, Y=Y, F=V @ f.B_f, Q=V @ f.A_f @ U.T @ Z, G=f.C_f @ U.T @ Z)


def sampled_theorem3(p: Values, f: Values, P: Array, gamma2: float) -> tuple[Array, Values]:
    """(10): (6) congruent by diag(J₁, I, J₁, I)."""
    J1, unknowns = sampled_unknowns(f, P)
    m, s = p.Gamma.shape[1], p.L.shape[0]
    matrix = sampled_analysis(lambda x, w: sampled_step(p, f, x, w), (len(P), m), P, gamma2)
    return congruence(matrix, J1, np.eye(s), J1, np.eye(m)), unknowns


def sampled_robust_performance(p: Values, f: Values, P: Array, gamma2: float) -> tuple[Array, Values]:
    """(13): (6) for the channels (ξ, w) → (η, e) of Lemma 2, congruent as (10) is."""
    J1, unknowns = sampled_unknowns(f, P)
    (n, m), s = p.Gamma.shape, p.L.shape[0]
    matrix = sampled_analysis(lambda x, xi, w: sampled_step_uncertain(p, f, x, xi, w), (len(P), n, m), P, gamma2)
    return congruence(matrix, J1, np.eye(n + s), J1, np.eye(n + m)), unknowns
