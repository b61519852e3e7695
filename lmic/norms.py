"""Norms of linear systems, by bisection on the eigenvalues of a Hamiltonian (python-control)."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lmic.recover import StateSpace


def h_infinity(system: StateSpace, discrete: bool = True) -> NDArray[Any]:
    """H∞ norm at each of the K frozen parameters; infinite where the system is unstable."""
    import control

    norms = []
    for A, B, C, D in zip(*_same_length(_square(system)), strict=True):
        eigenvalues = np.linalg.eigvals(A)
        stable = np.abs(eigenvalues).max() < 1 if discrete else eigenvalues.real.max() < 0
        if not stable:
            norms.append(np.inf)
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            frozen = control.ss(A, B, C, D, True) if discrete else control.ss(A, B, C, D)
            norms.append(float(control.norm(frozen, p="inf", tol=1e-9)))
    return np.array(norms)


def _square(system: StateSpace) -> StateSpace:
    """With zero inputs or outputs added: python-control 0.10 forms its Hamiltonian for square systems only."""
    outputs, inputs = system.D.shape[-2:]
    more_inputs, more_outputs = max(outputs - inputs, 0), max(inputs - outputs, 0)
    return StateSpace(
        system.A,
        np.pad(system.B, ((0, 0), (0, 0), (0, more_inputs))),
        np.pad(system.C, ((0, 0), (0, more_outputs), (0, 0))),
        np.pad(system.D, ((0, 0), (0, more_outputs), (0, more_inputs))),
    )


def _same_length(system: StateSpace) -> list[NDArray[Any]]:
    matrices = [system.A, system.B, system.C, system.D]
    length = max(len(matrix) for matrix in matrices)
    return [np.broadcast_to(matrix, (length, *matrix.shape[1:])) for matrix in matrices]
