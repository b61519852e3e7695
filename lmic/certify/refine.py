"""From a grid to the continuum: points at which a proof fails join the grid until the proof succeeds.

A grid says nothing between its points. The proof on the whole domain names a point where it fails;
with that point's coordinates in the grid the problem is solved again, until the LMIs are proven for
every parameter or the rounds are spent.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp

from lmic.certify.certificate import Certificate
from lmic.certify.ends import blank, lower_only, proven_or_point
from lmic.certify.verify import BUDGET
from lmic.compiler.bind import Binding
from lmic.errors import CertificateError, LmicError, Place
from lmic.pipeline import Result, finish, run
from lmic.relax.grid import Grid, grid_points
from lmic.relax.relax import Relaxation, chosen_grid
from lmic.relax.space import Axis, space
from lmic.solve.cone import ConeSolver

#: solutions of refined grids before giving up
ROUNDS = 20
#: share of the objective given away for the proof
SHARE = 1e-4


@dataclass(frozen=True)
class Refined:
    """A certificate for the whole domain, the last result and its grid, and the results of all rounds.

    ``values`` are what was minimised on each grid, so that the last less the first is what the
    continuum costs.
    """

    certificate: Certificate
    result: Result
    relaxation: Relaxation
    values: tuple[float, ...]


def certify_domain(
    binding: Binding,
    relaxation: Relaxation,
    given: Mapping[str, Any] | None = None,
    sizes: Mapping[str, int] | None = None,
    solver: ConeSolver | Sequence[ConeSolver] | None = None,
    rounds: int = ROUNDS,
    budget: int = BUDGET,
) -> Refined:
    """Solve, prove, refine the grid, until the LMIs are proven on the whole domain.

    ``sizes`` are those that the binding was made with. Raises CertificateError where ``rounds`` do
    not suffice, or no strictly feasible point is found.
    """
    values: list[float] = []
    for _ in range(rounds):
        result = run(finish(binding, given, relaxation), solver)
        if not result.solution.status.usable:
            raise CertificateError(
                f"on the refined grid the solver's answer is '{result.solution.status}'", Place(binding.theorem.name)
            )
        values.append(result.solution.value)
        found = proven_or_point(blank(result, relaxation, given, sizes), result, SHARE, budget)
        if isinstance(found, Certificate):
            try:
                found = lower_only(found, result, relaxation)
            except LmicError as error:
                found = replace(found, notes=(f"no lower bound is proven: {error}",))
            return Refined(found, result, relaxation, tuple(values))
        finer = _with_point(binding, relaxation, found)
        if finer == relaxation:
            break
        relaxation = finer
    raise CertificateError(
        f"{len(values)} grids do not suffice for a proof on the whole domain; begin with a finer one, or allow more",
        Place(binding.theorem.name),
    )


def _with_point(binding: Binding, relaxation: Relaxation, where: Mapping[sp.Symbol, Fraction]) -> Relaxation:
    """The relaxation with the point's coordinates in the grid of every gridded axis."""
    grids: dict[str, Grid | int] = dict(relaxation.grid)
    for axis in space(binding, relaxation.ties, relaxation.joint).axes:
        if any(key in relaxation.grid for key in axis.keys):
            points = grid_points(axis, chosen_grid(axis, relaxation))
            new = np.array([[float(where[symbol]) for symbol in axis.symbols]])
            grids[_key(axis)] = Grid.at(np.unique(np.concatenate([points, new]), axis=0).tolist())
    return replace(relaxation, grid=grids)


def _key(axis: Axis) -> str:
    """The most special name of an axis, which wins over the grid it was given."""
    return axis.keys[0]
