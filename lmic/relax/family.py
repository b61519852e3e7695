"""The outcome of a relaxation: K LMIs of one pattern."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic import svec
from lmic.parametric import ParametricLMI
from lmic.polynomials import Monomials

Array: TypeAlias = NDArray[Any]


class Soundness(StrEnum):
    """What a solution of the finite LMIs says about all parameters."""

    EXACT = "exact"
    SUFFICIENT = "sufficient"
    SAMPLED = "sampled"

    @staticmethod
    def weakest(several: Sequence[Soundness]) -> Soundness:
        order = list(Soundness)
        return max(several, key=order.index, default=Soundness.EXACT)


@dataclass(frozen=True)
class AxisRelaxation:
    """One axis made finite: LMI k takes monomial m with weight ``weights[k, m]``.

    ``monomials`` are the axis's parts of the LMI's monomials; ``labels`` name the K choices.
    """

    method: str
    weights: Array
    labels: tuple[str, ...]
    soundness: Soundness


@dataclass(frozen=True)
class LMIFamily:
    """K LMIs F_k(x) = Σ_m weights[k, m] F_m(x) ≻ 0 of one pattern.

    ``weights`` has shape (K, M); ``labels`` has one tuple of axis labels for each LMI.
    """

    lmi: ParametricLMI
    weights: Array
    labels: tuple[tuple[str, ...], ...]
    methods: tuple[str, ...]
    soundness: Soundness

    def __len__(self) -> int:
        return len(self.weights)

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


def axis_part(monomials: Monomials, symbols: set[Any]) -> Monomials:
    """The part of each monomial that lives on an axis."""
    return monomials.split(symbols)[0]
