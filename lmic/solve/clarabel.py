"""Clarabel through its own API (interior point, Apache-2.0)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import clarabel
import numpy as np
import scipy.sparse as sps

from lmic.interrupts import noticed
from lmic.solve.cone import ConeAnswer, ConeData, Status, no_answer

_STATUS = {
    "Solved": Status.SOLVED,
    "AlmostSolved": Status.ALMOST,
    "PrimalInfeasible": Status.INFEASIBLE,
    "AlmostPrimalInfeasible": Status.INFEASIBLE,
    "DualInfeasible": Status.UNBOUNDED,
    "AlmostDualInfeasible": Status.UNBOUNDED,
}


#: in rescaled coordinates these tolerances are reached, and the objective has ten digits or more
_FINE = {"tol_gap_abs": 1e-10, "tol_gap_rel": 1e-10, "tol_feas": 1e-10}
_ROUGH = {"max_iter": 50, "tol_gap_abs": 1e-6, "tol_gap_rel": 1e-6, "tol_feas": 1e-6}

#: what ends a solution that would have led Clarabel to a matrix without eigenvalues, and the settings that avoid it
PANIC = "Panic"
_SHORTER_STEPS = {"max_step_fraction": 0.9}

#: rows from which the multithreaded factorisation is the faster one
_MULTITHREADED_FROM = 1500


class Clarabel:
    """Minimise with Clarabel; ``settings`` overrides lmic's by name."""

    name = "clarabel"

    def __init__(self, **settings: Any) -> None:
        self.settings = settings

    def __call__(self, data: ConeData, rough: bool = False) -> ConeAnswer:
        """Solve the cone problem; where an eigenvalue routine of Clarabel gives up, once more with shorter steps."""
        answer = self._solve(data, rough, {})
        return self._solve(data, rough, _SHORTER_STEPS) if answer.word == PANIC else answer

    def _solve(self, data: ConeData, rough: bool, changed: Mapping[str, Any]) -> ConeAnswer:
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        if data.matrix.shape[0] > _MULTITHREADED_FROM:
            settings.direct_solve_method = "faer"
        for name, value in {**(_ROUGH if rough else _FINE), **changed, **self.settings}.items():
            setattr(settings, name, value)
        size = len(data.cost)
        scale = float(np.abs(data.cost).max(initial=0.0)) or 1.0
        cones = [clarabel.PSDTriangleConeT(int(order)) for order in data.orders]
        solver = clarabel.DefaultSolver(
            sps.csc_matrix((size, size)),
            data.cost / scale,
            sps.csc_matrix(-data.matrix),
            data.offset,
            cones,
            settings,
        )
        try:
            with noticed() as stop:
                # called after each iteration, while Clarabel itself hears no signal
                solver.set_termination_callback(lambda _: stop())
                solution = solver.solve()
        except BaseException as error:
            if type(error).__name__ != "PanicException":  # how a Rust panic arrives in Python
                raise
            return no_answer(data, PANIC)
        word = str(solution.status)
        return ConeAnswer(
            _STATUS.get(word, Status.FAILED),
            np.array(solution.x),
            np.array(solution.s),
            np.array(solution.z) * scale,
            int(solution.iterations),
            word,
        )
