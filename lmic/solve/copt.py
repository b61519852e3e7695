"""COPT through its own API (interior point, commercial; needs the package coptpy).

Without a licence COPT takes small problems, and that is how it is tested.
"""

from __future__ import annotations

import ctypes
import logging
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from typing import Any

import coptpy
import numpy as np
import scipy.sparse as sps

from lmic.algebra import svec
from lmic.errors import SolverError
from lmic.solve.cone import ConeAnswer, ConeData, Status, no_answer

_STATUS = {
    coptpy.COPT.OPTIMAL: (Status.SOLVED, "optimal"),
    coptpy.COPT.IMPRECISE: (Status.ALMOST, "imprecise"),
    # COPT gives no certificate: a search for the largest margin decides, and another solver finds the ray
    coptpy.COPT.INFEASIBLE: (Status.INFEASIBLE, "infeasible"),
    coptpy.COPT.UNBOUNDED: (Status.FAILED, "unbounded"),
}
_FINE = {"FeasTol": 1e-9, "DualTol": 1e-9, "RelGap": 1e-9}
_ROUGH = {"FeasTol": 1e-6, "DualTol": 1e-6}


class COPT:
    """Minimise with COPT; ``parameters`` overrides lmic's by COPT's names."""

    name = "copt"

    def __init__(self, **parameters: Any) -> None:
        self.parameters = parameters

    def __call__(self, data: ConeData, rough: bool = False) -> ConeAnswer:
        """Solve the cone problem; COPT takes matrices entry by entry, and rows where the order is 1."""
        scale = float(np.abs(data.cost).max(initial=0.0)) or 1.0
        try:
            return self._solve(_environment().createModel("lmic"), data, scale, rough)
        except coptpy.CoptError as error:
            if "licen" in str(error).lower() or "size" in str(error).lower():
                raise SolverError(
                    f"COPT refuses the problem ({error}); install a licence, or take another solver"
                ) from error
            return no_answer(data, str(error))

    def _solve(self, model: Any, data: ConeData, scale: float, rough: bool) -> ConeAnswer:
        parameters = {"Logging": 0, **(_ROUGH if rough else _FINE), **self.parameters}
        for name, value in parameters.items():
            model.setParam(name, value)
        free = model.addVars(len(data.cost), lb=-coptpy.COPT.INFINITY)
        variables = list(free.values())
        model.setObjective(
            coptpy.quicksum(variable * float(c) for variable, c in zip(variables, data.cost / scale, strict=True) if c)
        )
        columns = sps.csr_array(sps.hstack([sps.csc_array(data.offset[:, None]), data.matrix]))
        starts = np.concatenate([[0], np.cumsum(data.orders * (data.orders + 1) // 2)])
        rows = []
        for order, start, end in zip(data.orders.tolist(), starts[:-1], starts[1:], strict=True):
            part = sps.csc_array(columns[start:end])
            if order == 1:
                rows.append(_row(model, part, variables))
            else:
                _lmi(model, part, order, variables)
        model.solve()
        status, word = _STATUS.get(model.status, (Status.FAILED, f"status {model.status}"))
        iterations = int(model.barrieriter)
        if not status.usable:
            return replace(no_answer(data, word, iterations), status=status)
        y = np.array([variable.x for variable in variables])
        linear = np.repeat(data.orders == 1, np.diff(starts))
        # of matrices COPT gives lower triangles, column by column, without √2
        matrices = data.orders[data.orders > 1]
        slack, dual = data.matrix @ y + data.offset, np.zeros(len(data.offset))
        dual[linear] = [row.pi for row in rows]
        if len(matrices):
            place = svec.lower_by_columns(matrices)
            weights = np.concatenate([svec.weights(int(order)) for order in matrices])
            slack[~linear] = np.array(model.getLmiSlacks())[place] * weights
            dual[~linear] = np.array(model.getLmiDuals())[place] * weights
        return ConeAnswer(status, y, slack, dual * scale, iterations, word)


@cache
def _environment() -> Any:
    """COPT's environment, made once; what it prints of its licence goes to the log and not to the output."""
    config = coptpy.EnvrConfig()
    config.set("nobanner", "1")
    with _output_to_log():
        return coptpy.Envr(config)


@contextmanager
def _output_to_log() -> Iterator[None]:
    """What C code prints meanwhile becomes a message of the logger "lmic.copt"."""
    sys.stdout.flush()
    kept = os.dup(1)
    with tempfile.TemporaryFile() as printed:
        try:
            os.dup2(printed.fileno(), 1)
            yield
        finally:
            ctypes.CDLL(None).fflush(None)
            os.dup2(kept, 1)
            os.close(kept)
            printed.seek(0)
            logging.getLogger("lmic.copt").info(printed.read().decode(errors="replace"))


def _row(model: Any, part: sps.csc_array, variables: list[Any]) -> Any:
    """An LMI of order 1 as a linear inequality."""
    entries = sps.coo_array(part)
    terms = zip(entries.coords[1].tolist(), entries.data.tolist(), strict=True)
    total = coptpy.quicksum(variables[j - 1] * value for j, value in terms if j)
    return model.addConstr(total >= -float(part[0, 0]))


def _lmi(model: Any, part: sps.csc_array, order: int, variables: list[Any]) -> None:
    """An LMI, each of its matrices by the entries of the lower triangle."""
    small, large = svec.triangle(order)
    weights = svec.weights(order)
    expression = coptpy.LmiExpr()
    for j in np.flatnonzero(np.diff(part.indptr)).tolist():
        packed, values = (
            part.indices[part.indptr[j] : part.indptr[j + 1]],
            part.data[part.indptr[j] : part.indptr[j + 1]],
        )
        matrix = model.addSparseMat(
            order, large[packed].tolist(), small[packed].tolist(), (values / weights[packed]).tolist()
        )
        if j:
            expression.addTerm(variables[j - 1], matrix)
        else:
            expression.addConstant(coptpy.SymMatExpr(matrix))
    model.addConstr(expression)
