"""Solve a problem in the coordinates that a neighbouring problem's answer suggests.

The rough first pass of a solution from nothing only looks for coordinates. Along a sweep the last point's
slack knows them already. What comes out is measured on the problem itself like any other answer, and
where it does not settle, nothing is returned and the solution begins from nothing.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.solve import scaling
from lmic.solve.clarabel import Clarabel
from lmic.solve.cone import ConeData, ConeProblem, ConeSolver
from lmic.solve.lineality import lineality
from lmic.solve.passes import passes_of, svec_diagonal
from lmic.solve.solution import Solution
from lmic.solve.whole import judged

Array: TypeAlias = NDArray[Any]

#: passes before the neighbour is given up
PASSES = 4
#: in coordinates as good as these Clarabel's own scaling and the refinement of its steps cost time for nothing
COORDINATED = {"equilibrate_enable": False, "iterative_refinement_enable": False}
#: share of diag S by which the neighbour's slack is moved into the cone: at its own optimum it is singular
INWARDS = 0.1
#: violation (a thousandfold) and relative uncertainty up to which the answer counts
SETTLED = 1e-8


def solve_near(problem: ConeProblem, slack: Array, solver: ConeSolver) -> Solution | None:
    """The solution, begun in the coordinates of ``slack`` (svec, all LMIs); None where that does not settle it."""
    if isinstance(solver, Clarabel):
        solver = Clarabel(**{**COORDINATED, **solver.settings})
    data = ConeData(problem.cost, problem.matrix, problem.offset, problem.orders)
    if slack.shape != data.offset.shape or not np.isfinite(slack).all() or not scaling.affordable(data):
        return None
    directions = lineality(data.matrix)
    if directions.unseen(data.cost):
        return None
    kept = directions.kept
    reduced = ConeData(data.cost[kept], data.matrix[:, kept], data.offset, data.orders)
    guide = slack + INWARDS * svec_diagonal(slack, data.orders)
    best, steps = passes_of(reduced, solver, PASSES, guide=guide, settled=SETTLED)
    if not best.answer.status.usable or not best.merit <= SETTLED:
        return None
    x = np.zeros(problem.size)
    x[kept] = best.x
    return judged(problem, best, x, steps, len(directions.left_out), solver)
