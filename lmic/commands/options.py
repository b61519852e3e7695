"""The options that several commands take, those of compiling among them, and how their texts are read."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from lmic.errors import LmicError

if TYPE_CHECKING:
    from lmic.analysis.sampling import Gain
    from lmic.compiler.assemble import ConicProblem
    from lmic.compiler.bind import Binding
    from lmic.language.theorem import Theorem
    from lmic.plants.plant import Plant
    from lmic.relax.grid import Grid
    from lmic.relax.relax import Relaxation

Command = TypeVar("Command", bound=Callable[..., Any])


JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON and nothing else.")

_PLANT = "Plant file (.toml, .json, .mat, .npz) or a plant of the library, as peixoto2025.example1."
PLANT = click.option("--plant", type=click.Path(path_type=Path), required=True, help=_PLANT)
PLANT_OF_THEOREM = click.option("--plant", type=click.Path(path_type=Path), help=f"{_PLANT} Needed for a theorem.")
SOLVER = click.option(
    "--solver",
    "solver_names",
    multiple=True,
    metavar="NAME",
    help="clarabel, scs, cvxopt, sdpa, mosek or copt; given again, the next takes over where one fails.",
)


def _several(flag: str, name: str, metavar: str, text: str) -> Callable[[Any], Any]:
    return click.option(flag, name, multiple=True, metavar=metavar, help=text)


OPTIONS = (
    _several("--set", "given", "NAME=VALUE", "Value of a scalar, as eps=150."),
    _several("--dependence", "dependence", "UNKNOWN=CHOICE", "A degree, 'constant', or '1; rho1; sin(rho1)'."),
    _several("--size", "sizes", "NAME=N", "A dimension that no matrix of the plant fixes."),
    _several("--polya", "polya", "[NAME=]DEGREE", "Pólya degree, for all parameters or for one."),
    _several(
        "--grid", "grid", "NAME=GRID", "Points where a grid is used: 5, chebyshev:9, random:100, or '(1, 0); (0, 1)'."
    ),
    _several("--cover", "cover", "NAME=GAIN", "Grid that covers the sampling intervals: h=rigorous or h=published."),
    _several("--relax", "method", "NAME=METHOD", "auto, vertices, polya or grid."),
    _several("--tie", "ties", "B=A", "Instance b of a parameter equals instance a."),
)


def compiling(command: Command) -> Command:
    """Give a command the options of compiling; it gets them as keywords for :class:`Choices`."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command


@dataclass(frozen=True)
class Choices:
    """The options as texts."""

    given: Sequence[str] = ()
    dependence: Sequence[str] = ()
    sizes: Sequence[str] = ()
    polya: Sequence[str] = ()
    grid: Sequence[str] = ()
    cover: Sequence[str] = ()
    method: Sequence[str] = ()
    ties: Sequence[str] = ()

    def compile(self, theorem: Theorem, plant: Plant) -> ConicProblem:
        """The problem of a theorem and a plant with these choices."""
        from lmic.pipeline import compile

        return compile(
            theorem,
            plant,
            numbers(self.given, "--set"),
            dependences(self.dependence),
            self.relaxation(plant),
            self.dimensions(),
        )

    def prepare_files(self, theorem: str, plant: Path) -> Binding:
        """A theorem by name or path bound to a plant file, its scalars still open."""
        from lmic import library
        from lmic.pipeline import prepare
        from lmic.plants.files import read_plant

        return prepare(library.theorem(theorem), read_plant(plant), dependences(self.dependence), self.dimensions())

    def compile_files(self, theorem: str, plant: Path) -> ConicProblem:
        """The same from a theorem's name or path and a plant file."""
        from lmic import library
        from lmic.plants.files import read_plant

        return self.compile(library.theorem(theorem), read_plant(plant))

    def dimensions(self) -> dict[str, int]:
        """``["nx=3"]`` as {"nx": 3}."""
        sizes = {name: _count(value, f"--size {name}") for name, value in _pairs(self.sizes, "--size").items()}
        for name, value in sizes.items():
            if value < 1:
                raise LmicError(f"--size {name}={value}: a dimension is at least 1; give such a number")
        return sizes

    def relaxation(self, plant: Plant) -> Relaxation:
        """The relaxation that the options ask for; a covering takes its domain and matrix from the plant."""
        from lmic.analysis.sampling import cover
        from lmic.relax.relax import Relaxation

        grid = {name: _grid(name, value) for name, value in _pairs(self.grid, "--grid").items()}
        covered = {name: cover(plant, _gain(value), name).grid for name, value in _pairs(self.cover, "--cover").items()}
        return Relaxation(
            method=_pairs(self.method, "--relax"),
            polya=degrees(self.polya),
            grid=grid | covered,
            ties=_pairs(self.ties, "--tie"),
        )


def needed(plant: Path | None) -> Path:
    """The plant of a theorem."""
    if plant is None:
        raise click.MissingParameter(param_hint="'--plant'", param_type="option")
    return plant


def refuse_with_file(name: str, **options: Any) -> None:
    """Options that mean nothing beside a file that is a whole problem."""
    given = [option for option, value in options.items() if value]
    if given:
        raise LmicError(f"{name} is a whole problem, which --{given[0]} cannot change; leave the option out")


def interval(text: str, option: str) -> tuple[str, float, float]:
    """``"eps=0.1:6"`` as a name and the two ends."""
    ((name, value),) = _pairs([text], option).items()
    low, separator, high = value.partition(":")
    if not separator:
        raise LmicError(f"'{option} {text}' has no ':'; write {option} NAME=LOW:HIGH")
    ends = [float(numbers([f"{name}={end}"], option)[name]) for end in (low, high)]
    if not ends[0] < ends[1]:
        raise LmicError(f"'{option} {text}' is an empty interval; give its lower end first")
    return name, ends[0], ends[1]


def numbers(texts: Sequence[str], option: str) -> dict[str, Any]:
    """``["eps=150", "rho=1/3"]`` as exact numbers."""
    from lmic.plants.plant import exact_number

    found: dict[str, Any] = {}
    for name, value in _pairs(texts, option).items():
        try:
            found[name] = exact_number(value)
            float(found[name])
        except (LmicError, OverflowError) as error:
            raise LmicError(f"{option} {name}={value}: give a finite number such as 0.5 or 1/3") from error
    return found


def degrees(texts: Sequence[str]) -> dict[str, int] | int:
    """``["1"]`` for all parameters, or ``["alpha=1", "alpha+=0"]``."""
    if len(texts) == 1 and "=" not in texts[0]:
        return _count(texts[0], "--polya")
    return {name: _count(value, f"--polya {name}") for name, value in _pairs(texts, "--polya").items()} or 0


def dependences(texts: Sequence[str]) -> dict[str, Any]:
    """``["P1=2", "H=constant", "P=1; rho1; rho1**2"]``."""
    from lmic.compiler.bases import read_choice

    return {name: read_choice(value) for name, value in _pairs(texts, "--dependence").items()}


def _grid(name: str, text: str) -> Grid:
    from lmic.relax.grid import Grid

    try:
        return Grid.of(text)
    except LmicError as error:
        raise LmicError(f"--grid {name}={text}: {error}") from error


def _gain(text: str) -> Gain:
    from lmic.analysis.sampling import Gain

    if text not in list(Gain):
        raise LmicError(f"'{text}' after --cover is no gain; use {' or '.join(Gain)}")
    return Gain(text)


def _pairs(texts: Sequence[str], option: str) -> dict[str, str]:
    found: dict[str, str] = {}
    for text in texts:
        name, separator, value = text.partition("=")
        if name.strip() in found:
            raise LmicError(f"{option} gives {name.strip()} twice; give it once")
        if not separator or not name.strip():
            raise LmicError(f"'{option} {text}' has no name or no '='; write {option} NAME=VALUE")
        found[name.strip()] = value.strip()
    return found


def _count(text: str, option: str) -> int:
    from lmic.plants.expressions import quoted, whole_number

    count = whole_number(text)
    if count is None:
        raise LmicError(f"{quoted(text)} after {option} is not a whole number from 0 on; write a number such as 2")
    return count
