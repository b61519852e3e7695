"""Grid: the LMI at chosen points; nothing is said between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.algebra.polynomials import Monomials, homogeneous_exponents
from lmic.errors import LmicError, RelaxationError
from lmic.plants.expressions import quoted, whole_number
from lmic.plants.plant import exact_number
from lmic.relax.family import AxisRelaxation, Soundness
from lmic.relax.space import Axis

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class Grid:
    """How to choose points.

    ``kind``: "uniform" (``count`` per component, ends included), "chebyshev" (``count`` per
    component of a box), "random" (``count`` in all, with ``seed``) or "points" (``points`` given as rows).
    """

    count: int = 0
    kind: str = "uniform"
    seed: int = 0
    points: tuple[tuple[float, ...], ...] = ()

    @property
    def joint(self) -> bool:
        """Whether the points are those of a whole parameter, not of each component by itself."""
        return self.kind in ("random", "points")

    @classmethod
    def at(cls, points: Sequence[Sequence[float]]) -> Grid:
        """A grid of given points, one row each."""
        return cls(kind="points", points=tuple(tuple(map(float, np.atleast_1d(p))) for p in points))

    @classmethod
    def of(cls, choice: Grid | int | str) -> Grid:
        """A grid as it may be asked for: itself, a count, or a text.

        Texts are ``5``, ``chebyshev:9``, ``random:100``, or points, ``(1, 0); (1/3, 0.5)``. Raises RelaxationError for
        any other.
        """
        if isinstance(choice, Grid):
            return choice
        if isinstance(choice, int):
            return cls(choice)
        if "(" in choice or ")" in choice:
            return cls.at([_point(part.strip()) for part in choice.split(";")])
        kind, _, written = choice.rpartition(":")
        count = whole_number(written)
        if count is None:
            raise RelaxationError(
                f"{quoted(choice)} is no grid; write 5, chebyshev:9, random:100, or points as '(1, 0); (0, 1)'"
            )
        return cls(count, kind.strip() or "uniform")


def _point(text: str) -> list[float]:
    """``(1/3, 0)`` as its coordinates."""
    if not (text.startswith("(") and text.endswith(")")):
        raise RelaxationError(f"{quoted(text)} is no point; write points as '(1, 0); (0, 1)'")
    found = []
    for coordinate in text[1:-1].split(","):
        try:
            found.append(float(exact_number(coordinate.strip())))
        except (LmicError, OverflowError) as error:
            raise RelaxationError(
                f"{quoted(coordinate.strip())} in {text} is no finite number; write one such as 0.5 or 1/3"
            ) from error
    return found


def grid(axis: Axis, part: Monomials, choice: Grid) -> AxisRelaxation:
    """Evaluate at the points."""
    points = grid_points(axis, choice)
    weights = part.evaluate({symbol: points[:, k] for k, symbol in enumerate(axis.symbols)})
    if len(weights) != len(points):
        weights = np.broadcast_to(weights, (len(points), weights.shape[1]))
    labels = tuple(f"{axis.name} = {', '.join(f'{value:.4g}' for value in point)}" for point in points.tolist())
    method = f"grid of {len(points)} points"
    return AxisRelaxation(method, weights, labels, Soundness.SAMPLED, _implying(part, points), _ends(points))


def _implying(part: Monomials, points: Array) -> Array | None:
    """Points whose convex combinations are all the others, where the matrix is affine in one component."""
    affine = all(isinstance(atom, sp.Symbol) for atom in part.atoms) and part.exponents.sum(axis=1).max() <= 1
    if affine and points.shape[1] == 1:
        return _ends(points)
    first = np.unique(points, axis=0, return_index=True)[1]
    return np.sort(first) if len(first) < len(points) else None


def _ends(points: Array) -> Array:
    """The points farthest out in every direction of the box around them."""
    signs = np.array(list(product((-1.0, 1.0), repeat=points.shape[1])))
    return np.unique(np.argmax(points @ signs.T, axis=0))


def check_grid(name: str, choice: Grid) -> None:
    """Raise RelaxationError for a grid that makes no sense on any domain."""
    if choice.kind not in ("uniform", "chebyshev", "random", "points"):
        raise RelaxationError(
            f"'{choice.kind}' is no kind of grid for {name}; use uniform, chebyshev, random or points"
        )
    lengths = {len(point) for point in choice.points}
    if choice.kind == "points" and (len(lengths) != 1 or not np.isfinite(np.array(choice.points)).all()):
        raise RelaxationError(f"the grid points for {name} are not rows of finite numbers of one length; correct them")
    if choice.kind != "points" and choice.count < 1:
        raise RelaxationError(f"the grid for {name} has no point; give a count of at least 1")


def grid_points(axis: Axis, choice: Grid) -> Array:
    """The points on an axis, shape (K, symbols)."""
    domain = axis.domain
    if choice.kind == "points":
        return _checked(axis, np.array(choice.points, dtype=float))
    if choice.kind == "random":
        return domain.sample(choice.count, np.random.default_rng(choice.seed))
    if domain.kind == "simplex":
        if choice.kind == "chebyshev":
            raise RelaxationError(f"{axis.name} ranges over a simplex, which has no Chebyshev points; use uniform ones")
        parts = max(choice.count - 1, 1)
        return homogeneous_exponents(len(domain.components), parts) / parts
    low, high = domain.vertices.min(axis=0), domain.vertices.max(axis=0)
    sides = [_side(a, b, choice) for a, b in zip(low, high, strict=True)]
    points = np.array(list(product(*sides)))
    if domain.kind == "box":
        return points
    return np.unique(np.concatenate([points[domain.contains(points)], domain.vertices]), axis=0)


def _side(low: float, high: float, choice: Grid) -> Array:
    if low == high or choice.count == 1:
        return np.array([(low + high) / 2])
    if choice.kind == "chebyshev":
        angles = (2 * np.arange(choice.count) + 1) * np.pi / (2 * choice.count)
        return (low + high) / 2 - (high - low) / 2 * np.cos(angles)
    return np.linspace(low, high, choice.count)


def _checked(axis: Axis, points: Array) -> Array:
    """The points; raises where they are not those of the axis, or lie outside its domain."""
    if points.ndim != 2 or points.shape[1] != len(axis.symbols):
        names = ", ".join(map(str, axis.symbols))
        raise RelaxationError(
            f"the grid points of {axis.name} need {len(axis.symbols)} coordinates each; give ({names})"
        )
    outside = points[~axis.domain.contains(points)]
    if len(outside):
        point = ", ".join(f"{value:.12g}" for value in outside[0])
        raise RelaxationError(
            f"the grid point ({point}) of {axis.name} lies outside its domain, {axis.domain}; give points of the domain"
        )
    return points
