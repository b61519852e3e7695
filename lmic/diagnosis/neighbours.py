"""The neighbours of a choice of bases and relaxation: one thing changed at a time, compiled and solved."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

from lmic.compiler.assemble import ConicProblem
from lmic.compiler.bases import DEFAULT, Choice
from lmic.errors import LmicError
from lmic.language.theorem import Theorem
from lmic.pipeline import Result, compile, run
from lmic.plants.plant import Plant
from lmic.relax.grid import Grid
from lmic.relax.relax import MAX_DEGREE, Relaxation
from lmic.solve.cone import ConeSolver

#: how many times the unknowns or the LMIs' entries of the choice at hand a neighbour may have to be solved
GROWTH = 30


@dataclass(frozen=True)
class Chosen:
    """What a theorem is compiled with."""

    theorem: Theorem
    plant: Plant
    given: Mapping[str, Any] = field(default_factory=dict)
    dependence: Mapping[str, Choice] = field(default_factory=dict)
    relaxation: Relaxation = field(default_factory=Relaxation)
    sizes: Mapping[str, int] = field(default_factory=dict)

    def compile(self) -> ConicProblem:
        """The problem; raises LmicError where it cannot be formed."""
        return compile(self.theorem, self.plant, self.given, self.dependence, self.relaxation, self.sizes)

    def run(self, solver: ConeSolver | tuple[ConeSolver, ...] | None, at_most: tuple[int, int] | None = None) -> Result:
        """Compile and solve; raises LmicError where that is impossible or larger than (unknowns, rows)."""
        problem = self.compile()
        size = (problem.size, int(problem.starts[-1]))
        if at_most and (size[0] > at_most[0] or size[1] > at_most[1]):
            raise LmicError(
                f"has {size[0]} unknowns and {len(problem.orders)} LMIs, too many for a trial; solve it alone"
            )
        return run(problem, solver)


@dataclass(frozen=True)
class Trial:
    """One choice and what came of it; ``value`` is the report that is compared, None where there is no answer.

    ``option`` is the choice as the command line writes it, empty for the choice at hand. ``failure`` says why a
    neighbour was not solved.
    """

    option: str
    value: float | None = None
    status: str = ""
    trusted: bool = False
    unknowns: int = 0
    lmis: int = 0
    seconds: float = 0.0
    soundness: str = ""
    failure: str = ""

    @property
    def feasible(self) -> bool:
        """Whether it has a solution that was measured."""
        return self.status == "solved"


def trial(option: str, result: Result, seconds: float) -> Trial:
    """What is compared of a result: its first report, or the objective."""
    solution = result.solution
    value = next(iter(result.reports.values()), solution.value if result.theorem.minimise is not None else None)
    return Trial(
        option,
        value if solution.status.usable else None,
        solution.status.value,
        solution.trusted,
        result.problem.size,
        len(result.problem.orders),
        seconds,
        result.problem.soundness.value,
    )


def neighbours(chosen: Chosen, problem: ConicProblem) -> list[tuple[str, Chosen]]:
    """Every neighbour by the option that makes it: degrees, grids, then bases, as they apply to this problem."""
    return [*_degrees(chosen, problem), *_grids(chosen), *_bases(chosen, problem)]


def try_neighbours(
    chosen: Chosen,
    result: Result,
    solver: ConeSolver | tuple[ConeSolver, ...] | None = None,
    patience: float = float("inf"),
) -> Iterator[Trial]:
    """Solve the neighbours one after another; those that ``patience`` (seconds) does not reach are left out."""
    end = perf_counter() + patience
    limit = (GROWTH * result.problem.size, GROWTH * int(result.problem.starts[-1]))
    for option, neighbour in neighbours(chosen, result.problem):
        if perf_counter() >= end:
            return
        start = perf_counter()
        try:
            found = trial(option, neighbour.run(solver, limit), 0.0)
        except LmicError as error:
            found = Trial(option, failure=str(error))
        yield replace(found, seconds=perf_counter() - start)


def _bases(chosen: Chosen, problem: ConicProblem) -> Iterator[tuple[str, Chosen]]:
    """The degree of the unknowns that depend on a parameter, one up and one down: of all at once, then of each."""
    theorem, domains = chosen.theorem, problem.binding.domains
    steps = {
        name: _steps(chosen.dependence.get(name, DEFAULT))
        for name in theorem.unknowns
        if any(parameter in domains for parameter in theorem.dependence(name))
    }
    together = [{name: ways[k] for name, ways in steps.items() if k < len(ways)} for k in (1, 0)]
    changes = [change for change in together if len(change) > 1]
    changes += [{name: way} for name, ways in steps.items() for way in ways]
    for change in changes:
        option = " ".join(f"--dependence {name}={way}" for name, way in change.items())
        yield option, replace(chosen, dependence={**chosen.dependence, **change})


def _steps(choice: Choice) -> tuple[Choice, ...]:
    """The neighbours of a dependence; a basis of the user's own has none."""
    if choice in ("constant", 0):
        return (1,)
    if not isinstance(choice, int):
        return ()
    return ("constant" if choice == 1 else choice - 1, choice + 1)


def _degrees(chosen: Chosen, problem: ConicProblem) -> Iterator[tuple[str, Chosen]]:
    """The Pólya degree of each parameter that is relaxed by coefficients, one up and one down."""
    degrees = chosen.relaxation.polya
    used = any(axis.method.startswith("Pólya") for family in problem.families for axis in family.axes)
    if isinstance(degrees, int):
        keyed: dict[str, int] = {"": degrees} if used else {}
    else:
        keyed = dict(degrees)
    for key, degree in keyed.items():
        for other in (degree - 1, degree + 1):
            if 0 <= other <= MAX_DEGREE:
                polya = other if not key else {**keyed, key: other}
                option = f"--polya {key}={other}" if key else f"--polya {other}"
                yield option, replace(chosen, relaxation=replace(chosen.relaxation, polya=polya))


def _grids(chosen: Chosen) -> Iterator[tuple[str, Chosen]]:
    """Half and twice the points of each grid, ends kept, and coefficients in its place, which leave nothing out."""
    relaxation = chosen.relaxation
    for name, points in relaxation.grid.items():
        grid = Grid.of(points)
        if grid.kind == "points":
            continue
        kind = "" if grid.kind == "uniform" else f"{grid.kind}:"
        for count in ((grid.count + 1) // 2, 2 * grid.count - 1):
            if count not in (0, grid.count):
                changed = replace(relaxation, grid={**relaxation.grid, name: replace(grid, count=count)})
                yield f"--grid {name}={kind}{count}", replace(chosen, relaxation=changed)
        if relaxation.method.get(name, "auto") in ("auto", "grid"):
            changed = replace(relaxation, method={**relaxation.method, name: "polya"})
            yield f"--relax {name}=polya", replace(chosen, relaxation=changed)
