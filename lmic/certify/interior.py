"""Strictly feasible primal and dual points as near to an optimum as wanted, in floating point.

In the coordinates that a solution suggests (:mod:`lmic.solve.scaling`) every LMI has size one, and
a margin means the same everywhere. There the problem is solved once more with a cone moved inwards:
F_k(x) ⪰ ηI costs η·tr Z of the objective, Z_k ⪰ ζI costs ζ·tr F, and the cost is chosen.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.certify.statement import fractions, from_flint, to_flint
from lmic.compiler.assemble import ConicProblem
from lmic.errors import CertificateError
from lmic.solve import scaling
from lmic.solve.clarabel import Clarabel
from lmic.solve.cone import ConeData, ConeSolver
from lmic.solve.lineality import lineality
from lmic.solve.scaling import Scaling, slack_matrices
from lmic.solve.solution import ABSOLUTE, Solution

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class InnerDual:
    """Dual matrices in the coordinates of ``scaling``."""

    matrices: list[Array]
    scaling: Scaling

    def exact(self) -> list[Array]:
        """The same in the problem's own coordinates, DᵀZD, as fractions; raises where they are not finite."""
        if not all(np.isfinite(one).all() for one in self.matrices):
            raise CertificateError("the solver gave no dual matrices")
        pairs = zip(self.scaling.congruence, self.matrices, strict=True)
        exact = ((to_flint(fractions(transform)), to_flint(fractions(one))) for transform, one in pairs)
        return [from_flint(transform.transpose() * one * transform) for transform, one in exact]


def inner_point(problem: ConicProblem, solution: Solution, share: float, solver: ConeSolver | None = None) -> Array:
    """A strictly feasible x whose objective is about ``share`` of it above the optimum."""
    data, transform, kept, identity = _centred(problem, solution)
    packed = scaling.scaled_dual(solution.dual, transform, problem.orders)
    margin = share * _objective(problem, solution) / _trace(packed, identity)
    answer = (solver or Clarabel())(replace(data, offset=data.offset - margin * identity))
    x = solution.x.copy()
    x[kept] += transform.x(answer.y)
    return x


def inner_dual(problem: ConicProblem, solution: Solution, share: float, solver: ConeSolver | None = None) -> InnerDual:
    """Positive definite dual matrices whose bound is about ``share`` of the objective below the optimum."""
    data, transform, _, identity = _centred(problem, solution)
    margin = share * _objective(problem, solution) / _trace(data.offset, identity)
    answer = (solver or Clarabel())(replace(data, cost=data.cost - margin * (data.matrix.T @ identity)))
    return InnerDual(slack_matrices(answer.z + margin * identity, problem.orders), transform)


def _centred(problem: ConicProblem, solution: Solution) -> tuple[ConeData, Scaling, Array, Array]:
    """The problem without lineality in the solution's coordinates, with the solution as their origin.

    Its offset then is the solution's slack: a step from there is small, and so is its rounding. The
    last are the unknowns kept and svec of all identities.
    """
    whole = ConeData(problem.cost, problem.matrix, problem.offset, problem.orders)
    kept = lineality(whole.matrix).kept
    data = replace(whole, cost=whole.cost[kept], matrix=whole.matrix[:, kept])
    slack = whole.matrix @ solution.x + whole.offset
    scaled, transform = scaling.rescaled(data, slack)
    identity = np.concatenate([svec.identity(int(order)) for order in problem.orders])
    centred = replace(scaled, offset=scaling.scaled_slack(slack, transform, problem.orders))
    return centred, transform, kept, identity


def _objective(problem: ConicProblem, solution: Solution) -> float:
    return max(abs(solution.value - problem.constant), ABSOLUTE)


def _trace(packed: Array, identity: Array) -> float:
    """Sum of the traces, never zero."""
    return max(float(packed @ identity), float(np.finfo(float).eps))
