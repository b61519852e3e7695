"""Pólya: coefficients of the polynomial made homogeneous on a simplex, times (Σα)^d.

If every coefficient of a homogeneous polynomial is positive definite, the polynomial is on the
whole simplex; multiplying by (Σα)^d = 1 first makes the condition weaker, in the limit exact
(Pólya 1928; Hardy, Littlewood, Pólya, *Inequalities*, 2.24). Degree 0 on two simplexes is
Lemma 1 of Peixoto et al. (2025).
"""

from __future__ import annotations

from itertools import combinations_with_replacement
from math import factorial, prod

import numpy as np

from lmic.polynomials import Monomials
from lmic.relax.family import AxisRelaxation, Soundness
from lmic.relax.space import Axis


def polya(axis: Axis, part: Monomials, degree: int) -> AxisRelaxation:
    """Coefficients of total degree deg + ``degree`` in the simplex's components."""
    exponents = part.over(axis.symbols)
    target = int(exponents.sum(axis=1).max()) + degree
    targets = homogeneous_exponents(len(axis.symbols), target)
    # α^e (Σα)^(D-|e|) = Σ_f (D-|e|)! / Π(f-e)! α^f
    rest = targets[:, None, :] - exponents[None, :, :]
    factorials = np.array([factorial(k) for k in range(target + 1)], dtype=float)
    weights = np.where(
        (rest >= 0).all(axis=2),
        factorials[target - exponents.sum(axis=1)][None, :] / factorials[np.maximum(rest, 0)].prod(axis=2),
        0.0,
    )
    labels = tuple(_label(axis, powers) for powers in targets)
    return AxisRelaxation(f"Pólya degree {degree}", weights, labels, Soundness.SUFFICIENT)


def homogeneous_exponents(variables: int, degree: int) -> np.ndarray[tuple[int, int], np.dtype[np.int64]]:
    """Exponents of all monomials of the given degree, shape (count, variables)."""
    chosen = list(combinations_with_replacement(range(variables), degree))
    exponents = np.zeros((len(chosen), variables), dtype=np.int64)
    for row, choice in enumerate(chosen):
        np.add.at(exponents[row], list(choice), 1)
    return exponents


def multinomial(powers: tuple[int, ...]) -> int:
    """Coefficient of the monomial in (Σα)^(Σ powers)."""
    return factorial(sum(powers)) // prod(factorial(p) for p in powers)


def _label(axis: Axis, powers: np.ndarray[tuple[int], np.dtype[np.int64]]) -> str:
    factors = [f"{s}" if p == 1 else f"{s}^{p}" for s, p in zip(axis.symbols, powers, strict=True) if p]
    return f"{axis.name}: " + (" ".join(factors) or "1")
