"""Grids of sampling intervals that cover [h_l, h_u]: Algorithm 1 of Mustafa, Chen and Fujioka.

A filter designed at the points h_i keeps the error system stable for all intervals h_k = h_i + θ with
‖Σ_11(h_i)‖∞ ‖Δ(θ)‖ < 1 (Theorem 1), where Σ_11(h) = AΦ(h) (zI − Φ(h))⁻¹, Φ(h) = e^{hA} and
Δ(θ) = ∫_0^θ e^{ηA} dη. Σ_11 does not depend on the filter, so the grid is found before anything is solved.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from lmic.analysis.norms import h_infinity
from lmic.errors import PlantError, RelaxationError
from lmic.plants.plant import Plant
from lmic.relax.grid import Grid

Array: TypeAlias = NDArray[Any]

#: points beyond which a covering is given up (N_0 of Algorithm 1)
MAX_POINTS = 500


class Gain(StrEnum):
    """Which gain decides what a point covers."""

    RIGOROUS = "rigorous"
    PUBLISHED = "published"

    def of(self, alpha: float) -> float:
        """α itself, as Theorem 1 has it; as published, step 4 of Algorithm 1 takes √α."""
        return alpha if self is Gain.RIGOROUS else float(np.sqrt(alpha))


@dataclass(frozen=True)
class Covering:
    """Points h_i, their gains α_i = ‖Σ_11(h_i)‖∞, and the intervals H(h_i, α_i) that they cover, in order."""

    points: tuple[float, ...]
    gains: tuple[float, ...]
    intervals: tuple[tuple[float, float], ...]

    @property
    def grid(self) -> Grid:
        """The points as a grid."""
        return Grid.at([[point] for point in self.points])


def cover(plant: Plant, gain: Gain = Gain.RIGOROUS, parameter: str = "h", exponent: str = "A") -> Covering:
    """The points of Algorithm 1 for a plant whose data are functions of e^{hA}.

    Starts with the middle of the domain and adds the middle of every part that is not covered.
    Raises PlantError where the plant has no such parameter or matrix, or e^{hA} is not Schur;
    RelaxationError where :data:`MAX_POINTS` points do not suffice.
    """
    domain, matrix = plant.domains.get(parameter), plant.matrices.get(exponent)
    if domain is None or len(domain.components) != 1:
        raise PlantError(
            f"{plant.name}: {parameter} is no parameter with one component, so it cannot be covered; name another"
        )
    if matrix is None or matrix.monomials.atoms:
        raise PlantError(f"{plant.name}: a covering of {parameter} needs the constant matrix {exponent}; add it")
    A = matrix.numeric().coefficients[0]
    low, high = float(domain.vertices.min()), float(domain.vertices.max())
    if low <= 0:
        raise PlantError(
            f"{plant.name}: {parameter} reaches {low:g}; sampling intervals are positive; raise its lower end"
        )
    points, gains, intervals = [(low + high) / 2], list[float](), list[tuple[float, float]]()
    while True:
        for point in points[len(gains) :]:
            gains.append(sampled_gain(A, point))
            if not np.isfinite(gains[-1]):
                raise PlantError(
                    f"{plant.name}: {exponent} is not Hurwitz, so no interval around {point:g} is covered; "
                    f"give a --grid"
                )
            intervals.append(tolerated(A, point, gain.of(gains[-1])))
        gaps = _gaps(intervals, low, high)
        if not gaps:
            return Covering(*zip(*sorted(zip(points, gains, intervals, strict=True)), strict=True))
        if len(points) + len(gaps) > MAX_POINTS:
            raise RelaxationError(f"more than {MAX_POINTS} points are needed to cover {parameter}; shrink its domain")
        points += [(left + right) / 2 for left, right in gaps]


def sampled_gain(A: Array, h: float) -> float:
    """‖AΦ(h) (zI − Φ(h))⁻¹‖∞; infinite where A is not Hurwitz."""
    transition = scipy.linalg.expm(h * A)
    identity = np.eye(len(A))
    return h_infinity(transition, identity, A @ transition, 0 * identity, discrete=True)


def tolerated(A: Array, h: float, gain: float) -> tuple[float, float]:
    """H(h, α) of (9): where α‖Δ(θ)‖ < 1 is certain by ‖e^{ηA}‖ ≤ e^{ημ(A)}, η ≥ 0, and by μ(−A) for η < 0.

    The paper prints μ(−A) for μ(A) in the upper end, a misprint.
    """
    return h - _reach(logarithmic_norm(-A), gain), h + _reach(logarithmic_norm(A), gain)


def logarithmic_norm(A: Array) -> float:
    """μ(A), the largest eigenvalue of (A + Aᵀ)/2."""
    return float(np.linalg.eigvalsh((A + A.T) / 2)[-1])


def _reach(growth: float, gain: float) -> float:
    """The θ at which gain · (e^{θμ} − 1)/μ is one; infinite where it stays below."""
    if growth == 0:
        return 1 / gain
    ratio = growth / gain
    return float(np.log1p(ratio)) / growth if ratio > -1 else float("inf")


def _gaps(intervals: list[tuple[float, float]], low: float, high: float) -> list[tuple[float, float]]:
    """The parts of [low, high] outside the open intervals."""
    gaps, reached = [], low
    for left, right in sorted(intervals):
        if left >= reached:
            gaps.append((reached, min(left, high)))
        reached = max(reached, right)
    if reached <= high:
        gaps.append((reached, high))
    return [(left, right) for left, right in gaps if left <= high and right >= low]
