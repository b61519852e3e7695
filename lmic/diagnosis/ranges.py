"""How widely the numbers are spread: the plant's data, and the LMIs before and after rescaling."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.compiler.assemble import ConicProblem
from lmic.plants.plant import Plant
from lmic.solve import scaling
from lmic.solve.cone import ConeData

Array: TypeAlias = NDArray[Any]

#: entries smaller than this beside the largest of a rescaled problem are rounding
ROUNDING = 1e-13


@dataclass(frozen=True)
class Range:
    """The smallest and the largest size of the entries of something that are not zero."""

    what: str
    smallest: float
    largest: float

    @property
    def spread(self) -> float:
        """Their quotient."""
        return self.largest / self.smallest if self.smallest else 1.0


def data_ranges(plant: Plant) -> tuple[Range, ...]:
    """Of the coefficients of each matrix of a plant."""
    return tuple(_range(name, matrix.coefficients.astype(float)) for name, matrix in plant.matrices.items())


def lmi_ranges(problem: ConicProblem, x: Array | None) -> tuple[Range, ...]:
    """Of all LMIs together as compiled, and as they are when solved for the last time.

    That is in the coordinates that the answer x suggests; without one, or where the problem is too large for
    dense columns, with columns of unit norm.
    """
    data = ConeData(problem.cost, problem.matrix, problem.offset, problem.orders)
    before = _range("as compiled", np.concatenate([data.matrix.data, data.offset]))
    if x is not None and np.isfinite(x).all() and scaling.affordable(data):
        scaled, _ = scaling.rescaled(data, data.matrix @ x + data.offset)
        what = "rescaled by the answer"
    else:
        scaled, _ = scaling.initial(data)
        what = "with columns of unit norm"
    return before, _range(what, np.concatenate([scaled.matrix.data, scaled.offset]), ROUNDING)


def _range(what: str, values: Array, rounding: float = 0.0) -> Range:
    sizes = np.abs(values.ravel())
    largest = float(sizes.max(initial=0.0))
    counted = sizes[sizes > rounding * largest]
    return Range(what, float(counted.min(initial=largest)), largest)
