"""A paper reproduced: its tables beside ours, as rows of text for the terminal and for pages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lmic.analysis.norms import TOLERANCE
from lmic.commands.terminal import console, table, warning
from lmic.papers.cases import CaseTable
from lmic.papers.enclosures import Enclosure
from lmic.papers.reproduce import Frozen, Outcome, achieved
from lmic.simulate.trajectory import Trajectory

#: what stands in a row of the tables
COLUMNS = ("case", "paper", "lmic", "difference", "verdict", "proven", "frozen norm", "achieved (paper)")


@dataclass(frozen=True)
class Reproduction:
    """One paper: its cases' outcomes, what simulations achieved, and its figures."""

    cases: CaseTable
    outcomes: Mapping[str, Outcome]
    gains: Mapping[str, float]
    figures: Sequence[Path]

    @property
    def tables(self) -> dict[str, list[tuple[Outcome, list[str]]]]:
        """Rows by table."""
        found: dict[str, list[tuple[Outcome, list[str]]]] = {}
        for outcome in self.outcomes.values():
            row = _row(outcome, self.gains.get(outcome.case.id))
            found.setdefault(outcome.case.table, []).append((outcome, row))
        return found

    @property
    def warnings(self) -> list[tuple[str, str]]:
        """Case and warning."""
        return [
            (outcome.case.what, warning)
            for outcome in self.outcomes.values()
            for warning in outcome.result.solution.warnings
        ]


def achieved_gains(
    cases: CaseTable, simulated: Sequence[Mapping[str, Trajectory]], outcomes: Mapping[str, Outcome]
) -> dict[str, float]:
    """What the simulations from rest show of each bounded norm, by case."""
    return {
        case: achieved(trajectory, outcomes[case].result)
        for simulation, trajectories in zip(cases.simulations, simulated, strict=True)
        if not simulation.boundary
        for case, trajectory in trajectories.items()
    }


def print_reproduction(paper: Reproduction) -> None:
    """A paper's tables beside ours."""
    out = console()
    for name, rows in paper.tables.items():
        shown = table(*COLUMNS, title=f"{paper.cases.paper}, {name}")
        for _, row in rows:
            shown.add_row(*row)
        out.print(shown)
        for outcome, _ in rows:
            for text in outcome.result.solution.warnings:
                out.print(warning(f"{outcome.case.id}: {text}"), soft_wrap=True)
    if paper.cases.notes:
        out.print(paper.cases.notes, style="italic")
    for path in paper.figures:
        out.print(f"figure: {path}", soft_wrap=True)


def _difference(outcome: Outcome) -> str:
    """Relative to the paper's value, where the two are comparable."""
    case = outcome.case
    if case.paper is None or case.stand_in or case.paper.is_infinite():
        return ""
    return f"{outcome.value / float(case.paper) - 1:+.2%}"


def _frozen(frozen: Frozen | None) -> str:
    if frozen is None:
        return ""
    if abs(frozen.norm - frozen.bound) <= 10 * TOLERANCE * frozen.bound:  # a bound for one point may be attained
        return f"{frozen.norm:.4g} ≈ {frozen.bound:.4g}"
    return f"{frozen.norm:.4g} {'≤' if frozen.norm <= frozen.bound else '>'} {frozen.bound:.4g}"


def _proven(enclosure: Enclosure | None) -> str:
    if enclosure is None:
        return "numerical"
    return f"{enclosure} ({'proven' if enclosure.upper is None else enclosure.standing})"


def _row(outcome: Outcome, gain: float | None) -> list[str]:
    """The cells of a case; ``gain`` is what its simulation achieved."""
    case = outcome.case
    printed = f" ({case.paper_gain})" if case.paper_gain is not None else ""
    return [
        case.what,
        "" if case.paper is None else "∞" if case.paper.is_infinite() else str(case.paper),
        f"{outcome.value:.7g}",
        _difference(outcome),
        outcome.verdict.value,
        _proven(outcome.enclosure),
        _frozen(outcome.frozen),
        "" if gain is None else f"{gain:.4g}{printed}",
    ]
