"""A recovered filter or controller as python-control systems, one for each frozen parameter."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.errors import Place, RecoveryError
from lmic.language.systems import ContinuousSystem, DelaySystem, DiscreteSystem
from lmic.recover.recover import Design

Array: TypeAlias = NDArray[Any]

#: a recovered matrix of a state-space system: its letter, and what several systems are told apart by
_MATRIX = re.compile(r"([ABCD])(_?[A-Za-z]*)")


def state_spaces(design: Design, **parameters: Any) -> list[Any]:
    """The recovered system as a ``control.StateSpace`` at each of K frozen parameter values.

    The recovered matrices A, B, C and D (zero where the theorem has none) of one name, such as A_F to
    D_F, make the system; a theorem that recovers one matrix alone makes a static gain of it. Discrete
    time has the step ``True``: the theorem does not know its length. Raises RecoveryError for 2-D
    systems, whose matrices ``design(...)`` gives as plain arrays.
    """
    import control

    place = Place(design.binding.theorem.name)
    stacks = {name: np.asarray(matrix) for name, matrix in _stacks(design, parameters).items()}
    step = _step(design)
    if len(stacks) == 1:
        (gains,) = stacks.values()
        return [control.ss([], [], [], gain, step) for gain in gains]
    matched = {name: _MATRIX.fullmatch(name) for name in stacks}
    suffixes = {found[2] for found in matched.values() if found}
    letters = {found[1]: stacks[name] for name, found in matched.items() if found}
    if len(suffixes) != 1 or not set("ABC") <= set(letters) or len(letters) != len(stacks):
        names = ", ".join(stacks) or "nothing"
        raise RecoveryError(
            f"the theorem recovers {names}, which is no system x⁺ = A x + B u, y = C x + D u; "
            "take the matrices from design(...)",
            place,
        )
    zeros = np.zeros((len(letters["A"]), letters["C"].shape[1], letters["B"].shape[2]))
    quadruples = zip(letters["A"], letters["B"], letters["C"], letters.get("D", zeros), strict=True)
    return [control.ss(A, B, C, D, step) for A, B, C, D in quadruples]


def _stacks(design: Design, parameters: Mapping[str, Any]) -> dict[str, Array]:
    """The recovered matrices, each of shape (K, rows, cols)."""
    found = {name: design.at(node, parameters) for name, node in design.binding.theorem.recover.items()}
    length = max((len(matrix) for matrix in found.values()), default=1)
    return {name: np.broadcast_to(matrix, (length, *matrix.shape[1:])) for name, matrix in found.items()}


def _step(design: Design) -> Any:
    """True in discrete time, 0 in continuous time, None where the theorem does not say."""
    systems = [bound.system for bound in design.binding.theorem.guarantees]
    if any(isinstance(system, (DiscreteSystem, DelaySystem)) for system in systems):
        return True
    return 0 if any(isinstance(system, ContinuousSystem) for system in systems) else None
