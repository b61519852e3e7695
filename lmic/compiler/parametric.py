"""The record between binding and relaxing: an LMI as monomials times pencils."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sps
import sympy as sp
from numpy.typing import NDArray

from lmic.algebra.polynomials import Monomials
from lmic.errors import Place

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class ParametricLMI:
    """F(θ, x) = Σ_m monomials[m](θ) · F_m(x) ≻ 0.

    Entry p of the pattern is the packed matrix entry ``rows[p]`` (see ``lmic.algebra.svec``) of the
    coefficient of x[``columns[p]`` - 1], or of the constant F_m0 where ``columns[p]`` is 0.
    ``coefficients`` is a sparse monomials x pattern array.
    """

    place: Place
    partition: tuple[int, ...]
    monomials: Monomials
    rows: Array
    columns: Array
    coefficients: sps.csr_array

    @property
    def order(self) -> int:
        """Order of the matrix F."""
        return sum(self.partition)

    def fixed(self, values: Mapping[sp.Symbol, float]) -> ParametricLMI:
        """With the given scalars put in their values."""
        known, rest = self.monomials.split(set(values))
        if not known.atoms:
            return self
        merged, inverse = rest.merged()
        weights = known.evaluate({symbol: np.array([value]) for symbol, value in values.items()})[0]
        gather = sps.csr_array((weights, (inverse, np.arange(len(weights)))), shape=(len(merged), len(weights)))
        return replace(self, monomials=merged, coefficients=(gather @ self.coefficients).tocsr())

    def renamed(self, new: Mapping[sp.Symbol, sp.Symbol]) -> ParametricLMI:
        """With symbols made equal to others; monomials that become equal are added up."""
        if not new:
            return self
        monomials, inverse = self.monomials.renamed(new).merged()
        gather = sps.csr_array(
            (np.ones(len(inverse)), (inverse, np.arange(len(inverse)))), shape=(len(monomials), len(inverse))
        )
        return replace(self, monomials=monomials, coefficients=(gather @ self.coefficients).tocsr())
