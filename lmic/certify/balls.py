"""Balls for data that are not rational: arrays of them, and back to fractions."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, TypeAlias

import flint
import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]

#: bits of the ball arithmetic
PRECISION = 320


def balls(values: Array) -> Array:
    """An array of fractions, or of balls already, as balls; at flint's current precision."""
    found = np.empty(values.shape, dtype=object)
    for place, value in np.ndenumerate(values):
        found[place] = ball(value)
    return found


def ball(value: Any) -> flint.arb:
    """A fraction as a ball that holds it; a ball stays itself."""
    if isinstance(value, flint.arb):
        return value
    exact = Fraction(value)
    return flint.arb(flint.fmpq(exact.numerator, exact.denominator))


def middle(value: Any) -> Fraction:
    """The midpoint of a ball; a fraction stays itself."""
    if not isinstance(value, flint.arb):
        return Fraction(value)
    mantissa, exponent = value.mid().man_exp()
    return int(mantissa) * Fraction(2) ** int(exponent)


def below(value: flint.arb) -> Fraction:
    """A fraction that is not above anything in the ball."""
    return middle(value.lower())


def has_balls(values: Array) -> bool:
    """Whether any value is a ball."""
    return any(isinstance(value, flint.arb) for value in values.ravel())


def is_zero(value: Any) -> bool:
    """Whether a value is exactly zero."""
    return bool(value.is_zero()) if isinstance(value, flint.arb) else value == 0
