"""Points and dual matrices that may prove an enclosure: from double precision, or from 200 bits.

Nothing here is a proof. What is offered first gives away the least.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from importlib.metadata import version
from itertools import chain
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.certify.definite import is_positive_definite
from lmic.certify.finite import FiniteProblem
from lmic.certify.interior import inner_dual, inner_point
from lmic.certify.precise import solve_precisely
from lmic.certify.statement import fractions, from_flint, to_flint
from lmic.compiler.assemble import ConicProblem
from lmic.errors import CertificateError
from lmic.pipeline import Result
from lmic.solve.clarabel import Clarabel
from lmic.solve.cone import ConeData
from lmic.solve.exchange import binding_lmis, relative_eigenvalues
from lmic.solve.face_optimum import SHARES as INSIDE
from lmic.solve.face_optimum import FaceOptimum
from lmic.solve.lineality import lineality
from lmic.solve.scaling import slack_matrices
from lmic.solve.sdpa import PACKAGE
from lmic.solve.solution import Solution
from lmic.solve.whole import margin

Array: TypeAlias = NDArray[Any]
#: the exact problem of the LMIs with these numbers
Exact: TypeAlias = Callable[[Sequence[int]], FiniteProblem]

#: shares of the objective that are given away for a proof
SHARES = (1e-8, 1e-7, 1e-6, 1e-5, 1e-4)
#: shares of its diagonal added to a solver's dual matrix, tried in turn
ROUNDING = (1e-14, 1e-12, 1e-10)
#: shares of a point well inside the cones that are mixed in
BLENDS = tuple(10.0**power for power in range(-12, -3))
#: LMIs up to which the dual of all is tried before that of the binding ones
FEW = 40
#: unknowns up to which 200 bits take minutes
MOST_UNKNOWNS = 1500
#: binary digits of an unknown's coordinate, tried in turn
BITS = (53, 72, 96, 128, 192)
#: gap and infeasibility at which SDPA stops. Both shrink at one pace, so that asking for less of either
#: only makes the slacks and the dual matrices thinner
STOP = {"epsilonStar": 1e-9, "epsilonDash": 1e-28}


@dataclass(frozen=True)
class DualCandidate:
    """Positive definite matrices of fractions for the LMIs ``chosen``, and the exact problem of these.

    They are matrices on ``faces`` where these are known (see :mod:`lmic.certify.face`).
    """

    chosen: Sequence[int]
    problem: FiniteProblem
    matrices: list[Array]
    faces: tuple[Array | None, ...] | None = None


@dataclass(frozen=True)
class Candidates:
    """``points`` are vectors of all unknowns, floats or fractions; ``solver`` says where both come from."""

    points: Iterator[Array]
    duals: Iterator[DualCandidate]
    solver: str


def in_double_precision(result: Result, exact: Exact) -> Candidates:
    """Strictly inside the cones, by interior solutions near the result's."""
    solver = double_precision(result.solution.solver)
    optimum = result.solution.on_face
    if optimum is not None:
        return Candidates(_points_on_face(result, optimum), _duals_on_face(result, optimum, exact), solver)
    return Candidates(interior_points(result, SHARES), _interior_duals(result, exact), solver)


def in_multiprecision(result: Result, exact: Exact) -> Candidates:
    """The last iterates of SDPA at 200 bits; raises LmicError without the package."""
    chosen = _chosen(result)[0]
    if result.problem.size > MOST_UNKNOWNS:
        raise CertificateError(f"{result.problem.size} unknowns are too many for 200 bits")
    problem = exact(chosen)
    if not problem.rational:
        raise CertificateError("at 200 bits nothing is proven, since the data are not rational")
    answer = solve_precisely(problem, **STOP)
    points = (np.array([rounded(value, bits) for value in answer.x], dtype=object) for bits in BITS)
    dual = DualCandidate(chosen, problem, [from_flint(matrix) for matrix in answer.duals])
    return Candidates(points, iter((dual,)), f"{PACKAGE} {version(PACKAGE)}, 200 bits")


def interior_points(result: Result, shares: Sequence[float]) -> Iterator[Array]:
    """Points at which the finite LMIs hold strictly in floating point, the nearest to the optimum first."""
    if result.theorem.minimise is None:
        yield result.solution.x
        return
    problem, solution = result.problem, result.solution
    near = (inner_point(problem, solution, share) for share in shares)
    for x in chain(near, _blended(problem, solution.x)):
        if np.isfinite(x).all() and relative_eigenvalues(problem, x).min() > 0:
            yield x


def _blended(problem: ConicProblem, x: Array) -> Iterator[Array]:
    """Towards a point that is well inside: what remains where a solution suggests no good coordinates."""
    if len(problem.orders) > FEW:
        return
    inside = margin(problem, Clarabel())
    if inside.status.usable and inside.value > 0:
        yield from ((1 - share) * x + share * inside.x for share in BLENDS)


def rounded(value: Fraction, bits: int) -> Fraction:
    """To so many binary digits."""
    if value == 0:
        return value
    unit = Fraction(2) ** (value.numerator.bit_length() - value.denominator.bit_length() - bits)
    return round(value / unit) * unit


def _interior_duals(result: Result, exact: Exact) -> Iterator[DualCandidate]:
    for problem, solution, chosen in _parts(result):
        finite = exact(chosen)
        for own in _rounded_inwards(slack_matrices(solution.dual, problem.orders)):
            yield DualCandidate(chosen, finite, list(map(fractions, own)))
        for share in SHARES:
            try:
                matrices = inner_dual(problem, solution, share).exact()
            except CertificateError:
                continue
            yield DualCandidate(chosen, finite, matrices)


def _points_on_face(result: Result, optimum: FaceOptimum) -> Iterator[Array]:
    """The solution itself, which is inside all cones in floating point, and points further inside."""
    yield result.solution.x
    kept = lineality(result.problem.matrix).kept
    for share in INSIDE:
        for inner in optimum.points(share, Clarabel()):
            x = np.zeros(result.problem.size)
            x[kept] = inner
            yield x


def _duals_on_face(result: Result, optimum: FaceOptimum, exact: Exact) -> Iterator[DualCandidate]:
    everything = list(range(len(result.problem.orders)))
    finite, faces = exact(everything), optimum.reduction.bases
    own = optimum.reduction.matrices(optimum.dual)
    for matrices in chain(_rounded_inwards(own), (optimum.dual_matrices(share, Clarabel()) for share in SHARES)):
        if all(np.isfinite(matrix).all() for matrix in matrices):
            yield DualCandidate(everything, finite, [fractions((one + one.T) / 2) for one in matrices], faces)


def _rounded_inwards(duals: Sequence[Array]) -> Iterator[list[Array]]:
    """A solver's own dual matrices, moved off the boundary that rounding may have taken them across."""
    for share in ROUNDING:
        moved = [(dual + dual.T) / 2 + share * np.diag(np.abs(np.diag(dual))) for dual in duals]
        if all(is_positive_definite(to_flint(fractions(matrix))) for matrix in moved):
            yield moved
            return


def _parts(result: Result) -> Iterator[tuple[ConicProblem, Solution, Sequence[int]]]:
    """Problems to take the dual of, with the numbers of their LMIs."""
    problem, solution = result.problem, result.solution
    for chosen in _chosen(result):
        rows = np.concatenate([np.arange(problem.starts[k], problem.starts[k + 1]) for k in chosen])
        yield problem.restricted(np.array(chosen)), replace(solution, dual=solution.dual[rows]), chosen


def _chosen(result: Result) -> list[list[int]]:
    """All LMIs if they are few, and those that carry the dual."""
    binding = np.flatnonzero(binding_lmis(result.problem, result.solution)).tolist()
    everything = list(range(len(result.problem.orders)))
    return [everything, binding] if len(everything) <= FEW else [binding]


def binding_part(result: Result) -> ConeData:
    """What a solver has to solve at the least: all LMIs if they are few, else those that bind."""
    part = result.problem.restricted(np.array(_chosen(result)[0]))
    return ConeData(part.cost, part.matrix, part.offset, part.orders)


def double_precision(solver: str) -> str:
    """How a certificate calls what it was made from."""
    return f"{solver}, double precision"
