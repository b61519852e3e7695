"""The answer of stage 6 and what was measured of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

from numpy.typing import NDArray

from lmic.solve.cone import Status

Array: TypeAlias = NDArray[Any]


#: an objective smaller than this is compared absolutely
ABSOLUTE = 1e-6


@dataclass(frozen=True)
class Pass:
    """One call of the solver: its word, and the answer measured on the problem itself."""

    word: str
    iterations: int
    value: float
    bound: float
    violation: float


@dataclass(frozen=True)
class Solution:
    """An answer and what was measured of it.

    ``value`` is the objective at ``x``. ``bound`` is the dual objective, less what the dual misses
    its equalities by, weighed with x: a lower bound to rounding, for solutions of the size of x.
    ``violation`` is the most negative eigenvalue over all LMIs (0 if none is negative),
    ``relative_violation`` the same of every F scaled to unit diagonal slack; ``worst`` names that
    LMI. ``dual`` is svec of the dual matrices, row by row as in the problem.
    """

    status: Status
    x: Array
    value: float
    bound: float
    violation: float
    relative_violation: float
    worst: str
    dual: Array
    lineality: int
    solver: str
    passes: tuple[Pass, ...]
    warnings: tuple[str, ...]

    @property
    def iterations(self) -> int:
        """Iterations of all passes."""
        return sum(step.iterations for step in self.passes)

    @property
    def gap(self) -> float:
        """Distance between the objective and the dual bound, relative to the objective."""
        return abs(self.value - self.bound) / max(abs(self.value), ABSOLUTE)

    @property
    def trusted(self) -> bool:
        """Usable, and nothing to warn of."""
        return self.status.usable and not self.warnings
