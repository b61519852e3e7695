"""Solve on a face of the dual, and come back to a point inside all cones (see :mod:`lmic.solve.recession`)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.solve import scaling
from lmic.solve.cone import ConeData, ConeSolver, Status
from lmic.solve.face_optimum import SHARES, FaceOptimum
from lmic.solve.passes import (
    TRUSTED_GAP,
    TRUSTED_VIOLATION,
    Candidate,
    candidate_of,
    passes_of,
    svec_diagonal,
    worst_of,
)
from lmic.solve.recession import reduction
from lmic.solve.solution import ABSOLUTE, Pass

Array: TypeAlias = NDArray[Any]


def solve_on_face(data: ConeData, solver: ConeSolver, passes: int) -> tuple[Candidate, tuple[Pass, ...]] | None:
    """The answer of a problem whose columns are independent; None where no face is found or it gives no answer."""
    faces = reduction(data, solver)
    if faces is None:
        return None
    core, rough, steps = _solved(faces.core, solver, passes)
    if not core.answer.status.usable:
        return None
    optimum = FaceOptimum(faces, core.x, core.dual, max(abs(core.step.value), ABSOLUTE), (rough.x, rough.dual))
    found: list[Candidate] = []
    for share in SHARES:
        for x in optimum.points(share, solver):
            found.append(_lifted(data, optimum, core, x))
            if found[-1].step.violation == 0.0:
                break
        if found and _best(found).merit <= TRUSTED_GAP:
            break
    return (_best(found), steps) if found else None


def _best(found: list[Candidate]) -> Candidate:
    return min(found, key=lambda one: one.merit)


def _solved(core: ConeData, solver: ConeSolver, passes: int) -> tuple[Candidate, Candidate, tuple[Pass, ...]]:
    """The best answer and the first. Sparse coordinates do for an interior on both sides; else all passes are tried."""
    scaled, transform = scaling.initial(core)
    found = [candidate_of(core, scaled, transform, solver(scaled))]
    while not _known(found[-1].step) and found[-1].answer.status.usable and len(found) < passes:
        scaled, transform = scaling.balanced(core, found[-1].slack, found[-1].dual)
        found.append(candidate_of(core, scaled, transform, solver(scaled)))
    best, steps = min(found, key=lambda one: max(one.step.gap, one.step.violation)), tuple(one.step for one in found)
    rough = found[0] if found[0].answer.status.usable else best
    # no more is asked of this point than its gap: LMIs that vanish here are given a margin of their own
    if best.step.gap <= TRUSTED_GAP or not scaling.affordable(core):
        return best, rough, steps
    other, more = passes_of(core, solver, passes)
    if other.step.gap < best.step.gap:
        best = rough = other
    return best, rough, steps + more


def _known(step: Pass) -> bool:
    return step.gap <= TRUSTED_GAP and step.violation <= TRUSTED_VIOLATION


def _lifted(data: ConeData, optimum: FaceOptimum, core: Candidate, x: Array) -> Candidate:
    """The candidate at a point of the whole problem; what bounds the core bounds the whole."""
    slack, dual = data.matrix @ x + data.offset, optimum.reduction.dual(core.dual)
    violation = max(0.0, -worst_of(slack, slack, data.orders, np.zeros(len(data.orders)))[1])
    price = violation * float(svec_diagonal(slack, data.orders) @ dual)
    step = replace(core.step, value=float(data.cost @ x), violation=violation, price=price)
    return Candidate(step, replace(core.answer, status=Status.SOLVED), x, slack, dual, optimum)
