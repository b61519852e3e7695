"""From a solver's dual matrices to ones that satisfy every equality exactly.

They miss their equalities by rounding, which a small step removes (:mod:`lmic.certify.correction`). A
step that is not small shows that Z must vanish in some directions (:mod:`lmic.certify.face`). What then
is rounded away in writing the matrices down is left to the pivot entries (:mod:`lmic.certify.lower`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from typing import Any, TypeAlias

import flint
import numpy as np
import scipy.linalg
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.certify.correction import PRECISION, corrected, svec_columns
from lmic.certify.definite import is_positive_definite
from lmic.certify.document import decimal_above
from lmic.certify.face import compressed, face_of, on_face
from lmic.certify.finite import FiniteProblem, Functional
from lmic.certify.infeasible import MARGIN, Infeasible, feasibility_of, is_zero, largest_margin
from lmic.certify.lower import Dual, Pivot, bounded_lower_bound, lower_bound
from lmic.certify.statement import fractions, to_flint
from lmic.errors import CertificateError

Array: TypeAlias = NDArray[Any]

#: binary digits of a dual entry, counted from the size that its diagonal entries give it; tried in turn
BITS = (96, 128, 192, 256)
#: shares of positive definite matrices that are mixed with singular ones
MIXED = tuple(Fraction(1, 10**power) for power in range(1, 16))
#: what is added to the matrices so that they are positive definite, relative to their mean eigenvalue
SHIFTS = (1e-12, 1e-10, 1e-8, 1e-6)
#: bounds on the unknowns of a proof that needs one, tried in turn; where the LMIs are homogeneous it is 1
RADII = (10**6, 10**4, 10**2)


def exact_dual(
    problem: FiniteProblem, matrices: Sequence[Array], faces: Sequence[Array | None] | None = None
) -> tuple[Dual, Fraction]:
    """Dual matrices near given ones (of fractions, positive definite), and the bound that they prove.

    They are W on ``faces``; where these are not known, those that the correction shows are taken. Raises
    CertificateError where none are found.
    """
    whole, known = problem, faces is not None
    if faces is None:
        kept, near = corrected(problem, matrices)
        faces = [_face(before, after) for before, after in zip(matrices, near, strict=True)]
        matrices = [m if face is None else on_face(m, face) for m, face in zip(near, faces, strict=True)]
    if known or any(face is not None for face in faces):
        problem = compressed(problem, faces)
        kept, near = corrected(problem, matrices)
    columns = svec_columns(problem)
    reason = CertificateError("no positive definite dual matrices were found near the solver's")
    for bits in BITS:
        rounded = tuple(_rounded(matrix, bits) for matrix in near)
        dual = Dual(rounded, tuple(faces), _pivots(rounded, columns, kept))
        try:
            return dual, lower_bound(whole, dual)
        except CertificateError as error:
            reason = error
    raise reason


def bounded_dual(
    problem: FiniteProblem, matrices: Sequence[Array], radius: Fraction, grown: Array
) -> tuple[Dual, Fraction]:
    """Dual matrices near given ones, and the bound that they prove for unknowns up to ``radius`` in size.

    For where the exact ones are singular in directions that are not rational. ``grown`` are the unknowns
    that reach the bound: what their equalities miss is its price. Raises CertificateError where none prove
    anything.
    """
    found: list[tuple[Dual, Fraction]] = []
    for free in (grown, np.zeros(0, dtype=int)):
        near = [_rounded(matrix, BITS[-1]) for matrix in corrected(problem, matrices, free)[1]]
        for shift in (Fraction(0), *MIXED):
            # mixed with the given ones, which are positive definite
            mixed = [(1 - shift) * one + shift * other for one, other in zip(near, matrices, strict=True)]
            dual = Dual(tuple(_rounded(matrix, BITS[0]) for matrix in mixed), (None,) * len(mixed), ())
            with suppress(CertificateError):
                found.append((dual, bounded_lower_bound(problem, dual, radius)))
    if not found:
        raise CertificateError("no positive definite dual matrices were found near the solver's")
    return max(found, key=lambda one: one[1])


def infeasibility(problem: FiniteProblem, functionals: Sequence[Functional], matrices: Sequence[Array]) -> Infeasible:
    """From dual matrices of the largest margin, in floating point. Raises CertificateError where none is proven."""
    problem = feasibility_of(problem)
    shifted = list(_shifted(matrices))
    for candidate in shifted:
        try:
            dual, bound = exact_dual(problem, candidate)
        except CertificateError:
            continue
        if bound >= 0 and not is_zero(dual):
            return Infeasible(tuple(functionals), dual, None, Fraction(0))
    homogeneous = all((lmi.columns > 0).all() for lmi in problem.lmis)
    duals = [Dual(tuple(candidate), (None,) * len(candidate), ()) for candidate in shifted]
    for radius in (1,) if homogeneous else RADII:
        claims = [Infeasible(tuple(functionals), dual, Fraction(radius), Fraction(0)) for dual in duals]
        margins = [max(largest_margin(problem, claim), Fraction(0)) for claim in claims]
        if min(margins, default=1) <= MARGIN:
            best = margins.index(min(margins))
            return replace(claims[best], margin=min(decimal_above(margins[best], 3), MARGIN))
    raise CertificateError("the dual matrices do not show that the LMIs have no solution")


def _face(before: Array, after: Array) -> Array | None:
    with flint.ctx.workprec(PRECISION):
        return face_of(flint.arb_mat(to_flint(before)), flint.arb_mat(to_flint(after)))


def _rounded(matrix: Array, bits: int) -> Array:
    """To so many binary digits of what the diagonal allows each entry to be."""
    exponents = [_exponent(entry) for entry in np.diag(matrix)]
    result = np.empty_like(matrix)
    for i, j in np.ndindex(*matrix.shape):
        unit = Fraction(2) ** ((exponents[i] + exponents[j]) // 2 - bits)
        result[i, j] = round(matrix[i, j] / unit) * unit
    return result


def _exponent(value: Fraction) -> int:
    """About log2 of a positive fraction."""
    if value <= 0:
        raise CertificateError("no positive definite dual matrices were found near the solver's")
    return value.numerator.bit_length() - value.denominator.bit_length()


def _pivots(matrices: Sequence[Array], columns: sps.csc_array, kept: Array) -> tuple[Pivot, ...]:
    """One entry of Z for each kept column: the pivots of an elimination, in the sizes of the entries."""
    places, sizes = [], []
    for k, one in enumerate(matrices):
        diagonal = np.sqrt(np.diag(one).astype(float))
        rows, cols = svec.triangle(len(one))
        places += [(k, int(i), int(j)) for i, j in zip(rows, cols, strict=True)]
        sizes.append(diagonal[rows] * diagonal[cols])
    weighted = sps.diags_array(np.concatenate(sizes)) @ columns[:, kept]
    norms = np.sqrt(np.asarray(weighted.multiply(weighted).sum(axis=0)).ravel())
    exchanged = scipy.linalg.lu_factor((weighted @ sps.diags_array(1 / norms)).toarray())[1]
    order = np.arange(len(places))
    for k, other in enumerate(exchanged.tolist()):
        order[[k, other]] = order[[other, k]]
    return tuple(Pivot(int(column), *places[int(entry)]) for column, entry in zip(kept, order, strict=False))


def _shifted(matrices: Sequence[Array]) -> Iterator[list[Array]]:
    trace = sum(float(np.trace(matrix)) for matrix in matrices)
    mean = trace / sum(len(matrix) for matrix in matrices)
    for shift in SHIFTS:
        found = [fractions((m + m.T) / 2 + shift * mean * np.eye(len(m))) for m in matrices]
        if all(is_positive_definite(to_flint(matrix)) for matrix in found):
            yield found
