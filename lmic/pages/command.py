"""``lmic report`` and ``lmic gallery``."""

from __future__ import annotations

from pathlib import Path

import click

from lmic.commands.echo import echo_json
from lmic.commands.options import JSON
from lmic.errors import FormatError
from lmic.interrupts import keeping


@click.command()
@click.argument("result", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Page to write.  [default: RESULT with .html]")
@click.option("--theorem", metavar="PATH", help="The theorem file, where the theorem is not one of the library.")
@JSON
def report(result: Path, output: Path | None, theorem: str | None, as_json: bool) -> None:
    """Make a page of a result that 'lmic solve -o RESULT.json' stored, without solving again.

    The page needs no other file and no network: block matrices, sizes, numbers and what is known of them, the design,
    and by how much the LMIs hold between the points where they were imposed.
    """
    from lmic import library
    from lmic.pages.result import report as write_page
    from lmic.result_file import read_result

    if not result.name:
        raise FormatError(f"{result} is no file; give the one that 'lmic solve -o' wrote")
    page = output or result.with_suffix(".html")
    if page.suffix.lower() != ".html":
        raise FormatError(f"{page} would hold a page; end the name in .html")
    found, certificate = read_result(result, library.theorem(theorem) if theorem else None)
    write_page(found, certificate, page)
    if as_json:
        echo_json({"file": str(page), "theorem": found.theorem.name, "reports": dict(found.reports)})
    else:
        click.echo(str(page))


@click.command()
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), default=Path("site"), show_default=True, help="Folder to write."
)
def gallery(output: Path) -> None:
    """Write a page for every theorem of the library, and an index."""
    from lmic import library
    from lmic.commands import terminal
    from lmic.files import make_folder
    from lmic.pages.gallery import write_gallery

    make_folder(output)
    done: list[str] = []
    names = library.names()

    def kept() -> str:
        return f"{len(done)} of {len(names)} pages are in {output}, and the same command writes them all"

    with keeping(kept), terminal.progress(len(names), "gallery") as advance:

        def written(name: str) -> None:
            done.append(name)
            advance(name)

        index = write_gallery(output, written)
    click.echo(str(index))
