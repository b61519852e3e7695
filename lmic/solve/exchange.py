"""Exchange: solve on few LMIs, check all of them at once, add the worst, drop the slack ones.

At an optimum only a few dozen LMIs bind. The optimum of the chosen ones is a lower bound on that
of all; when its solution violates none of the others it is the optimum of all.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.assemble import ConicProblem
from lmic.solve.cone import ConeSolver, Status
from lmic.solve.scaling import slack_matrices
from lmic.solve.solution import Pass, Solution
from lmic.solve.whole import PASSES, TRUSTED_VIOLATION, solve_whole

Array: TypeAlias = NDArray[Any]

#: LMIs of a family to begin with, and added after a round at the most
FIRST, ADDED = 8, 12
#: rounds at each effort after which the whole problem is solved instead
ROUNDS = 30
#: violation that the rough rounds still allow
ROUGH_VIOLATION = 1e-5
#: LMIs whose share of the dual is below this after the rough rounds are dropped
SHARE = 1e-5
#: matrices whose eigenvalues are computed in one call
BATCH = 8192


def solve_by_exchange(problem: ConicProblem, solver: ConeSolver, passes: int = PASSES) -> Solution:
    """The solution of all LMIs, by solving few at a time.

    First roughly (one pass of the solver, a loose tolerance), which finds the LMIs that bind; then
    with all passes and the tight tolerance on those, until none of the others is violated.
    """
    active = np.concatenate([_spread(start, count) for start, count in _ranges(problem)])
    steps: list[Pass] = []
    for effort, tolerance in ((1, ROUGH_VIOLATION), (passes, TRUSTED_VIOLATION)):
        for _ in range(ROUNDS):
            found = solve_whole(problem.restricted(active), solver, effort)
            steps += found.passes
            if not found.status.usable:
                break
            least = relative_eigenvalues(problem, found.x)
            violated = np.setdiff1d(np.flatnonzero(least < -tolerance), active)
            if not len(violated):
                break
            active = np.union1d(active, _worst_of_each(problem, violated, least))
        if found.status.usable and effort == 1:
            active = active[binding_lmis(problem.restricted(active), found)]
    if found.status is Status.INFEASIBLE:
        # infeasible already with few of the LMIs, so with all
        return replace(found, passes=tuple(steps), dual=_spread_dual(problem, active, found.dual))
    if not found.status.usable or len(violated):
        return solve_whole(problem, solver, passes)
    return _complete(problem, active, found, least, steps)


def binding_lmis(part: ConicProblem, found: Solution) -> Array:
    """Which LMIs carry the dual, each weighed in the units of its own slack."""
    weights = []
    duals = slack_matrices(found.dual, part.orders)
    matrices = slack_matrices(part.matrix @ found.x + part.offset, part.orders)
    for dual, matrix in zip(duals, matrices, strict=True):
        weights.append(float(np.diag(dual) @ np.abs(np.diag(matrix))))
    return np.array(weights) > SHARE * max(weights)


def relative_eigenvalues(problem: ConicProblem, x: Array) -> Array:
    """Least eigenvalue of every LMI at x, scaled to unit diagonal."""
    found = []
    for family in problem.families:
        for start in range(0, len(family), BATCH):
            matrices = family.subset(np.arange(start, min(start + BATCH, len(family)))).matrices(x)
            diagonal = np.abs(np.diagonal(matrices, axis1=1, axis2=2))
            floor = 1e-12 * diagonal.max(axis=1, keepdims=True)
            root = 1 / np.sqrt(np.maximum(diagonal, np.maximum(floor, np.finfo(float).tiny)))
            found.append(np.linalg.eigvalsh(root[:, :, None] * matrices * root[:, None, :])[:, 0])
    return np.concatenate(found)


def _ranges(problem: ConicProblem) -> list[tuple[int, int]]:
    """First LMI and number of LMIs of every family."""
    counts = [len(family) for family in problem.families]
    return list(zip(np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(int).tolist(), counts, strict=True))


def _spread(start: int, count: int) -> Array:
    return start + np.unique(np.linspace(0, count - 1, min(count, FIRST)).round().astype(int))


def _worst_of_each(problem: ConicProblem, violated: Array, least: Array) -> Array:
    """The worst violated LMIs of every family."""
    chosen = []
    for start, count in _ranges(problem):
        mine = violated[(violated >= start) & (violated < start + count)]
        chosen.append(mine[np.argsort(least[mine])[:ADDED]])
    return np.concatenate(chosen)


def _spread_dual(problem: ConicProblem, active: Array, dual: Array) -> Array:
    """The dual of the active LMIs as a dual of all: zero for the others."""
    if not len(dual):
        return dual
    rows = np.concatenate([np.arange(problem.starts[k], problem.starts[k + 1]) for k in active])
    full = np.zeros(int(problem.starts[-1]))
    full[rows] = dual
    return full


def _complete(problem: ConicProblem, active: Array, found: Solution, least: Array, steps: list[Pass]) -> Solution:
    """The answer for all LMIs: violations are those of the worst of all."""
    worst = int(np.argmin(least))
    inactive_worst = worst not in active
    return replace(
        found,
        relative_violation=min(found.relative_violation, float(least[worst]) if inactive_worst else 0.0),
        worst=problem.label(worst) if inactive_worst else found.worst,
        dual=_spread_dual(problem, active, found.dual),
        passes=tuple(steps),
    )
