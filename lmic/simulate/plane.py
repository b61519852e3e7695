"""2-D systems (Fornasini–Marchesini) over the quarter plane."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.language.systems import FornasiniMarchesini
from lmic.recover.recover import Design

Array: TypeAlias = NDArray[Any]


def simulate_plane(
    design: Design,
    system: FornasiniMarchesini,
    w: Array,
    parameters: Mapping[str, Array],
    boundary: Array | None = None,
) -> tuple[Array, Array]:
    """State and output over I x J points.

    ``boundary`` (max(I, J), states) are the states x_{0,k} = x_{k,0}; zero without it. ``w`` and the
    parameters have shape (I, J, components).
    """
    height, width = w.shape[:2]
    flat = {name: values.reshape(height * width, -1) for name, values in parameters.items()}
    frozen = design.frozen(system, flat)
    A1, A2, B1, B2, C = (
        np.broadcast_to(frozen[name], (height * width, *frozen[name].shape[1:])).reshape(
            height, width, *frozen[name].shape[1:]
        )
        for name in ("A1", "A2", "B1", "B2", "C")
    )
    state = np.zeros((height, width, A1.shape[-1]))
    if boundary is not None:
        state[0, :, : boundary.shape[1]] = boundary[:width]
        state[:, 0, : boundary.shape[1]] = boundary[:height]
    for i in range(height - 1):
        for j in range(width - 1):
            state[i + 1, j + 1] = (
                A1[i, j + 1] @ state[i, j + 1]
                + A2[i + 1, j] @ state[i + 1, j]
                + B1[i, j + 1] @ w[i, j + 1]
                + B2[i + 1, j] @ w[i + 1, j]
            )
    return state, np.einsum("ijab,ijb->ija", C, state)
