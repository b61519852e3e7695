"""Solve all LMIs of a problem at once: reduce, solve, rescale by the answer, solve again, judge."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.solve import scaling
from lmic.solve.cone import ConeData, ConeProblem, ConeSolver, Status
from lmic.solve.lineality import lineality
from lmic.solve.on_face import solve_on_face
from lmic.solve.passes import PASSES, ROUNDING, TRUSTED_GAP, TRUSTED_VIOLATION, Candidate, passes_of, worst_of
from lmic.solve.solution import TRUSTED_UNCERTAINTY, Pass, Solution
from lmic.solve.vanishing import vanishing

Array: TypeAlias = NDArray[Any]

#: a feasible point has least eigenvalues above this, relative to the diagonal
STRICT = 1e-11
#: relative eigenvalue down to which a direction of growth is one
RAY = 1e-6
#: a largest margin up to this means that there is none
NO_MARGIN = 1e-8
#: bound on the sum of traces in a search for the largest margin, per unit of order and data
TRACE_LIMIT = 1e4


def solve_whole(problem: ConeProblem, solver: ConeSolver, passes: int = PASSES, near: Array | None = None) -> Solution:
    """Minimise; where the theorem minimises nothing, find the point of largest margin.

    ``near`` is a point close to the solution, in whose coordinates to begin.
    """
    if not problem.cost.any():
        return _feasibility(problem, solver, passes)
    data = ConeData(problem.cost, problem.matrix, problem.offset, problem.orders)
    directions = lineality(data.matrix)
    kept, unseen = directions.kept, len(directions.left_out)
    if directions.unseen(data.cost):
        return _without_answer(problem, Status.UNBOUNDED, solver, unseen, ())
    reduced = replace(data, cost=data.cost[kept], matrix=data.matrix[:, kept])
    guide = None if near is None else data.matrix @ near + data.offset
    best, steps = _solved(reduced, guide, solver, passes)
    # a problem without a solution may end in an answer of which no digit is known
    doubtful = best.answer.status in (Status.INFEASIBLE, Status.FAILED)
    if doubtful or (best.answer.status.usable and best.step.uncertainty > TRUSTED_UNCERTAINTY):
        feasible = margin(problem, solver, passes)
        if feasible.bound <= NO_MARGIN:
            found = _without_answer(problem, Status.INFEASIBLE, solver, unseen, steps)
            return replace(found, dual=feasible.dual)
        if feasible.value > NO_MARGIN and np.isfinite(feasible.x).all():
            # there is a point after all: begin again in its coordinates
            slack = data.matrix @ feasible.x + data.offset
            again, more = passes_of(reduced, solver, passes, guide=slack)
            best, steps = again if doubtful or again.merit < best.merit else best, steps + more
    if best.answer.status is Status.UNBOUNDED and _is_ray(reduced, best.x):
        return _without_answer(problem, Status.UNBOUNDED, solver, unseen, steps)
    x = np.zeros(problem.size)
    x[kept] = best.x
    return judged(problem, best, x, steps, unseen, solver)


def _solved(
    reduced: ConeData, guide: Array | None, solver: ConeSolver, passes: int
) -> tuple[Candidate, tuple[Pass, ...]]:
    """All passes; on a face of the dual too where they leave doubt, and first where they cost too much."""
    affordable = scaling.affordable(reduced)
    first = None if affordable else solve_on_face(reduced, solver, passes)
    if first and first[0].step.uncertainty <= TRUSTED_UNCERTAINTY:
        return first
    best, steps = passes_of(reduced, solver, passes, guide=guide)
    doubtful = affordable and passes > 1 and best.answer.status.usable and best.merit > TRUSTED_GAP
    other = solve_on_face(reduced, solver, passes) if doubtful else first
    if other is None:
        return best, steps
    return min(other[0], best, key=lambda one: one.merit), steps + other[1]


def margin(problem: ConeProblem, solver: ConeSolver, passes: int = PASSES) -> Solution:
    """The largest t ≤ 1 for which some x has F_k(x) ⪰ t·I for all k, and that x.

    Positive means strictly feasible. The sum of the traces is bounded, so that a condition
    homogeneous in its unknowns has a bounded set of solutions.
    """
    identity = np.concatenate([svec.identity(int(order)) for order in problem.orders])
    matrix, offset = problem.matrix, problem.offset
    limit = TRACE_LIMIT * (problem.orders.sum() + np.abs(offset).sum())
    trace = sps.csc_array(-(matrix.T @ identity)[None, :])
    left = sps.vstack([matrix, sps.csc_array((1, problem.size)), trace])
    right = sps.csc_array(np.concatenate([-identity, [-1.0, 0.0]])[:, None])
    data = ConeData(
        np.concatenate([np.zeros(problem.size), [-1.0]]),
        sps.csc_array(sps.hstack([left, right])),
        np.concatenate([offset, [1.0, limit - offset @ identity]]),
        np.concatenate([problem.orders, [1, 1]]),
    )
    kept = lineality(data.matrix).kept

    def decided(candidate: Candidate) -> bool:
        """A strictly feasible point, or a dual that shows there is none: more passes can only lose that."""
        point = np.zeros(problem.size + 1)
        point[kept] = candidate.x
        if point[-1] > NO_MARGIN and _strictly_feasible(problem, point[:-1]):
            return True
        return candidate.answer.status.usable and -candidate.step.bound <= NO_MARGIN

    reduced = replace(data, cost=data.cost[kept], matrix=data.matrix[:, kept])
    best, steps = passes_of(reduced, solver, passes, decided)
    x = np.zeros(problem.size + 1)
    x[kept] = best.x
    found = judged(problem, best, x[:-1], steps, problem.size + 1 - len(kept), solver)
    return replace(found, value=float(x[-1]), bound=-best.step.bound, dual=best.dual[:-2])


def _feasibility(problem: ConeProblem, solver: ConeSolver, passes: int) -> Solution:
    """A strictly feasible point; what was measured at it decides, not the solver's word."""
    found = margin(problem, solver, passes)
    packed = problem.matrix @ found.x + problem.offset
    least, relative, place = worst_of(packed, packed, problem.orders, vanishing(packed, found.x, problem, ROUNDING))
    measured = replace(
        found, violation=min(least, 0.0), relative_violation=min(relative, 0.0), worst=problem.label(place)
    )
    if _strictly_feasible(problem, found.x):
        return replace(measured, status=Status.SOLVED, value=0.0, bound=0.0, price=0.0, warnings=())
    if found.bound <= NO_MARGIN:
        return replace(measured, status=Status.INFEASIBLE, warnings=(Status.INFEASIBLE.advice,))
    doubt = f"the largest margin found is {found.value:.1e}, and positive definiteness does not stand out from rounding"
    return replace(measured, status=Status.ALMOST, value=0.0, bound=0.0, price=0.0, warnings=(doubt,))


def _strictly_feasible(problem: ConeProblem, x: Array) -> bool:
    """Whether every F_k(x) is positive definite by more than its own rounding.

    Where large unknowns cancel, a small positive eigenvalue may be rounding and nothing else.
    """
    matrix, offset = problem.matrix, problem.offset
    values = scaling.slack_matrices(matrix @ x + offset, problem.orders)
    sizes = scaling.slack_matrices(abs(matrix) @ np.abs(x) + np.abs(offset), problem.orders)
    for value, size in zip(values, sizes, strict=True):
        diagonal = np.diag(value)
        if not np.isfinite(value).all() or not (diagonal > 0).all():
            return False
        root = 1 / np.sqrt(diagonal)
        rounding = ROUNDING * len(value) * np.linalg.norm(root[:, None] * size * root)
        if np.linalg.eigvalsh(root[:, None] * value * root)[0] <= max(STRICT, rounding):
            return False
    return True


def _is_ray(data: ConeData, direction: Array) -> bool:
    """Whether the objective falls along a direction in which every F_k grows: a proof of unboundedness."""
    growth = data.matrix @ direction
    size = np.linalg.norm(growth) + np.finfo(float).tiny
    least = min(float(np.linalg.eigvalsh(matrix)[0]) for matrix in scaling.slack_matrices(growth / size, data.orders))
    return bool(data.cost @ direction < 0 and least > -RAY)


def judged(
    problem: ConeProblem, best: Candidate, x: Array, steps: tuple[Pass, ...], unseen: int, solver: ConeSolver
) -> Solution:
    """Measure the answer on the problem itself and say what is wrong with it."""
    rows = int(problem.starts[-1])
    slack = best.slack[:rows]
    floors = vanishing(slack, x, problem, ROUNDING)
    least, relative, place = worst_of(problem.matrix @ x + problem.offset, slack, problem.orders, floors)
    found = Solution(
        status=best.answer.status,
        x=x,
        value=float(problem.cost @ x) + problem.constant,
        bound=best.step.bound + problem.constant,
        price=best.step.price,
        violation=min(least, 0.0),
        relative_violation=min(relative, 0.0),
        worst=problem.label(place),
        dual=best.dual[:rows],
        on_face=best.on_face,
        lineality=unseen,
        solver=solver.name,
        passes=steps,
        warnings=(),
    )
    warnings = _warnings(found)
    # the solver's word says little in either direction: what was measured decides, and a claim of
    # infeasibility or unboundedness that gets here has not stood its test
    measured = Status.ALMOST if warnings else Status.SOLVED
    status = measured if found.status.usable else Status.FAILED
    return replace(found, status=status, warnings=warnings)


def _warnings(found: Solution) -> tuple[str, ...]:
    warnings = []
    if not found.status.usable:
        warnings.append(f"the solver ended with '{found.passes[-1].word}': {found.status.advice}")
    if found.relative_violation < -TRUSTED_VIOLATION:
        warnings.append(
            f"the LMI '{found.worst}' is violated by {-found.relative_violation:.1e} relative to its diagonal, "
            f"so the number is no bound; mending that would raise the objective by about {found.price:.1e}"
        )
    if found.gap > TRUSTED_GAP:
        warnings.append(
            f"primal and dual objective differ by {found.gap:.1e} (relative), so the digits beyond that are not known"
        )
    return tuple(warnings)


def _without_answer(
    problem: ConeProblem, status: Status, solver: ConeSolver, unseen: int, steps: tuple[Pass, ...]
) -> Solution:
    value = np.inf if status is Status.INFEASIBLE else -np.inf
    empty = np.full(problem.size, np.nan)
    return Solution(
        status,
        empty,
        value,
        value,
        np.inf,
        -np.inf,
        -np.inf,
        "",
        np.zeros(0),
        unseen,
        solver.name,
        steps,
        (status.advice,),
    )
