"""Stage 6: solve a conic problem, whole or by exchange."""

from __future__ import annotations

from typing import Any, TypeAlias

from numpy.typing import NDArray

from lmic.assemble import ConicProblem
from lmic.solve.attainment import with_attainment
from lmic.solve.clarabel import Clarabel
from lmic.solve.cone import ConeSolver
from lmic.solve.exchange import solve_by_exchange
from lmic.solve.neighbour import solve_near
from lmic.solve.solution import Solution
from lmic.solve.whole import PASSES, solve_whole

Array: TypeAlias = NDArray[Any]

#: from this number of LMIs on, most of them do not bind and exchange is the faster way
EXCHANGE_FROM = 40


def solve(
    problem: ConicProblem, solver: ConeSolver | None = None, passes: int = PASSES, near: Array | None = None
) -> Solution:
    """Minimise, or find a point of largest margin where the theorem minimises nothing.

    ``near`` is the slack (svec, all LMIs) of a neighbouring problem's answer, whose coordinates may save passes.
    """
    if len(problem.orders) >= EXCHANGE_FROM:
        return solve_by_exchange(problem, solver or Clarabel(), passes)
    if near is not None and problem.cost.any() and (found := solve_near(problem, near, solver)):
        return found
    solver = solver or Clarabel()
    return with_attainment(problem, solve_whole(problem, solver, passes), solver, passes)
