"""Which unknown diverges: the size of each at the answer, and within growing bounds on all of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.compiler.assemble import ConicProblem
from lmic.solve import scaling
from lmic.solve.attainment import RADII, bounded
from lmic.solve.cone import ConeData, ConeSolver
from lmic.solve.lineality import lineality
from lmic.solve.passes import passes_of
from lmic.solve.solution import ABSOLUTE

Array: TypeAlias = NDArray[Any]

#: growth, as a power of the bound, from which an unknown diverges
DIVERGES = 0.5
#: relative fall of the objective from one bound to the next that counts
FALLS = 1e-6
#: passes within a bound: magnitudes are wanted, not digits
PASSES = 3


@dataclass(frozen=True)
class Growth:
    """The largest entry of an unknown, in its own units.

    ``within[r]`` is the same under the bound r of :class:`Bounds`; ``power`` is p where that grows like
    boundᵖ between the last two. An unknown that the objective is made of is not bounded.
    """

    unknown: str
    largest: float
    within: tuple[float, ...] = ()
    power: float = 0.0

    @property
    def diverges(self) -> bool:
        """Whether it follows the bound."""
        return self.power >= DIVERGES


@dataclass(frozen=True)
class Bounds:
    """The unknowns' sizes, and the objective within each bound; no bounds where they were not tried."""

    growths: tuple[Growth, ...]
    bounds: tuple[float, ...] = ()
    objectives: tuple[float, ...] = ()

    @property
    def diverging(self) -> tuple[Growth, ...]:
        """The unknowns that follow the bound, the fastest first."""
        return tuple(sorted((one for one in self.growths if one.diverges), key=lambda one: -one.power))

    @property
    def falls(self) -> bool:
        """Whether the objective still falls when the last bound is raised."""
        if len(self.objectives) < 2:
            return False
        before, after = self.objectives[-2:]
        return before - after > FALLS * max(abs(after), ABSOLUTE)


def growth(problem: ConicProblem, x: Array, solver: ConeSolver) -> Bounds:
    """The sizes at x and within bounds of 1e3, 1e4 and 1e5 on every unknown that the objective does not hold.

    Where a problem minimises nothing, or is too large for dense columns, only the sizes at x.
    """
    # a direction that no LMI sees would follow any bound
    kept = lineality(problem.matrix).kept
    data = ConeData(problem.cost[kept], problem.matrix[:, kept], problem.offset, problem.orders)
    largest = _sizes(problem, x)
    if not problem.cost.any() or not scaling.affordable(data):
        return Bounds(tuple(Growth(name, size) for name, size in largest.items()))
    bounds, objectives, sizes = [], [], []
    for radius in RADII[:-1]:
        best, _ = passes_of(bounded(data, radius), solver, PASSES)
        if not best.answer.status.usable:  # the bound leaves no solution
            continue
        bounds.append(radius)
        objectives.append(best.step.value + problem.constant)
        whole = np.zeros(problem.size)
        whole[kept] = best.x
        sizes.append(_sizes(problem, whole))
    found = []
    for name, size in largest.items():
        within = tuple(one[name] for one in sizes)
        found.append(Growth(name, size, within, _power(bounds, within)))
    return Bounds(tuple(found), tuple(bounds), tuple(objectives))


def _sizes(problem: ConicProblem, x: Array) -> dict[str, float]:
    return {
        name: float(np.abs(x[unknown.columns]).max(initial=0.0)) for name, unknown in problem.layout.unknowns.items()
    }


def _power(bounds: list[float], within: tuple[float, ...]) -> float:
    """The logarithmic slope between the last two bounds."""
    if len(within) < 2 or min(within[-2:]) <= 0:
        return 0.0
    return float(np.log(within[-1] / within[-2]) / np.log(bounds[-1] / bounds[-2]))
