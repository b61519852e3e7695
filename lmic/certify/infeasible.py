"""Proofs that LMIs have no solution.

For Z_k ⪰ 0, not all zero, with Σ_k ⟨F_i^k, Z_k⟩ = 0 for every unknown and Σ_k ⟨F_0^k, Z_k⟩ ≤ 0, no x has
F(x) ≻ 0, since then Σ_k ⟨F^k(x), Z_k⟩ > 0. Often such Z are singular in irrational directions and
nothing exact is near them. Matrices that miss the equalities by r_i still show, for all x with |x_i| ≤ R,
min_k λ_min(F^k(x)) ≤ (Σ_k ⟨F_0^k, Z_k⟩ + R Σ_i |r_i|) / Σ_k tr Z_k: no such x has a larger margin.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.certify.definite import is_positive_definite
from lmic.certify.finite import FiniteProblem, Functional
from lmic.certify.lower import Dual, lower_bound, products
from lmic.certify.statement import to_flint
from lmic.errors import CertificateError

Array: TypeAlias = NDArray[Any]

#: largest relative margin that still counts as none
MARGIN = Fraction(1, 10**6)


@dataclass(frozen=True)
class Infeasible:
    """Dual matrices for the finite LMIs of ``functionals`` that show that these have no solution.

    With a ``radius``, that they have none with every unknown within ± radius and F_k(x) ≻ margin·I.
    """

    functionals: tuple[Functional, ...]
    dual: Dual
    radius: Fraction | None
    margin: Fraction


def feasibility_of(problem: FiniteProblem) -> FiniteProblem:
    """The problem with nothing to minimise."""
    return replace(problem, cost=np.full(problem.size, Fraction(0), dtype=object), constant=Fraction(0))


def check_infeasible(problem: FiniteProblem, claim: Infeasible) -> None:
    """Raise CertificateError unless the dual matrices prove the claim."""
    problem = feasibility_of(problem)
    if claim.radius is None:
        proves = lower_bound(problem, claim.dual) >= 0 and not is_zero(claim.dual)
    else:
        proves = largest_margin(problem, claim) <= claim.margin <= MARGIN
    if not proves:
        raise CertificateError("the dual matrices do not show that the LMIs have no solution")


def largest_margin(problem: FiniteProblem, claim: Infeasible) -> Fraction:
    """What the least eigenvalue over all LMIs cannot exceed for |x_i| ≤ radius."""
    matrices = claim.dual.matrices
    if not problem.rational:
        raise CertificateError("a bound on the margin takes data that are rational")
    if any(face is not None for face in claim.dual.faces) or claim.dual.pivots or claim.radius is None:
        raise CertificateError("a bound on the margin takes whole dual matrices and a radius")
    for matrix, lmi in zip(matrices, problem.lmis, strict=True):
        if matrix.shape != (lmi.order, lmi.order) or not is_positive_definite(to_flint(matrix)):
            raise CertificateError("a dual matrix is not positive definite")
    constant, *misses = products(problem, matrices)
    trace = sum((sum(np.diag(matrix), Fraction(0)) for matrix in matrices), Fraction(0))
    return Fraction((constant + claim.radius * sum(map(abs, misses), Fraction(0))) / trace)


def is_zero(dual: Dual) -> bool:
    """Whether all Z = V W Vᵀ with W ≻ 0 are zero, which proves nothing: no W has a row, or its V vanishes."""
    return not any(
        matrix.size and (face is None or face.any()) for matrix, face in zip(dual.matrices, dual.faces, strict=True)
    )
