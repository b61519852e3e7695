"""Exact problems at 200 bits, by SDPA (optional extra).

SDPA reads doubles. Each LMI is therefore multiplied by its common denominator, which leaves the
data exact where they are short enough.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from typing import Any, TypeAlias

import flint
import numpy as np
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.certify.finite import FiniteProblem
from lmic.solve.cone import Status
from lmic.solve.lineality import lineality
from lmic.solve.sdpa import Block, full, solve_blocks

Array: TypeAlias = NDArray[Any]

#: integers up to this are doubles
EXACT = 2**53


@dataclass(frozen=True)
class PreciseAnswer:
    """The unknowns ``x`` and the dual matrix of each LMI, with all the digits that SDPA has.

    ``rounded`` says whether data had to be rounded to doubles. ``word`` is SDPA's own.
    """

    status: Status
    x: list[Fraction]
    duals: list[flint.fmpq_mat]
    iterations: int
    word: str
    rounded: bool


def solve_precisely(problem: FiniteProblem, **options: Any) -> PreciseAnswer:
    """Solve an exact problem at 200 bits; unknowns that no LMI sees are zero. Raises LmicError without SDPA."""
    denominators = [_denominator(lmi.values) for lmi in problem.lmis]
    scaled = [lmi.values * factor for lmi, factor in zip(problem.lmis, denominators, strict=True)]
    factor = _denominator(problem.cost)
    cost = problem.cost * factor
    rounded = any(abs(value) > EXACT for values in (cost, *scaled) for value in values)
    blocks = [
        Block(lmi.order, lmi.columns, lmi.rows, lmi.cols, values.astype(float))
        for lmi, values in zip(problem.lmis, scaled, strict=True)
    ]
    kept = lineality(_svec_columns(blocks, problem.size)).kept
    answer = solve_blocks(cost.astype(float)[kept], [_restricted(block, kept) for block in blocks], options)
    x = [Fraction(0)] * problem.size
    for place, value in zip(kept.tolist(), answer.x, strict=True):
        x[place] = value
    # the dual of the scaled LMI and the scaled cost, back in the problem's own
    duals = [dual * flint.fmpq(d, factor) for dual, d in zip(answer.duals, denominators, strict=True)]
    return PreciseAnswer(answer.status, x, duals, answer.iterations, answer.word, rounded)


def _denominator(values: Array) -> int:
    return lcm(*(Fraction(value).denominator for value in values))


def _svec_columns(blocks: Sequence[Block], size: int) -> sps.csc_array:
    """The unknowns' columns of all LMIs, for their rank."""
    parts = [sps.csc_array(full(block, size))[:, 1:] for block in blocks]
    return sps.csc_array(sps.vstack(parts))


def _restricted(block: Block, kept: Array) -> Block:
    """Only the columns of the unknowns ``kept``, numbered anew."""
    chosen = np.concatenate([[0], 1 + kept])
    used = np.isin(block.columns, chosen)
    columns = np.searchsorted(chosen, block.columns[used])
    return Block(block.order, columns, block.rows[used], block.cols[used], block.values[used])
