"""The answer of stage 6 and what was measured of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

from numpy.typing import NDArray

from lmic.solve.cone import Status
from lmic.solve.face_optimum import FaceOptimum

Array: TypeAlias = NDArray[Any]


#: an objective smaller than this is compared absolutely
ABSOLUTE = 1e-6
#: relative uncertainty up to which an objective is a number at all: three digits
TRUSTED_UNCERTAINTY = 1e-3


@dataclass(frozen=True)
class Pass:
    """One call of the solver: its word, and the answer measured on the problem itself.

    ``violation`` is relative to the LMIs' diagonals; ``price`` is what mending it costs.
    """

    word: str
    iterations: int
    value: float
    bound: float
    violation: float
    price: float

    @property
    def gap(self) -> float:
        """Distance between the objective and the dual bound, relative to the objective."""
        return relative_uncertainty(self.value, self.bound, 0.0)

    @property
    def uncertainty(self) -> float:
        """Distance from the dual bound to the objective with its price, relative to the objective."""
        return relative_uncertainty(self.value, self.bound, self.price)


@dataclass(frozen=True)
class Solution:
    """An answer and what was measured of it.

    ``x`` has one entry for each scalar unknown; ``value`` is the objective there. ``bound`` is the dual
    objective, less what the dual misses its equalities by, weighed with x: a lower bound to rounding, for
    solutions of the size of x.
    ``price`` estimates, from the dual, how much the objective rises when the violation is mended.
    ``violation`` is the most negative eigenvalue over all LMIs (0 if none is negative),
    ``relative_violation`` the same of every F scaled to unit diagonal slack; ``worst`` names that
    LMI. ``attained`` is false where the objective falls with every bound on the unknowns that was tried, true
    where it does not, and None where no bound was tried: a small gap alone says nothing of it.
    ``dual`` is svec of the dual matrices, row by row as in the problem. ``handovers`` say which solvers
    failed before this one had an answer, and why. ``on_face`` is the optimum on a face of the
    dual, where the answer was found there.
    """

    status: Status
    x: Array
    value: float
    bound: float
    price: float
    violation: float
    relative_violation: float
    worst: str
    dual: Array
    lineality: int
    solver: str
    passes: tuple[Pass, ...]
    warnings: tuple[str, ...]
    attained: bool | None = None
    handovers: tuple[str, ...] = ()
    on_face: FaceOptimum | None = None

    @property
    def iterations(self) -> int:
        """Iterations of all passes."""
        return sum(step.iterations for step in self.passes)

    @property
    def gap(self) -> float:
        """Distance between the objective and the dual bound, relative to the objective."""
        return relative_uncertainty(self.value, self.bound, 0.0)

    @property
    def uncertainty(self) -> float:
        """Distance from the dual bound to the objective with its price, relative to the objective."""
        return relative_uncertainty(self.value, self.bound, self.price)

    @property
    def trusted(self) -> bool:
        """Usable, and known to three digits; ``uncertainty`` and ``warnings`` say how many more."""
        return self.status.usable and self.uncertainty <= TRUSTED_UNCERTAINTY


def relative_uncertainty(value: float, bound: float, price: float) -> float:
    """(|value − bound| + price) / |value|."""
    return (abs(value - bound) + abs(price)) / max(abs(value), ABSOLUTE)
