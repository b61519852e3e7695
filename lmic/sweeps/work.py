"""What a worker does: compile once for a line of points, then set the scalars and solve, point after point."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from time import perf_counter
from typing import Any

from lmic.compiler.bind import Binding
from lmic.pipeline import Result, finish, prepare, run
from lmic.sweeps.plan import Key, Line
from lmic.sweeps.search import search_scalar

#: seconds after which a line is handed back, so that what is done is kept and the rest is shared out again
PATIENCE = 6.0

#: what this process compiled last, by the digest of its line
_bindings: dict[str, Binding] = {}


@dataclass(frozen=True)
class Done:
    """The records of the points that were solved, and the part of the line that was not reached."""

    records: tuple[tuple[Key, Mapping[str, Any]], ...]
    rest: Line | None


def solve_line(line: Line, patience: float = PATIENCE) -> Done:
    """Solve the points one after another, each near the last; at least one, and no more after ``patience`` seconds.

    Whatever goes wrong at a point is its record.
    """
    start = perf_counter()
    # one thread for each worker: the threads of several would fight for the cores
    os.environ.setdefault("RAYON_NUM_THREADS", "1")
    records: list[tuple[Key, Mapping[str, Any]]] = []
    near: Result | None = None
    for count, (key, scalars) in enumerate(zip(line.keys, line.scalars, strict=True)):
        if count and perf_counter() - start > patience:
            return Done(tuple(records), line.part(count))
        record, near = _solve(line, scalars, near)
        records.append((key, record))
    return Done(tuple(records), None)


def _solve(line: Line, scalars: Mapping[str, Any], near: Result | None) -> tuple[Mapping[str, Any], Result | None]:
    start = perf_counter()
    try:
        binding = prepared(line)
        extra: dict[str, Any] = {}
        if line.search:
            name, low, high = line.search
            found = search_scalar(binding, name, low, high, scalars, line.relaxation)
            result, extra = found.result, {"found": {name: found.value}, "solves": found.solves}
        else:
            result = run(finish(binding, scalars, line.relaxation), near=near)
    except Exception as error:
        return {"error": f"{type(error).__name__}: {error}", "seconds": _seconds(start)}, None
    return {**result_record(result), **extra, "seconds": _seconds(start)}, result


def result_record(result: Result) -> dict[str, Any]:
    """What a sweep keeps of a result; a number that is not finite is null."""
    solution = result.solution
    return {
        "status": solution.status.value,
        "reports": {name: _number(value) for name, value in result.reports.items()},
        "objective": _number(solution.value),
        "bound": _number(solution.bound),
        "uncertainty": _number(solution.uncertainty),
        "violation": _number(solution.relative_violation),
        "soundness": result.problem.soundness.value,
        "trusted": solution.trusted,
        "iterations": solution.iterations,
        "solves": 1,
    }


def prepared(line: Line) -> Binding:
    """The line's theorem bound to its plant, once in each process for all lines that share them."""
    if line.digest not in _bindings:
        binding = prepare(line.theorem, line.plant, line.dependence, line.sizes)
        _bindings.clear()
        _bindings[line.digest] = binding
        return binding
    return _bindings[line.digest]


def _seconds(start: float) -> float:
    return round(perf_counter() - start, 4)


def _number(value: float) -> float | None:
    return float(value) if isfinite(value) else None
