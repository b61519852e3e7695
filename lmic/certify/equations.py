"""Sparse systems of linear equations, exact or in balls.

What can be solved one equation at a time, is; flint solves the rest as a dense matrix. Systems that are triangular
in some order of their rows and columns take time in proportion to their entries.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeAlias

from lmic.certify.balls import is_zero

#: flint's rational numbers or its balls
Number: TypeAlias = Any


def solve(system: Mapping[tuple[int, int], Number], right: Sequence[Number], matrix: Any) -> list[Number]:
    """x with Σ_j system[i, j]·x[j] = right[i] for every i; ``matrix`` is flint's class of dense matrices.

    Entries that are absent are zero. Raises ZeroDivisionError where the system is singular, or may be.
    """
    size = len(right)
    rows: list[dict[int, Number]] = [{} for _ in range(size)]
    columns: list[list[int]] = [[] for _ in range(size)]
    for (i, j), value in system.items():
        if not is_zero(value):  # a ball that may hold zero stays
            rows[i][j] = value
            columns[j].append(i)
    first, last = _elimination([list(row) for row in rows], columns)
    x: list[Number] = [None] * size

    def solved(i: int, j: int | None = None) -> Number:
        """The right-hand side of equation i less all that is known of its left."""
        return right[i] - sum(value * x[k] for k, value in rows[i].items() if k != j and x[k] is not None)

    for i, j in first:
        x[j] = solved(i, j) / rows[i][j]
    eliminated = [*first, *last]
    inner = sorted(set(range(size)).difference(i for i, _ in eliminated))
    unknown = sorted(set(range(size)).difference(j for _, j in eliminated))
    if inner:
        core = matrix(len(inner), len(inner), [rows[i].get(j, 0) for i in inner for j in unknown])
        found = core.solve(matrix(len(inner), 1, [solved(i) for i in inner])).entries()
        for j, value in zip(unknown, found, strict=True):
            x[j] = value
    for i, j in reversed(last):
        x[j] = solved(i, j) / rows[i][j]
    return x


def _elimination(
    rows: Sequence[Sequence[int]], columns: Sequence[Sequence[int]]
) -> tuple[list[tuple[int, int]], list[tuple[int, int]]]:
    """Equations to solve before all others, in order, and after all others, in reverse, each for one unknown.

    Before: those in which one unknown is left. After: those which alone hold an unknown.
    """
    live_rows, live_columns = set(range(len(rows))), set(range(len(columns)))

    def peeled(
        lines: Sequence[Sequence[int]], across: Sequence[Sequence[int]], here: set[int], there: set[int]
    ) -> Iterator[tuple[int, int]]:
        """Lines that cross one live line only, with that one; both die."""
        counts = {k: len(there.intersection(lines[k])) for k in here}
        waiting = [k for k in sorted(here) if counts[k] == 1]
        for k in waiting:
            left = there.intersection(lines[k])
            if len(left) != 1:  # its only one went to another of these
                continue
            (other,) = left
            yield k, other
            here.remove(k)
            there.remove(other)
            for neighbour in here.intersection(across[other]):
                counts[neighbour] -= 1
                if counts[neighbour] == 1:
                    waiting.append(neighbour)

    first = list(peeled(rows, columns, live_rows, live_columns))
    last = [(i, j) for j, i in peeled(columns, rows, live_columns, live_rows)]
    return first, last
