"""Case tables: what a paper prints and how to ask for it. They are data beside the theorems."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from decimal import Decimal
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from lmic.analysis.sampling import Gain
from lmic.errors import LibraryError
from lmic.library import root
from lmic.papers.signals import Uniform
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation


@dataclass(frozen=True)
class Case:
    """One number of a paper.

    ``paper`` is the value as printed, None for a case that the paper does not have, and ``paper_gain`` the gain it
    simulated; ``given`` are the scalars; ``cover`` names sampling intervals whose grid is found by covering their
    domain; ``refine`` says that the grid grows until the LMIs are proven on the whole domain; ``below`` is the case
    whose optimum is a lower bound on this one's; ``stand_in`` says that the paper's data are lost; ``reference`` is
    the known optimum, which only tests read.
    """

    id: str
    table: str
    what: str
    theorem: str
    plant: Path
    report: str
    paper: Decimal | None
    given: Mapping[str, Any]
    relaxation: Relaxation
    cover: Mapping[str, Gain]
    refine: bool
    below: str | None
    stand_in: bool
    paper_gain: Decimal | None
    reference: Decimal | None

    @property
    def library_plant(self) -> str:
        """The plant's file as certificates name it."""
        return self.plant.relative_to(root()).as_posix()


@dataclass(frozen=True)
class Panel:
    """A figure: the signals to show ("e", "w", "x3" for a state's component, or a name)."""

    id: str
    title: str
    show: tuple[str, ...]


@dataclass(frozen=True)
class Simulation:
    """Closed loops of several cases under one disturbance and one parameter trajectory.

    ``size`` is the number of steps, or of places in both directions; ``w``, ``parameters``,
    ``boundary`` (2-D) and ``delay`` are expressions in the step k or the place (i, j); a parameter may
    be random instead.
    """

    cases: tuple[str, ...]
    size: tuple[int, ...]
    w: tuple[str, ...]
    parameters: Mapping[str, tuple[str, ...] | Uniform]
    boundary: tuple[str, ...]
    delay: Mapping[str, str]
    figures: tuple[Panel, ...]


@dataclass(frozen=True)
class Response:
    """A figure: the magnitude over the frequencies of a 2-D case's closed loop at frozen parameters.

    ``parameters`` are rows of values by name, as many for each; ``delay`` the steps along i and j.
    """

    id: str
    title: str
    case: str
    parameters: Mapping[str, tuple[tuple[float, ...], ...]]
    delay: tuple[int, int]


@dataclass(frozen=True)
class Improvement:
    """A figure: by how many per cent the first theorem of a curve is below each other."""

    id: str
    title: str


@dataclass(frozen=True)
class Curve:
    """A figure: a report of several theorems over an axis of a sweep.

    ``over`` are the sweep's axes as its command line writes them; ``search`` is a scalar with the interval in which
    the best value is sought at every point.
    """

    id: str
    title: str
    theorems: tuple[str, ...]
    plant: Path
    report: str
    over: Mapping[str, str]
    given: Mapping[str, Any]
    search: tuple[str, float, float] | None
    improvement: Improvement | None


@dataclass(frozen=True)
class CaseTable:
    """All cases, simulations, responses and curves of one paper; ``group`` is its folder in the library."""

    group: str
    paper: str
    notes: str
    cases: tuple[Case, ...]
    simulations: tuple[Simulation, ...]
    responses: tuple[Response, ...]
    curves: tuple[Curve, ...]


def case_tables() -> list[CaseTable]:
    """The case tables of the library, one for each folder that has a cases.toml."""
    return [read_cases(path) for path in sorted(root().glob("*/cases.toml"))]


def select(names: tuple[str, ...]) -> list[CaseTable]:
    """The tables reduced to the cases and curves whose id begins with one of ``names`` (all without names)."""
    tables = case_tables()
    if not names:
        return tables
    known = [case.id for table in tables for case in table.cases]
    known += [curve.id for table in tables for curve in table.curves]
    for name in names:
        if not any(_matches(case, name) for case in known):
            prefixes = {case.rpartition(".")[0] for case in known}
            near = get_close_matches(name, sorted({*known, *prefixes, *(table.group for table in tables)}), n=3)
            hint = (
                f"did you mean {' or '.join(near)}?"
                if near
                else f"a name begins with {', '.join(t.group for t in tables)}"
            )
            raise LibraryError(f"no case is called '{name}'; {hint}")
    reduced = []
    for table in tables:
        wanted = {case.id for case in table.cases if any(_matches(case.id, name) for name in names)}
        wanted |= {case.below for case in table.cases if case.id in wanted and case.below}
        cases = tuple(case for case in table.cases if case.id in wanted)
        simulations = tuple(s for s in table.simulations if wanted.issuperset(s.cases))
        responses = tuple(response for response in table.responses if response.case in wanted)
        curves = tuple(curve for curve in table.curves if any(_matches(curve.id, name) for name in names))
        if cases or curves:
            reduced.append(replace(table, cases=cases, simulations=simulations, responses=responses, curves=curves))
    return reduced


def _matches(case: str, name: str) -> bool:
    return case == name or case.startswith(name + ".")


def read_cases(path: Path) -> CaseTable:
    """Read one cases.toml; its ids are prefixed with the folder's name."""
    group = path.parent.name
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    return CaseTable(
        group,
        table["paper"],
        table.get("notes", ""),
        tuple(_case(entry, path, group) for entry in table.get("case", [])),
        tuple(_simulation(entry, group) for entry in table.get("simulation", [])),
        tuple(_response(entry, group) for entry in table.get("response", [])),
        tuple(_curve(entry, path, group) for entry in table.get("curve", [])),
    )


def _case(entry: Mapping[str, Any], path: Path, group: str) -> Case:
    return Case(
        id=f"{group}.{entry['id']}",
        table=entry["table"],
        what=entry["what"],
        theorem=f"{group}.{entry['theorem']}",
        plant=path.parent / entry["plant"],
        report=entry["report"],
        paper=Decimal(entry["paper"]) if "paper" in entry else None,
        given=entry.get("set", {}),
        relaxation=_relaxation(entry),
        refine=entry.get("refine", False),
        cover={name: Gain(text) for name, text in entry.get("cover", {}).items()},
        below=f"{group}.{entry['below']}" if "below" in entry else None,
        stand_in=entry.get("stand_in", False),
        paper_gain=Decimal(entry["paper_gain"]) if "paper_gain" in entry else None,
        reference=Decimal(entry["reference"]) if "reference" in entry else None,
    )


def _relaxation(entry: Mapping[str, Any]) -> Relaxation:
    grids: dict[str, Grid | int] = dict(entry.get("grid", {}))
    grids |= {name: Grid.at(points) for name, points in entry.get("points", {}).items()}
    return Relaxation(entry.get("relax", {}), entry.get("polya", 0), grids, entry.get("ties", {}))


def _uniform(entry: Mapping[str, Any]) -> Uniform:
    low, high = entry["uniform"]
    return Uniform(low, high, entry.get("seed", 0))


def _simulation(entry: Mapping[str, Any], group: str) -> Simulation:
    size = entry["size"]
    return Simulation(
        cases=tuple(f"{group}.{case}" for case in entry["cases"]),
        size=(size,) if isinstance(size, int) else tuple(size),
        w=tuple(entry["w"]),
        parameters={
            name: _uniform(value) if isinstance(value, dict) else tuple(value)
            for name, value in entry["parameters"].items()
        },
        boundary=tuple(entry.get("boundary", ())),
        delay={f"{group}.{case}": text for case, text in entry.get("delay", {}).items()},
        figures=tuple(Panel(f"{group}.{f['id']}", f["title"], tuple(f["show"])) for f in entry.get("figures", [])),
    )


def _response(entry: Mapping[str, Any], group: str) -> Response:
    along_i, along_j = entry.get("delay", (0, 0))
    return Response(
        id=f"{group}.{entry['id']}",
        title=entry["title"],
        case=f"{group}.{entry['case']}",
        parameters={name: tuple(map(tuple, rows)) for name, rows in entry["parameters"].items()},
        delay=(along_i, along_j),
    )


def _curve(entry: Mapping[str, Any], path: Path, group: str) -> Curve:
    searched = [(name, float(low), float(high)) for name, (low, high) in entry.get("search", {}).items()]
    better = entry.get("improvement")
    return Curve(
        id=f"{group}.{entry['id']}",
        title=entry["title"],
        theorems=tuple(f"{group}.{name}" for name in entry["theorems"]),
        plant=path.parent / entry["plant"],
        report=entry["report"],
        over=entry["over"],
        given=entry.get("set", {}),
        search=searched[0] if searched else None,
        improvement=Improvement(f"{group}.{better['id']}", better["title"]) if better else None,
    )
