"""SDPA in 200-bit arithmetic, for problems that double precision does not solve (optional extra).

SDPA reads doubles; its answer is read at full length from its result file.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from importlib import import_module, metadata
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias

import flint
import numpy as np
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.errors import LmicError
from lmic.solve.cone import ConeAnswer, ConeData, Status

Array: TypeAlias = NDArray[Any]

PACKAGE = "sdpa-multiprecision"
_DIGITS = "%+.70Fe"
_OPTIONS: Mapping[str, Any] = {
    "maxIteration": 400,
    "epsilonStar": 1e-36,
    "epsilonDash": 1e-36,
    "lambdaStar": 1e6,
    "omegaStar": 2.0,
    "lowerBound": -1e30,
    "upperBound": 1e30,
    "betaStar": 0.1,
    "betaBar": 0.3,
    "gammaStar": 0.9,
    "print": "no",
    "xPrint": _DIGITS,
    "yPrint": _DIGITS,
    "sPrint": _DIGITS,
    "numThreads": 1,
}
_ROUGH = {"epsilonStar": 1e-8, "epsilonDash": 1e-8}
_STATUS = {
    "pdOPT": Status.SOLVED,
    "pdFEAS": Status.ALMOST,
    "pFEAS": Status.ALMOST,
    "dFEAS": Status.ALMOST,
    # SDPA's primal is the problem in the unknowns
    "pFEAS_dINF": Status.UNBOUNDED,
    "pUNBD": Status.UNBOUNDED,
    "pINF_dFEAS": Status.INFEASIBLE,
    "dUNBD": Status.INFEASIBLE,
}


@dataclass(frozen=True)
class Block:
    """An LMI in doubles: value in (row, col), row ≤ col, of the matrix of ``columns``; column 0 is the constant."""

    order: int
    columns: Array
    rows: Array
    cols: Array
    values: Array


@dataclass(frozen=True)
class Answer:
    """The unknowns, each LMI and its dual matrix, with all the digits that SDPA has; ``word`` is its own."""

    x: list[Fraction]
    slacks: list[flint.fmpq_mat]
    duals: list[flint.fmpq_mat]
    iterations: int
    word: str

    @property
    def status(self) -> Status:
        """What SDPA's word says."""
        return _STATUS.get(self.word, Status.FAILED)


class SDPA:
    """Minimise with SDPA at 200 bits; ``options`` override lmic's by SDPA's names."""

    name = "sdpa"

    def __init__(self, **options: Any) -> None:
        self.options = options

    def __call__(self, data: ConeData, rough: bool = False) -> ConeAnswer:
        """Solve the cone problem; its doubles are taken as they are, less the rounding of svec's √2."""
        answer = solve_blocks(data.cost, _blocks(data), {**(_ROUGH if rough else {}), **self.options})
        return ConeAnswer(
            answer.status,
            np.array([float(value) for value in answer.x]),
            _packed(answer.slacks),
            _packed(answer.duals),
            answer.iterations,
            answer.word,
        )


# The call -------------------------------------------------------------------------------------------


def solve_blocks(cost: Array, blocks: Sequence[Block], options: Mapping[str, Any]) -> Answer:
    """Minimise cost·x with every block positive semidefinite; ``options`` are SDPA's. Raises LmicError without SDPA.

    SeDuMi's form: its y are our unknowns, its x our dual matrices.
    """
    solve_sdpa, param, cone = _package()
    matrices = [full(block, len(cost)) for block in blocks]
    stacked = sps.vstack(matrices, format="csc")
    with TemporaryDirectory() as directory:
        file = Path(directory) / "result"
        settings = param({**_OPTIONS, **options, "sdpaResult": str(file)}, True)
        *_, info = solve_sdpa(
            sps.csc_matrix(-stacked[:, 1:].T),
            sps.csc_matrix(-np.asarray(cost, dtype=float)[:, None]),
            sps.csc_matrix(stacked[:, [0]]),
            cone(s=tuple(block.order for block in blocks)),
            settings,
        )
        ctypes.CDLL(None).fflush(None)  # SDPA leaves the end of its file in the C library's buffer
        text = file.read_text()
    orders = [block.order for block in blocks]
    return Answer(
        _numbers(_section(text, "xVec")),
        _matrices(_numbers(_section(text, "xMat")), orders),
        _matrices(_numbers(_section(text, "yMat")), orders),
        int(info["iteration"]),
        str(info["phasevalue"]),
    )


def _package() -> tuple[Any, Any, Any]:
    """The three entries of the package; another package, in double precision, has the same import name."""
    try:
        metadata.version(PACKAGE)
    except metadata.PackageNotFoundError as error:
        raise LmicError(
            f"multiprecision needs the package {PACKAGE}; install it with pip install 'lmic[multiprecision]'"
        ) from error
    try:
        metadata.version("sdpa-python")
    except metadata.PackageNotFoundError:
        solve_sdpa = import_module("sdpap.sdpacall.sdpacall").solve_sdpa
        return solve_sdpa, import_module("sdpap.param").param, import_module("sdpap.symcone").SymCone
    raise LmicError(
        f"sdpa-python and {PACKAGE} install the same module sdpap, in different precision; "
        f"uninstall both and install {PACKAGE} alone"
    )


def _section(text: str, name: str) -> str:
    """What follows ``name =`` in the result file, up to the next assignment."""
    found = re.search(rf"{name} =\s*(.*?)(?=\n\s*\w+ =|\n\s*main loop|\Z)", text, re.DOTALL)
    if found is None:
        raise LmicError(f"SDPA's result has no {name}; the installed version writes another format than 0.2.3")
    return found.group(1)


def _numbers(text: str) -> list[Fraction]:
    return [Fraction(number) for number in re.findall(r"[+-]\d+(?:\.\d+)?(?:e[+-]?\d+)?", text)]


def _matrices(numbers: Sequence[Fraction], orders: Sequence[int]) -> list[flint.fmpq_mat]:
    if len(numbers) != sum(order**2 for order in orders):
        raise LmicError("SDPA's result does not hold a matrix for each LMI; the installed version is not 0.2.3")
    found, start = [], 0
    for order in orders:
        entries = [flint.fmpq(f.numerator, f.denominator) for f in numbers[start : start + order**2]]
        matrix = flint.fmpq_mat(order, order, entries)
        found.append((matrix + matrix.transpose()) / 2)  # rounded entry by entry
        start += order**2
    return found


# Between the forms of a problem ---------------------------------------------------------------------


def full(block: Block, size: int) -> sps.coo_array:
    """vec of the constant and of every unknown's matrix, as columns."""
    off = block.rows != block.cols
    places = np.concatenate([block.rows * block.order + block.cols, block.cols[off] * block.order + block.rows[off]])
    columns = np.concatenate([block.columns, block.columns[off]])
    values = np.concatenate([block.values, block.values[off]])
    return sps.coo_array((values, (places, columns)), shape=(block.order**2, size + 1))


def _blocks(data: ConeData) -> list[Block]:
    """The LMIs of a cone problem, √2 taken out."""
    stacked = sps.csr_array(sps.hstack([sps.csc_array(data.offset[:, None]), data.matrix]))
    found, start = [], 0
    for order in map(int, data.orders):
        part = sps.coo_array(stacked[start : start + svec.length(order)])
        rows, cols = svec.triangle(order)
        packed, columns = part.coords
        values = part.data / svec.weights(order)[packed]
        found.append(Block(order, columns, rows[packed], cols[packed], values))
        start += svec.length(order)
    return found


def _packed(matrices: Sequence[flint.fmpq_mat]) -> Array:
    """svec of the matrices, one after another."""
    parts = []
    for matrix in matrices:
        order = matrix.nrows()
        rows, cols = svec.triangle(order)
        entries = [matrix[int(i), int(j)] for i, j in zip(rows, cols, strict=True)]
        parts.append(np.array([int(e.p) / int(e.q) for e in entries]) * svec.weights(order))
    return np.concatenate(parts)
