"""One-dimensional searches over a given scalar: the theorem is bound once and re-bound per value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmic.bind import Binding
from lmic.errors import LmicError, Place
from lmic.pipeline import Result, finish, run
from lmic.relax.relax import Relaxation
from lmic.solve.cone import ConeSolver, Status

GOLDEN = (np.sqrt(5.0) - 1) / 2


@dataclass(frozen=True)
class Found:
    """The best value of the scalar, the result there, and how many problems were solved.

    ``other`` is the nearest value on the far side: infeasible for a bisection, the width of the
    last bracket for a line search.
    """

    scalar: str
    value: float
    other: float
    result: Result
    solves: int


def search_scalar(
    binding: Binding,
    scalar: str,
    low: float,
    high: float,
    given: Mapping[str, Any],
    relaxation: Relaxation,
    solver: ConeSolver | Sequence[ConeSolver] | None = None,
) -> Found:
    """Bisection where the theorem declares it for this scalar, a line search otherwise."""
    declared = binding.theorem.bisect
    if declared is not None and declared.scalar.name == scalar:
        return bisect(binding, low, high, given, relaxation, solver)
    return line_search(binding, scalar, low, high, given, relaxation, solver)


def bisect(
    binding: Binding,
    low: float,
    high: float,
    given: Mapping[str, Any] | None = None,
    relaxation: Relaxation | None = None,
    solver: ConeSolver | Sequence[ConeSolver] | None = None,
    tolerance: float = 1e-6,
) -> Found:
    """Best value of the theorem's ``bisect`` scalar in [low, high], to ``tolerance`` (relative).

    The LMIs must be feasible at one end and infeasible at the other, as the theorem's goal says;
    raises LmicError where they are not.
    """
    goal = binding.theorem.bisect
    if goal is None:
        raise LmicError("nothing is declared to be bisected; use a line search", Place(binding.theorem.name))
    name = goal.scalar.name

    def solved(value: float) -> Result:
        return run(finish(binding, {**(given or {}), name: value}, relaxation), solver)

    good, bad = (low, high) if goal.goal == "maximise" else (high, low)
    best, solves = solved(good), 2
    if not _feasible(best):
        raise LmicError(
            f"the LMIs have no solution at {name} = {good:g}; widen the bracket", Place(binding.theorem.name)
        )
    if _feasible(at_bad := solved(bad)):
        return Found(name, bad, bad, at_bad, solves)
    while abs(good - bad) > tolerance * max(abs(good), abs(bad)):
        middle = (good + bad) / 2
        result = solved(middle)
        solves += 1
        if _feasible(result):
            good, best = middle, result
        else:
            bad = middle
    return Found(name, good, bad, best, solves)


def line_search(
    binding: Binding,
    scalar: str,
    low: float,
    high: float,
    given: Mapping[str, Any] | None = None,
    relaxation: Relaxation | None = None,
    solver: ConeSolver | Sequence[ConeSolver] | None = None,
    tolerance: float = 1e-4,
    samples: int = 9,
) -> Found:
    """Value of a given scalar with the least objective in [low, high].

    The best of ``samples`` equally spaced values brackets a golden-section search, which finds
    the minimum to ``tolerance`` (of the interval) where the objective has one minimum there.
    """
    results: dict[float, Result] = {}

    def objective(value: float) -> float:
        if value not in results:
            results[value] = run(finish(binding, {**(given or {}), scalar: value}, relaxation), solver)
        solution = results[value].solution
        return solution.value if solution.status.usable else np.inf

    points = np.linspace(low, high, samples)
    values = [objective(float(point)) for point in points]
    if not np.isfinite(values).any():
        raise LmicError(
            f"the LMIs have no solution at {samples} values of {scalar} from {low:g} to {high:g}; change the interval",
            Place(binding.theorem.name),
        )
    best = int(np.argmin(values))
    left, right = float(points[max(best - 1, 0)]), float(points[min(best + 1, samples - 1)])
    while right - left > tolerance * (high - low):
        inner, outer = right - GOLDEN * (right - left), left + GOLDEN * (right - left)
        if objective(inner) <= objective(outer):
            right = outer
        else:
            left = inner
    value = min(results, key=objective)
    return Found(scalar, value, right - left, results[value], len(results))


def _feasible(result: Result) -> bool:
    return result.solution.status is Status.SOLVED
