"""By how much the LMIs hold at a solution: least eigenvalues over the whole domain, between imposed points too.

Relative eigenvalues are those of the LMI scaled to unit diagonal. Sampling finds where an LMI fails; that one holds
everywhere is said by the soundness of its relaxation, and proven by a certificate.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.analysis.walk import Chart, Walk
from lmic.compiler.assemble import ConicProblem
from lmic.compiler.parametric import ParametricLMI
from lmic.language.parameters import instance_symbol
from lmic.relax.family import LMIFamily
from lmic.relax.grid import grid_points
from lmic.relax.relax import chosen_grid
from lmic.relax.space import Axis, space
from lmic.solve.passes import ROUNDING

Array: TypeAlias = NDArray[Any]
Values: TypeAlias = Mapping[sp.Symbol, Array]

#: random points of the whole domain, beside those of the walk
RANDOM = 500
#: random points of what does not walk, beside its vertices and centre
BESIDE = 4
#: combinations of what does not walk at each point of the walk
COMBINATIONS = 64
#: combinations among which these are chosen
MANY = 4096
#: cubes of orders over all points of an LMI: larger matrices are looked at in fewer
WORK = 1e9
#: entries of the matrices that are formed at once
ENTRIES = 2**22


@dataclass(frozen=True)
class Margin:
    """One LMI at a solution.

    ``imposed`` is the least relative eigenvalue over the LMIs that were imposed, ``found`` over all points of the
    domain that were looked at, ``least`` the least eigenvalue itself there, ``where`` the point of ``found``.
    ``along`` is the least relative eigenvalue at each point of a walk, over everything that does not walk, shape (K,);
    ``held`` are the positions on the walk at which the LMI was imposed, where the walk is a line.
    """

    lmi: str
    imposed: float
    found: float
    least: float
    where: str
    along: Array
    held: Array

    @property
    def holds(self) -> bool:
        """Whether the LMI holds, up to rounding, at every point that was looked at."""
        return self.found >= min(self.imposed, 0.0) - 1e-9

    def joined(self, other: Margin) -> Margin:
        """With what was found of the same LMI at other points."""
        lower = min(self, other, key=lambda margin: margin.found)
        return replace(self, found=lower.found, where=lower.where, least=min(self.least, other.least))


def margins(problem: ConicProblem, x: Array, path: Walk) -> list[Margin]:
    """The margins of every LMI at the unknowns ``x``, along a walk through the parameters' domains and at random."""
    axes = space(problem.binding, problem.relaxation.ties).axes
    return [_margin(problem, family, axes, x, path) for family in problem.families]


def over(problem: ConicProblem, x: Array, place: Chart, lmi: str) -> tuple[Margin, tuple[Array, Array]]:
    """The margin of one LMI over a chart, and at which values of its two components that LMI was imposed."""
    axes = space(problem.binding, problem.relaxation.ties).axes
    family = next(family for family in problem.families if family.lmi.place.lmi == lmi)
    margin = _margin(problem, family, axes, x, place.points)
    lines = [replace(place.points, component=name) for name in place.names]
    mine = _occurring(family.lmi, axes)
    u, v = (_held(problem, family, mine, _walking(problem, mine), line) for line in lines)
    return margin, (u, v)


def imposed(problem: ConicProblem, path: Walk) -> Array:
    """Positions on a walk along a line at which some LMI is imposed, so that they may be put on the walk."""
    axes = space(problem.binding, problem.relaxation.ties).axes
    found = []
    for family in problem.families:
        mine = _occurring(family.lmi, axes)
        found.append(_held(problem, family, mine, _walking(problem, mine), path))
    return np.unique(np.concatenate(found))


def eigenvalues(lmi: ParametricLMI, x: Array, values: Values) -> tuple[Array, Array]:
    """Least eigenvalue of F(θ, x) and of F scaled to unit diagonal, each of shape (K,), at K values of the symbols."""
    length = max((len(value) for value in values.values()), default=1)
    weights = np.broadcast_to(lmi.monomials.evaluate(values), (length, len(lmi.monomials)))
    batch = max(1, ENTRIES // lmi.order**2)
    parts = [_eigenvalues(lmi, x, weights[k : k + batch]) for k in range(0, length, batch)]
    least, relative = zip(*parts, strict=True)
    return np.concatenate(least), np.concatenate(relative)


def _eigenvalues(lmi: ParametricLMI, x: Array, weights: Array) -> tuple[Array, Array]:
    matrices = LMIFamily(lmi, weights, (), np.arange(len(weights))).matrices(x)
    diagonal = np.abs(np.einsum("kii->ki", matrices))
    largest = diagonal.max(axis=1, keepdims=True)
    # a matrix that is zero to rounding has no diagonal to be relative to: the size of its data takes its place
    sizes = LMIFamily(_absolute(lmi), np.abs(weights), (), np.arange(len(weights))).packed(np.abs(x))
    size = sizes.max(axis=1, keepdims=True)
    floor = np.where(largest <= ROUNDING * size, size, 1e-14 * largest) + np.finfo(float).tiny
    root = 1 / np.sqrt(np.maximum(diagonal, floor))
    scaled = root[:, :, None] * matrices * root[:, None, :]
    return np.linalg.eigvalsh(matrices)[:, 0], np.linalg.eigvalsh(scaled)[:, 0]


def _absolute(lmi: ParametricLMI) -> ParametricLMI:
    return ParametricLMI(lmi.place, lmi.partition, lmi.monomials, lmi.rows, lmi.columns, abs(lmi.coefficients))


def _margin(problem: ConicProblem, family: LMIFamily, axes: Sequence[Axis], x: Array, path: Walk) -> Margin:
    lmi = family.lmi
    mine = _occurring(lmi, axes)
    walking = _walking(problem, mine)
    least_imposed = _eigenvalues(lmi, x, family.weights)[1].min()
    steps = _walked(problem, mine, walking, path, lmi.order)
    _, relative = eigenvalues(lmi, x, steps)
    along = relative.reshape(-1, len(path)).min(axis=0) if steps else np.full(len(path), relative[0])
    everywhere = _everywhere(mine, steps, int(np.clip(WORK / lmi.order**3, 1, RANDOM)))
    least, relative = eigenvalues(lmi, x, everywhere)
    worst = int(np.argmin(relative))
    where = ", ".join(f"{symbol} = {values[worst]:.4g}" for symbol, values in everywhere.items())
    held = _held(problem, family, mine, walking, path)
    return Margin(lmi.place.lmi, float(least_imposed), float(relative[worst]), float(least.min()), where, along, held)


def _occurring(lmi: ParametricLMI, axes: Sequence[Axis]) -> list[Axis]:
    symbols = {symbol for atom in lmi.monomials.atoms for symbol in atom.free_symbols}
    return [axis for axis in axes if symbols & set(axis.symbols)]


def _walking(problem: ConicProblem, axes: Sequence[Axis]) -> dict[str, str]:
    """For each parameter in the axes the instance that walks: the first of those that occur."""
    order = {name: [parameter.instance for parameter in found] for name, found in problem.binding.instances.items()}
    found: dict[str, str] = {}
    for axis in sorted(axes, key=lambda axis: order[axis.parameter].index(axis.instance)):
        symbols = {instance_symbol(c, axis.instance) for c in problem.binding.domains[axis.parameter].components}
        if symbols & set(axis.symbols):
            found.setdefault(axis.parameter, axis.instance)
    return found


def _walked(
    problem: ConicProblem, axes: Sequence[Axis], walking: Mapping[str, str], path: Walk, order: int
) -> dict[Any, Array]:
    """Values of all symbols: for each combination of what does not walk, all points of the walk."""
    moving: dict[sp.Symbol, Array] = {}
    for name, instance in walking.items():
        components = problem.binding.domains[name].components
        moving |= {instance_symbol(c, instance): path.points[name][:, k] for k, c in enumerate(components)}
    beside: list[tuple[Axis, Array]] = []
    generator = np.random.default_rng(0)
    for axis in axes:
        if set(axis.symbols) <= set(moving):
            continue
        if set(axis.symbols) & set(moving):  # a bounded step: to stay is in its bounds, and what else depends on where
            now = [symbol for symbol in axis.symbols if symbol in moving]
            later = [symbol for symbol in axis.symbols if symbol not in moving]
            moving |= {symbol: moving[now[k]] for k, symbol in enumerate(later)}
            continue
        corners = axis.domain.vertices
        points = np.vstack([corners, corners.mean(axis=0), axis.domain.sample(BESIDE, generator)])
        beside.append((axis, points))
    most = int(np.clip(WORK / (len(path) * order**3), 1, COMBINATIONS))
    choices = _choices([len(points) for _, points in beside], [len(a.domain.vertices) for a, _ in beside], most)
    found = {symbol: np.tile(values, len(choices)) for symbol, values in moving.items()}
    for number, (axis, points) in enumerate(beside):
        for k, symbol in enumerate(axis.symbols):
            found[symbol] = np.repeat(points[choices[:, number], k], len(path))
    return found


def _choices(counts: Sequence[int], vertices: Sequence[int], most: int) -> Array:
    """At most so many combinations, a row of numbers each; those of vertices, numbered first, before others."""
    if not counts:
        return np.zeros((1, 0), dtype=int)
    generator = np.random.default_rng(0)
    total = prod(counts)
    numbers = generator.permutation(total) if total <= MANY else generator.integers(total, size=MANY)
    choices = np.column_stack(np.unravel_index(numbers, counts))
    between = (choices >= np.array(vertices)).sum(axis=1)
    return choices[np.argsort(between, kind="stable")[:most]]


def _everywhere(axes: Sequence[Axis], steps: Values, count: int) -> dict[sp.Symbol, Array]:
    """The points of the walk with all combinations, and random points of every axis."""
    generator = np.random.default_rng(1)
    found: dict[sp.Symbol, Array] = {}
    for axis in axes:
        points = axis.domain.sample(count, generator)
        for k, symbol in enumerate(axis.symbols):
            found[symbol] = np.concatenate([steps[symbol], points[:, k]])
    return found


def _held(
    problem: ConicProblem, family: LMIFamily, axes: Sequence[Axis], walking: Mapping[str, str], path: Walk
) -> Array:
    """Positions on a line at which the LMI was imposed."""
    symbols = {instance_symbol(path.component, instance) for instance in walking.values()}
    for axis, relaxed in zip(axes, family.axes, strict=False):
        if len(axes) == len(family.axes) and path.component and symbols & set(axis.symbols):
            place = next(k for k, symbol in enumerate(axis.symbols) if symbol in symbols)
            if relaxed.method == "vertices":
                return np.unique(axis.domain.vertices[:, place])
            if relaxed.method.startswith("grid"):
                return np.unique(grid_points(axis, chosen_grid(axis, problem.relaxation))[:, place])
    return np.zeros(0)
