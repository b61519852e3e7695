"""Exchange: solve on few LMIs, check all of them at once, drop the slack ones, add the worst.

At an optimum only a few dozen LMIs bind. The optimum of the chosen ones is a lower bound on that
of all; when its solution violates none of the others it is the optimum of all. LMIs that are convex
combinations of others (see :attr:`lmic.relax.family.LMIFamily.implying`) never need to be chosen.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.compiler.assemble import ConicProblem
from lmic.solve.cone import ConeSolver, Status
from lmic.solve.passes import PASSES, TRUSTED_VIOLATION
from lmic.solve.scaling import slack_matrices
from lmic.solve.solution import Pass, Solution
from lmic.solve.whole import solve_whole

Array: TypeAlias = NDArray[Any]

#: LMIs of a family to begin with, and added after a round at the most
FIRST, ADDED = 64, 12
#: rounds at each effort after which the whole problem is solved instead
ROUNDS = 30
#: violation that the rough rounds still allow
ROUGH_VIOLATION = 1e-5
#: LMIs whose share of the dual is below this, at either effort, are dropped; a rough dual is blurred
ROUGH_SHARE, SHARE = 1e-3, 1e-5
#: matrices whose eigenvalues are computed in one call
BATCH = 8192


def implying_lmis(problem: ConicProblem) -> Array:
    """Numbers of the LMIs that imply all."""
    starts = [start for start, _ in _ranges(problem)]
    return np.concatenate([start + family.implying for start, family in zip(starts, problem.families, strict=True)])


def solve_by_exchange(problem: ConicProblem, solver: ConeSolver, passes: int = PASSES) -> Solution:
    """The solution of all LMIs, by solving few at a time.

    First roughly (one pass of the solver, a loose tolerance), which finds the LMIs that bind; then
    with all passes and the tight tolerance on those, until none of the others is violated.
    """
    candidates = implying_lmis(problem)
    checked = problem.restricted(candidates)
    active = _first(problem)
    steps: list[Pass] = []
    near: Array | None = None
    highest = -np.inf
    for effort, tolerance, share in ((1, ROUGH_VIOLATION, ROUGH_SHARE), (passes, TRUSTED_VIOLATION, SHARE)):
        for _ in range(ROUNDS):
            part = problem.restricted(active)
            found = solve_whole(part, solver, effort, near)
            steps += found.passes
            if not found.status.usable:
                break
            least = relative_eigenvalues(checked, found.x)
            violated = np.flatnonzero(~np.isin(candidates, active) & (least < -tolerance))
            near = found.x if effort > 1 else None
            if not len(violated):
                break
            # with a value higher than ever before no choice of LMIs comes back
            if found.value > highest:
                highest, active = found.value, active[binding_lmis(part, found, share)]
            active = np.union1d(active, candidates[_worst_of_each(checked, violated, least)])
        if found.status.usable and effort == 1:
            active, near = active[binding_lmis(part, found, share)], found.x
    if found.status is Status.INFEASIBLE:
        # infeasible already with few of the LMIs, so with all
        return replace(found, passes=tuple(steps), dual=_spread_dual(problem, active, found.dual))
    if not found.status.usable or len(violated):
        return complete(problem, candidates, solve_whole(checked, solver, passes))
    return replace(complete(problem, active, found), passes=tuple(steps))


def complete(problem: ConicProblem, active: Array, found: Solution) -> Solution:
    """The answer for all LMIs from that for the ones numbered ``active``: violations are those of the worst of all."""
    if len(active) == len(problem.orders) or not found.status.usable:
        return replace(found, dual=_spread_dual(problem, active, found.dual))
    least = relative_eigenvalues(problem, found.x)
    worst = int(np.argmin(least))
    inactive_worst = worst not in active
    others = np.setdiff1d(np.flatnonzero(least < 0), active)
    return replace(
        found,
        on_face=None,  # it knows nothing of the others
        violation=min(found.violation, _least_eigenvalue(problem.restricted(others), found.x)),
        relative_violation=min(found.relative_violation, float(least[worst]) if inactive_worst else 0.0),
        worst=problem.label(worst) if inactive_worst else found.worst,
        dual=_spread_dual(problem, active, found.dual),
    )


def binding_lmis(part: ConicProblem, found: Solution, share: float = SHARE) -> Array:
    """Which LMIs carry more than a share of the dual, each weighed in the units of its own slack."""
    weights = []
    duals = slack_matrices(found.dual, part.orders)
    matrices = slack_matrices(part.matrix @ found.x + part.offset, part.orders)
    for dual, matrix in zip(duals, matrices, strict=True):
        weights.append(float(np.diag(dual) @ np.abs(np.diag(matrix))))
    return np.array(weights) > share * max(weights)


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


def _least_eigenvalue(problem: ConicProblem, x: Array) -> float:
    """Over all LMIs at x; zero without any."""
    found = [np.linalg.eigvalsh(family.matrices(x))[:, 0].min() for family in problem.families]
    return float(min(found, default=0.0))


def _ranges(problem: ConicProblem) -> list[tuple[int, int]]:
    """First LMI and number of LMIs of every family."""
    counts = [len(family) for family in problem.families]
    return list(zip(np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(int).tolist(), counts, strict=True))


def _first(problem: ConicProblem) -> Array:
    """The LMIs to begin with: at the corners of the domain, where most of those that bind are found."""
    chosen = []
    for (start, _), family in zip(_ranges(problem), problem.families, strict=True):
        ends = family.ends
        spread = np.unique(np.linspace(0, len(ends) - 1, min(len(ends), FIRST)).round().astype(int))
        chosen.append(start + ends[spread])
    return np.concatenate(chosen)


def _worst_of_each(problem: ConicProblem, violated: Array, least: Array) -> Array:
    """The worst violated LMIs of every family."""
    chosen = []
    for start, count in _ranges(problem):
        mine = violated[(violated >= start) & (violated < start + count)]
        chosen.append(mine[np.argsort(least[mine])[:ADDED]])
    return np.concatenate(chosen)


def _spread_dual(problem: ConicProblem, active: Array, dual: Array) -> Array:
    """The dual of the active LMIs as a dual of all: zero for the others."""
    if not len(dual) or len(active) == len(problem.orders):
        return dual
    rows = np.concatenate([np.arange(problem.starts[k], problem.starts[k + 1]) for k in active])
    full = np.zeros(int(problem.starts[-1]))
    full[rows] = dual
    return full
