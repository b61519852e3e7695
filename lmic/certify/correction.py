"""The smallest correction of dual matrices that miss their equalities, in the metric of the matrices themselves.

ΔZ = Σ_i y_i Z F_i Z moves every eigenvalue of Z by the same small share, however thin Z is. The y solve
M y = r, with M_ij = Σ_k ⟨F_i, Z F_j Z⟩ and the misses r. M is factorised in double precision and y refined
against exact misses; where that does not converge, M is solved in fixed point.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, TypeAlias

import flint
import numpy as np
import scipy.linalg
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.certify.balls import middle
from lmic.certify.finite import FiniteLMI, FiniteProblem
from lmic.certify.lower import misses
from lmic.certify.statement import from_flint, to_flint
from lmic.errors import CertificateError
from lmic.solve.lineality import lineality

Array: TypeAlias = NDArray[Any]

#: bits of the corrections, in fixed point
PRECISION = 512
#: the misses that are left, relative to the first: below what is rounded away when the matrices are written down
LEFT = 1e-40
#: refinements of y at the most, and what each has to reduce the misses to
REFINEMENTS, REDUCED = 40, 0.1


def corrected(
    problem: FiniteProblem, matrices: Sequence[Array], free: Sequence[int] | Array = ()
) -> tuple[Array, list[Array]]:
    """Independent unknowns that are not ``free``, and Z + Σ_i y_i Z F_i Z, which meets their equalities."""
    columns = svec_columns(problem)
    kept = np.setdiff1d(lineality(columns).kept, free)
    found = _refined(problem, matrices, columns[:, kept], kept)
    return kept, _in_fixed_point(problem, matrices, kept) if found is None else found


def _refined(
    problem: FiniteProblem, matrices: Sequence[Array], columns: sps.csc_array, kept: Array
) -> list[Array] | None:
    """The corrected matrices by M in double precision; None where it does not tell enough."""
    factor, norms = _factor(problem, matrices, columns)
    if factor is None:
        return None
    y = np.full(len(kept), Fraction(0), dtype=object)
    near, miss = list(matrices), _misses(problem, matrices, kept)
    first = size = np.abs(miss / norms).max(initial=0.0)
    for _ in range(REFINEMENTS):
        if size <= LEFT * first:
            return near
        scaled = miss / norms / size
        step = scipy.linalg.cho_solve((factor, False), scaled) / norms
        if not np.isfinite(step).all():
            return None
        y += np.array([Fraction(value) for value in step.tolist()], dtype=object) * Fraction(size)
        near = _stepped(problem, matrices, kept, y)
        miss = _misses(problem, near, kept)
        before, size = size, np.abs(miss / norms).max()
        if size > REDUCED * before:
            return None
    return near


def _factor(problem: FiniteProblem, matrices: Sequence[Array], columns: sps.csc_array) -> tuple[Array | None, Array]:
    """R with N M N ≈ RᵀR for the norms 1/N of the columns Lᵀ F_i L, where Z = L Lᵀ."""
    parts, start = [], 0
    for lmi, matrix in zip(problem.lmis, matrices, strict=True):
        end = start + svec.length(lmi.order)
        try:
            root = np.linalg.cholesky(matrix.astype(float))
        except np.linalg.LinAlgError:
            return None, np.ones(0)
        rows, cols = svec.triangle(lmi.order)
        weights = svec.weights(lmi.order)
        own = svec.unpack(columns[start:end].toarray().T / weights, lmi.order)
        parts.append(((root.T @ own @ root)[:, rows, cols] * weights).T)
        start = end
    dense = np.concatenate(parts)
    norms = np.linalg.norm(dense, axis=0)
    if not (norms > 0).all():
        return None, norms
    factor = np.asarray(np.linalg.qr(dense / norms, mode="r"))
    return (factor if np.isfinite(factor).all() and np.diag(factor).all() else None), norms


def _misses(problem: FiniteProblem, matrices: Sequence[Array], kept: Array) -> Array:
    """In double precision, each to all its digits."""
    with flint.ctx.workprec(PRECISION):  # balls lose digits at any lower precision
        return np.array([float(middle(value)) for value in misses(problem, matrices)[kept]])


def _stepped(problem: FiniteProblem, matrices: Sequence[Array], kept: Array, y: Array) -> list[Array]:
    """Z + Σ_i y_i Z F_i Z."""
    weights = dict(zip(kept.tolist(), y, strict=True))
    return [matrix + _step(lmi, matrix, weights) for lmi, matrix in zip(problem.lmis, matrices, strict=True)]


def _in_fixed_point(problem: FiniteProblem, matrices: Sequence[Array], kept: Array) -> list[Array]:
    with flint.ctx.workprec(PRECISION):
        miss = misses(problem, matrices)[kept]
    metric = _metric(problem, matrices, kept)
    size = len(kept)
    with flint.ctx.workprec(PRECISION):
        left = flint.arb_mat(size, size, [flint.arb(int(value)) for value in metric.ravel()])
        right = flint.arb_mat(size, 1, [flint.arb(_fixed(value)) for value in miss])
        try:
            solution = left.solve(right, algorithm="approx").mid().entries()
        except ZeroDivisionError as error:
            raise CertificateError("the equalities of the dual are not independent") from error
    return _stepped(problem, matrices, kept, np.array([middle(value) for value in solution], dtype=object))


def _metric(problem: FiniteProblem, matrices: Sequence[Array], kept: Array) -> Array:
    """Σ_k ⟨F_i, Z F_j Z⟩ for the unknowns ``kept``, as integers in units of 2^-PRECISION."""
    place = np.full(problem.size, -1)
    place[kept] = np.arange(len(kept))
    total = np.zeros((len(kept), len(kept)), dtype=object)
    for lmi, matrix in zip(problem.lmis, matrices, strict=True):
        used = lmi.columns > 0
        used[used] = place[lmi.columns[used] - 1] >= 0
        rows, cols = lmi.rows[used], lmi.cols[used]
        unknown = place[lmi.columns[used] - 1]
        values = np.array([_fixed(value) for value in lmi.values[used]], dtype=object)
        off = rows != cols
        entry = np.concatenate([rows * lmi.order + cols, (cols * lmi.order + rows)[off]])
        unknown, values = np.concatenate([unknown, unknown[off]]), np.concatenate([values, values[off]])
        distinct, position = np.unique(entry, return_inverse=True)
        i, j = np.divmod(distinct, lmi.order)
        fixed = np.array([[_fixed(value) for value in row] for row in matrix], dtype=object).reshape(matrix.shape)
        kernel = (fixed[np.ix_(i, i)] * fixed[np.ix_(j, j)]) >> PRECISION
        mine, local = np.unique(unknown, return_inverse=True)
        half = np.zeros((len(distinct), len(mine)), dtype=object)
        for k in range(len(entry)):
            half[:, local[k]] += (kernel[:, position[k]] * values[k]) >> PRECISION
        product = np.zeros((len(mine), len(mine)), dtype=object)
        for k in range(len(entry)):
            product[local[k]] += (half[position[k]] * values[k]) >> PRECISION
        total[np.ix_(mine, mine)] += product
    return total


def _step(lmi: FiniteLMI, matrix: Array, y: dict[int, Fraction]) -> Array:
    """Σ_i y_i Z F_i Z."""
    direction = np.full((lmi.order, lmi.order), Fraction(0), dtype=object)
    for column, row, col, value in zip(
        lmi.columns.tolist(), lmi.rows.tolist(), lmi.cols.tolist(), lmi.values, strict=True
    ):
        if column - 1 in y:
            direction[row, col] += middle(value) * y[column - 1]
    direction = np.triu(direction) + np.triu(direction, 1).T
    weight = to_flint(matrix)
    return from_flint(weight * to_flint(direction) * weight)


def _fixed(value: Any) -> int:
    return int(middle(value) * (1 << PRECISION))


def svec_columns(problem: FiniteProblem) -> sps.csc_array:
    """The columns of all unknowns in svec coordinates, LMI below LMI, in floating point."""
    data, rows, cols = [], [], []
    start = 0
    for lmi in problem.lmis:
        used = lmi.columns > 0
        i, j = lmi.rows[used], lmi.cols[used]
        data.append(lmi.values[used].astype(float) * np.where(i == j, 1.0, np.sqrt(2.0)))
        rows.append(start + svec.packed_index(i, j))
        cols.append(lmi.columns[used] - 1)
        start += svec.length(lmi.order)
    entries = np.concatenate(data), (np.concatenate(rows), np.concatenate(cols))
    return sps.csc_array(sps.coo_array(entries, shape=(start, problem.size)))
