"""Discrete time, with or without a delayed state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.language.systems import DelaySystem, DiscreteSystem
from lmic.recover.recover import Design

Array: TypeAlias = NDArray[Any]


def simulate_discrete(
    design: Design,
    system: DiscreteSystem | DelaySystem,
    w: Array,
    parameters: Mapping[str, Array],
    delay: Array | None = None,
) -> tuple[Array, Array]:
    """State and output from the zero state; ``delay[k]`` is the delay in steps at time k."""
    steps = len(w)
    matrices = {
        name: np.broadcast_to(m, (steps, *m.shape[1:])) for name, m in design.frozen(system, parameters).items()
    }
    A, B, C, D = (matrices[name] for name in "ABCD")
    state = np.zeros((steps + 1, A.shape[-1]))
    output = np.empty((steps, C.shape[-2]))
    for k in range(steps):
        state[k + 1] = A[k] @ state[k] + B[k] @ w[k]
        output[k] = C[k] @ state[k] + D[k] @ w[k]
        if isinstance(system, DelaySystem) and delay is not None and k >= delay[k]:
            past = state[k - int(delay[k])]
            state[k + 1] += matrices["A_d"][k] @ past
            output[k] += matrices["C_d"][k] @ past
    return state[:-1], output
