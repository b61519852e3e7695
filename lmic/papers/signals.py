"""Signals of a case table: expressions in the step k, or in the place (i, j), as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.algebra.polynomials import atom_values
from lmic.plants.expressions import parse

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class Uniform:
    """Independent values, uniform between ``low`` and ``high``, the same for the same ``seed``."""

    low: float
    high: float
    seed: int = 0


def trajectory_of(texts: Sequence[str] | Uniform, size: Sequence[int]) -> Array:
    """Values of a parameter over ``size`` steps or places, shape (*size, components)."""
    if isinstance(texts, Uniform):
        return np.random.default_rng(texts.seed).uniform(texts.low, texts.high, (*size, 1))
    return signal(texts, size)


def signal(texts: Sequence[str], size: Sequence[int]) -> Array:
    """Values of expressions over ``size`` steps (k) or places (i, j), shape (*size, components)."""
    names = ["k"] if len(size) == 1 else ["i", "j"]
    symbols = {name: sp.Symbol(name) for name in names}
    axes = np.meshgrid(*(np.arange(count, dtype=float) for count in size), indexing="ij")
    values = {symbols[name]: axis for name, axis in zip(names, axes, strict=True)}
    return np.stack(
        [np.broadcast_to(atom_values(parse(text, symbols), values), tuple(size)) for text in texts], axis=-1
    )
