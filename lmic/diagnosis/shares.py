"""Which LMI and which parameter point binds: how the dual's weight is shared out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.compiler.assemble import ConicProblem
from lmic.solve.scaling import slack_matrices

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class Share:
    """The share of one LMI in the dual's weight; ``points`` are its vertex, monomial or grid point on each axis."""

    lmi: str
    points: tuple[str, ...]
    share: float

    @property
    def label(self) -> str:
        """The LMI and its point in one text."""
        return ", ".join((self.lmi, *self.points))


@dataclass(frozen=True)
class Shares:
    """All LMIs, the largest share first; ``by_lmi`` and ``by_point`` add them up."""

    shares: tuple[Share, ...]

    @property
    def by_lmi(self) -> dict[str, float]:
        """The share of each LMI of the theorem over all of its points."""
        return _added([(share.lmi, share.share) for share in self.shares])

    @property
    def by_point(self) -> dict[str, float]:
        """The share of each vertex, monomial or grid point over all LMIs; points of several axes count by each."""
        return _added([(point, share.share) for share in self.shares for point in share.points])


def weights_at(problem: ConicProblem, x: Array, dual: Array) -> Array:
    """⟨Z_k, diag F_k(x)⟩: what widening LMI k by a share of its own diagonal would gain, for every k."""
    duals = slack_matrices(dual, problem.orders)
    slacks = slack_matrices(problem.matrix @ x + problem.offset, problem.orders)
    return np.array([np.diag(z) @ np.abs(np.diag(s)) for z, s in zip(duals, slacks, strict=True)])


def shares_of(problem: ConicProblem, weights: Array) -> Shares:
    """The weights as shares of their sum, with the LMIs' names."""
    weights = np.maximum(weights, 0.0)
    shared = weights / (weights.sum() or 1.0)
    found = [
        Share(family.lmi.place.lmi, family.label(k), float(share))
        for (family, k), share in zip(problem.blocks(), shared, strict=True)
    ]
    return Shares(tuple(sorted(found, key=lambda one: -one.share)))


def _added(parts: list[tuple[str, float]]) -> dict[str, float]:
    sums: dict[str, float] = {}
    for name, share in parts:
        sums[name] = sums.get(name, 0.0) + share
    return dict(sorted(sums.items(), key=lambda item: -item[1]))
