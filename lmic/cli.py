"""The command line. Heavy imports wait until a command needs them."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from lmic import __version__
from lmic.errors import LmicError

if TYPE_CHECKING:
    from lmic.assemble import ConicProblem
    from lmic.language.theorem import Theorem

JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON and nothing else.")
PLANT = click.option(
    "--plant", type=click.Path(path_type=Path), required=True, help="Plant file: .toml, .json, .mat or .npz."
)
SET = click.option("--set", "settings", multiple=True, metavar="NAME=VALUE", help="Value of a scalar, as eps=150.")
POLYA = click.option(
    "--polya", multiple=True, metavar="[NAME=]DEGREE", help="Pólya degree, for all parameters or for one."
)
DEPENDENCE = click.option(
    "--dependence",
    multiple=True,
    metavar="UNKNOWN=CHOICE",
    help="A degree, 'constant', or functions '1; rho1; sin(rho1)'.",
)
SIZE = click.option(
    "--size", "sizes", multiple=True, metavar="NAME=N", help="A dimension that no matrix of the plant fixes."
)


class Group(click.Group):
    """Prints lmic's own errors as one line and ends with 1; ``--debug`` shows the traceback."""

    def main(self, args: Sequence[str] | None = None, **kwargs: Any) -> Any:  # type: ignore[override]
        """Run the command line; ``--debug`` may stand anywhere in it."""
        words = list(sys.argv[1:] if args is None else args)
        debug = "--debug" in words
        try:
            return super().main([word for word in words if word != "--debug"], **kwargs)
        except LmicError as error:
            if debug:
                raise
            click.echo(f"{type(error).__name__}: {error}", err=True)
            sys.exit(1)
        except BrokenPipeError:
            sys.stderr.close()
            sys.exit(1)


@click.group(cls=Group)
@click.version_option(__version__, prog_name="lmic")
@click.option(
    "--debug", is_flag=True, expose_value=False, help="Show the traceback of an error (anywhere in the line)."
)
def main() -> None:
    """Compile, solve and check parameter-dependent linear matrix inequalities."""


@main.command("list")
@JSON
def list_theorems(as_json: bool) -> None:
    """List the theorems of the library."""
    from lmic import library, terminal

    found = {name: library.theorem(name) for name in library.names()}
    if as_json:
        return echo_json([{"name": n, "title": t.title, "source": str(t.source)} for n, t in found.items()])
    table = terminal.table("theorem", "title", "source")
    for name, theorem in found.items():
        table.add_row(
            name, theorem.title, f"{theorem.source.authors} ({theorem.source.year}), {theorem.source.statement}"
        )
    terminal.console().print(table)
    return None


@main.command()
@click.argument("name")
@click.option("--plant", type=click.Path(path_type=Path), help="Compile for this plant.")
@click.option("--vertices", default=2, show_default=True, help="Without a plant: vertices of each domain.")
@SET
@POLYA
@DEPENDENCE
@SIZE
@JSON
def show(
    name: str,
    plant: Path | None,
    vertices: int,
    settings: Sequence[str],
    polya: Sequence[str],
    dependence: Sequence[str],
    sizes: Sequence[str],
    as_json: bool,
) -> None:
    """Show a theorem: statement, data, unknowns, and its size once compiled."""
    from lmic import library, reporting
    from lmic.pipeline import compile
    from lmic.plants.files import read_plant
    from lmic.plants.random import random_plant

    theorem = library.theorem(name)
    chosen = {key: int(value) for key, value in pairs(sizes, "--size").items()}
    data = read_plant(plant) if plant else random_plant(theorem, chosen, vertices)
    given = pairs(settings, "--set") if plant else {s.name: 1 for s in theorem.givens} | pairs(settings, "--set")
    problem = compile(theorem, data, given, dependences(dependence), degrees(polya), chosen)
    if as_json:
        return echo_json(reporting.description(theorem, problem))
    reporting.print_description(theorem, problem)
    return None


@main.command()
@click.argument("name")
@click.option("--document", is_flag=True, help="A whole document that pdflatex compiles.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Write to a file.")
@JSON
def latex(name: str, document: bool, output: Path | None, as_json: bool) -> None:
    """Print a theorem's block matrices as LaTeX (amsmath)."""
    from lmic import latex as writer
    from lmic import library
    from lmic.export import write_whole

    theorem = library.theorem(name)
    if as_json:
        return echo_json({lmi: writer.matrix(matrix) for lmi, matrix in theorem.lmis.items()})
    text = writer.document(theorem) if document else writer.theorem(theorem)
    if output:
        write_whole(output, text + "\n")
    else:
        click.echo(text)
    return None


@main.command()
@click.argument("name")
@PLANT
@SET
@POLYA
@DEPENDENCE
@SIZE
@JSON
def solve(
    name: str,
    plant: Path,
    settings: Sequence[str],
    polya: Sequence[str],
    dependence: Sequence[str],
    sizes: Sequence[str],
    as_json: bool,
) -> None:
    """Solve a theorem (by name or path) for a plant and print what it reports and recovers."""
    from lmic import reporting
    from lmic.pipeline import run

    result = run(_problem(name, plant, settings, polya, dependence, sizes))
    if as_json:
        echo_json(reporting.result_record(result))
    else:
        reporting.print_result(result)
    if not result.solution.status.usable:
        sys.exit(1)


@main.command()
@click.argument("name")
@PLANT
@SET
@POLYA
@DEPENDENCE
@SIZE
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="File to write, ending in .dat-s.")
@JSON
def export(
    name: str,
    plant: Path,
    settings: Sequence[str],
    polya: Sequence[str],
    dependence: Sequence[str],
    sizes: Sequence[str],
    output: Path,
    as_json: bool,
) -> None:
    """Write the compiled problem in SDPA sparse format."""
    from lmic.export import write_sdpa

    if output.suffixes[-1:] != [".dat-s"]:
        raise LmicError(f"the format of {output} is unknown; end the name in .dat-s")
    problem = _problem(name, plant, settings, polya, dependence, sizes)
    write_sdpa(problem, output)
    summary = {"file": str(output), "unknowns": problem.size, "lmis": len(problem.orders)}
    if as_json:
        echo_json(summary)
    else:
        click.echo(f"{output}: {problem.size} unknowns, {len(problem.orders)} LMIs")


@main.command()
@click.argument("names", nargs=-1)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default=Path("reports"),
    show_default=True,
    help="Folder for the figures.",
)
@JSON
def reproduce(names: tuple[str, ...], output: Path, as_json: bool) -> None:
    """Regenerate the papers' tables and figures (all, or by the beginning of their ids)."""
    from lmic import reporting, terminal
    from lmic.papers.cases import select
    from lmic.papers.figures import draw
    from lmic.papers.reproduce import reproduce as run_table
    from lmic.papers.reproduce import run_simulation

    records = []
    trusted = True
    for table in select(names):
        outcomes = {}
        with terminal.progress(len(table.cases), table.paper, quiet=as_json) as advance:
            for outcome in run_table(table):
                outcomes[outcome.case.id] = outcome
                advance(outcome.case.what)
        simulated = [run_simulation(simulation, outcomes) for simulation in table.simulations]
        figures = [path for one in simulated for path in draw(one, outcomes, output)]
        records += reporting.reproduction_records(outcomes, simulated)
        trusted &= all(outcome.result.solution.trusted for outcome in outcomes.values())
        if not as_json:
            reporting.print_reproduction(table, outcomes, simulated, figures)
    if as_json:
        echo_json(records)
    if not trusted:
        sys.exit(1)


def _problem(
    name: str,
    plant: Path,
    settings: Sequence[str],
    polya: Sequence[str],
    dependence: Sequence[str],
    sizes: Sequence[str],
) -> ConicProblem:
    from lmic import library
    from lmic.pipeline import compile
    from lmic.plants.files import read_plant

    theorem: Theorem = library.theorem(name)
    chosen = {key: int(value) for key, value in pairs(sizes, "--size").items()}
    return compile(
        theorem, read_plant(plant), pairs(settings, "--set"), dependences(dependence), degrees(polya), chosen
    )


# Reading options ---------------------------------------------------------------------------------


def pairs(texts: Sequence[str], option: str) -> dict[str, Any]:
    """``["eps=150", "rho=1/3"]`` as a dictionary of exact numbers."""
    from lmic.plants.plant import exact_number

    found: dict[str, Any] = {}
    for text in texts:
        name, separator, value = text.partition("=")
        if not separator or not name.strip():
            raise LmicError(f"{option} {text} has no '='; write {option} NAME=VALUE")
        found[name.strip()] = exact_number(value.strip())
    return found


def degrees(texts: Sequence[str]) -> dict[str, int] | int:
    """``["1"]`` for all parameters, or ``["alpha=1", "alpha+=0"]``."""
    if len(texts) == 1 and "=" not in texts[0]:
        return _degree(texts[0])
    found = {}
    for text in texts:
        name, separator, value = text.rpartition("=")
        if not separator:
            raise LmicError(f"--polya {text} is given beside others; write --polya NAME=DEGREE for each")
        found[name] = _degree(value)
    return found or 0


def _degree(text: str) -> int:
    if not text.strip().isdecimal():
        raise LmicError(f"the Pólya degree '{text}' is not a whole number from 0; write --polya 1")
    return int(text)


def dependences(texts: Sequence[str]) -> dict[str, Any]:
    """``["P1=2", "H=constant", "P=1; rho1; rho1**2"]``."""
    found: dict[str, Any] = {}
    for text in texts:
        name, separator, value = text.partition("=")
        if not separator:
            raise LmicError(f"--dependence {text} has no '='; write --dependence P=2 or --dependence 'P=1; rho1'")
        value = value.strip()
        if value.isdecimal():
            found[name] = int(value)
        else:
            found[name] = value if value == "constant" else [part.strip() for part in value.split(";")]
    return found


# Printing -------------------------------------------------------------------------------------------


def echo_json(data: Any) -> None:
    """Print plain data as JSON; infinities and NaN as null."""
    import json

    click.echo(json.dumps(_finite(data), indent=2, ensure_ascii=False))


def _finite(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _finite(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_finite(value) for value in data]
    if isinstance(data, float) and not (abs(data) < float("inf")):
        return None
    return data
