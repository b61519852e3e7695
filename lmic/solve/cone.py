"""The numeric problem a conic solver sees, and the interface every solver fills in."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Protocol, TypeAlias

import numpy as np
import scipy.sparse as sps
from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]


class ConeProblem(Protocol):
    """What solving needs of a problem, compiled or read from a file: minimise cost·x + constant.

    ``matrix`` and ``offset`` hold svec of all LMIs, ``starts`` the first row of each and the number of rows.
    """

    @property
    def cost(self) -> Array:
        """Coefficients of the objective; all zero for a feasibility problem."""
        ...

    @property
    def constant(self) -> float:
        """Constant of the objective."""
        ...

    @property
    def size(self) -> int:
        """Number of scalar unknowns."""
        ...

    @property
    def orders(self) -> Array:
        """Order of each LMI."""
        ...

    @property
    def starts(self) -> Array:
        """First row of each LMI, and the number of rows."""
        ...

    @property
    def matrix(self) -> sps.csc_array:
        """Columns of the unknowns, rows svec of all LMIs."""
        ...

    @property
    def offset(self) -> Array:
        """svec of all LMIs at x = 0."""
        ...

    def label(self, index: int) -> str:
        """Name of the LMI number ``index``."""
        ...


@dataclass(frozen=True)
class ConeData:
    """minimise cost·y subject to matrix·y + offset ∈ product of PSD cones in svec coordinates.

    ``orders`` are the orders of the cones, in the order of the rows.
    """

    cost: Array
    matrix: sps.csc_array
    offset: Array
    orders: Array


class Status(StrEnum):
    """What a solver says of its answer; each member's text is what to do about it."""

    SOLVED = "solved"
    ALMOST = "almost solved"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    FAILED = "failed"

    @property
    def advice(self) -> str:
        """What to do about it."""
        return _ADVICE[self]

    @property
    def usable(self) -> bool:
        """Whether there is a point to look at."""
        return self in (Status.SOLVED, Status.ALMOST)


_ADVICE = {
    Status.SOLVED: "",
    Status.ALMOST: "the solver stopped short of its tolerance; its violation and gap say how far to trust the number",
    Status.INFEASIBLE: "no solution satisfies the LMIs; try a richer basis, a higher Pólya degree, or check the data",
    Status.UNBOUNDED: "the objective has no lower bound; the LMIs leave the minimised quantity free",
    Status.FAILED: "the solver gave up; rescale the data or try other values of the given scalars",
}


@dataclass(frozen=True)
class ConeAnswer:
    """Primal ``y``, slack ``s`` = matrix·y + offset as the solver holds it, dual ``z``; svec coordinates.

    For an infeasible problem ``z`` is the certificate: matrixᵀz = 0, offset·z < 0.
    """

    status: Status
    y: Array
    s: Array
    z: Array
    iterations: int
    word: str


def no_answer(data: ConeData, word: str, iterations: int = 0) -> ConeAnswer:
    """The answer of a solver that gave up, with its word for it."""
    nothing = np.full(len(data.offset), np.nan)
    return ConeAnswer(Status.FAILED, np.full(len(data.cost), np.nan), nothing, nothing, iterations, word)


class ConeSolver(Protocol):
    """A conic solver: one file each, named in ``lmic/solve/registry.py``."""

    name: str

    def __call__(self, data: ConeData, rough: bool = False) -> ConeAnswer:
        """Solve; ``rough`` asks for a quick answer that only serves to find better coordinates.

        Raises SolverError where the solver cannot run at all: no licence, a problem beyond its limits.
        """
        ...
