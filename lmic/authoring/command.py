"""``lmic new`` and ``lmic check``."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from lmic.commands.echo import echo_json
from lmic.commands.options import JSON


@click.command()
@click.argument("name")
@click.option(
    "-o",
    "--output",
    "folder",
    type=click.Path(path_type=Path),
    default=Path(),
    help="Folder to write to.  [default: this one]",
)
@JSON
def new(name: str, folder: Path, as_json: bool) -> None:
    """Write a theorem file to begin with, commented, and a plant that it runs with at once."""
    from lmic.authoring.starter import write_starter

    theorem, plant = write_starter(name, folder)
    if as_json:
        return echo_json({"theorem": str(theorem), "plant": str(plant)})
    shown = theorem if theorem.is_absolute() else f"./{theorem}"
    click.echo(f"written: {theorem}\nwritten: {plant}\n\nnext:\n  lmic check {shown} --plant {plant}")
    click.echo(f"  lmic solve {shown} --plant {plant}")
    return None


@click.command()
@click.argument("name")
@click.option("--plant", type=click.Path(path_type=Path), help="Check this plant file too.")
@click.option("--size", "sizes", multiple=True, metavar="NAME=N", help="A dimension that no matrix of the plant fixes.")
@JSON
def check(name: str, plant: Path | None, sizes: tuple[str, ...], as_json: bool) -> None:
    """Explain every fault of a theorem (by path or name) at its line, and show its matrices.

    Ends with 1 where there is a fault. Declarations that nothing uses are told too, and are no fault.
    """
    from dataclasses import replace

    from lmic.authoring import display
    from lmic.authoring.checkup import check as examine
    from lmic.authoring.plants import check_plant
    from lmic.commands.options import Choices
    from lmic.library import locate

    located = locate(name)
    dimensions = Choices(sizes=sizes).dimensions()
    checkup = examine(located)
    stated = checkup.sound
    if plant and stated and checkup.theorem:
        theorem = checkup.theorem.variant(located.variant) if located.variant else checkup.theorem
        found = check_plant(replace(theorem, name=located.name), plant, dimensions)
        checkup = replace(checkup, findings=[*checkup.findings, *found])
    if as_json:
        echo_json(display.record(checkup))
    else:
        display.print_checkup(checkup)
        if plant and not stated:
            click.echo(f"{plant} is checked once the theorem has no fault")
    if not checkup.sound:
        sys.exit(1)
