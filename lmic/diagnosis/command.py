"""``lmic diagnose``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from lmic.commands.echo import echo_json
from lmic.commands.options import JSON, PLANT, SOLVER, Choices, compiling, dependences, numbers


@click.command()
@click.argument("name")
@PLANT
@compiling
@SOLVER
@click.option(
    "--patience",
    type=click.FloatRange(min=0),
    default=60.0,
    show_default=True,
    metavar="SECONDS",
    help="No further neighbour is begun after this time; 0 tries none.",
)
@JSON
def diagnose(
    name: str, plant: Path, solver_names: tuple[str, ...], patience: float, as_json: bool, **choices: Any
) -> None:
    """Say what the outcome of a theorem is due to: what binds, diverges or is out of scale, and what would help.

    Neighbouring bases, relaxations and grids are solved too, and compared.
    """
    from lmic import library
    from lmic.commands import terminal
    from lmic.diagnosis.diagnose import diagnose as run
    from lmic.diagnosis.reporting import diagnosis_record, print_diagnosis
    from lmic.plants.files import read_plant
    from lmic.solve.registry import solvers

    chosen, read = Choices(**choices), read_plant(plant)
    with terminal.counter(name, quiet=as_json) as advance:
        found = run(
            library.theorem(name),
            read,
            numbers(chosen.given, "--set"),
            dependences(chosen.dependence),
            chosen.relaxation(read),
            chosen.dimensions(),
            solvers(solver_names),
            patience,
            advance,
        )
    if as_json:
        echo_json(diagnosis_record(found))
    else:
        print_diagnosis(found)
