"""``lmic list``, ``show`` and ``latex``: the library and what its theorems state."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from lmic.commands.echo import echo_json
from lmic.commands.options import JSON, Choices, compiling
from lmic.errors import LmicError


@click.command("list")
@JSON
def list_theorems(as_json: bool) -> None:
    """List the theorems of the library."""
    from lmic.commands import terminal
    from lmic.index import entries

    if as_json:
        return echo_json([{"name": e.name, "title": e.title, "source": str(e.source)} for e in entries()])
    table = terminal.table("theorem", "title", "source")
    for entry in entries():
        table.add_row(entry.name, entry.title, entry.source.short)
    terminal.console().print(table)
    return None


@click.command()
@click.argument("name")
@click.option("--plant", type=click.Path(path_type=Path), help="Compile for this plant, a file or one of the library.")
@click.option("--vertices", default=2, show_default=True, help="Without a plant: vertices of each domain.")
@compiling
@JSON
def show(name: str, plant: Path | None, vertices: int, as_json: bool, **choices: Any) -> None:
    """Show a theorem: statement, data, unknowns, and its size once compiled."""
    from lmic import library, reporting
    from lmic.plants.files import read_plant
    from lmic.plants.random import random_plant

    theorem, chosen = library.theorem(name), Choices(**choices)
    if not plant:
        given = [f"{symbol.name}=1" for symbol in theorem.givens]
        chosen = replace(chosen, given=(*given, *chosen.given))
    problem = chosen.compile(
        theorem, read_plant(plant) if plant else random_plant(theorem, chosen.dimensions(), vertices)
    )
    if as_json:
        echo_json(reporting.description(theorem, problem))
    else:
        reporting.print_description(theorem, problem)


@click.command()
@click.argument("name")
@click.option("--document", is_flag=True, help="A whole document that pdflatex compiles.")
@click.option("--mathml", is_flag=True, help="MathML in place of LaTeX.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Write to a file.")
@JSON
def latex(name: str, document: bool, mathml: bool, output: Path | None, as_json: bool) -> None:
    """Print a theorem's block matrices as LaTeX (amsmath), numbered and labelled, or as MathML."""
    from lmic import library
    from lmic.files import write_whole
    from lmic.typeset import latex as writer
    from lmic.typeset import mathml as mathml_writer

    theorem = library.theorem(name)
    if document and mathml:
        raise LmicError("--document is of LaTeX; leave it or --mathml out")
    if as_json:
        matrix = mathml_writer.matrix if mathml else writer.matrix
        return echo_json({name: matrix(lmi) for name, lmi in writer.statement_lmis(theorem).items()})
    if mathml:
        text = mathml_writer.theorem(theorem)
    else:
        text = writer.document(theorem) if document else writer.theorem(theorem)
    if output:
        write_whole(output, text + "\n")
    else:
        click.echo(text)
    return None
