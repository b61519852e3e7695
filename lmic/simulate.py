"""Simulate the closed loop of a design along a parameter trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.language.systems import Bound
from lmic.recover import Design

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class Trajectory:
    """Signals over T steps: ``w`` (T, nw), ``z`` (T, nz), and the parameters by name (T, components)."""

    w: Array
    z: Array
    parameters: dict[str, Array]

    @property
    def gain(self) -> float:
        """‖z‖₂ / ‖w‖₂ of this trajectory."""
        return float(np.linalg.norm(self.z) / np.linalg.norm(self.w))


def simulate(design: Design, bound: Bound, w: Array, parameters: dict[str, Array]) -> Trajectory:
    """The error z of a discrete-time closed loop driven by ``w`` from the zero state."""
    system = design.closed_loop(bound, parameters)
    steps = len(w)
    A, B, C, D = (np.broadcast_to(m, (steps, *m.shape[1:])) for m in (system.A, system.B, system.C, system.D))
    state = np.zeros(A.shape[-1])
    z = np.empty((steps, C.shape[-2]))
    for k in range(steps):
        z[k] = C[k] @ state + D[k] @ w[k]
        state = A[k] @ state + B[k] @ w[k]
    return Trajectory(w, z, parameters)
