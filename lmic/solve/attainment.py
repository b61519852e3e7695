"""Whether an infimum is attained: the objective over growing bounds on the unknowns.

Diverging unknowns alone show nothing: they also diverge along directions that the objective does not
feel. Where each of the bounds binds and the objective falls from one to the next, it is not attained
within the largest of them; no computation tells of unknowns beyond.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.solve import scaling
from lmic.solve.cone import ConeData, ConeProblem, ConeSolver
from lmic.solve.passes import passes_of
from lmic.solve.solution import Solution
from lmic.solve.whole import judged

Array: TypeAlias = NDArray[Any]

#: bounds on the unknowns, one after another
RADII = (1e3, 1e4, 1e5, 1e6)
#: share of the bound from which an unknown has reached it
REACHED = 0.999


def with_attainment(problem: ConeProblem, found: Solution, solver: ConeSolver, passes: int) -> Solution:
    """The solution, or the best one within the last bound where no bound attains the infimum, and a word about it.

    Asked only where the answer is usable and leaves something to warn of: an attained optimum is
    found to all digits.
    """
    data = ConeData(problem.cost, problem.matrix, problem.offset, problem.orders)
    if not (problem.cost.any() and found.status.usable and found.warnings and scaling.affordable(data)):
        return found
    values: list[float] = []
    for radius in RADII:
        best, steps = passes_of(bounded(data, radius), solver, passes)
        reached = np.abs(best.x[data.cost == 0]).max(initial=0.0) >= REACHED * radius
        falls = not values or values[-1] - best.step.value > best.step.uncertainty * abs(best.step.value)
        if not best.answer.status.usable:
            return found
        if not (reached and falls):
            return replace(found, attained=True)
        values.append(best.step.value)
    within = judged(problem, best, best.x, found.passes + steps, found.lineality, solver)
    shown = ", ".join(
        f"{value + problem.constant:.9g} with |x| ≤ {radius:.0e}" for radius, value in zip(RADII, values, strict=True)
    )
    note = f"the infimum is not attained within |x| ≤ {RADII[-1]:.0e}: the objective falls as the bound grows, {shown}"
    return replace(within, bound=min(found.bound, within.bound), attained=False, warnings=(*within.warnings, note))


def bounded(data: ConeData, radius: float) -> ConeData:
    """The problem with |x_i| ≤ radius for every unknown that the objective does not hold."""
    free = sps.csc_array(sps.eye_array(len(data.cost)))[data.cost == 0]
    count = free.shape[0]
    return replace(
        data,
        matrix=sps.csc_array(sps.vstack([data.matrix, free, -free])),
        offset=np.concatenate([data.offset, np.full(2 * count, radius)]),
        orders=np.concatenate([data.orders, np.ones(2 * count, dtype=int)]),
    )
