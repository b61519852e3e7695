"""Run a sweep: plan it, do what its file does not hold yet, keep every result as it comes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from lmic.compiler.bases import Choice
from lmic.errors import SweepError
from lmic.interrupts import keeping
from lmic.language.theorem import Theorem
from lmic.plants.plant import Plant, exact_number
from lmic.relax.relax import Relaxation
from lmic.sweeps.axes import Kind, axes_of
from lmic.sweeps.plan import Line, Plan
from lmic.sweeps.store import Store
from lmic.sweeps.swept import Swept
from lmic.sweeps.work import prepared
from lmic.sweeps.workers import Workers, workers

#: neighbours in one piece of work: the first is solved from nothing, the others near the last
LENGTH = 64
#: pieces for each worker at the least, so that none waits long for the last
SHARES = 4


def sweep(
    theorem: Theorem,
    plant: Plant | Sequence[Plant],
    over: Mapping[str, Any],
    given: Mapping[str, Any] | None = None,
    dependence: Mapping[str, Choice] | None = None,
    relaxation: Relaxation | None = None,
    sizes: Mapping[str, int] | None = None,
    search: tuple[str, float, float] | None = None,
    file: str | Path | None = None,
    jobs: int | None = None,
    scheduler: str | None = None,
    advance: Callable[[int, int], None] | None = None,
) -> Swept:
    """Solve a theorem at every combination of the values in ``over``.

    ``over`` maps a scalar's name, or ``"polya"``, ``"polya:alpha"``, ``"grid:rho"``, ``"dependence:P"``, to its
    values (a sequence, or a text as on the command line, ``"0.1:6:296"``); several plants are an axis of their own.
    ``given`` to ``sizes`` are the choices of :func:`lmic.compile` that stay. ``search`` names a scalar and an interval
    in which its best value is sought at every point. Results are kept in ``file``, from which the same sweep resumes;
    the work is done by ``jobs`` processes (all cores without) or by the Dask cluster of ``scheduler``. ``advance`` is
    called with the number of points that have come in and the number of all. A point that fails is recorded with
    its reason.

    Raises SweepError for a sweep that cannot be done, PlantError for a scalar that is missing or unknown.
    """
    plants = (plant,) if isinstance(plant, Plant) else tuple(plant)
    if not plants:
        raise SweepError("a sweep needs a plant; give at least one")
    if jobs is not None and jobs < 1:
        raise SweepError(f"{jobs} processes cannot do anything; give at least 1")
    exact = {name: exact_number(value) for name, value in (given or {}).items()}
    plan = Plan(
        theorem,
        plants,
        axes_of(over, plants),
        exact,
        dict(dependence or {}),
        dict(sizes or {}),
        relaxation or Relaxation(),
        (search[0], float(search[1]), float(search[2])) if search else None,
    )
    return run_plan(plan, Path(file) if file else None, jobs, scheduler, advance)


def run_plan(
    plan: Plan,
    file: Path | None = None,
    jobs: int | None = None,
    scheduler: str | None = None,
    advance: Callable[[int, int], None] | None = None,
) -> Swept:
    """Do what the file of a plan does not hold yet."""
    store = Store(plan, file)
    with keeping(store.kept), store:
        left = sum(key not in store.records for key in plan.points())
        if advance:
            advance(len(plan) - left, len(plan))
        if left:
            _check(plan)
            with workers(jobs if left > 1 else 1, scheduler) as crew:
                lines = list(plan.lines(_length(plan, jobs), store.records))
                while lines:
                    lines = _round(crew, lines, store, advance)
        return Swept(plan, {key: store.records[key] for key in plan.points()})


def _check(plan: Plan) -> None:
    """What would fail at every point is an error of the sweep: a theorem and plant that do not fit."""
    if not any(axis.kind in (Kind.PLANT, Kind.DEPENDENCE) for axis in plan.axes):
        prepared(next(plan.lines(1, {})))


def _round(crew: Workers, lines: list[Line], store: Store, advance: Callable[[int, int], None] | None) -> list[Line]:
    """Hand out lines, keep what comes; what was handed back is left for another round."""
    rests: list[Line] = []
    for done in crew(lines):
        store.append(done.records)
        if advance:
            advance(len(done.records), len(store.plan))
        if done.rest:
            rests.append(done.rest)
    return rests


def _length(plan: Plan, jobs: int | None) -> int:
    return max(1, min(LENGTH, len(plan) // (SHARES * (jobs or 2))))
