"""The record of a simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class Trajectory:
    """Signals over time, shape (T, components), or over the plane, shape (I, J, components).

    ``w`` is the disturbance, ``e`` the output that the theorem bounds, ``state`` the closed loop's
    state, ``others`` further signals by name, ``parameters`` the parameters' components.
    """

    w: Array
    e: Array
    state: Array
    parameters: Mapping[str, Array]
    others: Mapping[str, Array]

    @property
    def gain(self) -> float:
        """‖e‖₂ / ‖w‖₂."""
        return float(np.linalg.norm(self.e) / np.linalg.norm(self.w))

    @property
    def peak(self) -> float:
        """Largest |e| at one time or place, over ‖w‖₂."""
        return float(np.linalg.norm(self.e, axis=-1).max() / np.linalg.norm(self.w))
