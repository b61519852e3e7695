"""What a sweep runs over, and how it is written: ``eps=0.1:6:296``, ``polya=0,1,2``, ``dependence:P=constant,1``."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from typing import Any

import numpy as np

from lmic.compiler.bases import Choice, read_choice
from lmic.errors import LmicError, SweepError
from lmic.plants.expressions import whole_number
from lmic.plants.plant import Plant, exact_number
from lmic.relax.grid import Grid

#: a comma between values: those of a point stand in parentheses
_COMMA = re.compile(r",(?![^(]*\))")


class Kind(StrEnum):
    """What varies along an axis; ``set`` is a scalar of the theorem or the plant."""

    SCALAR = "set"
    PLANT = "plant"
    DEPENDENCE = "dependence"
    POLYA = "polya"
    GRID = "grid"


@dataclass(frozen=True)
class Axis:
    """Values of one thing, each with the text that identifies it in a sweep's file.

    ``name`` is that of the scalar, unknown or parameter, empty for plants and for one Pólya degree of all parameters.
    """

    kind: Kind
    name: str
    values: tuple[Any, ...]
    labels: tuple[str, ...]

    @property
    def column(self) -> str:
        """The axis in tables and files: ``eps``, ``plant``, ``dependence P``."""
        return self.name if self.kind is Kind.SCALAR else f"{self.kind} {self.name}".strip()

    @property
    def numeric(self) -> bool:
        """Whether the values are numbers."""
        return self.kind in (Kind.SCALAR, Kind.POLYA)

    @property
    def shown(self) -> tuple[Any, ...]:
        """The values for tables and plots: numbers, or the labels."""
        return tuple(map(float, self.values)) if self.numeric else self.labels


def make_axis(key: str, values: Any) -> Axis:
    """The axis of a key such as ``eps``, ``polya:alpha`` or ``dependence:P``; a text is read as the command line's.

    Raises SweepError for an unknown kind, for no value, or for one value twice.
    """
    kind, name = _kind(key.strip())
    try:
        found = _texts(kind, values) if isinstance(values, str) else list(values)
        read = tuple(_READ[kind](value) for value in found)
    except (LmicError, TypeError, ValueError, OverflowError) as error:
        raise SweepError(f"'{key}={_short(values)}' is no axis: {error}") from error
    axis = Axis(kind, name, read, tuple(_label(kind, value) for value in read))
    if not read:
        raise SweepError(f"the axis {key} has no value; give at least one")
    twice = next((label for label in axis.labels if axis.labels.count(label) > 1), None) if len(read) < 10**4 else None
    if twice or len(set(axis.labels)) < len(read):
        raise SweepError(f"the axis {key} has a value twice{f', {twice}' if twice else ''}; give it once")
    return axis


def plant_axis(plants: Sequence[Plant]) -> Axis:
    """The axis of several plants, identified by their names."""
    names = tuple(plant.name for plant in plants)
    if len(set(names)) < len(names):
        raise SweepError(f"two plants are called {max(names, key=names.count)}; rename one, a sweep tells them by name")
    return Axis(Kind.PLANT, "", tuple(plants), names)


def axes_of(over: Mapping[str, Any], plants: Sequence[Plant]) -> tuple[Axis, ...]:
    """All axes, the plants' first where there are several; raises SweepError where two are the same."""
    axes = [plant_axis(plants)] if len(plants) > 1 else []
    axes += [make_axis(key, values) for key, values in over.items()]
    columns = [axis.column for axis in axes]
    if len(set(columns)) < len(columns):
        raise SweepError(f"{max(columns, key=columns.count)} is swept twice; give one axis for it")
    if not axes:
        raise SweepError("nothing is swept over; give an axis such as eps=0.1:6:60, or several plants")
    return tuple(axes)


def number_label(value: Fraction) -> str:
    """A fraction as a decimal where it is a short one: 3/25 is 0.12."""
    shown = Fraction(repr(float(value)))
    return repr(float(value)).removesuffix(".0") if shown == value else str(value)


def _kind(key: str) -> tuple[Kind, str]:
    """``polya:alpha`` as its kind and name; a bare name is a scalar's, except polya."""
    prefix, separator, name = key.partition(":")
    if not separator:
        return (Kind.POLYA, "") if key == Kind.POLYA else (Kind.SCALAR, key)
    if prefix not in (*Kind,) or prefix == Kind.PLANT or not name:
        raise SweepError(f"'{key}' is no axis; write a scalar's name, dependence:P, polya, polya:alpha or grid:rho")
    return Kind(prefix), name


def _texts(kind: Kind, text: str) -> list[Any]:
    """``1,10,50``, ``5,(0, 1); (1, 0)``, ``LOW:HIGH:COUNT`` or ``log:LOW:HIGH:COUNT``; only scalars have ranges."""
    parts = text.split(":")
    if kind is not Kind.SCALAR or len(parts) == 1:
        return [part.strip() for part in _COMMA.split(text) if part.strip()]
    logarithmic = parts[0].strip() == "log"
    if len(parts) - logarithmic != 3 or (count := whole_number(parts[-1])) is None:
        raise SweepError("a range is LOW:HIGH:COUNT or log:LOW:HIGH:COUNT; write one such as 0.1:6:60")
    low, high = exact_number(parts[-3].strip()), exact_number(parts[-2].strip())
    if count < 2 or not low < high or (logarithmic and low <= 0):
        raise SweepError(
            "a range goes from a lower to a higher number, positive ones with log, in 2 points or more; correct it"
        )
    if logarithmic:
        middle = np.geomspace(float(low), float(high), count)[1:-1]
        return [low, *(exact_number(float(value)) for value in middle), high]
    return [low + (high - low) * Fraction(k, count - 1) for k in range(count)]


def _degree(value: Any) -> int:
    if (degree := whole_number(str(value))) is not None:
        return degree
    raise SweepError(f"'{value}' is no Pólya degree; give a whole number from 0")


def _dependence(value: Any) -> Choice:
    return read_choice(value) if isinstance(value, str) else value


def _label(kind: Kind, value: Any) -> str:
    match kind:
        case Kind.SCALAR:
            return number_label(value)
        case Kind.GRID:
            return _grid_label(value)
        case Kind.DEPENDENCE if isinstance(value, Iterable) and not isinstance(value, str):
            return "; ".join(map(str, value))
    return str(value)


def _grid_label(grid: Grid) -> str:
    if grid.kind == "points":
        return "; ".join(" ".join(f"{value:.12g}" for value in point) for point in grid.points)
    seed = f" seed {grid.seed}" if grid.seed else ""
    return f"{grid.count}" if grid.kind == "uniform" else f"{grid.kind}:{grid.count}{seed}"


def _short(values: Any) -> str:
    text = str(values)
    return text if len(text) <= 60 else f"{text[:57]}..."


_READ: Mapping[Kind, Callable[[Any], Any]] = {
    Kind.SCALAR: exact_number,
    Kind.PLANT: lambda plant: plant,
    Kind.DEPENDENCE: _dependence,
    Kind.POLYA: _degree,
    Kind.GRID: Grid.of,
}
