"""Matrix functions as data: entries of exp(tM), evaluated together, once for each value of t."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg
import sympy as sp
from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]


class ExponentialEntry(sp.Function):
    """Entry (row, column) of exp(time · exponent), counted from 0; the exponent is an exact constant matrix."""

    nargs = 4
    is_commutative = True  # a number, though one of its arguments is a matrix

    @property
    def exponent(self) -> sp.ImmutableMatrix:
        """The matrix M of exp(tM)."""
        return self.args[0]

    @property
    def place(self) -> tuple[int, int]:
        """Row and column."""
        return int(self.args[1]), int(self.args[2])

    @property
    def time(self) -> sp.Expr:
        """The scalar t of exp(tM)."""
        return self.args[3]

    @classmethod
    def _should_evalf(cls, argument: sp.Basic) -> int:
        return -1  # an entry stays exact whatever its arguments are

    def _sympystr(self, printer: Any) -> str:
        row, column = self.place
        return f"expm({printer.doprint(self.time)}*{_text(self.exponent)})[{row + 1},{column + 1}]"


@lru_cache(maxsize=64)
def _text(exponent: sp.ImmutableMatrix) -> str:
    """The exponent's rows, written once for all of its entries: atoms are put in order by their texts."""
    return str(exponent.tolist())


def exponential(exponent: sp.MatrixBase, time: sp.Expr, rows: int, columns: slice) -> sp.Matrix:
    """The first ``rows`` rows and the given columns of exp(time · exponent), as a matrix of entries."""
    exact = sp.ImmutableMatrix(exponent)
    wanted = range(*columns.indices(exact.cols))
    return sp.Matrix([[ExponentialEntry(exact, i, j, time) for j in wanted] for i in range(rows)])


def entry_values(atom: ExponentialEntry, time: Array) -> Array:
    """Values of an entry at values of its time, of the same shape."""
    row, column = atom.place
    values = _exponentials(atom.exponent, tuple(time.ravel().tolist()))
    return values[:, row, column].reshape(time.shape)


@lru_cache(maxsize=16)
def _exponentials(exponent: sp.ImmutableMatrix, times: tuple[float, ...]) -> Array:
    """exp(tM) for each t: all entries of a matrix, and all matrices of one exponent, share it."""
    matrix = np.array(exponent.tolist(), dtype=float)
    return np.asarray(scipy.linalg.expm(np.array(times)[:, None, None] * matrix))


def replaced_entries(atom: sp.Expr, values: Mapping[sp.Symbol, Any]) -> tuple[sp.Expr, dict[sp.Symbol, Any]]:
    """The expression with a symbol in place of each entry, and the values with those of the symbols."""
    known, shown = dict(values), {}
    for entry in atom.atoms(ExponentialEntry):
        shown[entry] = sp.Dummy()
        symbols = sorted(entry.time.free_symbols, key=str)
        time = sp.lambdify(symbols, entry.time, "numpy")(*(np.asarray(values[s], dtype=float) for s in symbols))
        known[shown[entry]] = entry_values(entry, np.asarray(time, dtype=float))
    return atom.xreplace(shown), known
