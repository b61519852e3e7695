"""What ``lmic check`` prints: the matrices with the shapes of their blocks, and the findings."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from lmic.authoring.checkup import CheckedLMI, Checkup, Finding
from lmic.authoring.execution import Unwritten
from lmic.commands import terminal
from lmic.language.star import Star

#: how a star and a block whose expression failed are shown
STAR, FAILED = "⋆", "?"
#: columns beyond which a matrix is not measured
WIDEST = 10_000


def cells(checked: CheckedLMI) -> list[list[str]]:
    """The blocks as texts."""
    return [[_cell(entry) for entry in row] for row in checked.lmi.rows]


def record(checkup: Checkup) -> dict[str, Any]:
    """A checkup as plain data."""
    return {
        "sound": checkup.sound,
        "findings": [finding_record(finding) for finding in checkup.findings],
        "lmis": {
            name: {
                "sense": _sense(checked),
                "sizes": [str(size) for size in checked.partition],
                "blocks": cells(checked),
                "faulty": sorted(checked.faulty),
            }
            for name, checked in checkup.lmis.items()
        },
    }


def finding_record(finding: Finding) -> dict[str, Any]:
    """A finding as plain data."""
    return {
        "fault": finding.fault,
        "kind": finding.kind,
        "file": str(finding.file),
        "line": finding.line,
        "lmi": finding.place.lmi,
        "block": finding.place.block,
        "part": finding.place.part,
        "message": finding.reason,
    }


def print_checkup(checkup: Checkup) -> None:
    """The matrices, and what was found."""
    out = terminal.console()
    for name, checked in checkup.lmis.items():
        _print_lmi(out, name, checked)
    for finding in checkup.findings:
        kind = Text(f"{finding.kind}: ", style="bold red" if finding.fault else "yellow")
        out.print(kind + Text(str(finding)), soft_wrap=True)
    faults = sum(finding.fault for finding in checkup.findings)
    unused = len(checkup.findings) - faults
    also = f", {_count(unused, 'unused declaration')}" if unused else ""
    out.print(_count(faults, "fault") + also)


def _print_lmi(out: Console, name: str, checked: CheckedLMI) -> None:
    """The block matrix, or where it is wider than the terminal its blocks below one another."""
    shown = matrix(name, checked)
    if Measurement.get(out, out.options.update(max_width=WIDEST), shown).minimum <= out.width:
        out.print(shown)
    else:
        out.print(listing(name, checked))


def matrix(name: str, checked: CheckedLMI) -> Table:
    """The block matrix with the sizes of its rows and columns at the edges."""
    sizes = [str(size) for size in checked.partition]
    shown = terminal.table("", *sizes, title=f"{name} {_sense(checked)}")
    for column in shown.columns:
        column.no_wrap = True
    for i, row in enumerate(cells(checked)):
        edge = sizes[i] if i < len(sizes) else ""
        shown.add_row(Text(edge, style="bold"), *(_styled(checked, i, j, text) for j, text in enumerate(row)))
    return shown


def listing(name: str, checked: CheckedLMI) -> Table:
    """The blocks one below another with their shapes, without zeros and stars."""
    shown = terminal.table("block", "shape", "expression", title=f"{name} {_sense(checked)}")
    sizes = [str(size) for size in checked.partition]
    for i, row in enumerate(cells(checked)):
        for j, text in enumerate(row):
            if text not in (STAR, "0") or (i + 1, j + 1) in checked.faulty:
                shape = f"{sizes[i]} x {sizes[j]}" if j < len(sizes) else ""
                shown.add_row(f"({i + 1},{j + 1})", shape, _styled(checked, i, j, text))
    return shown


def _styled(checked: CheckedLMI, i: int, j: int, text: str) -> Text:
    return Text(f"✗ {text}", style="bold red") if (i + 1, j + 1) in checked.faulty else Text(text)


def _cell(entry: Any) -> str:
    if isinstance(entry, Star):
        return STAR
    return FAILED if isinstance(entry, Unwritten) else str(entry)


def _sense(checked: CheckedLMI) -> str:
    return "≻ 0" if checked.lmi.sense > 0 else "≺ 0"


def _count(number: int, what: str) -> str:
    return f"{number or 'no'} {what}{'' if number == 1 else 's'}"
