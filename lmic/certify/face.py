"""Faces of the cone of dual matrices: Z = V W Vᵀ with W ≻ 0 and an integer V.

Where the unknowns may grow without end at no cost, some F(x) grows along v vᵀ and every dual matrix
must have Z v = 0: none is positive definite, and rounding decides the sign of what should be zero.
On the face the problem is that of the compressed LMIs Vᵀ F(x) V ⪰ 0. They follow from the LMIs
whatever V is, so a bound proven for them holds, and only the search for V may fail.
"""

from __future__ import annotations

import operator
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import reduce
from typing import Any, TypeAlias

import flint
import numpy as np
from numpy.typing import NDArray

from lmic.algebra.integer_bases import free_rows, integer_complement
from lmic.certify.balls import PRECISION, is_zero
from lmic.certify.definite import inverse_factor
from lmic.certify.finite import FiniteLMI, FiniteProblem
from lmic.errors import CertificateError

Array: TypeAlias = NDArray[Any]

#: what remains of a direction of Z that must be zero, relative to what it was before the equalities were met
VANISHED = 1e-3
#: denominators of the null space that are looked for, and how near its entries have to be to such fractions
DENOMINATOR, NEAR = 64, 1e-5


def compressed(problem: FiniteProblem, faces: Sequence[Array | None]) -> FiniteProblem:
    """The problem with Vᵀ F V for each LMI that has a face; one with no columns is left without entries."""
    with flint.ctx.workprec(PRECISION):
        lmis = [lmi if face is None else _compressed(lmi, face) for lmi, face in zip(problem.lmis, faces, strict=True)]
    return replace(problem, lmis=tuple(lmis))


def _compressed(lmi: FiniteLMI, face: Array) -> FiniteLMI:
    supports = [np.flatnonzero(row) for row in face]
    entries: dict[tuple[int, int, int], list[Any]] = defaultdict(list)
    for column, row, col, value in zip(
        lmi.columns.tolist(), lmi.rows.tolist(), lmi.cols.tolist(), lmi.values, strict=True
    ):
        for i, j in {(row, col), (col, row)}:
            for a in supports[i]:
                for b in supports[j]:
                    if a <= b:
                        entries[column, int(a), int(b)].append(value * int(face[i, a] * face[j, b]))
    sums = {key: reduce(operator.add, terms) for key, terms in entries.items()}
    kept = sorted(key for key, value in sums.items() if not is_zero(value))
    places = np.array(kept, dtype=int).reshape(-1, 3)
    values = np.array([sums[key] for key in kept] + [None], dtype=object)[:-1]
    return FiniteLMI(face.shape[1], places[:, 0], places[:, 1], places[:, 2], values)


def face_of(before: flint.arb_mat, after: flint.arb_mat) -> Array | None:
    """V of the face that holds ``after``, by the directions in which it vanishes beside ``before`` ≻ 0.

    None where there are none. Raises CertificateError where they span no space of small fractions.
    """
    inverse = inverse_factor(before)
    if inverse is None:
        raise CertificateError("a dual matrix is not positive definite")
    relative = (inverse * after * inverse.transpose()).mid()
    values, vectors = np.linalg.eigh(_floats(relative))
    null = np.abs(values) < VANISHED
    if not null.any():
        return None
    directions = _floats((inverse.transpose() * flint.arb_mat(vectors[:, null].tolist())).mid())
    face = integer_complement(directions.T, DENOMINATOR, NEAR)
    if face is None:
        raise CertificateError("the dual matrices must vanish in directions that are no small fractions")
    return face


def on_face(matrix: Array, face: Array) -> Array:
    """W with V W Vᵀ nearest to a matrix of fractions on the face, read off the rows in which V is diagonal."""
    free = free_rows(face)
    scale = np.array([Fraction(1, int(face[row, a])) for a, row in enumerate(free)], dtype=object)
    return np.asarray(matrix[np.ix_(free, free)] * scale[:, None] * scale[None, :])


def _floats(matrix: flint.arb_mat) -> Array:
    values = [float(entry.mid()) for entry in matrix.entries()]
    return np.array(values).reshape(matrix.nrows(), matrix.ncols())
