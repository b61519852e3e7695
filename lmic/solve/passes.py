"""Solve, rescale by the answer, solve again: the passes of stage 6, and what is measured of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.solve import scaling
from lmic.solve.cone import ConeAnswer, ConeData, ConeSolver, Status
from lmic.solve.face_optimum import FaceOptimum
from lmic.solve.solution import ABSOLUTE, TRUSTED_UNCERTAINTY, Pass
from lmic.solve.vanishing import lifted, vanishing

Array: TypeAlias = NDArray[Any]

#: passes of rescaling and solving again
PASSES = 6
#: beyond this relative violation or this relative gap there is something to warn of
TRUSTED_VIOLATION = 1e-9
TRUSTED_GAP = 1e-7
#: rounding of one entry, relative to the sum of the sizes that make it up
ROUNDING = 16 * np.finfo(float).eps
#: the largest margin asked for at first, relative to the slack's diagonal: a wild answer says nothing of what is needed
FIRST_MARGIN = 1e-6
#: growth of the margin, from the violation on, while an answer leaves a cone
RETREAT = 4.0
#: passes stop when violation and gap are within this (see Candidate.merit)
SETTLED = 1e-9


@dataclass(frozen=True)
class Candidate:
    """An answer as measured on the problem itself; ``on_face`` where it was found on a face of the dual."""

    step: Pass
    answer: ConeAnswer
    x: Array
    slack: Array
    dual: Array
    on_face: FaceOptimum | None = None

    @property
    def merit(self) -> float:
        """Worst of violation and uncertainty, each relative; the smaller the better.

        A violation counts a thousandfold: it spoils the bound, which a gap does not.
        """
        uncertainty = self.step.uncertainty
        return max(1e3 * self.step.violation, uncertainty) if np.isfinite(uncertainty) else np.inf


def passes_of(
    data: ConeData,
    solver: ConeSolver,
    passes: int,
    enough: Callable[[Candidate], bool] | None = None,
    guide: Array | None = None,
    settled: float = SETTLED,
) -> tuple[Candidate, tuple[Pass, ...]]:
    """Solve, rescale by the answer, solve again, until violation and gap are ``settled`` or ``enough`` says so.

    ``guide`` is a slack whose coordinates to begin in. Where dense columns cost too much the
    coordinates stay as they are.
    """
    if not scaling.affordable(data):
        return _retreat(data, solver, passes)
    scaled, transform = scaling.initial(data) if guide is None else scaling.rescaled(data, guide)
    found: list[Candidate] = []
    for number in range(passes):
        rough = number == 0 and guide is None
        candidate = candidate_of(data, scaled, transform, solver(scaled, rough=rough))
        found.append(candidate)
        if enough and enough(candidate):
            return candidate, tuple(one.step for one in found)
        if number == 0 and candidate.answer.status in (Status.INFEASIBLE, Status.UNBOUNDED):
            break
        if not rough and best_of(found).merit <= settled:
            break
        if number + 1 == passes:
            break
        # an answer that is no answer says nothing of the right coordinates
        nearest = candidate if np.isfinite(candidate.slack).all() else best_of(found)
        if not np.isfinite(nearest.slack).all():
            break
        scaled, transform = scaling.rescaled(
            data, lifted(nearest.slack, vanishing(nearest.slack, nearest.x, data, ROUNDING), data.orders)
        )
    return best_of(found), tuple(one.step for one in found)


def _retreat(data: ConeData, solver: ConeSolver, passes: int) -> tuple[Candidate, tuple[Pass, ...]]:
    """Solve in sparse coordinates; while the answer leaves a cone, ask for a share of diag S as margin."""
    scaled, transform = scaling.initial(data)
    found = [candidate_of(data, scaled, transform, solver(scaled))]
    diagonal = svec_diagonal(found[0].slack, data.orders)
    share = min(found[0].step.violation, FIRST_MARGIN)
    while len(found) < passes and found[-1].answer.status.usable and found[-1].step.violation > SETTLED:
        margin = share * diagonal
        answer = solver(replace(scaled, offset=scaled.offset - margin))
        found.append(candidate_of(data, scaled, transform, replace(answer, s=answer.s + margin)))
        share *= RETREAT
    best, last = best_of(found), found[-1]
    # a point inside the cones is worth more than digits that it costs, or that are not known without it either
    inside = last.answer.status.usable and last.step.violation <= SETTLED
    known = [step.uncertainty <= TRUSTED_UNCERTAINTY for step in (last.step, best.step)]
    return last if inside and (known[0] or not known[1]) else best, tuple(one.step for one in found)


def best_of(found: list[Candidate]) -> Candidate:
    """The candidate of least merit among those whose bound no feasible candidate contradicts."""
    values = [one.step.value for one in found if one.step.violation <= TRUSTED_VIOLATION]
    least = min(values, default=np.inf)
    least += TRUSTED_GAP * max(abs(least), ABSOLUTE)
    sound = [one for one in found if not one.step.bound > least]
    return min(sound or found, key=lambda one: one.merit)


def candidate_of(data: ConeData, scaled: ConeData, transform: scaling.Scaling, answer: ConeAnswer) -> Candidate:
    """An answer to the scaled problem, taken back to ``data`` and measured there."""
    x = transform.x(answer.y)
    slack = scaling.unscaled_slack(answer.s, transform, data.orders)
    dual = scaling.unscaled_dual(answer.z, transform, data.orders)
    relative = worst_of(data.matrix @ x + data.offset, slack, data.orders, vanishing(slack, x, data, ROUNDING))[1]
    # where the dual misses its equalities it bounds less: charge the miss, weighed with this y
    miss = float(np.abs(scaled.matrix.T @ answer.z - scaled.cost) @ np.abs(answer.y))
    bound = float(-data.offset @ dual) - miss
    violation = max(0.0, -relative)
    # what it would cost to go back into the cones by that much of every diagonal, to first order
    price = violation * float(svec_diagonal(slack, data.orders) @ dual)
    step = Pass(answer.word, answer.iterations, float(data.cost @ x), bound, violation, price)
    return Candidate(step, answer, x, slack, dual)


def worst_of(packed: Array, slack: Array, orders: Array, floors: Array) -> tuple[float, float, int]:
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


def svec_diagonal(packed: Array, orders: Array) -> Array:
    """The diagonals of the matrices of an svec vector, zero elsewhere."""
    return packed * np.concatenate([svec.identity(int(order)) for order in orders])
