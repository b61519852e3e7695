"""Write a conic problem for other programs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from lmic import svec
from lmic.assemble import ConicProblem
from lmic.files import write_whole


def write_sdpa(problem: ConicProblem, path: Path) -> None:
    """SDPA sparse format: minimise Σ c_i x_i subject to Σ x_i F_i − F_0 ⪰ 0.

    Numbers are written with all their digits. F_0 is the negative of our constant matrix.
    """
    write_whole(path, "\n".join(_sdpa_lines(problem)) + "\n")


def _sdpa_lines(problem: ConicProblem) -> Iterator[str]:
    theorem = problem.binding.theorem
    yield f'"{theorem.name}: {theorem.title}; plant {problem.binding.plant.name}'.replace("\n", " ")
    yield f'"relaxation {problem.soundness.value}; the objective lacks the constant {problem.constant!r}'
    yield str(problem.size)
    yield str(len(problem.orders))
    yield " ".join(str(int(order)) for order in problem.orders)
    yield " ".join(repr(float(c)) for c in problem.cost)
    columns = problem.columns
    block_of = np.repeat(np.arange(len(problem.orders)), np.diff(problem.starts))
    for column in range(problem.size + 1):
        rows = columns.indices[columns.indptr[column] : columns.indptr[column + 1]]
        values = columns.data[columns.indptr[column] : columns.indptr[column + 1]]
        order = np.argsort(rows)
        sign = -1.0 if column == 0 else 1.0
        for row, value in zip(rows[order], values[order], strict=True):
            block = int(block_of[row])
            i, j = svec.triangle(int(problem.orders[block]))
            place = int(row - problem.starts[block])
            entry = value / (1.0 if i[place] == j[place] else np.sqrt(2.0))
            yield f"{column} {block + 1} {i[place] + 1} {j[place] + 1} {sign * float(entry)!r}"
