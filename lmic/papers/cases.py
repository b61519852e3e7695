"""Case tables: what a paper prints and how to ask for it. They are data beside the theorems."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

from lmic.errors import LibraryError
from lmic.library import root


@dataclass(frozen=True)
class Case:
    """One number of a paper.

    ``paper`` is the value as printed; ``given`` the scalars; ``reference`` the known optimum,
    which only tests read.
    """

    id: str
    table: str
    what: str
    theorem: str
    plant: Path
    report: str
    paper: Decimal
    given: Mapping[str, Any]
    reference: Decimal | None


@dataclass(frozen=True)
class Panel:
    """A figure: the signals to show ("e", "w" or a parameter's name)."""

    id: str
    title: str
    show: tuple[str, ...]


@dataclass(frozen=True)
class Simulation:
    """Closed loops of several cases under one disturbance and one parameter trajectory.

    ``w`` and ``parameters`` are expressions in the step k, one per component.
    """

    cases: tuple[str, ...]
    steps: int
    w: tuple[str, ...]
    parameters: Mapping[str, tuple[str, ...]]
    figures: tuple[Panel, ...]


@dataclass(frozen=True)
class CaseTable:
    """All cases and simulations of one paper; ``group`` is its folder in the library."""

    group: str
    paper: str
    cases: tuple[Case, ...]
    simulations: tuple[Simulation, ...]


def case_tables() -> list[CaseTable]:
    """The case tables of the library, one for each folder that has a cases.toml."""
    return [read_cases(path) for path in sorted(root().glob("*/cases.toml"))]


def select(names: tuple[str, ...]) -> list[CaseTable]:
    """The tables reduced to the cases whose id starts with one of ``names`` (all without names)."""
    tables = case_tables()
    if not names:
        return tables
    known = [case.id for table in tables for case in table.cases]
    for name in names:
        if not any(_matches(case, name) for case in known):
            raise LibraryError(f"no case is called '{name}'; the cases are {', '.join(known)}")
    reduced = []
    for table in tables:
        cases = tuple(case for case in table.cases if any(_matches(case.id, name) for name in names))
        kept = {case.id for case in cases}
        simulations = tuple(s for s in table.simulations if kept.issuperset(s.cases))
        if cases:
            reduced.append(CaseTable(table.group, table.paper, cases, simulations))
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
        tuple(_case(entry, path, group) for entry in table.get("case", [])),
        tuple(_simulation(entry, group) for entry in table.get("simulation", [])),
    )


def _case(entry: Mapping[str, Any], path: Path, group: str) -> Case:
    return Case(
        id=f"{group}.{entry['id']}",
        table=entry["table"],
        what=entry["what"],
        theorem=f"{group}.{entry['theorem']}",
        plant=path.parent / entry["plant"],
        report=entry["report"],
        paper=Decimal(entry["paper"]),
        given=entry.get("set", {}),
        reference=Decimal(entry["reference"]) if "reference" in entry else None,
    )


def _simulation(entry: Mapping[str, Any], group: str) -> Simulation:
    return Simulation(
        cases=tuple(f"{group}.{case}" for case in entry["cases"]),
        steps=entry["steps"],
        w=tuple(entry["w"]),
        parameters={name: tuple(texts) for name, texts in entry["parameters"].items()},
        figures=tuple(Panel(f"{group}.{f['id']}", f["title"], tuple(f["show"])) for f in entry["figures"]),
    )
