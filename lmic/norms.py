"""Norms of linear systems at frozen parameters, independent of the LMIs that bound them."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from lmic.language.systems import ContinuousSystem, DelaySystem, DiscreteSystem, FornasiniMarchesini, System
from lmic.recover import Design

Array: TypeAlias = NDArray[Any]

#: points per frequency from which the maximum over the torus is refined
TORUS = 48


def frozen_gain(design: Design, system: System, parameters: Mapping[str, Any]) -> Array | None:
    """The ℓ2 gain (H∞ norm) at each of K frozen parameters; infinite where unstable.

    None for a system with delay: its gain depends on the delay's course.
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
        case FornasiniMarchesini():
            return np.array([torus_norm(**m) for m in stacks])


def h_infinity(A: Array, B: Array, C: Array, D: Array, discrete: bool) -> float:
    """H∞ norm by bisection on the eigenvalues of a Hamiltonian (python-control)."""
    import control

    eigenvalues = np.linalg.eigvals(A)
    if not (np.abs(eigenvalues).max() < 1 if discrete else eigenvalues.real.max() < 0):
        return float("inf")
    # zero inputs or outputs are added: python-control 0.10 forms its Hamiltonian for square systems only
    outputs, inputs = D.shape
    more_inputs, more_outputs = max(outputs - inputs, 0), max(inputs - outputs, 0)
    B, C = np.pad(B, ((0, 0), (0, more_inputs))), np.pad(C, ((0, more_outputs), (0, 0)))
    D = np.pad(D, ((0, more_outputs), (0, more_inputs)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        system = control.ss(A, B, C, D, True) if discrete else control.ss(A, B, C, D)
        return float(control.norm(system, p="inf", tol=1e-9))


def torus_norm(A1: Array, A2: Array, B1: Array, B2: Array, C: Array) -> float:
    """Largest gain of a 2-D system over the frequency torus, from a grid refined by a local search."""

    def gain(first: Array, second: Array) -> Array:
        z1, z2 = np.exp(1j * first)[..., None, None], np.exp(1j * second)[..., None, None]
        response = C @ np.linalg.solve(np.eye(len(A1)) - z1 * A1 - z2 * A2, z1 * B1 + z2 * B2)
        return np.linalg.svd(response, compute_uv=False)[..., 0]

    # the response of a real system is even in (ω1, ω2) together: half the torus is enough
    first, second = np.meshgrid(np.linspace(0, np.pi, TORUS), np.linspace(-np.pi, np.pi, 2 * TORUS), indexing="ij")
    values = gain(first, second)
    best = int(np.argmax(values))

    def loss(point: Array) -> float:
        return -float(gain(point[:1], point[1:])[0])

    start = np.array([first.ravel()[best], second.ravel()[best]])
    refined = minimize(loss, start, method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12})
    return max(float(values.max()), -loss(refined.x))
