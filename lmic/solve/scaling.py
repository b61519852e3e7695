"""Congruence rescaling: F ≻ 0 exactly when D F Dᵀ ≻ 0, and x = T y for any invertible T.

A thin interior makes one scaling of the whole problem useless; conic solvers may scale a PSD cone
by one number only. Here every LMI gets its own congruence from the slack S of an earlier pass,
D ≈ S^(-1/2), which brings the solution to the middle of every cone, and the unknowns get
orthonormal columns. That makes every column dense, which a large problem cannot afford: it gets
a diagonal D, in which slack and dual have the same diagonal.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.solve.cone import ConeData

Array: TypeAlias = NDArray[Any]

#: shares of diag(S) added to S, tried in turn until the columns are well enough conditioned: at the
#: optimum S is singular, and its inverse root must stay bounded
REGULARISATION = (1e-4, 1e-2, 1.0)
CONDITION = 1e-10

#: share of the largest diagonal entry below which one is rounding
VANISHED = 1e-14

#: multiplications per iteration of the solver up to which dense columns are affordable: a second or two
AFFORDABLE = 2e9


@dataclass(frozen=True)
class Scaling:
    """``congruence[k]`` is D of LMI k; ``unknowns`` is T (a vector where it is diagonal)."""

    congruence: list[Array]
    unknowns: Array

    def x(self, y: Array) -> Array:
        """The unknowns in the problem's own coordinates."""
        return self.unknowns @ y if self.unknowns.ndim == 2 else self.unknowns * y


def initial(data: ConeData) -> tuple[ConeData, Scaling]:
    """Columns of unit norm; nothing is known about the slacks yet."""
    norms = np.sqrt(np.asarray(data.matrix.multiply(data.matrix).sum(axis=0)).ravel())
    scale = 1 / np.where(norms > 0, norms, 1.0)
    matrix = sps.csc_array(data.matrix @ sps.diags_array(scale))
    return ConeData(data.cost * scale, matrix, data.offset, data.orders), Scaling(
        [np.eye(int(order)) for order in data.orders], scale
    )


def balanced(data: ConeData, slack: Array, dual: Array) -> tuple[ConeData, Scaling]:
    """Diagonal congruences after which slack and dual have equal diagonals (that of Nesterov and Todd's scaling).

    Columns have unit norm, and stay as sparse as they are.
    """
    congruence, entries = [], []
    for own, other in zip(slack_matrices(slack, data.orders), slack_matrices(dual, data.orders), strict=True):
        root = (_positive(np.diag(other)) / _positive(np.diag(own))) ** 0.25
        rows, cols = svec.triangle(len(root))
        congruence.append(np.diag(root))
        entries.append(root[rows] * root[cols])
    entry = np.concatenate(entries)
    scaled, columns = initial(
        ConeData(data.cost, sps.csc_array(sps.diags_array(entry) @ data.matrix), entry * data.offset, data.orders)
    )
    return scaled, Scaling(congruence, columns.unknowns)


def _positive(diagonal: Array) -> Array:
    """A diagonal without what is zero but for rounding."""
    return np.maximum(diagonal, max(VANISHED * np.abs(diagonal).max(initial=0.0), np.finfo(float).tiny))


def affordable(data: ConeData) -> bool:
    """Whether the problem may be solved with dense columns: the cost of one factorisation is bounded."""
    orders, unknowns = data.orders.astype(float), data.matrix.shape[1]
    lengths = orders * (orders + 1) / 2
    return float((lengths**2 * (lengths / 3 + unknowns)).sum() + unknowns**3 / 3) <= AFFORDABLE


def rescaled(data: ConeData, slack: Array) -> tuple[ConeData, Scaling]:
    """The problem in the coordinates that a slack suggests, or as at first where a vanishing slack suggests none."""
    slacks = slack_matrices(slack, data.orders)
    for regularisation in REGULARISATION:
        congruence = [inverse_root(matrix, regularisation) for matrix in slacks]
        columns = _congruent(data, congruence)
        triangular = scipy.linalg.qr(columns[:, 1:], mode="economic")[1]
        pivots = np.abs(np.diag(triangular))
        if pivots.min() > CONDITION * pivots.max():
            break
    if not pivots.all():
        return initial(data)
    unknowns = scipy.linalg.solve_triangular(triangular, np.eye(len(triangular)))
    # the product, not the orthonormal factor: it belongs to these ``unknowns`` however they are rounded
    scaled = ConeData(unknowns.T @ data.cost, sps.csc_array(columns[:, 1:] @ unknowns), columns[:, 0], data.orders)
    return scaled, Scaling(congruence, unknowns)


def slack_matrices(packed: Array, orders: Array) -> list[Array]:
    """The matrices of an svec vector, one per LMI."""
    lengths = orders * (orders + 1) // 2
    parts = np.split(packed, np.cumsum(lengths)[:-1])
    return [svec.unpack(part / svec.weights(int(n)), int(n)) for part, n in zip(parts, orders, strict=True)]


def inverse_root(slack: Array, regularisation: float) -> Array:
    """D with D S Dᵀ ≈ I, bounded where S is nearly singular."""
    diagonal = np.diag(slack)
    floor = np.finfo(float).eps * max(float(diagonal.max(initial=0.0)), np.finfo(float).tiny)
    jacobi = 1 / np.sqrt(np.maximum(diagonal, floor))
    values, vectors = np.linalg.eigh(jacobi[:, None] * slack * jacobi)
    roots = 1 / np.sqrt(np.maximum(values, 0.0) + regularisation)
    result: Array = (vectors * roots).T * jacobi
    return result


def _congruent(data: ConeData, congruence: list[Array]) -> Array:
    """Offset and columns of the problem after the congruence, dense."""
    columns = np.column_stack([data.offset, data.matrix.toarray()])
    start = 0
    for transform in congruence:
        n = len(transform)
        rows = slice(start, start + svec.length(n))
        i, j = svec.triangle(n)
        weight = svec.weights(n)
        matrices = transform @ svec.unpack(columns[rows].T / weight, n) @ transform.T
        columns[rows] = (matrices[:, i, j] * weight).T
        start += svec.length(n)
    return columns


def unscaled_slack(scaled: Array, scaling: Scaling, orders: Array) -> Array:
    """svec of D⁻¹ S D⁻ᵀ for every LMI: the slack in the problem's own coordinates."""
    return _transformed(scaled, [np.linalg.inv(d) for d in scaling.congruence], orders)


def unscaled_dual(scaled: Array, scaling: Scaling, orders: Array) -> Array:
    """svec of Dᵀ Z D for every LMI: the dual in the problem's own coordinates."""
    return _transformed(scaled, [d.T for d in scaling.congruence], orders)


def scaled_slack(packed: Array, scaling: Scaling, orders: Array) -> Array:
    """svec of D S Dᵀ for every LMI: the slack in the scaled coordinates."""
    return _transformed(packed, scaling.congruence, orders)


def scaled_dual(packed: Array, scaling: Scaling, orders: Array) -> Array:
    """svec of D⁻ᵀ Z D⁻¹ for every LMI: the dual in the scaled coordinates."""
    return _transformed(packed, [np.linalg.inv(d).T for d in scaling.congruence], orders)


def _transformed(packed: Array, transforms: list[Array], orders: Array) -> Array:
    parts = []
    for matrix, transform in zip(slack_matrices(packed, orders), transforms, strict=True):
        result = transform @ matrix @ transform.T
        i, j = svec.triangle(len(result))
        parts.append(result[i, j] * svec.weights(len(result)))
    return np.concatenate(parts)
