"""The command line. Heavy imports wait until a command needs them."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from lmic import __version__, interrupts
from lmic.authoring.command import check, new
from lmic.diagnosis.command import diagnose
from lmic.echo import echo_json, sentence, silence_output
from lmic.errors import LmicError
from lmic.options import JSON, Choices, compiling, needed, numbers, refuse_with_file
from lmic.pages.command import report
from lmic.papers.command import reproduce
from lmic.sweeps.command import sweep

PLANT_HELP = "Plant file (.toml, .json, .mat, .npz) or a plant of the library, as peixoto2025.example1."
PLANT = click.option("--plant", type=click.Path(path_type=Path), required=True, help=PLANT_HELP)
PLANT_OF_THEOREM = click.option("--plant", type=click.Path(path_type=Path), help=f"{PLANT_HELP} Needed for a theorem.")
SOLVER = click.option(
    "--solver",
    "solver_names",
    multiple=True,
    metavar="NAME",
    help="clarabel, scs, cvxopt, sdpa, mosek or copt; given again, the next takes over where one fails.",
)


class Group(click.Group):
    """Ends in one line where something is wrong or Ctrl-C was pressed; ``--debug`` shows an error's traceback."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; one that is interrupted says what is kept."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt as stop:
            click.echo(f"interrupted; {stop.args[0] if stop.args else interrupts.NOTHING}", err=True)
            ctx.exit(interrupts.EXIT)

    def main(self, args: Sequence[str] | None = None, **kwargs: Any) -> Any:  # type: ignore[override]
        """Run the command line; ``--debug`` may stand anywhere in it."""
        words = list(sys.argv[1:] if args is None else args)
        debug = "--debug" in words
        try:
            try:
                return super().main([word for word in words if word != "--debug"], **kwargs)
            finally:
                sys.stdout.flush()  # a full disk shows here
        except (LmicError, OSError, MemoryError) as error:
            if debug:
                raise
            if isinstance(error, OSError):
                silence_output()
            if not isinstance(error, BrokenPipeError):  # as of lmic list | head -1, which has all that it wants
                click.echo(sentence(error), err=True)
            sys.exit(1)


@click.group(cls=Group)
@click.version_option(__version__, prog_name="lmic")
@click.option(
    "--debug", is_flag=True, expose_value=False, help="Show the traceback of an error (anywhere in the line)."
)
def main() -> None:
    """Compile, solve and check parameter-dependent linear matrix inequalities."""


main.add_command(diagnose)
main.add_command(reproduce)
main.add_command(sweep)
main.add_command(new)
main.add_command(check)
main.add_command(report)


@main.command("list")
@JSON
def list_theorems(as_json: bool) -> None:
    """List the theorems of the library."""
    from lmic import terminal
    from lmic.index import entries

    if as_json:
        return echo_json([{"name": e.name, "title": e.title, "source": str(e.source)} for e in entries()])
    table = terminal.table("theorem", "title", "source")
    for entry in entries():
        table.add_row(entry.name, entry.title, entry.source.short)
    terminal.console().print(table)
    return None


@main.command()
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


@main.command()
@click.argument("name")
@click.option("--document", is_flag=True, help="A whole document that pdflatex compiles.")
@click.option("--mathml", is_flag=True, help="MathML in place of LaTeX.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Write to a file.")
@JSON
def latex(name: str, document: bool, mathml: bool, output: Path | None, as_json: bool) -> None:
    """Print a theorem's block matrices as LaTeX (amsmath), numbered and labelled, or as MathML."""
    from lmic import latex as writer
    from lmic import library
    from lmic import mathml as mathml_writer
    from lmic.files import write_whole

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


@main.command()
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
    from lmic.interchange.formats import is_problem_file
    from lmic.solve.registry import solvers
    from lmic.solving import solve_file, solve_theorem

    solver = solvers(solver_names)
    if is_problem_file(name):
        refuse_with_file(name, plant=plant, search=search, certify=certify, refine=refine, output=output, **choices)
        trusted = solve_file(name, solver, as_json)
    else:
        chosen = Choices(**choices)
        trusted = solve_theorem(name, needed(plant), chosen, solver, search, certify, refine, output, as_json)
    if not trusted:
        sys.exit(1)


@main.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--theorem", metavar="PATH", help="The theorem file, where the theorem is not one of the library.")
@JSON
def verify(file: Path, theorem: str | None, as_json: bool) -> None:
    """Prove a certificate anew from its theorem and its file alone, without any solver."""
    from lmic import library, reporting
    from lmic.certify.certificate_file import read_certificate
    from lmic.certify.verify import verify as prove

    certificate = read_certificate(file)
    verdict = prove(certificate, library.theorem(theorem) if theorem else None)
    if as_json:
        echo_json(reporting.verdict_record(certificate, verdict))
    else:
        reporting.print_verdict(certificate, verdict)
    if not verdict.holds:
        sys.exit(1)


@main.command()
@click.argument("name")
@PLANT
@compiling
@click.option("--below", metavar="VALUE", required=True, help="The value that the theorem is said to reach.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Write the certificate to a file.")
@JSON
def refute(name: str, plant: Path, below: str, output: Path | None, as_json: bool, **choices: Any) -> None:
    """Prove that no solution of a theorem reports so small a value; ends with 1 where that is not proven."""
    from lmic.certify.certificate_file import write_certificate
    from lmic.certify.certify import refutation
    from lmic.pipeline import run

    chosen = Choices(**choices)
    value = numbers([f"value={below}"], "--below")["value"]
    result = run(chosen.compile_files(name, plant))
    certificate, report, lower = refutation(
        result, chosen.relaxation(result.problem.binding.plant), numbers(chosen.given, "--set"), chosen.dimensions()
    )
    if output:
        write_certificate(certificate, output)
    refuted = lower > value
    if as_json:
        echo_json({"report": report, "below": float(value), "lower": float(lower), "refuted": refuted})
    else:
        verdict = "so it cannot be reached" if refuted else "which does not refute it"
        click.echo(f"{report} = {below}: {report} is at least {float(lower):.12g} (proven), {verdict}")
    if not refuted:
        sys.exit(1)


@main.command()
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


@main.command()
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), default=Path("site"), show_default=True, help="Folder to write."
)
def gallery(output: Path) -> None:
    """Write a page for every theorem of the library, and an index."""
    from lmic import library, terminal
    from lmic.files import make_folder
    from lmic.pages.gallery import write_gallery

    make_folder(output)
    done: list[str] = []
    names = library.names()

    def kept() -> str:
        return f"{len(done)} of {len(names)} pages are in {output}, and the same command writes them all"

    with interrupts.keeping(kept), terminal.progress(len(names), "gallery") as advance:

        def written(name: str) -> None:
            done.append(name)
            advance(name)

        index = write_gallery(output, written)
    click.echo(str(index))
