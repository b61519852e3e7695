"""SCS through its own API (first order, MIT): few digits, but none of the failures of an interior point."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sps
import scs

from lmic.algebra import svec
from lmic.solve.cone import ConeAnswer, ConeData, Status

_STATUS = {
    "solved": Status.SOLVED,
    "solved (inaccurate - reached max_iters)": Status.ALMOST,
    "infeasible": Status.INFEASIBLE,
    "unbounded": Status.UNBOUNDED,
}
_FINE = {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iters": 20000}
_ROUGH = {"eps_abs": 1e-5, "eps_rel": 1e-5, "max_iters": 5000}


class SCS:
    """Minimise with SCS; ``settings`` overrides lmic's by SCS's names."""

    name = "scs"

    def __init__(self, **settings: Any) -> None:
        self.settings = settings

    def __call__(self, data: ConeData, rough: bool = False) -> ConeAnswer:
        """Solve the cone problem; SCS takes svec of the lower triangles, column by column."""
        place = svec.lower_by_columns(data.orders)
        ours = np.argsort(place)  # the row of ours that stands at each place of SCS's
        scale = float(np.abs(data.cost).max(initial=0.0)) or 1.0
        problem = {
            "A": sps.csc_matrix(-sps.csr_array(data.matrix)[ours]),
            "b": data.offset[ours],
            "c": data.cost / scale,
        }
        settings = {"verbose": False, **(_ROUGH if rough else _FINE), **self.settings}
        solution = scs.SCS(problem, {"s": [int(order) for order in data.orders]}, **settings).solve()
        info = solution["info"]
        if info["status_val"] == scs.SIGINT:  # SCS takes Ctrl-C for itself
            raise KeyboardInterrupt
        return ConeAnswer(
            _STATUS.get(info["status"], Status.FAILED),
            np.array(solution["x"]),
            np.array(solution["s"])[place],
            np.array(solution["y"])[place] * scale,
            int(info["iter"]),
            str(info["status"]),
        )
