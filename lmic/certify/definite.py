"""Positive definiteness decided: exactly for a rational matrix, for certain for a ball of matrices.

The pivots of a symmetric elimination are quotients of leading principal minors, so their signs
decide (Sylvester). Computed as balls that hold the true pivots, they decide for certain wherever no
ball holds zero.
"""

from __future__ import annotations

import flint

from lmic.errors import CertificateError

#: bits of the elimination of a rational matrix, tried in turn; after these the characteristic polynomial decides
BITS = (53, 128, 256, 512, 1024)


def is_positive_definite(matrix: flint.fmpq_mat) -> bool:
    """Whether a symmetric rational matrix is positive definite; raises for one that is not symmetric."""
    if matrix != matrix.transpose():
        raise CertificateError("definiteness is asked of a matrix that is not symmetric; give a symmetric one")
    if any(matrix[i, i] <= 0 for i in range(matrix.nrows())):
        return False
    for bits in BITS:
        with flint.ctx.workprec(bits):
            verdict = decide(flint.arb_mat(matrix))
        if verdict is not None:
            return verdict
    return _has_positive_roots(matrix.numer_denom()[0].charpoly())


def decide(matrix: flint.arb_mat) -> bool | None:
    """True if every symmetric matrix in the ball is positive definite, False if none is, None if that is open.

    Works at flint's current precision; only the upper triangle is read.
    """
    rows = matrix.tolist()
    order = len(rows)
    for k in range(order):
        pivots = rows[k]
        if not pivots[k] > 0:
            return False if pivots[k] <= 0 else None
        for i in range(k + 1, order):
            row, factor = rows[i], pivots[i] / pivots[k]
            for j in range(i, order):
                row[j] -= factor * pivots[j]
    return True


def proves_positive_definite(matrix: flint.arb_mat) -> bool:
    """Whether every symmetric matrix in the ball is certainly positive definite, at flint's current precision.

    Elimination lets the radii grow with every step. Here the ball is first taken to X F Xᵀ with the
    inverse factor X of its midpoint, which is near the identity, and Gershgorin's discs decide;
    X F Xᵀ ≻ 0 shows that X is regular and F ≻ 0.
    """
    inverse = inverse_factor(matrix.mid())
    if inverse is None:
        return False
    rows = (inverse * matrix * inverse.transpose()).tolist()
    return all(
        row[i] > sum((abs(entry) for j, entry in enumerate(row) if j != i), flint.arb(0)) for i, row in enumerate(rows)
    )


def inverse_factor(matrix: flint.arb_mat) -> flint.arb_mat | None:
    """X with X F Xᵀ ≈ I, free of error; None where F is not positive definite at this precision."""
    order = matrix.nrows()
    rows = matrix.tolist()
    factor = [[flint.arb(0)] * order for _ in range(order)]
    for k in range(order):
        pivots = rows[k]
        if not pivots[k] > 0:
            return None
        root = pivots[k].sqrt()
        for i in range(k, order):
            factor[i][k] = (pivots[i] / root).mid()
            for j in range(i, order):
                if i > k:
                    rows[i][j] = (rows[i][j] - pivots[i] * pivots[j] / pivots[k]).mid()
    try:
        return flint.arb_mat(factor).inv().mid()
    except ZeroDivisionError:
        return None


def _has_positive_roots(polynomial: flint.fmpz_poly) -> bool:
    """Whether a polynomial with real roots only has no root at or below zero (Descartes' rule of signs)."""
    degree = polynomial.degree()
    return all((-1) ** (degree - k) * polynomial[k] > 0 for k in range(degree + 1))
