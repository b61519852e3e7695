"""``lmic solve``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from lmic.commands.options import JSON, PLANT_OF_THEOREM, SOLVER, Choices, compiling, needed, refuse_with_file


@click.command()
@click.argument("name")
@PLANT_OF_THEOREM
@compiling
@SOLVER
@click.option("--search", metavar="NAME=LOW:HIGH", help="Best value of a scalar, by bisection or a line search.")
@click.option(
    "--certify",
    type=click.Path(path_type=Path),
    is_flag=False,
    flag_value=Path("-"),
    metavar="[FILE]",
    help="Prove an enclosure of the result, and write the certificate to a file.",
)
@click.option(
    "--refine",
    type=click.IntRange(min=1),
    metavar="ROUNDS",
    help="With --certify: points where the proof on the whole domain fails join the grid, for so many rounds.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Write the result (.json), a page of it (.html), or the design at the domains' vertices (.npz, .mat, .tex).",
)
@JSON
def solve(
    name: str,
    plant: Path | None,
    solver_names: tuple[str, ...],
    search: str | None,
    certify: Path | None,
    refine: int | None,
    output: Path | None,
    as_json: bool,
    **choices: Any,
) -> None:
    """Solve a theorem (by name or path) for a plant and print what it reports and recovers.

    NAME may also be a file with a semidefinite program: .dat-s (SDPA), .cbf, .mat (SeDuMi) or .npz.
    """
    from lmic.commands.solving import solve_file, solve_theorem
    from lmic.interchange.formats import is_problem_file
    from lmic.solve.registry import solvers

    solver = solvers(solver_names)
    if is_problem_file(name):
        refuse_with_file(name, plant=plant, search=search, certify=certify, refine=refine, output=output, **choices)
        trusted = solve_file(name, solver, as_json)
    else:
        chosen = Choices(**choices)
        trusted = solve_theorem(name, needed(plant), chosen, solver, search, certify, refine, output, as_json)
    if not trusted:
        sys.exit(1)
