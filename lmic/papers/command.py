"""``lmic reproduce``."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from lmic.commands.echo import echo_json
from lmic.commands.options import JSON

if TYPE_CHECKING:
    from lmic.papers.cases import CaseTable
    from lmic.papers.reporting import Reproduction
    from lmic.papers.reproduce import Outcome


@click.command()
@click.argument("names", nargs=-1)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default=Path("reports"),
    show_default=True,
    help="Folder for the figures and the report.",
)
@click.option(
    "--certify",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    help="Prove an enclosure of every number anew (as --fresh), and write the certificates to a folder.",
)
@click.option("--fresh", is_flag=True, help="Prove every enclosure anew, instead of the library's certificates.")
@JSON
def reproduce(names: tuple[str, ...], output: Path, certify: Path | None, fresh: bool, as_json: bool) -> None:
    """Regenerate the papers' tables and figures (all, or by the beginning of their ids), and one report."""
    from time import perf_counter

    from lmic.files import make_folder
    from lmic.pages.report import write_report
    from lmic.papers.cases import select
    from lmic.papers.reporting import Reproduction, print_reproduction

    tables = select(names)
    for folder in filter(None, (output, certify)):
        make_folder(folder)
    start = perf_counter()
    papers: list[Reproduction] = []
    done: dict[str, Outcome] = {}
    trusted = True
    try:
        for table in tables:
            done = {}
            paper, sound = _reproduced(table, done, output, certify, fresh, as_json)
            papers.append(paper)
            trusted &= sound
            if not as_json:
                print_reproduction(paper)
    except KeyboardInterrupt as stop:
        # the numbers of the paper at hand that are known; it has no figures yet
        reached = [*papers, *([Reproduction(tables[len(papers)], done, {}, [])] if done else [])]
        left = _left(tables[len(papers) :], done, whole=not names)
        kept = "nothing was finished"
        if reached:
            count = sum(len(paper.outcomes) for paper in reached)
            kept = f"{count} numbers are in {write_report(reached, output, perf_counter() - start)[0]}"
        raise KeyboardInterrupt(f"{kept}; go on with: lmic reproduce {left} -o {output / 'rest'}") from stop
    written = write_report(papers, output, perf_counter() - start)
    if as_json:
        records: list[dict[str, Any]] = [
            outcome.record() | {"achieved": paper.gains.get(case)}
            for paper in papers
            for case, outcome in paper.outcomes.items()
        ]
        echo_json(records)
    else:
        click.echo(f"report: {', '.join(map(str, written))}")
    if not trusted:
        sys.exit(1)


def _reproduced(
    table: CaseTable, outcomes: dict[str, Outcome], output: Path, certify: Path | None, fresh: bool, quiet: bool
) -> tuple[Reproduction, bool]:
    """Everything of one paper, and whether its numbers are to be trusted; ``outcomes`` fill up as they come."""
    from lmic.certify.certificate_file import write_certificate
    from lmic.commands import terminal
    from lmic.papers.figures import draw, draw_curve, draw_responses
    from lmic.papers.reporting import Reproduction, achieved_gains
    from lmic.papers.reproduce import Verdict, run_curve, run_simulation
    from lmic.papers.reproduce import reproduce as run_table

    swept = {}
    with terminal.progress(len(table.cases) + len(table.curves), table.paper, quiet=quiet) as advance:
        for outcome in run_table(table, fresh=fresh or certify is not None):
            outcomes[outcome.case.id] = outcome
            if certify and outcome.enclosure and outcome.certificate:
                write_certificate(outcome.certificate, certify / f"{outcome.case.id}.json")
            advance(outcome.case.what)
        for curve in table.curves:
            swept[curve.id] = (curve, run_curve(curve))
            advance(curve.title)
    simulated = [run_simulation(simulation, outcomes) for simulation in table.simulations]
    figures = [
        path
        for simulation, trajectories in zip(table.simulations, simulated, strict=True)
        for path in draw(simulation, trajectories, outcomes, output)
    ]
    figures += draw_responses(table, outcomes, output)
    figures += [path for curve, found in swept.values() for path in draw_curve(curve, found, output)]
    gains = achieved_gains(table, simulated, outcomes)
    trusted = all(outcome.verdict is not Verdict.UNTRUSTED for outcome in outcomes.values())
    trusted &= not any(one.failed or one.doubtful for _, found in swept.values() for one in found.values())
    return Reproduction(table, outcomes, gains, figures), trusted


def _left(tables: list[CaseTable], done: Mapping[str, Outcome], whole: bool) -> str:
    """What is left to reproduce as words of the command line: papers where ``whole`` ones were asked for, else ids."""
    words = []
    for table in tables:
        begun = any(case.id in done for case in table.cases)
        ids = [case.id for case in table.cases if case.id not in done] + [curve.id for curve in table.curves]
        words += [table.group] if whole and not begun else ids
    return " ".join(words)
