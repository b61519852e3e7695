"""Stage 6: solve a conic problem, whole or by exchange."""

from __future__ import annotations

from lmic.assemble import ConicProblem
from lmic.solve.attainment import with_attainment
from lmic.solve.clarabel import Clarabel
from lmic.solve.cone import ConeSolver
from lmic.solve.exchange import complete, implying_lmis, solve_by_exchange
from lmic.solve.solution import Solution
from lmic.solve.whole import PASSES, solve_whole

#: from this number of LMIs on, most of them do not bind and exchange is the faster way
EXCHANGE_FROM = 40


def solve(problem: ConicProblem, solver: ConeSolver | None = None, passes: int = PASSES) -> Solution:
    """Minimise, or find a point of largest margin where the theorem minimises nothing."""
    solver = solver or Clarabel()
    implying = implying_lmis(problem)
    if len(implying) >= EXCHANGE_FROM:
        return solve_by_exchange(problem, solver, passes)
    needed = problem if len(implying) == len(problem.orders) else problem.restricted(implying)
    return complete(problem, implying, with_attainment(needed, solve_whole(needed, solver, passes), solver, passes))
