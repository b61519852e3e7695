"""Proven lower bounds: dual matrices that satisfy every equality exactly.

For Z_k ⪰ 0 with Σ_k ⟨F_i^k, Z_k⟩ = c_i for every unknown, every feasible x has
c·x = Σ_k ⟨F^k(x) − F_0^k, Z_k⟩ ≥ −Σ_k ⟨F_0^k, Z_k⟩. With c = 0 and a positive right-hand side no x is
feasible. A solver's Z misses the equalities by rounding: the miss is removed in the coordinates in
which the problem is well conditioned, and what then is left, by an exact linear system for as many
entries of Z as there are independent equalities.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic import svec
from lmic.certify.definite import is_positive_definite
from lmic.certify.finite import FiniteProblem
from lmic.certify.interior import InnerDual
from lmic.certify.statement import fractions, from_flint, to_flint
from lmic.errors import CertificateError

Array: TypeAlias = NDArray[Any]

#: binary digits of a dual entry, counted from the size that its diagonal entries give it
BITS = 128
#: the miss that is left to the exact system, relative to the objective's gradient
MISS = 1e-30
#: corrections until then; each gains several digits
CORRECTIONS = 12


@dataclass(frozen=True)
class Pivot:
    """The entry (row, col) of dual matrix ``lmi`` that answers for the equality of unknown ``column``."""

    column: int
    lmi: int
    row: int
    col: int


@dataclass(frozen=True)
class Dual:
    """Symmetric matrices of dyadic fractions, one for each LMI, and the entries that make them exact."""

    matrices: tuple[Array, ...]
    pivots: tuple[Pivot, ...]


def lower_bound(problem: FiniteProblem, dual: Dual) -> Fraction:
    """What the dual proves: no feasible x has a smaller objective. Raises where it proves nothing."""
    exact = completed(problem, dual)
    products = _products(problem, exact)
    if (products[1:] != problem.cost).any():
        raise CertificateError("the dual matrices miss an equality")
    for k, matrix in enumerate(exact):
        if not is_positive_definite(to_flint(matrix)):
            raise CertificateError(f"the dual matrix {k + 1} is not positive definite")
    return problem.constant - products[0]


def completed(problem: FiniteProblem, dual: Dual) -> list[Array]:
    """The matrices with their pivot entries changed so that the pivots' equalities hold exactly."""
    matrices = [matrix.copy() for matrix in dual.matrices]
    if len(matrices) != len(problem.lmis):
        raise CertificateError(f"there are {len(matrices)} dual matrices for {len(problem.lmis)} LMIs")
    for matrix, lmi in zip(matrices, problem.lmis, strict=True):
        if matrix.shape != (lmi.order, lmi.order) or (matrix != matrix.T).any():
            raise CertificateError(f"a dual matrix is not symmetric of order {lmi.order}")
    for pivot in dual.pivots:
        if not (pivot.column < problem.size and pivot.lmi < len(matrices)):
            raise CertificateError("a pivot of the dual names an unknown or a matrix that does not exist")
        if not max(pivot.row, pivot.col) < len(matrices[pivot.lmi]):
            raise CertificateError("a pivot of the dual names an entry that does not exist")
    columns = [pivot.column for pivot in dual.pivots]
    miss = (problem.cost - _products(problem, matrices)[1:])[columns]
    place = {column: k for k, column in enumerate(columns)}
    system = np.full((len(columns), len(columns)), Fraction(0), dtype=object)
    for k, pivot in enumerate(dual.pivots):
        lmi = problem.lmis[pivot.lmi]
        here = (lmi.rows == min(pivot.row, pivot.col)) & (lmi.cols == max(pivot.row, pivot.col)) & (lmi.columns > 0)
        for column, value in zip(lmi.columns[here] - 1, lmi.values[here], strict=True):
            if column in place:
                system[place[column], k] += value * (1 if pivot.row == pivot.col else 2)
    try:
        change = from_flint(to_flint(system).solve(to_flint(miss[:, None])))[:, 0]
    except ZeroDivisionError as error:
        raise CertificateError("the dual's pivot entries do not determine their equalities") from error
    for pivot, value in zip(dual.pivots, change, strict=True):
        matrices[pivot.lmi][pivot.row, pivot.col] += value
        if pivot.row != pivot.col:
            matrices[pivot.lmi][pivot.col, pivot.row] += value
    return matrices


def exact_dual(problem: FiniteProblem, inside: InnerDual, matrix: sps.csc_array) -> Dual:
    """Dual matrices of dyadic fractions near those of ``inside``, and pivots that make them exact.

    ``matrix`` holds the columns of all unknowns in svec coordinates, as the compiler made them.
    Raises where those of ``inside`` are not positive definite.
    """
    if not all(np.isfinite(one).all() for one in inside.matrices):
        raise CertificateError("the solver gave no dual matrices")
    congruence = [to_flint(fractions(transform)) for transform in inside.scaling.congruence]
    scaled = [fractions(one) for one in inside.matrices]
    gram = scipy.linalg.cho_factor((inside.data.matrix.T @ inside.data.matrix).toarray())
    unknowns = inside.scaling.unknowns
    size = np.abs(inside.data.cost).max(initial=np.finfo(float).tiny)
    matrices = _unscaled(congruence, scaled)
    for _ in range(CORRECTIONS):
        miss = (problem.cost - _products(problem, matrices)[1:])[inside.kept].astype(float)
        miss = unknowns.T @ miss if unknowns.ndim == 2 else unknowns * miss
        if np.abs(miss).max() <= MISS * size:
            break
        step = inside.data.matrix @ scipy.linalg.cho_solve(gram, miss)
        orders = inside.data.orders
        parts = np.split(step, np.cumsum(orders * (orders + 1) // 2)[:-1])
        scaled = [
            one + fractions(svec.unpack(part / svec.weights(order), order))
            for one, part, order in zip(scaled, parts, orders.tolist(), strict=True)
        ]
        matrices = _unscaled(congruence, scaled)
    if not all(np.linalg.eigvalsh(one.astype(float))[0] > 0 for one in scaled):
        raise CertificateError("no positive definite dual matrices were found near the solver's")
    return Dual(tuple(map(_rounded, matrices)), _pivots(matrices, matrix[:, inside.kept], inside.kept))


def _products(problem: FiniteProblem, matrices: Sequence[Array]) -> Array:
    """Σ_k ⟨F_i^k, Z_k⟩ for the constants and every unknown."""
    total = np.full(problem.size + 1, Fraction(0), dtype=object)
    for lmi, matrix in zip(problem.lmis, matrices, strict=True):
        total = total + lmi.inner(matrix, problem.size)
    return total


def _unscaled(congruence: Sequence[Any], scaled: Sequence[Array]) -> list[Array]:
    """Dᵀ Z D, exactly."""
    return [
        from_flint(transform.transpose() * to_flint(one) * transform)
        for transform, one in zip(congruence, scaled, strict=True)
    ]


def _rounded(matrix: Array) -> Array:
    """To BITS binary digits of what the diagonal allows each entry to be."""
    exponents = np.array([_exponent(entry) for entry in np.diag(matrix)])
    result = np.empty_like(matrix)
    for i, j in np.ndindex(*matrix.shape):
        unit = Fraction(2) ** int((exponents[i] + exponents[j]) // 2 - BITS)
        result[i, j] = round(matrix[i, j] / unit) * unit
    return result


def _exponent(value: Fraction) -> int:
    """About log2 of a positive fraction."""
    return value.numerator.bit_length() - value.denominator.bit_length()


def _pivots(matrices: Sequence[Array], matrix: sps.csc_array, kept: Array) -> tuple[Pivot, ...]:
    """One entry of Z for each kept column, so that the system is well conditioned in the sizes of the entries."""
    places, sizes = [], []
    for k, one in enumerate(matrices):
        diagonal = np.sqrt(np.diag(one).astype(float))
        rows, cols = svec.triangle(len(one))
        places += [(k, int(i), int(j)) for i, j in zip(rows, cols, strict=True)]
        sizes.append(diagonal[rows] * diagonal[cols])
    weighted = sps.diags_array(np.concatenate(sizes)) @ matrix
    norms = np.sqrt(np.asarray(weighted.multiply(weighted).sum(axis=0)).ravel())
    dense = (weighted @ sps.diags_array(1 / norms)).toarray().T
    order = scipy.linalg.qr(dense, mode="r", pivoting=True)[1][: len(kept)]
    return tuple(Pivot(int(column), *places[int(entry)]) for column, entry in zip(kept, order, strict=True))
