"""Independent dense formulas of the standard conditions, as :mod:`dense_formulas` has the papers'."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import SimpleNamespace as Values

import numpy as np
from dense_maps import Array, add, congruence, lifted, linear_map, quadratic_form, reorder
from numpy.linalg import inv

# standard: continuous time -----------------------------------------------------------------------------------
# The form dV/dt + supply with V = xᵀP(ρ)x, dV/dt = xᵀṖx + 2 xᵀPẋ, polarised.


def flow_form(
    P: Array, P_dot: Array, flow: Callable[..., Array], supply: Callable[..., float], sizes: Sequence[int]
) -> Array:
    """dV/dt + supply as a form in the state and the inputs."""
    return quadratic_form(lambda x, *w: float(x @ P_dot @ x + 2 * x @ P @ flow(x, *w) + supply(x, *w)), sizes)


def lyapunov_continuous(A: Array, P: Array, P_dot: Array, beta: float = 0.0) -> Array:
    """dV/dt + 2βV: stability for β = 0, decay rate β, as d/dt (e^{2βt}V) < 0."""
    return flow_form(P, P_dot, lambda x: A @ x, lambda x: float(2 * beta * x @ P @ x), [len(A)])


def bounded_real_continuous(A: Array, B: Array, C: Array, D: Array, P: Array, P_dot: Array, gamma: float) -> Array:
    """dV/dt − γwᵀw + zᵀz/γ, lifted in z."""
    n, nw = B.shape
    form = flow_form(P, P_dot, lambda x, w: A @ x + B @ w, lambda x, w: float(-gamma * w @ w), (n, nw))
    M = linear_map(lambda x, w: C @ x + D @ w, (n, nw))
    return lifted(form, (M, np.eye(len(M)) / gamma))


def passivity_continuous(A: Array, B: Array, C: Array, D: Array, P: Array, P_dot: Array, nu: float) -> Array:
    """dV/dt − 2zᵀw + 2νwᵀw."""
    return flow_form(
        P, P_dot, lambda x, w: A @ x + B @ w, lambda x, w: float(2 * nu * w @ w - 2 * (C @ x + D @ w) @ w), B.shape
    )


def energy_continuous(A: Array, B: Array, P: Array, P_dot: Array) -> Array:
    """dV/dt − wᵀw."""
    return flow_form(P, P_dot, lambda x, w: A @ x + B @ w, lambda x, w: float(-w @ w), B.shape)


def peak(P: Array, C: Array, D: Array | None, mu: float) -> Array:
    """Positive when zᵀz/μ < xᵀPx + wᵀw for z = Cx + Dw (w absent without D): minus the lifted form."""
    sizes = [len(P)] + ([D.shape[1]] if D is not None else [])
    form = quadratic_form(lambda x, *w: float(-x @ P @ x - sum(v @ v for v in w)), sizes)
    M = linear_map(lambda x, *w: C @ x + (D @ w[0] if w else 0), sizes)
    return congruence(-lifted(form, (M, np.eye(len(M)) / mu)), np.eye(len(form)), -np.eye(len(M)))


def state_feedback_continuous(A: Array, B: Array, K: Array, Q: Array, Q_dot: Array) -> Array:
    """dV/dt of the closed loop with P = Q⁻¹, Ṗ = −Q⁻¹Q̇Q⁻¹, congruent by Q."""
    P, P_dot = inv(Q), -inv(Q) @ Q_dot @ inv(Q)
    return congruence(flow_form(P, P_dot, lambda x: A @ x + B @ (K @ x), lambda x: 0.0, [len(A)]), Q)


def state_feedback_hinf_continuous(p: Values, K: Array, Q: Array, Q_dot: Array, gamma: float) -> Array:
    """The bounded-real lemma of the closed loop with P = Q⁻¹, congruent by Q in x."""
    P, P_dot = inv(Q), -inv(Q) @ Q_dot @ inv(Q)
    (n, nw), nz = p.B_w.shape, p.C_z.shape[0]
    form = flow_form(
        P, P_dot, lambda x, w: p.A @ x + p.B_w @ w + p.B_u @ (K @ x), lambda x, w: float(-gamma * w @ w), (n, nw)
    )
    M = linear_map(lambda x, w: p.C_z @ x + p.D_zw @ w + p.D_zu @ (K @ x), (n, nw))
    return congruence(lifted(form, (M, np.eye(nz) / gamma)), Q, np.eye(nw + nz))


def observer_continuous(A: Array, C: Array, L: Array, P: Array, P_dot: Array) -> Array:
    """dV/dt of e = x − x̂, whose flow is that of plant minus observer at x = e, x̂ = 0."""
    return flow_form(P, P_dot, lambda e: A @ e - L @ (C @ e), lambda e: 0.0, [len(A)])


# standard: discrete time ---------------------------------------------------------------------------------------
# Positive LMIs: minus the lifted form of V⁺ − V + supply; signs of the lifted rows turned by congruence.


def step_lmi(
    P: Array,
    P_next: Array,
    step: Callable[..., Array],
    inputs: Sequence[int],
    supply: float,
    *outputs: tuple[Array, float],
) -> Array:
    """[V + supply·wᵀw …] lifted in x⁺ by P⁺ (congruent by P⁺) and in outputs z = M(x, w) by I/level."""
    sizes = [len(P), *inputs]
    form = quadratic_form(lambda x, *w: float(-x @ P @ x - supply * sum(v @ v for v in w)), sizes)
    N = linear_map(step, sizes)
    matrix = -lifted(form, (N, P_next), *((M, np.eye(len(M)) / level) for M, level in outputs))
    tail = sum(len(M) for M, _ in outputs)
    return congruence(matrix, np.eye(sum(sizes)), -P_next, *([-np.eye(tail)] if tail else []))


def lyapunov_discrete(A: Array, P: Array, P_next: Array, beta: float = 1.0) -> Array:
    """V⁺ < β²V: stability for β = 1, decay rate β."""
    return step_lmi(beta**2 * P, P_next, lambda x: A @ x, [], 0.0)


def bounded_real_discrete(A: Array, B: Array, C: Array, D: Array, P: Array, P_next: Array, gamma: float) -> Array:
    """V⁺ − V − γwᵀw + zᵀz/γ < 0, lifted in x⁺ and z."""
    nw = B.shape[1]
    M = linear_map(lambda x, w: C @ x + D @ w, (len(A), nw))
    return step_lmi(P, P_next, lambda x, w: A @ x + B @ w, [nw], gamma, (M, gamma))


def passivity_discrete(A: Array, B: Array, C: Array, D: Array, P: Array, P_next: Array, nu: float) -> Array:
    """2zᵀw − 2νwᵀw − (V⁺ − V), lifted in x⁺."""
    n, nw = B.shape
    form = quadratic_form(lambda x, w: float(-x @ P @ x + 2 * nu * w @ w - 2 * (C @ x + D @ w) @ w), (n, nw))
    matrix = -lifted(form, (linear_map(lambda x, w: A @ x + B @ w, (n, nw)), P_next))
    return congruence(matrix, np.eye(n + nw), -P_next)


def energy_discrete(A: Array, B: Array, P: Array, P_next: Array) -> Array:
    """V⁺ − V < wᵀw, lifted in x⁺."""
    return step_lmi(P, P_next, lambda x, w: A @ x + B @ w, [B.shape[1]], 1.0)


def slack_stability(A: Array, P: Array, G: Array) -> Array:
    """De Oliveira et al.: [P Aᵀ; A P⁻¹] congruent by diag(I, Gᵀ), GP⁻¹Gᵀ replaced by its bound G + Gᵀ − P."""
    n = len(A)
    matrix = congruence(np.block([[P, A.T], [A, inv(P)]]), np.eye(n), G.T)
    return add(matrix, [n, n], 1, G + G.T - P - G @ inv(P) @ G.T)


def slack_poly_stability(A: Array, S: Array, S_next: Array, G: Array) -> Array:
    """Daafouz, Bernussou: V⁺ < V with P = S⁻¹, [S⁻¹ Aᵀ; A S⁺], by G in x; GᵀS⁻¹G replaced by G + Gᵀ − S."""
    n = len(A)
    matrix = congruence(np.block([[inv(S), A.T], [A, S_next]]), G, np.eye(n))
    return add(matrix, [n, n], 0, G + G.T - S - G.T @ inv(S) @ G)


def state_feedback_discrete(A: Array, B: Array, K: Array, Q: Array, Q_next: Array, G: Array) -> Array:
    """The same for the closed loop A + BK; without slack, G = Q."""
    return slack_poly_stability(linear_map(lambda x: A @ x + B @ (K @ x), [len(A)]), Q, Q_next, G)


def state_feedback_hinf_discrete(p: Values, K: Array, Q: Array, Q_next: Array, G: Array, gamma: float) -> Array:
    """The closed loop's bounded-real lemma with P = Q⁻¹, by G in x, GᵀQ⁻¹G replaced by its bound; order x⁺, x, w, z."""
    (n, nw), nz = p.B_w.shape, p.C_z.shape[0]
    M = linear_map(lambda x, w: p.C_z @ x + p.D_zw @ w + p.D_zu @ (K @ x), (n, nw))
    matrix = step_lmi(inv(Q), inv(Q_next), lambda x, w: p.A @ x + p.B_w @ w + p.B_u @ (K @ x), [nw], gamma, (M, gamma))
    matrix = congruence(matrix, G, np.eye(nw), Q_next, np.eye(nz))
    matrix = add(matrix, [n, nw, n, nz], 0, G + G.T - Q - G.T @ inv(Q) @ G)
    return reorder(matrix, [n, nw, n, nz], [2, 0, 1, 3])


def observer_discrete(A: Array, C: Array, L: Array, P: Array, P_next: Array, G: Array) -> Array:
    """V⁺ < V of e = x − x̂, [P Āᵀ; Ā P⁺⁻¹], by Gᵀ in e⁺; GP⁺⁻¹Gᵀ replaced by its bound G + Gᵀ − P⁺."""
    n = len(A)
    closed = linear_map(lambda e: A @ e - L @ (C @ e), [n])
    matrix = congruence(np.block([[P, closed.T], [closed, inv(P_next)]]), np.eye(n), G.T)
    return add(matrix, [n, n], 1, G + G.T - P_next - G @ inv(P_next) @ G.T)


# standard: H2 -------------------------------------------------------------------------------------------------------


def h2_continuous(A: Array, C: Array, P: Array, P_dot: Array) -> Array:
    """dV/dt + zᵀz < 0 from an impulse on, lifted in z."""
    form = flow_form(P, P_dot, lambda x: A @ x, lambda x: 0.0, [len(A)])
    return lifted(form, (C, np.eye(len(C))))


def h2_discrete(A: Array, C: Array, P: Array, P_next: Array) -> Array:
    """V⁺ − V + zᵀz < 0 from an impulse on, lifted in x⁺ and z."""
    return step_lmi(P, P_next, lambda x: A @ x, [], 0.0, (linear_map(lambda x: C @ x, [len(A)]), 1.0))


def h2_trace(B: Array, D: Array | None, P: Array, Z: Array) -> Array:
    """wᵀZw > V(Bw) + ‖Dw‖² for every w: the energy of the impulse response in direction w; lifted, by P in x."""
    nw = B.shape[1]
    maps = [(B, P)] + ([(D, np.eye(len(D)))] if D is not None else [])
    matrix = -lifted(-Z, *maps)
    tail = [-np.eye(len(D))] if D is not None else []
    return congruence(matrix, np.eye(nw), -P, *tail)
