"""Diagnose a problem: solve it, and measure what its answer, or the lack of one, is due to."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

from lmic.compiler.bases import Choice
from lmic.diagnosis.advice import advice
from lmic.diagnosis.distance import Distance, distance
from lmic.diagnosis.growth import Bounds, growth
from lmic.diagnosis.neighbours import Chosen, Trial, neighbours, trial, try_neighbours
from lmic.diagnosis.ranges import Range, data_ranges, lmi_ranges
from lmic.diagnosis.shares import Shares, shares_of, weights_at
from lmic.diagnosis.unseen import Direction, unseen_directions
from lmic.interrupts import keeping
from lmic.language.theorem import Theorem
from lmic.pipeline import Result
from lmic.plants.plant import Plant
from lmic.relax.relax import Relaxation
from lmic.solve.cone import ConeSolver
from lmic.solve.registry import solvers

#: seconds after which no further neighbour is begun
PATIENCE = 60.0


@dataclass(frozen=True)
class Diagnosis:
    """What was measured of a problem.

    ``binding`` are the shares of the LMIs in the dual at the optimum, or in that of the largest margin where there
    is none. ``distance`` is that margin, for problems without an answer and for those that minimise nothing.
    ``growth`` are the unknowns' sizes, empty without an answer. ``trials`` begin with the choice at hand;
    ``untried`` are the neighbours that patience did not reach. ``advice`` follows from all of these.
    """

    result: Result
    binding: Shares
    distance: Distance | None
    growth: Bounds
    data: tuple[Range, ...]
    lmis: tuple[Range, ...]
    unseen: tuple[Direction, ...]
    trials: tuple[Trial, ...]
    untried: tuple[str, ...]
    advice: tuple[str, ...]


def diagnose(
    theorem: Theorem,
    plant: Plant,
    given: Mapping[str, Any] | None = None,
    dependence: Mapping[str, Choice] | None = None,
    relaxation: Relaxation | None = None,
    sizes: Mapping[str, int] | None = None,
    solver: ConeSolver | Sequence[ConeSolver] | None = None,
    patience: float = PATIENCE,
    advance: Callable[[int, int], None] = lambda more, total: None,
) -> Diagnosis:
    """Solve a theorem for a plant, with the choices of :func:`lmic.compile`, and say what the outcome is due to.

    Neighbouring choices of bases and relaxation are solved too, none being begun after ``patience`` seconds;
    ``advance`` is called with the number of problems that were solved and of all. Raises LmicError where the
    problem cannot be compiled.
    """
    several = solvers() if solver is None else tuple(solver) if isinstance(solver, Sequence) else (solver,)
    chosen = Chosen(theorem, plant, given or {}, dependence or {}, relaxation or Relaxation(), sizes or {})
    start = perf_counter()
    result = chosen.run(several)
    trials = [trial("", result, perf_counter() - start)]
    problem, solution = result.problem, result.solution
    usable = solution.status.usable
    margin = None if usable and problem.cost.any() else distance(problem, several[0])
    bounds = growth(problem, solution.x, several[0]) if usable else Bounds(())
    binding = margin.shares if margin else shares_of(problem, weights_at(problem, solution.x, solution.dual))
    planned = [option for option, _ in neighbours(chosen, problem)]
    advance(1, len(planned) + 1)
    with keeping(lambda: f"{len(trials) - 1} of {len(planned)} neighbours were solved; --patience makes it shorter"):
        for found in try_neighbours(chosen, result, several, patience):
            trials.append(found)
            advance(1, len(planned) + 1)
    unseen = unseen_directions(problem)
    return Diagnosis(
        result,
        binding,
        margin,
        bounds,
        data_ranges(plant),
        lmi_ranges(problem, solution.x if usable else None),
        unseen,
        tuple(trials),
        tuple(planned[len(trials) - 1 :]),
        advice(solution, binding, margin, bounds, unseen, trials),
    )
