"""CVXOPT's conelp (interior point, GPL-3, so that it is an optional extra)."""

from __future__ import annotations

from typing import Any, TypeAlias

import cvxopt
import cvxopt.solvers
import numpy as np
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.solve.cone import ConeAnswer, ConeData, Status, no_answer

Array: TypeAlias = NDArray[Any]

_STATUS = {
    "optimal": Status.SOLVED,
    "primal infeasible": Status.INFEASIBLE,
    "dual infeasible": Status.UNBOUNDED,
}
#: an answer with the word "unknown" is looked at when its residuals and its gap are within this
_NEAR = 1e-5
_FINE = {"abstol": 1e-9, "reltol": 1e-9, "feastol": 1e-9, "maxiters": 50}
_ROUGH = {"abstol": 1e-6, "reltol": 1e-6, "feastol": 1e-6, "maxiters": 50}


class CVXOPT:
    """Minimise with CVXOPT; ``options`` overrides lmic's by CVXOPT's names."""

    name = "cvxopt"

    def __init__(self, **options: Any) -> None:
        self.options = options

    def __call__(self, data: ConeData, rough: bool = False) -> ConeAnswer:
        """Solve the cone problem; CVXOPT takes whole matrices, column by column, without √2."""
        lower, upper, weights = _places(data.orders)
        rows = int((data.orders**2).sum())
        spread = sps.csr_array(
            (np.tile(1 / weights, 2), (np.concatenate([lower, upper]), np.tile(np.arange(len(lower)), 2))),
            shape=(rows, len(lower)),
        )
        spread.data[:] = np.where(spread.data > 1, 1.0, spread.data)  # the diagonal was counted twice
        columns = sps.coo_array(spread @ data.matrix)
        scale = float(np.abs(data.cost).max(initial=0.0)) or 1.0
        options = {"show_progress": False, **(_ROUGH if rough else _FINE), **self.options}
        try:
            found = cvxopt.solvers.conelp(
                cvxopt.matrix(data.cost / scale),
                cvxopt.spmatrix(
                    (-columns.data).tolist(), columns.coords[0].tolist(), columns.coords[1].tolist(), columns.shape
                ),
                cvxopt.matrix(spread @ data.offset),
                {"l": 0, "q": [], "s": [int(order) for order in data.orders]},
                options=options,
            )
        except (ArithmeticError, ValueError) as error:  # a singular system, or more unknowns than the LMIs see
            return no_answer(data, f"{type(error).__name__}: {error}")
        word = str(found["status"])
        status = _STATUS.get(word, Status.ALMOST if _near(found) else Status.FAILED)
        return ConeAnswer(
            status,
            _vector(found["x"], len(data.cost)),
            _vector(found["s"], rows)[lower] * weights,
            _vector(found["z"], rows)[lower] * weights * scale,
            int(found["iterations"]),
            word,
        )


def _places(orders: Array) -> tuple[Array, Array, Array]:
    """Places of the packed entries in the lower and upper triangles of whole matrices, and svec's weights."""
    lower, upper, start = [], [], 0
    for order in map(int, orders):
        small, large = svec.triangle(order)
        lower.append(start + small * order + large)
        upper.append(start + large * order + small)
        start += order**2
    return np.concatenate(lower), np.concatenate(upper), np.concatenate([svec.weights(int(n)) for n in orders])


def _near(found: dict[str, Any]) -> bool:
    """Whether an answer that CVXOPT calls unknown is worth measuring."""
    keys = ("primal infeasibility", "dual infeasibility", "relative gap")
    return all(found[key] is not None and abs(found[key]) <= _NEAR for key in keys)


def _vector(values: Any, length: int) -> Array:
    """CVXOPT's column, or nothing where it has none (half of a certificate of infeasibility)."""
    return np.full(length, np.nan) if values is None else np.array(values, dtype=float).ravel()
