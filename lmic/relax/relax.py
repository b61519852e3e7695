"""Choose and combine relaxations: for each LMI and each axis, from the dependence found there."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import reduce
from math import comb, prod
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.algebra.polynomials import Monomials
from lmic.compiler.bind import Binding
from lmic.compiler.parametric import ParametricLMI
from lmic.errors import RelaxationError
from lmic.relax.family import AxisRelaxation, LMIFamily
from lmic.relax.grid import Grid, check_grid, grid
from lmic.relax.polya import polya
from lmic.relax.space import Axis, Space, space
from lmic.relax.vertices import vertices

Array: TypeAlias = NDArray[Any]

#: Pólya degrees above this make more LMIs than any solver takes
MAX_DEGREE = 50

METHODS = ("auto", "vertices", "polya", "grid")


@dataclass(frozen=True)
class Relaxation:
    """How parameters are made finite. Every mapping is keyed by a parameter (``r``), an instance
    (``r[c]``, ``alpha+``) or a component's symbol (``rho1``); the most special key wins.

    ``method``: "auto" (affine → vertices, polynomial on a simplex or a joint polytope → Pólya, otherwise grid),
    "vertices", "polya" or "grid". ``polya``: degrees, 0 where nothing is said. ``grid``: the points where a grid is
    used. ``ties``: instances that are equal, {"b": "a"}.
    """

    method: Mapping[str, str] = field(default_factory=dict)
    polya: Mapping[str, int] | int = 0
    grid: Mapping[str, Grid | int] = field(default_factory=dict)
    ties: Mapping[str, str] = field(default_factory=dict)

    @property
    def joint(self) -> frozenset[str]:
        """The parameters and instances whose grid has points of all components together."""
        return frozenset(name for name, points in self.grid.items() if Grid.of(points).joint)


def relax(binding: Binding, choice: Relaxation | None = None) -> list[LMIFamily]:
    """Finitely many LMIs for each parametric one."""
    choice = choice or Relaxation()
    geometry = space(binding, choice.ties, choice.joint)
    _check_keys(choice, geometry)
    return [relax_lmi(lmi.renamed(geometry.equal), geometry, choice) for lmi in binding.lmis.values()]


def relax_lmi(lmi: ParametricLMI, geometry: Space, choice: Relaxation) -> LMIFamily:
    """One LMI; independent axes combine to all pairs of their choices."""
    parts = [(axis, lmi.monomials.split(set(axis.symbols))[0]) for axis in geometry.axes]
    parts = [(axis, part) for axis, part in parts if part.atoms]
    remaining = set(lmi.monomials.atoms) - {atom for _, part in parts for atom in part.atoms}
    if remaining:
        raise RelaxationError(
            f"{min(map(str, remaining))} mixes symbols that vary independently, and fits no relaxation; "
            "give its parameter a joint grid (random or points)",
            lmi.place,
        )
    methods = [_method(lmi, axis, part, choice) for axis, part in parts]
    _check_memory(lmi, [_count(m, axis, part, choice) for m, (axis, part) in zip(methods, parts, strict=True)])
    relaxed = [_relax_axis(m, axis, part, choice) for m, (axis, part) in zip(methods, parts, strict=True)]
    weights = reduce(_combine, [r.weights for r in relaxed], np.ones((1, len(lmi.monomials))))
    if not np.isfinite(weights).all():
        monomial = int(np.argmin(np.isfinite(weights).all(axis=0)))
        atom = next(a for a, p in zip(lmi.monomials.atoms, lmi.monomials.exponents[monomial], strict=True) if p)
        raise RelaxationError(
            f"{atom} is not finite at a point of the relaxation; change the function, or shrink the domain", lmi.place
        )
    return LMIFamily(lmi, weights, tuple(relaxed), np.arange(len(weights)))


def _method(lmi: ParametricLMI, axis: Axis, part: Monomials, choice: Relaxation) -> str:
    """The relaxation of one axis; raises where the requested one does not apply, and says which do."""
    polynomial = all(isinstance(atom, sp.Symbol) for atom in part.atoms)
    degree = int(part.exponents.sum(axis=1).max())
    affine = polynomial and degree <= 1
    method = _option(choice.method, axis, "auto")
    if method == "auto":
        asked = not isinstance(choice.polya, int) and any(key in choice.polya for key in axis.keys)
        # a box may be gridded side by side; on simplexes and joint polytopes coefficients are natural
        natural = axis.domain.kind != "box" or asked
        method = "vertices" if affine else "polya" if polynomial and natural else "grid"
    gridded = _option(choice.grid, axis, None) is not None
    if {"vertices": affine, "polya": polynomial, "grid": gridded}[method]:
        return str(method)
    kind = "not polynomial" if not polynomial else "affine" if affine else f"of degree {degree}"
    mends = [(f"--relax {axis.parameter}=vertices", affine), (f"--polya {axis.parameter}=0", polynomial)]
    fitting = [mend for mend, fits in mends if fits] + [f"--grid {axis.parameter}=5"]
    missing = ", but no grid is given" if method == "grid" else f", so '{method}' does not apply"
    raise RelaxationError(
        f"the dependence on {axis.name} is {kind}{missing}; what fits: {' or '.join(fitting)}", lmi.place
    )


def _relax_axis(method: str, axis: Axis, part: Monomials, choice: Relaxation) -> AxisRelaxation:
    if method == "vertices":
        return vertices(axis, part)
    if method == "polya":
        return polya(axis, part, _polya_degree(axis, choice))
    return grid(axis, part, chosen_grid(axis, choice))


def _count(method: str, axis: Axis, part: Monomials, choice: Relaxation) -> int:
    """How many choices an axis will have, before any is written down."""
    corners = len(axis.domain.vertices)
    if method == "vertices":
        return corners
    if method == "polya":
        target = int(part.exponents.sum(axis=1).max()) + _polya_degree(axis, choice)
        return comb(corners + target - 1, target)
    points = chosen_grid(axis, choice)
    if points.joint:
        return len(points.points) or points.count
    symbols = len(axis.symbols)
    simplex = axis.domain.kind == "simplex"
    return comb(points.count + symbols - 2, symbols - 1) if simplex else points.count**symbols


def _polya_degree(axis: Axis, choice: Relaxation) -> int:
    return choice.polya if isinstance(choice.polya, int) else int(_option(choice.polya, axis, 0))


def chosen_grid(axis: Axis, choice: Relaxation) -> Grid:
    """The grid that is asked for on an axis."""
    return Grid.of(_option(choice.grid, axis, None))


def _option(options: Mapping[str, Any], axis: Axis, default: Any) -> Any:
    return next((options[key] for key in axis.keys if key in options), default)


def _check_keys(choice: Relaxation, geometry: Space) -> None:
    """Options for parameters that do not exist are mistakes, not wishes."""
    known = {key for axis in geometry.axes for key in axis.keys} | {str(s) for s in geometry.equal}
    for options in (choice.method, choice.grid, choice.polya if isinstance(choice.polya, Mapping) else {}):
        for key in options:
            if key not in known:
                mend = (
                    f"options go to {', '.join(sorted(known))}" if known else "leave the option out, as there is none"
                )
                raise RelaxationError(f"'{key}' is no parameter here; {mend}")
    for method in choice.method.values():
        if method not in METHODS:
            raise RelaxationError(f"'{method}' is no relaxation; use {', '.join(METHODS)}")
    for name, points in choice.grid.items():
        check_grid(name, Grid.of(points))
    degrees = [choice.polya] if isinstance(choice.polya, int) else list(choice.polya.values())
    if any(not 0 <= degree <= MAX_DEGREE for degree in degrees):
        raise RelaxationError(
            f"Pólya degrees go from 0 to {MAX_DEGREE}; beyond that the LMIs are too many to write down"
        )


def _check_memory(lmi: ParametricLMI, counts: list[int]) -> None:
    """Refuse, before allocating it, what does not fit into half the memory: weights and packed values."""
    needed = 8 * prod(counts) * (len(lmi.monomials) + svec.length(lmi.order))
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if needed > memory / 2:
        raise RelaxationError(
            f"{' x '.join(map(str, counts))} points need about {needed / 1e9:.0f} GB of {memory / 1e9:.0f} GB; "
            "take fewer grid points, or vertices where the dependence is affine",
            lmi.place,
        )


def _combine(first: Array, second: Array) -> Array:
    """Weights of all pairs: the product of the two, monomial by monomial."""
    return (first[:, None, :] * second[None, :, :]).reshape(-1, first.shape[1])
