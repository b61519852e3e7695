"""``lmic sweep``."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from lmic.commands.echo import echo_json
from lmic.commands.options import JSON, Choices, compiling, dependences, interval, numbers
from lmic.errors import SweepError
from lmic.interrupts import keeping

if TYPE_CHECKING:
    from lmic.sweeps.swept import Swept

#: rows up to which the table is printed
SHOWN = 60


@click.command()
@click.argument("name")
@click.option(
    "--plant",
    "plants",
    type=click.Path(path_type=Path),
    multiple=True,
    required=True,
    help="Plant, a file or one of the library; several of them are an axis.",
)
@click.option(
    "--over",
    multiple=True,
    metavar="AXIS=VALUES",
    help="eps=0.1:6:296, eps=log:1:1000:7, eps=1,10,50, polya=0,1,2, grid:rho=5,9, dependence:P=constant,1,2.",
)
@compiling
@click.option("--search", metavar="NAME=LOW:HIGH", help="Best value of a scalar at every point.")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    required=True,
    help="File of results (JSON lines), which the same command resumes.",
)
@click.option("--jobs", type=click.IntRange(min=1), help="Processes.  [default: all cores]")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler to work on, as tcp://host:8786.")
@click.option("--table", type=click.Path(path_type=Path), help="Write the table: .csv or .parquet.")
@click.option("--plot", "picture", type=click.Path(path_type=Path), help="Draw: .png, .pdf or .svg.")
@click.option("--report", metavar="NAME", help="What is drawn.  [default: what the theorem reports first]")
@click.option("--least-over", metavar="AXIS", help="Print and draw only the least value along an axis.")
@JSON
def sweep(
    name: str,
    plants: tuple[Path, ...],
    over: tuple[str, ...],
    search: str | None,
    output: Path,
    jobs: int | None,
    scheduler: str | None,
    table: Path | None,
    picture: Path | None,
    report: str | None,
    least_over: str | None,
    as_json: bool,
    **choices: Any,
) -> None:
    """Solve a theorem at every combination of scalars, plants, bases and relaxations."""
    from lmic import library
    from lmic.commands import terminal
    from lmic.plants.files import read_plant
    from lmic.sweeps.plot import check_picture, plot
    from lmic.sweeps.sweep import sweep as run
    from lmic.sweeps.swept import check_table

    chosen = Choices(**choices)
    read = [read_plant(plant) for plant in plants]
    axes = _axes(over)
    if table:
        check_table(table)
    if picture:
        check_picture(picture)
    with terminal.counter(name, quiet=as_json) as advance:
        swept = run(
            library.theorem(name),
            read,
            axes,
            numbers(chosen.given, "--set"),
            dependences(chosen.dependence),
            chosen.relaxation(read[0]),
            chosen.dimensions(),
            interval(search, "--search") if search else None,
            output,
            jobs,
            scheduler,
            advance,
        )
    with keeping(lambda: f"all points are in {output}, and the same command shows them"):
        if table:
            swept.write_table(table)
        if picture:
            plot(swept, picture, report, least_over)
        if as_json:
            echo_json(_record(swept, output))
        else:
            _print(swept, output, report, least_over, [path for path in (table, picture) if path])
    if swept.doubtful or swept.failed:
        sys.exit(1)


def _axes(texts: Sequence[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for text in texts:
        key, separator, values = text.partition("=")
        if not separator or not key.strip():
            raise SweepError(f"'--over {text}' has no name or no '='; write --over eps=0.1:6:60")
        if key.strip() in found:
            raise SweepError(f"--over gives {key.strip()} twice; give it once")
        found[key.strip()] = values
    return found


def _record(swept: Swept, output: Path) -> dict[str, Any]:
    return {
        "file": str(output),
        "points": len(swept.plan),
        "solves": swept.solves,
        "statuses": swept.statuses,
        "doubtful": swept.doubtful,
        "failed": swept.failed,
        "table": swept.columns(),
    }


def _print(swept: Swept, output: Path, report: str | None, least_over: str | None, written: Sequence[Path]) -> None:
    """The table where it is short, else what there is to say in few words."""
    from lmic.commands import terminal

    out = terminal.console()
    rows = _least_rows(swept, report, least_over) if least_over else _rows(swept)
    if len(next(iter(rows.values()))) <= SHOWN:
        shown = terminal.table(*rows)
        for row in zip(*rows.values(), strict=True):
            shown.add_row(*("" if cell is None else cell if isinstance(cell, str) else f"{cell:.8g}" for cell in row))
        out.print(shown)
    counts = ", ".join(f"{count} {status}" for status, count in swept.statuses.items())
    out.print(f"{len(swept.plan)} points ({counts}), {swept.solves} problems solved")
    if swept.doubtful:
        out.print(terminal.warning(f"{swept.doubtful} numbers are not to be trusted: column trusted"))
    for reason, number in swept.failed.items():
        out.print(f"{number} failed: {reason}", style="red", soft_wrap=True)
    for path in (output, *written):
        out.print(f"written: {path}", soft_wrap=True)


def _rows(swept: Swept) -> dict[str, list[Any]]:
    columns = swept.columns()
    sought = [swept.plan.search[0]] if swept.plan.search else []
    return {name: columns[name] for name in (*swept.plan.columns, *sought, *swept.reports, "status", "soundness")}


def _least_rows(swept: Swept, report: str | None, over: str) -> dict[str, list[Any]]:
    """One row for each combination of the other axes."""
    from itertools import product

    name = report or swept.reports[0]
    least, where = swept.least(name, over)
    others = [axis for axis in swept.plan.axes if axis.column != over]
    cells = list(product(*(axis.shown for axis in others)))
    found: dict[str, list[Any]] = {axis.column: [row[k] for row in cells] for k, axis in enumerate(others)}
    return found | {f"least {name}": least.ravel().tolist(), f"at {over}": where.ravel().tolist()}
