"""MOSEK's optimizer API (interior point, commercial; needs the package Mosek and a licence).

This was written against the documented API of MOSEK 11 and is tested without a licence as far as the
data that MOSEK is handed, which its own writer gives back, and the way in which its answer is taken.
"""

from __future__ import annotations

from typing import Any

import mosek
import numpy as np
import scipy.sparse as sps

from lmic.algebra import svec
from lmic.errors import SolverError
from lmic.solve.cone import ConeAnswer, ConeData, Status, no_answer

_STATUS = {
    mosek.solsta.optimal: Status.SOLVED,
    mosek.solsta.prim_and_dual_feas: Status.ALMOST,
    mosek.solsta.prim_infeas_cer: Status.INFEASIBLE,
    mosek.solsta.dual_infeas_cer: Status.UNBOUNDED,
}
_TOLERANCES = ("intpnt_co_tol_pfeas", "intpnt_co_tol_dfeas", "intpnt_co_tol_rel_gap")
_FINE, _ROUGH = 1e-10, 1e-6


class Mosek:
    """Minimise with MOSEK; ``parameters`` are doubles by MOSEK's names, such as intpnt_co_tol_rel_gap=1e-9."""

    name = "mosek"

    def __init__(self, **parameters: float) -> None:
        self.parameters = parameters

    def __call__(self, data: ConeData, rough: bool = False) -> ConeAnswer:
        """Solve the cone problem; MOSEK takes svec of the lower triangles, column by column."""
        place = svec.lower_by_columns(data.orders)
        scale = float(np.abs(data.cost).max(initial=0.0)) or 1.0
        with mosek.Task() as task:
            self._fill(task, data, scale, rough)
            try:
                task.optimize()
            except mosek.Error as error:
                if "license" in str(error.errno):
                    raise SolverError(
                        f"MOSEK has no licence ({error.errno}); install one, or take another solver"
                    ) from error
                return no_answer(data, str(error))
            if not task.solutiondef(mosek.soltype.itr):
                return no_answer(data, "no solution")
            word = task.getsolsta(mosek.soltype.itr)
            return ConeAnswer(
                _STATUS.get(word, Status.FAILED),
                np.array(task.getxx(mosek.soltype.itr)),
                np.array(task.evaluateaccs(mosek.soltype.itr))[place],
                np.array(task.getaccdotys(mosek.soltype.itr))[place] * scale,
                int(task.getintinf(mosek.iinfitem.intpnt_iter)),
                str(word).removeprefix("solsta."),
            )

    def _fill(self, task: Any, data: ConeData, scale: float, rough: bool) -> None:
        """Affine expressions in MOSEK's order of the entries, each LMI in its cone."""
        size, rows = len(data.cost), len(data.offset)
        place = svec.lower_by_columns(data.orders)
        entries = sps.coo_array(data.matrix)
        constants = np.zeros(rows)
        constants[place] = data.offset
        task.appendvars(size)
        task.putvarboundsliceconst(0, size, mosek.boundkey.fr, -np.inf, np.inf)
        task.putclist(np.arange(size, dtype=np.int32), data.cost / scale)
        task.putobjsense(mosek.objsense.minimize)
        task.appendafes(rows)
        task.putafefentrylist(place[entries.coords[0]], entries.coords[1].astype(np.int32), entries.data)
        task.putafegslice(0, rows, constants)
        start = 0
        for order in map(int, data.orders):
            length = svec.length(order)
            domain = task.appendrplusdomain(1) if order == 1 else task.appendsvecpsdconedomain(length)
            task.appendaccseq(domain, start, None)
            start += length
        tolerances = dict.fromkeys(_TOLERANCES, _ROUGH if rough else _FINE)
        for name, value in {**tolerances, **self.parameters}.items():
            task.putdouparam(getattr(mosek.dparam, name), value)
