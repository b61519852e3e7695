"""Stage 6: solve a conic problem, whole or by exchange, with one solver after another until one has an answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, TypeAlias

from numpy.typing import NDArray

from lmic.compiler.assemble import ConicProblem
from lmic.errors import SolverError
from lmic.solve.attainment import with_attainment
from lmic.solve.cone import ConeProblem, ConeSolver, Status
from lmic.solve.exchange import complete, implying_lmis, solve_by_exchange
from lmic.solve.neighbour import solve_near
from lmic.solve.passes import PASSES
from lmic.solve.registry import solvers
from lmic.solve.solution import Solution
from lmic.solve.whole import solve_whole

Array: TypeAlias = NDArray[Any]

#: from this number of LMIs on, most of them do not bind and exchange is the faster way
EXCHANGE_FROM = 40


def solve(
    problem: ConeProblem,
    solver: ConeSolver | Sequence[ConeSolver] | None = None,
    passes: int = PASSES,
    near: Array | None = None,
) -> Solution:
    """Minimise, or find a point of largest margin where the theorem minimises nothing.

    Of several solvers the next is asked where one fails, and ``Solution.handovers`` keeps the reasons.
    That a problem is infeasible or unbounded is an answer, and so is a number that is not to be trusted.
    ``near`` is the slack (svec, all LMIs) of a neighbouring problem's answer, whose coordinates may save
    passes. Raises SolverError where none of the solvers could run.
    """
    several = solvers() if solver is None else tuple(solver) if isinstance(solver, Sequence) else (solver,)
    reasons: list[str] = []
    failed: Solution | None = None
    for one in several:
        try:
            found = _solved(problem, one, passes, near)
        except SolverError as error:
            reasons.append(f"{one.name}: {error}")
            continue
        if found.status is not Status.FAILED:
            return replace(found, handovers=tuple(reasons))
        reasons.append(f"{one.name} ended with '{found.passes[-1].word}'")
        failed = failed or found
    if failed is None:
        raise SolverError(f"no solver could run: {'; '.join(reasons)}")
    return replace(failed, handovers=tuple(reasons) if len(several) > 1 else ())


def _solved(problem: ConeProblem, solver: ConeSolver, passes: int, near: Array | None) -> Solution:
    """The answer of one solver; only a compiled problem has families, within which some LMIs imply others."""
    if not isinstance(problem, ConicProblem):
        return with_attainment(problem, solve_whole(problem, solver, passes), solver, passes)
    implying = implying_lmis(problem)
    if len(implying) >= EXCHANGE_FROM:
        return solve_by_exchange(problem, solver, passes)
    if near is not None and problem.cost.any() and (found := solve_near(problem, near, solver)):
        return found
    needed = problem if len(implying) == len(problem.orders) else problem.restricted(implying)
    return complete(problem, implying, with_attainment(needed, solve_whole(needed, solver, passes), solver, passes))
