"""The terminal: console, tables and progress bars in one style."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich import box
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text


def console() -> Console:
    """The terminal; wide enough for the tables where the output is a file.

    It takes texts as they are: rich would read the instance in ``r[a]`` as a style, and leave it out.
    """
    plain = Console(highlight=False, markup=False)
    return plain if plain.is_terminal else Console(highlight=False, markup=False, width=140)


def marked(word: str, rest: str, style: str = "bold") -> Text:
    """A line whose first word stands out."""
    return Text.assemble((word, style), rest)


def warning(text: str) -> Text:
    """A line that warns."""
    return marked("warning", f"     {text}", "bold red")


def table(*columns: str, title: str | None = None) -> Table:
    """An empty table in the project's style."""
    result = Table(box=box.SIMPLE_HEAD, title=title, title_justify="left", title_style="bold")
    for number, column in enumerate(columns):
        result.add_column(column, overflow="fold", no_wrap=number == 0)
    return result


def _bar(quiet: bool) -> Progress:
    errors = Console(stderr=True)
    return Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=errors,
        transient=True,
        disable=quiet or not errors.is_terminal,
    )


@contextmanager
def progress(total: int, title: str, quiet: bool = False) -> Iterator[Callable[[str], None]]:
    """A progress bar on standard error; call the yielded function after each piece of work."""
    with _bar(quiet) as bar:
        task = bar.add_task(title, total=total)
        yield lambda what: bar.update(task, advance=1, description=f"{title}: {what}")


@contextmanager
def counter(title: str, quiet: bool = False) -> Iterator[Callable[[int, int], None]]:
    """A progress bar whose total is told with each step: call the yielded function with (more, total)."""
    with _bar(quiet) as bar:
        task = bar.add_task(title, total=None)
        yield lambda more, total: bar.update(task, advance=more, total=total)
