"""One-dimensional searches over a given scalar: the theorem is bound once and re-bound per value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmic.compiler.bind import Binding
from lmic.errors import LmicError, Place
from lmic.interrupts import keeping
from lmic.pipeline import Result, finish, run
from lmic.relax.relax import Relaxation
from lmic.solve.cone import ConeSolver, Status
from lmic.solve.solution import ABSOLUTE

#: objectives that differ by less, relatively, are the same
FLAT = 1e-8


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

    A best value of zero is found to the square of that, of the interval. The LMIs must be feasible at the end that the
    theorem's goal calls the worse one; where they are at the other too, that is the best. Raises LmicError where they
    are not.
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

    def kept() -> str:
        ends = f"{min(good, bad):.12g}:{max(good, bad):.12g}"
        return f"after {solves} solves {name} = {good:.8g} is the best; go on with --search {name}={ends}"

    least = tolerance * abs(high - low)  # halving alone never comes near zero relative to itself
    with keeping(kept):
        while abs(good - bad) > tolerance * max(abs(good), abs(bad), least):
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

    The best of ``samples`` equally spaced values brackets a search by golden sections and parabolas (Brent), which
    finds the minimum to ``tolerance`` (of the interval) where the objective has one minimum there. It ends as soon as
    the three least values agree to the digits that a solution has, as on a plateau.
    """
    from scipy.optimize import minimize_scalar

    results: dict[float, Result] = {}

    def objective(value: float) -> float:
        if value not in results:
            near = min(results, key=lambda known: abs(known - value)) if len(results) >= samples else None
            problem = finish(binding, {**(given or {}), scalar: value}, relaxation)
            results[value] = run(problem, solver, None if near is None else results[near])
        return _value(results[value])

    def refined(value: float) -> float:
        if _flat(results):
            raise _FlatError
        return objective(value)

    def kept() -> str:
        known = sorted(results)
        if not any(_value(result) < np.inf for result in results.values()):
            return f"no solution was found at {len(known)} values of {scalar}; the same command begins anew"
        best = min(known, key=objective)
        left, right = (
            max((k for k in known if k < best), default=low),
            min((k for k in known if k > best), default=high),
        )
        return (
            f"after {len(known)} solves {scalar} = {best:.8g} is the best, with the objective {objective(best):.8g}; "
            f"go on with --search {scalar}={left:.12g}:{right:.12g}"
        )

    with keeping(kept):
        points = np.linspace(low, high, samples)
        values = [objective(float(point)) for point in points]
        if not np.isfinite(values).any():
            raise LmicError(
                f"the LMIs have no solution at {samples} values of {scalar} from {low:g} to {high:g}; "
                "change the interval",
                Place(binding.theorem.name),
            )
        best = int(np.argmin(values))
        left, right = float(points[max(best - 1, 0)]), float(points[min(best + 1, samples - 1)])
        width = tolerance * (high - low)
        with suppress(_FlatError):
            minimize_scalar(refined, bounds=(left, right), method="bounded", options={"xatol": width})
    value = min(results, key=objective)
    below = max((known for known in results if known < value), default=value)
    above = min((known for known in results if known > value), default=value)
    return Found(scalar, value, above - below, results[value], len(results))


class _FlatError(Exception):
    """Ends a line search that has nothing left to find."""


def _flat(results: Mapping[float, Result]) -> bool:
    """Whether the three least values are the same in the digits that are known of them."""
    values = sorted(map(_value, results.values()))
    return len(values) > 2 and values[2] - values[0] <= FLAT * max(abs(values[0]), ABSOLUTE)


def _value(result: Result) -> float:
    return result.solution.value if result.solution.status.usable else np.inf


def _feasible(result: Result) -> bool:
    return result.solution.status is Status.SOLVED
