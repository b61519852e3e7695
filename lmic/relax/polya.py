"""Pólya: coefficients of the polynomial made homogeneous on a simplex, times (Σλ)^d.

A point of a polytope is p = Σ_v λ_v V_v with λ in the unit simplex; on a simplex λ = α, on an
interval λ are its two barycentric coordinates (the Bernstein form). If every coefficient of a
homogeneous polynomial in λ is positive definite, the polynomial is on the whole polytope.
Multiplying by (Σλ)^d = 1 first makes the condition weaker, in the limit exact (Pólya 1928; Hardy,
Littlewood, Pólya, *Inequalities*, 2.24). Degree 0 on two simplexes is Lemma 1 of Peixoto et al.
(2025).
"""

from __future__ import annotations

from math import comb
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.algebra.polynomials import Monomials, homogeneous_exponents
from lmic.errors import RelaxationError
from lmic.relax.family import AxisRelaxation, Soundness
from lmic.relax.space import Axis

Array: TypeAlias = NDArray[Any]

#: coefficients on one axis that are still written down
MAX_COEFFICIENTS = 100_000


def polya(axis: Axis, part: Monomials, degree: int) -> AxisRelaxation:
    """Coefficients of total degree deg + ``degree`` in the barycentric coordinates."""
    exponents = part.over(axis.symbols)
    corners = axis.domain.vertices
    target = int(exponents.sum(axis=1).max()) + degree
    count = comb(len(corners) + target - 1, target)
    if count > MAX_COEFFICIENTS:
        raise RelaxationError(
            f"Pólya degree {degree} on {axis.name} makes {count} coefficients; "
            f"take a degree that makes at most {MAX_COEFFICIENTS}"
        )
    targets = homogeneous_exponents(len(corners), target)
    distinct, inverse = np.unique(exponents, axis=0, return_inverse=True)
    forms = np.stack([_form(corners, powers, target, targets) for powers in distinct], axis=1)
    weights = forms[:, inverse.reshape(-1)]
    names = (
        [str(s) for s in axis.symbols] if axis.domain.kind == "simplex" else [f"v{k + 1}" for k in range(len(corners))]
    )
    labels = tuple(_label(axis, names, powers) for powers in targets)
    soundness = Soundness.EXACT if len(corners) == 1 else Soundness.SUFFICIENT
    corner = np.flatnonzero((targets == target).any(axis=1))
    return AxisRelaxation(f"Pólya degree {degree}", weights, labels, soundness, ends=corner)


def _form(corners: Array, powers: Array, target: int, targets: Array) -> Array:
    """Coefficients of Π_i (Σ_v corners[v, i] λ_v)^powers[i] · (Σλ)^rest over ``targets``."""
    form: dict[tuple[int, ...], float] = {(0,) * len(corners): 1.0}
    linear = [corners[:, i] for i, power in enumerate(powers) for _ in range(int(power))]
    for factor in [*linear, *[np.ones(len(corners))] * (target - len(linear))]:
        following: dict[tuple[int, ...], float] = {}
        for monomial, value in form.items():
            for v in np.flatnonzero(factor):
                raised = (*monomial[:v], monomial[v] + 1, *monomial[v + 1 :])
                following[raised] = following.get(raised, 0.0) + value * float(factor[v])
        form = following
    return np.array([form.get(tuple(row), 0.0) for row in targets.tolist()])


def _label(axis: Axis, names: list[str], powers: Array) -> str:
    factors = [name if p == 1 else f"{name}^{p}" for name, p in zip(names, powers, strict=True) if p]
    return f"{axis.name}: " + (" ".join(factors) or "1")
