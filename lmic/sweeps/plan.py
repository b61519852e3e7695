"""The plan of a sweep: a theorem, its choices and its axes, and what identifies them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice, product
from math import prod
from typing import Any, TypeAlias

from lmic.compiler.bases import Choice
from lmic.compiler.bind import scalar_values
from lmic.errors import Place, SweepError
from lmic.fingerprint import digest, plant_data, statement
from lmic.language.theorem import Theorem
from lmic.plants.plant import Plant
from lmic.relax.relax import Relaxation
from lmic.sweeps.axes import Axis, Kind

#: the labels of a point, one for each axis
Key: TypeAlias = tuple[str, ...]

MAX_POINTS = 10**7


@dataclass(frozen=True)
class Line:
    """Points that differ in given scalars only: they share what is compiled, which ``digest`` tells from others.

    ``scalars`` are the values of each point, with its key in ``keys``.
    """

    theorem: Theorem
    plant: Plant
    dependence: Mapping[str, Choice]
    sizes: Mapping[str, int]
    relaxation: Relaxation
    search: tuple[str, float, float] | None
    digest: str
    scalars: tuple[Mapping[str, Any], ...]
    keys: tuple[Key, ...]

    def part(self, start: int, end: int | None = None) -> Line:
        """Some of the points."""
        return replace(self, scalars=self.scalars[start:end], keys=self.keys[start:end])


@dataclass(frozen=True)
class Plan:
    """Everything that a sweep computes, point by point, is decided here.

    ``search`` is a scalar with the interval in which its best value is sought at every point.
    """

    theorem: Theorem
    plants: tuple[Plant, ...]
    axes: tuple[Axis, ...]
    given: Mapping[str, Any] = field(default_factory=dict)
    dependence: Mapping[str, Choice] = field(default_factory=dict)
    sizes: Mapping[str, int] = field(default_factory=dict)
    relaxation: Relaxation = field(default_factory=Relaxation)
    search: tuple[str, float, float] | None = None

    def __post_init__(self) -> None:
        place = Place(self.theorem.name)
        if len(self) > MAX_POINTS:
            raise SweepError(
                f"{len(self)} points are more than a sweep may have ({MAX_POINTS}); coarsen an axis", place
            )
        fixed: Mapping[Kind, Mapping[str, Any]] = {
            Kind.SCALAR: self.given,
            Kind.DEPENDENCE: self.dependence,
            Kind.GRID: self.relaxation.grid,
        }
        for axis in self.axes:
            if axis.name in fixed.get(axis.kind, {}):
                raise SweepError(f"{axis.name} is both fixed and swept over; remove one", place)
            if axis.kind is Kind.POLYA:
                self._check_degrees(axis)
            if axis.kind is Kind.DEPENDENCE and axis.name not in self.theorem.unknowns:
                known = ", ".join(self.theorem.unknowns)
                raise SweepError(
                    f"{axis.name} is no unknown of the theorem, which has {known}; correct the name", place
                )
            if self.search and axis.column == self.search[0]:
                raise SweepError(f"{axis.name} is both searched and swept over; remove one", place)
        # a scalar without a value, or a misspelt one, would fail at every point
        first = {**self.given, **{axis.name: axis.values[0] for axis in self.axes if axis.kind is Kind.SCALAR}}
        first |= {self.search[0]: self.search[1]} if self.search else {}
        for plant in self.plants:
            scalar_values(self.theorem, plant, first)

    def _check_degrees(self, axis: Axis) -> None:
        """A degree that is swept over leaves those of other parameters, if they are given by name, and no others."""
        degrees = self.relaxation.polya
        if degrees if isinstance(degrees, int) or not axis.name else axis.name in degrees:
            raise SweepError(
                f"Pólya degrees are fixed while {axis.column} is swept over; fix those of other parameters by name",
                Place(self.theorem.name),
            )

    def __len__(self) -> int:
        return prod(self.shape)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each axis."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def columns(self) -> tuple[str, ...]:
        """The axes' columns."""
        return tuple(axis.column for axis in self.axes)

    def points(self) -> Iterator[Key]:
        """The keys of all points, the last axis fastest."""
        return product(*(axis.labels for axis in self.axes))

    def lines(self, length: int, done: Mapping[Key, Any]) -> Iterator[Line]:
        """What remains to be done, in lines of at most ``length`` neighbours along the last axis of scalars."""
        scalars = [axis for axis in self.axes if axis.kind is Kind.SCALAR]
        others = [axis for axis in self.axes if axis.kind is not Kind.SCALAR]
        order = [self.axes.index(axis) for axis in (*others, *scalars)]
        inverse = [order.index(k) for k in range(len(order))]
        for chosen in product(*(zip(axis.values, axis.labels, strict=True) for axis in others)):
            shared = self._line(others, [value for value, _ in chosen])
            head = [label for _, label in chosen]
            for rest in product(*(zip(a.values, a.labels, strict=True) for a in scalars[:-1])):
                last = zip(scalars[-1].values, scalars[-1].labels, strict=True) if scalars else iter([(None, "")])
                while part := list(islice(last, length)):
                    points = [(*rest, end) if scalars else rest for end in part]
                    labels = [[*head, *(label for _, label in point)] for point in points]
                    keys = [tuple(found[k] for k in inverse) for found in labels]
                    values = [
                        {**self.given, **{a.name: v for a, (v, _) in zip(scalars, point, strict=True)}}
                        for point in points
                    ]
                    left = [k for k, key in enumerate(keys) if key not in done]
                    if left:
                        yield replace(shared, scalars=tuple(values[k] for k in left), keys=tuple(keys[k] for k in left))

    def _line(self, axes: Sequence[Axis], values: Sequence[Any]) -> Line:
        """What the points of a line share."""
        plant, dependence, relaxation = self.plants[0], dict(self.dependence), self.relaxation
        for axis, value in zip(axes, values, strict=True):
            match axis.kind:
                case Kind.PLANT:
                    plant = value
                case Kind.DEPENDENCE:
                    dependence[axis.name] = value
                case Kind.GRID:
                    relaxation = replace(relaxation, grid={**relaxation.grid, axis.name: value})
                case Kind.POLYA if not axis.name:
                    relaxation = replace(relaxation, polya=value)
                case Kind.POLYA:
                    degrees = relaxation.polya if isinstance(relaxation.polya, Mapping) else {}
                    relaxation = replace(relaxation, polya={**degrees, axis.name: value})
        compiled = [self.fingerprint, plant.name, sorted((name, str(choice)) for name, choice in dependence.items())]
        return Line(self.theorem, plant, dependence, self.sizes, relaxation, self.search, digest(compiled), (), ())

    # What identifies the problem -----------------------------------------------------------------

    @cached_property
    def header(self) -> dict[str, Any]:
        """What a sweep's file says of its problem; the axes' values may grow, all else must stay."""
        return {
            "theorem": self.theorem.name,
            "plants": [plant.name for plant in self.plants],
            "axes": list(self.columns),
            "search": list(self.search) if self.search else None,
            "fixed": {name: str(value) for name, value in self.given.items()},
            "fingerprint": self.fingerprint,
        }

    @cached_property
    def fingerprint(self) -> str:
        """A digest of the statement, the plants' data and all choices but the axes' values."""
        parts = {
            "theorem": statement(self.theorem),
            "plants": [plant_data(plant) for plant in self.plants],
            "axes": [(axis.kind.value, axis.name) for axis in self.axes],
            "given": sorted((name, str(value)) for name, value in self.given.items()),
            "dependence": sorted((name, str(choice)) for name, choice in self.dependence.items()),
            "sizes": sorted(self.sizes.items()),
            "relaxation": repr(self.relaxation),
            "search": self.search,
        }
        return digest(parts)
