"""A program as the object of a modelling layer: CVXPY, and PICOS where it is installed.

Both have one vector of unknowns, ``x``, in the order of the problem's columns; its names are those of
:meth:`~lmic.interchange.sdp.SDP.name`.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.compiler.assemble import ConicProblem
from lmic.errors import LmicError
from lmic.interchange.sdp import SDP, sdp_of_problem

Array: TypeAlias = NDArray[Any]


def cvxpy_problem(problem: ConicProblem | SDP) -> Any:
    """A ``cvxpy.Problem`` in the variable ``x``; constraint k is LMI k.

    ``x`` has one entry for each scalar unknown, in the order of the problem's columns. The expressions are symmetric
    as they stand: CVXPY looks at the symmetric part alone.
    """
    import cvxpy

    sdp = _sdp(problem)
    x = cvxpy.Variable(sdp.size, name="x")
    constraints = [
        cvxpy.reshape(sps.csr_matrix(matrix[:, 1:]) @ x + matrix[:, [0]].toarray().ravel(), (order, order), order="F")
        >> 0
        for matrix, order in _matrices(sdp)
    ]
    cost = sdp.cost @ x + sdp.constant
    return cvxpy.Problem(cvxpy.Maximize(-cost) if sdp.maximised else cvxpy.Minimize(cost), constraints)


def picos_problem(problem: ConicProblem | SDP) -> Any:
    """A ``picos.Problem`` in the variable ``x``; constraint k is LMI k, named by its label.

    Raises LmicError where PICOS, which is under the GPL, is not installed.
    """
    try:
        import picos
    except ImportError as error:
        raise LmicError("a PICOS problem needs the package picos; install it with pip install 'lmic[picos]'") from error
    sdp = _sdp(problem)
    x = picos.RealVariable("x", sdp.size)
    found = picos.Problem()
    cost = picos.Constant("c", sdp.cost).T * x + sdp.constant
    found.set_objective("max" if sdp.maximised else "min", -cost if sdp.maximised else cost)
    for k, (matrix, order) in enumerate(_matrices(sdp)):
        coefficients = sps.csc_matrix(matrix[:, 1:])
        constant = np.asarray(matrix[:, [0]].toarray())
        value = (picos.Constant(f"F{k + 1}", coefficients) * x + constant).reshaped((order, order))
        found.add_constraint(value >> 0)
    return found


def _sdp(problem: ConicProblem | SDP) -> SDP:
    return sdp_of_problem(problem) if isinstance(problem, ConicProblem) else problem


def _matrices(sdp: SDP) -> list[tuple[sps.csc_array, int]]:
    """vec of each LMI with its order: column 0 the constant, column i that of x[i - 1]."""
    columns = sps.csr_array(sdp.vectorised())
    starts = np.concatenate([[0], np.cumsum(sdp.orders**2)])
    return [(sps.csc_array(columns[starts[k] : starts[k + 1]]), int(order)) for k, order in enumerate(sdp.orders)]
