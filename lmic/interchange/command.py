"""``lmic export``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from lmic.commands.echo import echo_json
from lmic.commands.options import JSON, PLANT_OF_THEOREM, Choices, compiling, needed, refuse_with_file


@click.command()
@click.argument("name")
@PLANT_OF_THEOREM
@compiling
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    required=True,
    help="File to write: .dat-s (SDPA), .cbf, .mat (SeDuMi) or .npz (NumPy).",
)
@JSON
def export(name: str, plant: Path | None, output: Path, as_json: bool, **choices: Any) -> None:
    """Write the compiled problem for another program, in the format that the file's suffix names.

    NAME may also be a file in one of the formats, which is then converted.
    """
    from lmic.interchange.formats import is_problem_file, read_problem, write_problem
    from lmic.interchange.sdp import sdp_of_problem

    if is_problem_file(name):
        refuse_with_file(name, plant=plant, **choices)
        sdp = read_problem(name)
    else:
        sdp = sdp_of_problem(Choices(**choices).compile_files(name, needed(plant)))
    write_problem(sdp, output)
    summary = {"file": str(output), "unknowns": sdp.size, "lmis": len(sdp.orders), "soundness": sdp.notes.soundness}
    if as_json:
        echo_json(summary)
    else:
        click.echo(f"{output}: {sdp.size} unknowns, {len(sdp.orders)} LMIs, soundness: {sdp.notes.soundness}")
