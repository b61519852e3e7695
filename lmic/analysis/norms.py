"""Norms of linear systems at frozen parameters, independent of the LMIs that bound them."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from lmic.language.systems import (
    ContinuousSystem,
    DelayedFornasiniMarchesini,
    DelaySystem,
    DiscreteSystem,
    FornasiniMarchesini,
    PlaneSystem,
    System,
)
from lmic.recover.recover import Design

Array: TypeAlias = NDArray[Any]

#: relative accuracy of an H∞ norm
TOLERANCE = 1e-9
#: points per phase, by the number of phases, from which a maximum over the torus is refined
POINTS = {1: 96, 2: 64, 3: 24, 4: 14}
#: local maxima of the grid that are refined
STARTS = 4
#: entries of the matrices that are formed at once
ENTRIES = 2**19


def frozen_gain(design: Design, system: System, parameters: Mapping[str, Any]) -> Array | None:
    """The ℓ2 gain (H∞ norm) at each of K frozen parameters; infinite where unstable.

    None for a :class:`DelaySystem`: its gain depends on the delay's course. The delays of a 2-D system
    are fixed, and its gain is the supremum over all of them.
    """
    if isinstance(system, DelaySystem):
        return None
    matrices = design.frozen(system, parameters)
    stacks = [dict(zip(matrices, frozen, strict=True)) for frozen in zip(*matrices.values(), strict=True)]
    match system:
        case DiscreteSystem():
            return np.array([h_infinity(**m, discrete=True) for m in stacks])
        case ContinuousSystem():
            return np.array([h_infinity(**m, discrete=False) for m in stacks])
        case FornasiniMarchesini() | DelayedFornasiniMarchesini():
            return np.array([torus_norm(**m) for m in stacks])


def frozen_peak(design: Design, system: System, parameters: Mapping[str, Any]) -> Array | None:
    """The energy-to-peak norm of a 2-D system at each of K frozen parameters; infinite where unstable.

    That is the norm of z on a diagonal i + j = n over ‖w‖₂, no less than the largest |z| at a place. Delays
    are taken to be zero: one of all for which a bound holds. None for other systems.
    """
    if not isinstance(system, PlaneSystem):
        return None
    matrices = design.frozen(system, parameters)
    if isinstance(system, DelayedFornasiniMarchesini):
        matrices |= {f"A{k}": matrices[f"A{k}"] + matrices.pop(f"A_d{k}") for k in (1, 2)}
    stacks = [dict(zip(matrices, frozen, strict=True)) for frozen in zip(*matrices.values(), strict=True)]
    return np.array([diagonal_peak(**m) for m in stacks])


def frozen_magnitude(
    design: Design, system: PlaneSystem, parameters: Mapping[str, Any], frequencies: Array, delay: Sequence[int]
) -> Array:
    """Magnitude of a stable 2-D system's response at K frozen parameters, shape (K, N).

    ``frequencies`` has shape (N, 2), in radians per step along i and j; ``delay`` are d1 and d2, of no
    effect where the system has no delays.
    """
    matrices = design.frozen(system, parameters)
    dynamics = np.stack([matrices[name] for name in ("A1", "A2", "A_d1", "A_d2") if name in matrices], axis=1)
    inputs = np.stack([matrices["B1"], matrices["B2"]], axis=1)
    phases = np.hstack([frequencies, frequencies * (1 + np.asarray(delay))])[:, : dynamics.shape[1]]
    return np.array([magnitude(*frozen, phases) for frozen in zip(dynamics, inputs, matrices["C"], strict=True)])


def h_infinity(A: Array, B: Array, C: Array, D: Array, discrete: bool) -> float:
    """H∞ norm by bisection on the eigenvalues of a Hamiltonian (python-control)."""
    import control

    eigenvalues = np.linalg.eigvals(A)
    if not (np.abs(eigenvalues).max() < 1 if discrete else eigenvalues.real.max() < 0):
        return float("inf")
    if discrete:
        A, B, C, D = _bilinear(A, B, C, D)
    # zero inputs or outputs are added: python-control 0.10 forms its Hamiltonian for square systems only
    outputs, inputs = D.shape
    more_inputs, more_outputs = max(outputs - inputs, 0), max(inputs - outputs, 0)
    B, C = np.pad(B, ((0, 0), (0, more_inputs))), np.pad(C, ((0, more_outputs), (0, 0)))
    D = np.pad(D, ((0, more_outputs), (0, more_inputs)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return float(control.norm(control.ss(A, B, C, D), p="inf", tol=TOLERANCE))


def _bilinear(A: Array, B: Array, C: Array, D: Array) -> tuple[Array, Array, Array, Array]:
    """The continuous-time system of the same gain over all frequencies, z = (1 + s)/(1 − s).

    The discrete-time Hamiltonian needs A⁻¹, and sampled filters have poles at zero.
    """
    identity = np.eye(len(A))
    shifted = np.linalg.inv(A + identity)
    root = np.sqrt(2.0)
    return shifted @ (A - identity), root * shifted @ B, root * C @ shifted, D - C @ shifted @ B


def torus_norm(
    A1: Array, A2: Array, B1: Array, B2: Array, C: Array, A_d1: Array | None = None, A_d2: Array | None = None
) -> float:
    """Largest gain of a 2-D system over its frequencies and, where it has delays, over all of them.

    A_d1 acts with the phase (d1 + 1) ω1 and A_d2 with (d2 + 1) ω2. At almost every frequency these come
    arbitrarily close to any two phases as d1 and d2 vary, so that the supremum over all delays is the
    maximum over independent phases. Infinite unless Σ_k z_k A_k is Schur stable for all |z_k| = 1: its
    spectral radius is largest there of all |z_k| ≤ 1 (it is plurisubharmonic), so that I − Σ_k z_k A_k is
    then regular in the closed polydisc, as stability for all delays asks.
    """
    dynamics = np.stack([A1, A2, *(matrix for matrix in (A_d1, A_d2) if matrix is not None and matrix.any())])
    batch = max(1, ENTRIES // A1.size)

    if not _stable(dynamics, batch):
        return float("inf")
    inputs = np.stack([B1, B2])
    return torus_maximum(lambda phases: magnitude(dynamics, inputs, C, phases), len(dynamics), batch)


def _stable(dynamics: Array, batch: int) -> bool:
    """Whether Σ_k z_k A_k is Schur stable for all |z_k| = 1."""

    def radius(phases: Array) -> Array:
        # a common phase turns the eigenvalues and leaves their size
        turned = dynamics[0] + np.tensordot(np.exp(-1j * phases), dynamics[1:], axes=1)
        return np.abs(np.linalg.eigvals(turned)).max(axis=-1)

    return torus_maximum(radius, len(dynamics) - 1, batch) < 1


def diagonal_peak(A1: Array, A2: Array, B1: Array, B2: Array, C: Array) -> float:
    """Largest norm of z on a diagonal i + j = n, over ‖w‖₂, of a 2-D system without delays; infinite if unstable.

    A wave of phase φ along the diagonals moves by A(φ) = A1 e^{−iφ} + A2 from one to the next; the square
    is the largest eigenvalue over φ of C P C*, with the Gramian P = A P A* + B B* of that wave.
    """
    size, dynamics, inputs = len(A1), np.stack([A2, A1]), np.stack([B2, B1])
    batch = max(1, ENTRIES // size**4)

    def square(phases: Array) -> Array:
        z = np.hstack([np.ones((len(phases), 1)), np.exp(-1j * phases)])
        step, entry = np.tensordot(z, dynamics, axes=1), np.tensordot(z, inputs, axes=1)
        squared = np.einsum("nij,nkl->nikjl", step, step.conj()).reshape(-1, size**2, size**2)
        supply = (entry @ entry.conj().swapaxes(1, 2)).reshape(-1, size**2, 1)
        gramian = np.linalg.solve(np.eye(size**2) - squared, supply).reshape(-1, size, size)
        return np.linalg.eigvalsh(C @ gramian @ C.T)[:, -1]

    return float(np.sqrt(torus_maximum(square, 1, batch))) if _stable(dynamics, batch) else float("inf")


def magnitude(dynamics: Array, inputs: Array, C: Array, phases: Array) -> Array:
    """Largest singular value of C (I − Σ_k z_k A_k)⁻¹ (z_1 B_1 + z_2 B_2), z_k = exp(−iφ_k), shape (N,).

    ``dynamics`` are the K matrices A_k, ``inputs`` B_1 and B_2, ``phases`` has shape (N, K) in radians.
    """
    z = np.exp(-1j * phases)
    system = np.eye(dynamics.shape[-1]) - np.tensordot(z, dynamics, axes=1)
    response = C @ np.linalg.solve(system, np.tensordot(z[:, :2], inputs, axes=1))
    return np.linalg.svd(response, compute_uv=False)[:, 0]


def torus_maximum(function: Callable[[Array], Array], dimension: int, batch: int) -> float:
    """Maximum of a function of ``dimension`` phases: a grid, its best local maxima refined by Nelder–Mead.

    ``function`` maps phases (N, dimension) to N values and is asked for at most ``batch`` of them.
    """
    count = POINTS[dimension]
    step = 2 * np.pi / count
    grid = step * np.indices([count] * dimension).reshape(dimension, -1).T
    values = np.concatenate([function(grid[k : k + batch]) for k in range(0, len(grid), batch)])
    starts = grid[_local_maxima(values.reshape([count] * dimension))[:STARTS]]
    return max(float(values.max()), *(_refined(function, start, step / 2) for start in starts))


def _refined(function: Callable[[Array], Array], start: Array, step: float) -> float:
    """The local maximum that a simplex search reaches from ``start`` and its neighbours at ``step``."""

    def loss(point: Array) -> float:
        return -float(function(point[None])[0])

    simplex = np.vstack([start, start + step * np.eye(len(start))])
    options: Any = {"initial_simplex": simplex, "xatol": 1e-9, "fatol": 1e-12}
    return -loss(minimize(loss, start, method="Nelder-Mead", options=options).x)


def _local_maxima(values: Array) -> Array:
    """Flat indices of the entries that no neighbour along an axis exceeds (periodic), the largest first."""
    neighbours = [np.roll(values, shift, axis) for axis in range(values.ndim) for shift in (-1, 1)]
    found = np.flatnonzero(np.all([values >= other for other in neighbours], axis=0))
    return found[np.argsort(-values.ravel()[found])]
