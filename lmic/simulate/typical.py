"""A simulation for a first look: a pulse at every input, from rest, while the parameters take a walk."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.analysis.walk import Walk, walk
from lmic.language.parameters import NEXT
from lmic.language.systems import DiscreteSystem, FornasiniMarchesini
from lmic.pipeline import Result
from lmic.simulate.discrete import simulate_discrete
from lmic.simulate.plane import simulate_plane
from lmic.simulate.trajectory import Trajectory

Array: TypeAlias = NDArray[Any]

#: steps, and places along each side of a plane
STEPS, SIDE = 60, 40
#: the pulse: from this step or place on, and how long
START, LENGTH = 3, 12


def typical(result: Result) -> Trajectory | None:
    """The first guarantee's system; None for systems whose motion the theorem does not fix, as one with delays."""
    guarantees = result.theorem.guarantees
    system = guarantees[0].system if guarantees else None
    path = walk(result.problem.binding.domains)
    if isinstance(system, DiscreteSystem):
        parameters = parameters_along(result, path, STEPS)
        w = _pulse(np.zeros((STEPS, _inputs(result, system, path))))
        state, z = simulate_discrete(result.design, system, w, parameters)
        others = {
            name: simulate_discrete(result.design, other, w, parameters)[1]
            for name, other in result.theorem.signals.items()
            if isinstance(other, DiscreteSystem)
        }
        return Trajectory(w, z, state, parameters, others)
    if isinstance(system, FornasiniMarchesini):
        line = parameters_along(result, path, 2 * SIDE - 1)
        diagonal = np.add.outer(np.arange(SIDE), np.arange(SIDE))
        parameters = {name: values[diagonal] for name, values in line.items()}
        w = np.zeros((SIDE, SIDE, _inputs(result, system, path)))
        w[START : START + LENGTH] = _pulse(w[START : START + LENGTH].swapaxes(0, 1)).swapaxes(0, 1)
        state, z = simulate_plane(result.design, system, w, parameters)
        return Trajectory(w, z, state, parameters, {})
    return None


def parameters_along(result: Result, path: Walk, steps: int) -> dict[str, Array]:
    """The parameters over the steps, each (steps, components): along the walk, no faster than they may move.

    They rest at the centre of their domain where the problem ties instances to one another.
    """
    binding = result.problem.binding
    bounds = {name: _step(result, name) for name in path.points}
    if len(path) == 1 or result.problem.relaxation.ties or "constant" in bounds.values():
        return {name: np.tile(d.vertices.mean(axis=0), (steps, 1)) for name, d in binding.domains.items()}
    # the least time for each piece of the walk, in steps
    needed = np.full(len(path) - 1, 1e-9)
    for name, values in path.points.items():
        if bounds[name] == "free":
            continue
        ends = [np.abs(np.asarray(bounds[name][c], dtype=float)).min() for c in binding.domains[name].components]
        needed = np.maximum(needed, (np.abs(np.diff(values, axis=0)) / np.maximum(ends, 1e-12)).max(axis=1))
    times = np.concatenate([[0.0], np.cumsum(needed)])
    times *= max(1.0, (steps - 1) / times[-1])
    return {
        name: np.column_stack([np.interp(np.arange(steps), times, column) for column in values.T])
        for name, values in path.points.items()
    }


def _step(result: Result, name: str) -> Any:
    """How far a parameter may move in a step: "free", "constant" or bounds."""
    motion = result.problem.binding.plant.motions.get(name)
    if motion is not None and motion.step is not None:
        return motion.step
    stated = [parameter.step for parameter in result.problem.binding.instances[name] if parameter.step]
    later = any(parameter.instance == NEXT for parameter in result.problem.binding.instances[name])
    return stated[0] if stated else "constant" if later else "free"


def _pulse(signal: Array) -> Array:
    """Ones in the place of the pulse on the first axis."""
    found = signal.copy()
    found[START : START + LENGTH] = 1.0
    return found


def _inputs(result: Result, system: Any, path: Walk) -> int:
    first = {name: values[:1] for name, values in path.points.items()}
    matrices = result.design.frozen(system, first)
    return int(matrices["B" if "B" in matrices else "B1"].shape[-1])
