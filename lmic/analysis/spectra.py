"""Poles and zeros at frozen parameters: of the system that a theorem speaks of, and of what it recovers."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.analysis.walk import Walk
from lmic.errors import LmicError
from lmic.language.systems import ContinuousSystem, DelaySystem, DiscreteSystem
from lmic.recover.recover import Design

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class Spectra:
    """Poles of the system (K, states), and poles and zeros of the recovered one at each of K points of a walk.

    ``closed`` is None where the theorem promises nothing of a system with poles; ``poles`` is None where it recovers
    no dynamic system. ``zeros`` are those of each channel, from one input to one output.
    """

    discrete: bool
    closed: Array | None
    poles: Array | None
    zeros: list[Array]


def spectra(design: Design, path: Walk) -> Spectra | None:
    """Along a walk; None where there is neither a system with poles nor a dynamic design."""
    systems = [bound.system for bound in design.binding.theorem.guarantees]
    timed = [s for s in systems if isinstance(s, (DiscreteSystem, ContinuousSystem, DelaySystem))]
    if not timed:
        return None
    closed = None if isinstance(timed[0], DelaySystem) else np.linalg.eigvals(design.frozen(timed[0], path.points)["A"])
    try:
        designed = design.state_spaces(**path.points) if design.binding.theorem.recover else []
    except LmicError:  # what is recovered is no state-space system
        designed = []
    dynamic = [system for system in designed if system.nstates]
    poles = np.array([np.linalg.eigvals(system.A) for system in dynamic]) if dynamic else None
    if closed is None and poles is None:
        return None
    return Spectra(not isinstance(timed[0], ContinuousSystem), closed, poles, [_zeros(system) for system in dynamic])


def _zeros(system: Any) -> Array:
    """Finite zeros of every channel."""
    found = [np.zeros(0, dtype=complex)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for row in range(system.noutputs):
            for column in range(system.ninputs):
                zeros = np.asarray(system[row, column].zeros(), dtype=complex)
                found.append(zeros[np.abs(zeros) < 1e6 * max(1.0, np.abs(system.A).max())])
    return np.concatenate(found)
