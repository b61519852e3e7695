"""The outcome of a relaxation: K LMIs of one pattern."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from math import prod
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.compiler.parametric import ParametricLMI

Array: TypeAlias = NDArray[Any]


class Soundness(StrEnum):
    """What a solution of the finite LMIs says about all parameters."""

    EXACT = "exact"
    SUFFICIENT = "sufficient"
    SAMPLED = "sampled"

    @staticmethod
    def weakest(several: Sequence[Soundness]) -> Soundness:
        """The soundness of a conclusion that rests on several."""
        order = list(Soundness)
        return max(several, key=order.index, default=Soundness.EXACT)


@dataclass(frozen=True)
class AxisRelaxation:
    """One axis made finite: LMI k takes monomial m with weight ``weights[k, m]``.

    ``labels`` name the K choices. ``implying`` are the choices of which all others are convex
    combinations, ``ends`` those at the corners of the domain; None stands for all.
    """

    method: str
    weights: Array
    labels: tuple[str, ...]
    soundness: Soundness
    implying: Array | None = None
    ends: Array | None = None


@dataclass(frozen=True)
class LMIFamily:
    """K LMIs F_k(x) = Σ_m weights[k, m] F_m(x) ≻ 0 of one pattern.

    ``weights`` has shape (K, M). The LMIs are combinations of the choices on each axis, the last
    axis running fastest; ``members`` are their numbers among all combinations.
    """

    lmi: ParametricLMI
    weights: Array
    axes: tuple[AxisRelaxation, ...]
    members: Array = field(repr=False)

    def __len__(self) -> int:
        return len(self.weights)

    @property
    def soundness(self) -> Soundness:
        """The weakest of the axes'."""
        return Soundness.weakest([axis.soundness for axis in self.axes])

    @property
    def methods(self) -> tuple[str, ...]:
        """The relaxation of each axis."""
        return tuple(axis.method for axis in self.axes)

    def label(self, k: int) -> tuple[str, ...]:
        """Vertex, monomial or grid point of LMI k on each axis."""
        if not self.axes:
            return ()
        choice = np.unravel_index(int(self.members[k]), [len(axis.labels) for axis in self.axes])
        return tuple(axis.labels[int(c)] for axis, c in zip(self.axes, choice, strict=True))

    @property
    def whole(self) -> bool:
        """Whether no combination of the axes' choices is left out."""
        return len(self.members) == prod(len(axis.labels) for axis in self.axes)

    @property
    def implying(self) -> Array:
        """Numbers of LMIs whose convex combinations are all the others: these imply the whole family.

        With one axis' weights a convex combination of others', so is the LMI, for every choice on the other axes.
        """
        if not self.whole:
            return np.arange(len(self))
        return self._combinations([axis.implying for axis in self.axes])

    @property
    def ends(self) -> Array:
        """Numbers of LMIs at the corners of every axis' domain."""
        if not self.whole:
            return np.arange(len(self))
        return self._combinations([axis.ends for axis in self.axes])

    def _combinations(self, chosen: Sequence[Array | None]) -> Array:
        shape = [len(axis.labels) for axis in self.axes]
        if not shape:
            return np.arange(len(self))
        choices = [np.arange(count) if some is None else some for some, count in zip(chosen, shape, strict=True)]
        return np.ravel_multi_index(np.ix_(*choices), shape).ravel()

    def subset(self, chosen: Array) -> LMIFamily:
        """Only the LMIs numbered ``chosen``."""
        return replace(self, weights=self.weights[chosen], members=self.members[chosen])

    @property
    def values(self) -> Array:
        """Coefficients of the K LMIs over the pattern, shape (K, pattern)."""
        return np.ascontiguousarray((self.lmi.coefficients.T @ self.weights.T).T)

    def packed(self, x: Array) -> Array:
        """The K matrices at x, packed without √2, shape (K, order(order+1)/2)."""
        lmi = self.lmi
        values = np.concatenate([[1.0], x])[lmi.columns]
        contract = sps.csr_array(
            (values, (np.arange(len(values)), lmi.rows)), shape=(len(values), svec.length(lmi.order))
        )
        return self.weights @ np.asarray((lmi.coefficients @ contract).todense())

    def matrices(self, x: Array) -> Array:
        """The K matrices F_k(x), shape (K, order, order)."""
        return svec.unpack(self.packed(x), self.lmi.order)
