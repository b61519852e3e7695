"""Solve all LMIs of a problem at once: reduce, solve, rescale by the answer, solve again, judge."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.solve import scaling
from lmic.solve.cone import ConeAnswer, ConeData, ConeProblem, ConeSolver, Status
from lmic.solve.lineality import lineality
from lmic.solve.solution import ABSOLUTE, TRUSTED_UNCERTAINTY, Pass, Solution
from lmic.solve.vanishing import lifted, vanishing

Array: TypeAlias = NDArray[Any]

#: passes of rescaling and solving again
PASSES = 6
#: beyond this relative violation or this relative gap there is something to warn of
TRUSTED_VIOLATION = 1e-9
TRUSTED_GAP = 1e-7
#: a feasible point has least eigenvalues above this, relative to the diagonal
STRICT = 1e-11
#: rounding of one entry, relative to the sum of the sizes that make it up
ROUNDING = 16 * np.finfo(float).eps
#: relative eigenvalue down to which a direction of growth is one
RAY = 1e-6
#: a largest margin up to this means that there is none
NO_MARGIN = 1e-8
#: bound on the sum of traces in a search for the largest margin, per unit of order and data
TRACE_LIMIT = 1e4
#: the largest margin asked for at first, relative to the slack's diagonal: a wild answer says nothing of what is needed
FIRST_MARGIN = 1e-6
#: growth of the margin, from the violation on, while an answer leaves a cone
RETREAT = 4.0
#: passes stop when violation and gap are within this (see _Candidate.merit)
SETTLED = 1e-9


@dataclass(frozen=True)
class _Candidate:
    step: Pass
    answer: ConeAnswer
    x: Array
    slack: Array
    dual: Array

    @property
    def merit(self) -> float:
        """Worst of violation and uncertainty, each relative; the smaller the better.

        A violation counts a thousandfold: it spoils the bound, which a gap does not.
        """
        uncertainty = self.step.uncertainty
        return max(1e3 * self.step.violation, uncertainty) if np.isfinite(uncertainty) else np.inf


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
    best, steps = passes_of(reduced, solver, passes, guide=guide)
    doubtful = best.answer.status in (Status.INFEASIBLE, Status.FAILED)
    if doubtful:
        feasible = margin(problem, solver, passes)
        if feasible.bound <= NO_MARGIN:
            found = _without_answer(problem, Status.INFEASIBLE, solver, unseen, steps)
            return replace(found, dual=feasible.dual)
        if feasible.value > NO_MARGIN and np.isfinite(feasible.x).all():
            # there is a point after all: begin again in its coordinates
            slack = data.matrix @ feasible.x + data.offset
            best, more = passes_of(reduced, solver, passes, guide=slack)
            steps += more
    if best.answer.status is Status.UNBOUNDED and _is_ray(reduced, best.x):
        return _without_answer(problem, Status.UNBOUNDED, solver, unseen, steps)
    x = np.zeros(problem.size)
    x[kept] = best.x
    return judged(problem, best, x, steps, unseen, solver)


def margin(problem: ConeProblem, solver: ConeSolver, passes: int = PASSES) -> Solution:
    """The largest t ≤ 1 for which some x has F_k(x) ⪰ t·I for all k, and that x.

    Positive means strictly feasible. The sum of the traces is bounded, so that a condition
    homogeneous in its unknowns has a bounded set of solutions.
    """
    identity = np.concatenate([svec_identity(int(order)) for order in problem.orders])
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

    def decided(candidate: _Candidate) -> bool:
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
    least, relative, place = _worst(packed, packed, problem.orders, vanishing(packed, found.x, problem, ROUNDING))
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


def svec_identity(order: int) -> Array:
    """svec of the identity."""
    diagonal = np.arange(order)
    vector = np.zeros(order * (order + 1) // 2)
    vector[diagonal * (diagonal + 3) // 2] = 1.0
    return vector


def svec_diagonal(packed: Array, orders: Array) -> Array:
    """The diagonals of the matrices of an svec vector, zero elsewhere."""
    return packed * np.concatenate([svec_identity(int(order)) for order in orders])


def passes_of(
    data: ConeData,
    solver: ConeSolver,
    passes: int,
    enough: Callable[[_Candidate], bool] | None = None,
    guide: Array | None = None,
    settled: float = SETTLED,
) -> tuple[_Candidate, tuple[Pass, ...]]:
    """Solve, rescale by the answer, solve again, until violation and gap are ``settled`` or ``enough`` says so.

    ``guide`` is a slack whose coordinates to begin in. Where dense columns cost too much the
    coordinates stay as they are.
    """
    if not scaling.affordable(data):
        return _retreat(data, solver, passes)
    scaled, transform = scaling.initial(data) if guide is None else scaling.rescaled(data, guide)
    found: list[_Candidate] = []
    for number in range(passes):
        rough = number == 0 and guide is None
        candidate = _candidate(data, scaled, transform, solver(scaled, rough=rough))
        found.append(candidate)
        if enough and enough(candidate):
            return candidate, tuple(one.step for one in found)
        if number == 0 and candidate.answer.status in (Status.INFEASIBLE, Status.UNBOUNDED):
            break
        if not rough and _best(found).merit <= settled:
            break
        if number + 1 == passes:
            break
        # an answer that is no answer says nothing of the right coordinates
        nearest = candidate if np.isfinite(candidate.slack).all() else _best(found)
        if not np.isfinite(nearest.slack).all():
            break
        scaled, transform = scaling.rescaled(
            data, lifted(nearest.slack, vanishing(nearest.slack, nearest.x, data, ROUNDING), data.orders)
        )
    return _best(found), tuple(one.step for one in found)


def _retreat(data: ConeData, solver: ConeSolver, passes: int) -> tuple[_Candidate, tuple[Pass, ...]]:
    """Solve in sparse coordinates; while the answer leaves a cone, ask for a share of diag S as margin."""
    scaled, transform = scaling.initial(data)
    found = [_candidate(data, scaled, transform, solver(scaled))]
    diagonal = svec_diagonal(found[0].slack, data.orders)
    share = min(found[0].step.violation, FIRST_MARGIN)
    while len(found) < passes and found[-1].answer.status.usable and found[-1].step.violation > SETTLED:
        margin = share * diagonal
        answer = solver(replace(scaled, offset=scaled.offset - margin))
        found.append(_candidate(data, scaled, transform, replace(answer, s=answer.s + margin)))
        share *= RETREAT
    best, last = _best(found), found[-1]
    # a point inside the cones is worth more than digits that it costs, or that are not known without it either
    inside = last.answer.status.usable and last.step.violation <= SETTLED
    known = [step.uncertainty <= TRUSTED_UNCERTAINTY for step in (last.step, best.step)]
    return last if inside and (known[0] or not known[1]) else best, tuple(one.step for one in found)


def _is_ray(data: ConeData, direction: Array) -> bool:
    """Whether the objective falls along a direction in which every F_k grows: a proof of unboundedness."""
    growth = data.matrix @ direction
    size = np.linalg.norm(growth) + np.finfo(float).tiny
    least = min(float(np.linalg.eigvalsh(matrix)[0]) for matrix in scaling.slack_matrices(growth / size, data.orders))
    return bool(data.cost @ direction < 0 and least > -RAY)


def _best(found: list[_Candidate]) -> _Candidate:
    """The candidate of least merit among those whose bound no feasible candidate contradicts."""
    values = [one.step.value for one in found if one.step.violation <= TRUSTED_VIOLATION]
    least = min(values, default=np.inf)
    least += TRUSTED_GAP * max(abs(least), ABSOLUTE)
    sound = [one for one in found if not one.step.bound > least]
    return min(sound or found, key=lambda one: one.merit)


def _candidate(data: ConeData, scaled: ConeData, transform: scaling.Scaling, answer: ConeAnswer) -> _Candidate:
    """An answer to the scaled problem, taken back to ``data`` and measured there."""
    x = transform.x(answer.y)
    slack = scaling.unscaled_slack(answer.s, transform, data.orders)
    dual = scaling.unscaled_dual(answer.z, transform, data.orders)
    relative = _worst(data.matrix @ x + data.offset, slack, data.orders, vanishing(slack, x, data, ROUNDING))[1]
    # where the dual misses its equalities it bounds less: charge the miss, weighed with this y
    miss = float(np.abs(scaled.matrix.T @ answer.z - scaled.cost) @ np.abs(answer.y))
    bound = float(-data.offset @ dual) - miss
    violation = max(0.0, -relative)
    # what it would cost to go back into the cones by that much of every diagonal, to first order
    price = violation * float(svec_diagonal(slack, data.orders) @ dual)
    step = Pass(answer.word, answer.iterations, float(data.cost @ x), bound, violation, price)
    return _Candidate(step, answer, x, slack, dual)


def _worst(packed: Array, slack: Array, orders: Array, floors: Array) -> tuple[float, float, int]:
    """Least eigenvalue, least eigenvalue relative to the diagonal or its floor, and the LMI of the latter."""
    least, relative, place = np.inf, np.inf, 0
    matrices = scaling.slack_matrices(packed, orders)
    for k, (matrix, reference) in enumerate(zip(matrices, scaling.slack_matrices(slack, orders), strict=True)):
        if not np.isfinite(matrix).all():
            return -np.inf, -np.inf, k
        # the solver's slack may be far from the matrix that it stands for
        diagonal = np.minimum(np.diag(reference), np.abs(np.diag(matrix)))
        diagonal = np.maximum(diagonal, max(1e-14 * np.abs(diagonal).max(), floors[k]) + np.finfo(float).tiny)
        root = 1 / np.sqrt(diagonal)
        least = min(least, float(np.linalg.eigvalsh(matrix)[0]))
        scaled = float(np.linalg.eigvalsh(root[:, None] * matrix * root)[0])
        if scaled < relative:
            relative, place = scaled, k
    return least, relative, place


def judged(
    problem: ConeProblem, best: _Candidate, x: Array, steps: tuple[Pass, ...], unseen: int, solver: ConeSolver
) -> Solution:
    """Measure the answer on the problem itself and say what is wrong with it."""
    rows = int(problem.starts[-1])
    slack = best.slack[:rows]
    floors = vanishing(slack, x, problem, ROUNDING)
    least, relative, place = _worst(problem.matrix @ x + problem.offset, slack, problem.orders, floors)
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
