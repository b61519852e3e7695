"""How far from having a solution: the largest t with F_k(x) ⪰ t·I for all k, in scaled coordinates.

The coordinates are those in which every row of an LMI has entries of size 1 at the most, for unknowns whose columns
have size 1; t is then a share of the data. Where no LMI has a constant term, x = 0 gives t = 0 and any x may be
multiplied by any factor; then the sum of all traces is kept from below at the sum of all orders, so that t is
the least eigenvalue beside a mean of one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.compiler.assemble import ConicProblem
from lmic.diagnosis.shares import Shares, shares_of
from lmic.solve.cone import ConeSolver
from lmic.solve.scaling import slack_matrices
from lmic.solve.whole import margin

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class Distance:
    """``margin`` is t, negative where the LMIs have no solution, and ``bound`` no t is above it.

    ``shares`` are the LMIs that keep t from growing, by the traces of their dual matrices.
    """

    margin: float
    bound: float
    shares: Shares


@dataclass(frozen=True)
class _Scaled:
    """The LMIs after a diagonal congruence, as the solving stage takes them."""

    cost: Array
    constant: float
    size: int
    orders: Array
    starts: Array
    matrix: sps.csc_array
    offset: Array

    def label(self, index: int) -> str:
        return f"LMI {index + 1}"


def distance(problem: ConicProblem, solver: ConeSolver) -> Distance:
    """The largest margin of a problem, whatever it minimises."""
    found = margin(_scaled(problem), solver)
    count = int(problem.starts[-1])
    traces = np.array([np.trace(dual) for dual in slack_matrices(found.dual[:count], problem.orders)])
    return Distance(found.value, found.bound, shares_of(problem, traces))


def _scaled(problem: ConicProblem) -> _Scaled:
    norms = np.sqrt(np.asarray(problem.matrix.multiply(problem.matrix).sum(axis=0)).ravel())
    matrix = sps.csc_array(problem.matrix @ sps.diags_array(1 / np.where(norms > 0, norms, 1.0)))
    largest = np.maximum(np.asarray(abs(matrix).max(axis=1).todense()).ravel(), np.abs(problem.offset))
    factors = []
    for k, order in enumerate(map(int, problem.orders)):
        rows, cols = svec.triangle(order)
        sizes = largest[problem.starts[k] : problem.starts[k + 1]]
        of_row = np.zeros(order)
        np.maximum.at(of_row, rows, sizes)
        np.maximum.at(of_row, cols, sizes)
        congruence = 1 / np.sqrt(np.where(of_row > 0, of_row, 1.0))
        factors.append(congruence[rows] * congruence[cols])
    factor = np.concatenate(factors)
    scaled, offset = sps.csc_array(sps.diags_array(factor) @ matrix), factor * problem.offset
    orders = problem.orders
    if not offset.any():
        identity = np.concatenate([svec.identity(int(order)) for order in orders])
        scaled = sps.csc_array(sps.vstack([scaled, sps.csr_array((scaled.T @ identity)[None, :])]))
        offset, orders = np.append(offset, -float(orders.sum())), np.append(orders, 1)
    lengths = orders * (orders + 1) // 2
    starts = np.concatenate([[0], np.cumsum(lengths)])
    return _Scaled(np.zeros(problem.size), 0.0, problem.size, orders, starts, scaled, offset)
