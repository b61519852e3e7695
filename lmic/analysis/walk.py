"""A walk through the parameters' domain: a line along which a function of the parameters can be drawn, or a map.

One parameter with one free component is walked from end to end. Any other domain is walked from vertex to vertex, each
to the nearest that is left, back to the first and on to the centre.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.plants.domains import BoxDomain, Domain, vertex_points

Array: TypeAlias = NDArray[Any]

#: points on a walk
POINTS = 121
#: vertices that a walk visits at most
VERTICES = 8
#: points of a map in each direction
SIDE = 25


@dataclass(frozen=True)
class Walk:
    """K points: the values of each parameter, shape (K, components), at increasing ``position``, shape (K,).

    ``component`` is the one component that varies freely, whose value is the position; empty where there are
    several. Then the position counts the legs, and ``stops`` are the labels of positions 0, 1, 2, …
    """

    points: Mapping[str, Array]
    position: Array
    component: str
    stops: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.position)

    def at(self, chosen: Array) -> Walk:
        """The walk at some of its points only."""
        points = {name: values[chosen] for name, values in self.points.items()}
        return Walk(points, self.position[chosen], self.component, self.stops)

    def through(self, positions: Array) -> Walk:
        """With further positions on it."""
        merged = np.union1d(self.position, positions)
        order = np.argsort(self.position)
        points = {
            name: np.column_stack([np.interp(merged, self.position[order], column) for column in values[order].T])
            for name, values in self.points.items()
        }
        return Walk(points, merged, self.component, self.stops)

    def thinned(self, count: int) -> Walk:
        """At most about ``count`` points, the stops among them."""
        step = max(1, round((len(self) - 1) / max(1, count - 1)))
        legs = max(1, len(self.stops) - 1)
        while step > 1 and (len(self) - 1) // legs % step:
            step -= 1
        return self.at(np.arange(0, len(self), step))


@dataclass(frozen=True)
class Chart:
    """The points of a domain with two free components, ``names``, on a grid of their values ``u`` and ``v``.

    ``inside`` tells which of the grid's places, shape (v, u), lie in the domain; ``points`` are those, in their order.
    """

    names: tuple[str, str]
    u: Array
    v: Array
    inside: Array
    points: Walk


def chart(domains: Mapping[str, Domain], count: int = SIDE) -> Chart | None:
    """A chart of all domains together; None where not just two components vary freely."""
    free = [component for domain in domains.values() for component in _free(domain)]
    if len(free) != 2:
        return None
    ends = {c: (v.min(), v.max()) for d in domains.values() for c, v in zip(d.components, d.vertices.T, strict=True)}
    u, v = (np.linspace(*ends[component], count) for component in free)
    grid = dict(zip(free, (places.ravel() for places in np.meshgrid(u, v)), strict=True))
    inside, points = np.ones(count**2, dtype=bool), {}
    for name, domain in domains.items():
        columns = [grid.get(c, np.full(count**2, ends[c][0])) for c in domain.components]
        if domain.kind == "simplex":
            columns[0] = 1 - sum(columns[1:], np.zeros(count**2))
        points[name] = np.column_stack(columns)
        inside &= domain.contains(points[name])
    kept = Walk({name: values[inside] for name, values in points.items()}, np.arange(inside.sum()), "", ())
    return Chart((free[0], free[1]), u, v, inside.reshape(count, count), kept)


def _free(domain: Domain) -> tuple[str, ...]:
    """Components that vary freely: on a simplex all but the first follow from no other."""
    if domain.kind == "simplex":
        return domain.components[1:]
    return tuple(c for c, values in zip(domain.components, domain.vertices.T, strict=True) if np.ptp(values) > 0)


def walk(domains: Mapping[str, Domain], count: int = POINTS) -> Walk:
    """The walk through all domains together; one point where nothing varies."""
    if not domains:
        return Walk({}, np.zeros(1), "", ())
    vertices = vertex_points(domains)
    total = len(next(iter(vertices.values())))
    if total == 1:
        return Walk(vertices, np.zeros(1), "", ())
    if total == 2:
        return _line(domains, vertices, count)
    order = _tour(np.hstack(list(vertices.values())))[:VERTICES]
    stops = {name: np.vstack([v[order], v[order[:1]], v.mean(axis=0)]) for name, v in vertices.items()}
    legs = len(order) + 1
    each = -(-(count - 1) // legs)
    position = np.arange(legs * each + 1) / each
    points = {
        name: np.column_stack([np.interp(position, np.arange(legs + 1), column) for column in values.T])
        for name, values in stops.items()
    }
    labels = tuple(_label({name: values[k] for name, values in stops.items()}) for k in range(legs))
    return Walk(points, position, "", (*labels, "centre"))


def _line(domains: Mapping[str, Domain], vertices: Mapping[str, Array], count: int) -> Walk:
    """From one of the two vertices to the other; a simplex is told by its last component."""
    share = np.linspace(0.0, 1.0, count)[:, None]
    points = {name: values[0] + share * (values[1] - values[0]) for name, values in vertices.items()}
    name = next(name for name, values in vertices.items() if (values[0] != values[1]).any())
    moving = np.flatnonzero(vertices[name][0] != vertices[name][1])
    place = int(moving[0] if isinstance(domains[name], BoxDomain) else moving[-1])
    return Walk(points, points[name][:, place], domains[name].components[place], ())


def _tour(vertices: Array) -> list[int]:
    """The vertices' numbers from the first on, each followed by the nearest that is left."""
    scale = np.ptp(vertices, axis=0)
    points = vertices / np.where(scale > 0, scale, 1.0)
    found, left = [0], list(range(1, len(points)))
    while left:
        distances = np.linalg.norm(points[left] - points[found[-1]], axis=1)
        found.append(left.pop(int(np.argmin(distances))))
    return found


def _label(values: Mapping[str, Array]) -> str:
    parts = [f"({', '.join(f'{value:.4g}' for value in point)})" for point in values.values()]
    return " ".join(parts)
