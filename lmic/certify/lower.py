"""Proven lower bounds: dual matrices that satisfy every equality exactly.

For Z_k ⪰ 0 with Σ_k ⟨F_i^k, Z_k⟩ = c_i for every unknown, every feasible x has
c·x = Σ_k ⟨F^k(x) − F_0^k, Z_k⟩ ≥ −Σ_k ⟨F_0^k, Z_k⟩. With c = 0 and a right-hand side of zero or more no x
has F(x) ≻ 0. The matrices as they are stored miss the equalities by rounding: as many entries of
theirs as there are independent equalities are determined anew by the linear system that these make,
exactly for rational data; for data known as balls, as balls that hold the true entries.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import flint
import numpy as np
from numpy.typing import NDArray

from lmic.certify.balls import PRECISION, ball, balls, below
from lmic.certify.definite import is_positive_definite, proves_positive_definite
from lmic.certify.equations import solve
from lmic.certify.face import compressed
from lmic.certify.finite import FiniteProblem
from lmic.certify.statement import fraction, rational, to_flint
from lmic.errors import CertificateError

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class Pivot:
    """The entry (row, col) of dual matrix ``lmi`` that answers for the equality of unknown ``column``."""

    column: int
    lmi: int
    row: int
    col: int


@dataclass(frozen=True)
class Dual:
    """Symmetric matrices W of dyadic fractions, one for each LMI, and the entries that make them exact.

    The dual matrices are Z = V W Vᵀ with the integer V of ``faces``, or W itself where that is None.
    """

    matrices: tuple[Array, ...]
    faces: tuple[Array | None, ...]
    pivots: tuple[Pivot, ...]


def lower_bound(problem: FiniteProblem, dual: Dual) -> Fraction:
    """What the dual proves: no feasible x has a smaller objective. Raises where it proves nothing."""
    _check_count(problem, dual)
    for face, lmi in zip(dual.faces, problem.lmis, strict=True):
        if face is not None and face.shape[0] != lmi.order:
            raise CertificateError(
                f"the face of a dual matrix has {face.shape[0]} rows for an LMI of order {lmi.order}"
            )
    on_faces = compressed(problem, dual.faces)
    _check(on_faces, dual)
    return _exact_bound(on_faces, dual) if problem.rational else _enclosed_bound(on_faces, dual)


def bounded_lower_bound(problem: FiniteProblem, dual: Dual, radius: Fraction) -> Fraction:
    """What matrices that miss their equalities still prove: the bound for all x with |x_i| ≤ ``radius``.

    Each miss r_i costs radius·|r_i|.
    """
    if any(face is not None for face in dual.faces) or dual.pivots:
        raise CertificateError("a bound for bounded unknowns takes whole dual matrices, without pivots")
    _check_count(problem, dual)
    _check(problem, dual)
    for k, matrix in enumerate(dual.matrices):
        if not is_positive_definite(to_flint(matrix)):
            raise CertificateError(f"the dual matrix {k + 1} is not positive definite")
    with flint.ctx.workprec(PRECISION):
        cost = sum((abs(miss) for miss in balls(misses(problem, dual.matrices))), flint.arb(0))
        value = ball(problem.constant) - ball(products(problem, dual.matrices)[0]) - ball(radius) * cost
        return below(value)


def _check_count(problem: FiniteProblem, dual: Dual) -> None:
    if len(dual.matrices) != len(problem.lmis) or len(dual.faces) != len(problem.lmis):
        raise CertificateError(f"there are {len(dual.matrices)} dual matrices for {len(problem.lmis)} LMIs")


def _check(problem: FiniteProblem, dual: Dual) -> None:
    for matrix, lmi in zip(dual.matrices, problem.lmis, strict=True):
        if matrix.shape != (lmi.order, lmi.order) or (matrix != matrix.T).any():
            raise CertificateError(f"a dual matrix is not symmetric of order {lmi.order}")
    for pivot in dual.pivots:
        if not (pivot.column < problem.size and pivot.lmi < len(dual.matrices)):
            raise CertificateError("a pivot of the dual names an unknown or a matrix that does not exist")
        if not max(pivot.row, pivot.col) < len(dual.matrices[pivot.lmi]):
            raise CertificateError("a pivot of the dual names an entry that does not exist")


def _exact_bound(problem: FiniteProblem, dual: Dual) -> Fraction:
    columns = [pivot.column for pivot in dual.pivots]
    miss = misses(problem, dual.matrices)[columns]
    system = {place: rational(value) for place, value in _system(problem, dual.pivots).items()}
    exact = _changed(dual, [fraction(value) for value in _solution(system, [*map(rational, miss)], flint.fmpq_mat)])
    sums = products(problem, exact)
    if (sums[1:] != problem.cost).any():
        raise CertificateError("the dual matrices miss an equality")
    for k, matrix in enumerate(exact):
        if not is_positive_definite(to_flint(matrix)):
            raise CertificateError(f"the dual matrix {k + 1} is not positive definite")
    return Fraction(problem.constant - sums[0])


def _enclosed_bound(problem: FiniteProblem, dual: Dual) -> Fraction:
    """The same where data are balls: the entries that meet the equalities are enclosed."""
    columns = [pivot.column for pivot in dual.pivots]
    if sorted(columns) != list(range(problem.size)):
        raise CertificateError("an unknown has no pivot, and for data that are not rational each one needs its own")
    with flint.ctx.workprec(PRECISION):
        matrices = tuple(balls(matrix) for matrix in dual.matrices)
        system = {place: ball(value) for place, value in _system(problem, dual.pivots).items()}
        change = _solution(system, [*misses(problem, matrices)[columns]], flint.arb_mat)
        exact = _changed(Dual(matrices, dual.faces, dual.pivots), change)
        for k, matrix in enumerate(exact):
            if not proves_positive_definite(flint.arb_mat(len(matrix), len(matrix), [*matrix.ravel()])):
                raise CertificateError(f"the dual matrix {k + 1} is not positive definite")
        return below(ball(problem.constant) - products(problem, exact)[0])


def _solution(system: Mapping[tuple[int, int], Any], right: Sequence[Any], matrix: Any) -> list[Any]:
    try:
        return solve(system, right, matrix)
    except ZeroDivisionError as error:
        raise CertificateError("the dual's pivot entries do not determine their equalities") from error


def products(problem: FiniteProblem, matrices: Sequence[Array]) -> Array:
    """Σ_k ⟨F_i^k, Z_k⟩ for the constants and every unknown."""
    total = np.full(problem.size + 1, Fraction(0), dtype=object)
    if not problem.rational:
        total, matrices = balls(total), [balls(matrix) for matrix in matrices]
    for lmi, matrix in zip(problem.lmis, matrices, strict=True):
        total = total + lmi.inner(matrix, problem.size)
    return total


def misses(problem: FiniteProblem, matrices: Sequence[Array]) -> Array:
    """c_i − Σ_k ⟨F_i^k, Z_k⟩ for every unknown."""
    cost = problem.cost if problem.rational else balls(problem.cost)
    return np.asarray(cost - products(problem, matrices)[1:])


def _system(problem: FiniteProblem, pivots: Sequence[Pivot]) -> dict[tuple[int, int], Any]:
    """What one in each pivot entry contributes to each pivot's equality, by (equality, entry)."""
    place = {pivot.column: k for k, pivot in enumerate(pivots)}
    entries: dict[tuple[int, int, int], list[int]] = {}
    for k, pivot in enumerate(pivots):
        entries.setdefault((pivot.lmi, min(pivot.row, pivot.col), max(pivot.row, pivot.col)), []).append(k)
    system = {}
    for number in sorted({pivot.lmi for pivot in pivots}):
        lmi = problem.lmis[number]
        terms = zip(lmi.columns.tolist(), lmi.rows.tolist(), lmi.cols.tolist(), lmi.values.tolist(), strict=True)
        for column, row, col, value in terms:
            for k in entries.get((number, row, col), ()):
                if column > 0 and column - 1 in place:
                    system[place[column - 1], k] = value * (1 if row == col else 2)
    return system


def _changed(dual: Dual, change: Sequence[Any]) -> list[Array]:
    matrices = [matrix.copy() for matrix in dual.matrices]
    for pivot, value in zip(dual.pivots, change, strict=True):
        matrices[pivot.lmi][pivot.row, pivot.col] += value
        if pivot.row != pivot.col:
            matrices[pivot.lmi][pivot.col, pivot.row] += value
    return matrices
