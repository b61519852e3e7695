"""The directions in the unknowns that no LMI sees, by the unknowns' names."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmic.compiler.assemble import ConicProblem
from lmic.solve.lineality import lineality

#: parts of a direction that are named, and the share of its largest from which one counts
NAMED, COUNTS = 4, 1e-6


@dataclass(frozen=True)
class Direction:
    """Change the unknowns along this and no LMI changes; ``text`` is its largest parts, ``unknowns`` all it has."""

    unknowns: tuple[str, ...]
    text: str


def unseen_directions(problem: ConicProblem) -> tuple[Direction, ...]:
    """One for each unknown (scalar) that could be left out."""
    found = lineality(problem.matrix)
    directions = []
    for j, column in enumerate(found.left_out.tolist()):
        direction = np.zeros(problem.size)
        direction[column] = 1.0
        direction[found.kept] = -found.combinations[:, j]
        # weighed in the units in which the LMIs feel each unknown
        weight = np.abs(direction * found.norms)
        parts = [k for k in np.argsort(-weight).tolist() if weight[k] > COUNTS * weight.max()]
        direction *= np.sign(direction[parts[0]])
        names = dict.fromkeys(problem.layout.label(k).partition("[")[0] for k in parts)
        terms = [_term(direction[k], problem.layout.label(k)) for k in parts[:NAMED]]
        rest = f" + {len(parts) - NAMED} more" if len(parts) > NAMED else ""
        directions.append(Direction(tuple(names), " + ".join(terms).replace("+ -", "- ") + rest))
    return tuple(directions)


def _term(factor: float, label: str) -> str:
    sign, size = "-" if factor < 0 else "", abs(factor)
    return f"{sign}{label}" if np.isclose(size, 1.0) else f"{sign}{size:.4g} {label}"
