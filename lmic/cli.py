"""The command line: all commands in one group. Their heavy imports wait until a command needs them."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import click

from lmic import __version__, interrupts
from lmic.authoring.command import check, new
from lmic.commands.echo import sentence, silence_output
from lmic.commands.proofs import refute, verify
from lmic.commands.solve import solve
from lmic.commands.theorems import latex, list_theorems, show
from lmic.diagnosis.command import diagnose
from lmic.errors import LmicError
from lmic.interchange.command import export
from lmic.pages.command import gallery, report
from lmic.papers.command import reproduce
from lmic.sweeps.command import sweep


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


for command in (
    list_theorems,
    new,
    check,
    show,
    latex,
    solve,
    diagnose,
    sweep,
    verify,
    refute,
    export,
    report,
    gallery,
    reproduce,
):
    main.add_command(command)
