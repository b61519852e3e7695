"""Vertices: exact where the LMI is affine in the axis's symbols.

An affine matrix function is positive definite on a polytope exactly when it is at its vertices.
"""

from __future__ import annotations

import numpy as np

from lmic.algebra.polynomials import Monomials
from lmic.relax.family import AxisRelaxation, Soundness
from lmic.relax.space import Axis


def vertices(axis: Axis, part: Monomials) -> AxisRelaxation:
    """Evaluate at every vertex of the axis's domain."""
    points = axis.domain.vertices
    weights = part.evaluate({symbol: points[:, k] for k, symbol in enumerate(axis.symbols)})
    if len(weights) != len(points):
        weights = np.broadcast_to(weights, (len(points), weights.shape[1]))
    labels = tuple(f"{axis.name}: vertex {k + 1}" for k in range(len(points)))
    return AxisRelaxation("vertices", weights, labels, Soundness.EXACT)
