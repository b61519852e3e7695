"""Choose and combine relaxations: for each LMI and each axis, from the dependence found there."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from itertools import product
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.bind import Binding
from lmic.errors import RelaxationError
from lmic.parametric import ParametricLMI
from lmic.polynomials import Monomials
from lmic.relax.family import AxisRelaxation, LMIFamily, Soundness
from lmic.relax.polya import polya
from lmic.relax.space import Axis, axes
from lmic.relax.vertices import vertices


def relax(binding: Binding, degrees: Mapping[str, int] | int = 0) -> list[LMIFamily]:
    """Finitely many LMIs for each parametric one.

    Axis by axis: absent → nothing, affine → vertices (exact), polynomial on a simplex →
    coefficients with the Pólya degree of ``degrees`` (per parameter, or one for all).
    """
    space = axes(binding.instances, binding.domains)
    if not isinstance(degrees, int):
        unknown = sorted(set(degrees) - {axis.name for axis in space} - set(binding.instances))
        if unknown:
            raise RelaxationError(
                f"{unknown[0]} is no parameter; Pólya degrees go to {', '.join(a.name for a in space)}"
            )
    return [relax_lmi(lmi, space, degrees) for lmi in binding.lmis.values()]


def relax_lmi(lmi: ParametricLMI, space: list[Axis], degrees: Mapping[str, int] | int) -> LMIFamily:
    """One LMI; independent axes combine to all pairs of their choices."""
    relaxed: list[AxisRelaxation] = []
    remaining = set(lmi.monomials.atoms)
    for axis in space:
        part = lmi.monomials.split(set(axis.symbols))[0]
        if not part.atoms:
            continue
        remaining -= set(part.atoms)
        relaxed.append(_relax_axis(lmi, axis, part, _degree(degrees, axis)))
    if remaining:
        raise RelaxationError(f"the dependence on {min(map(str, remaining))} fits no relaxation", lmi.place)
    weights = reduce(_combine, [r.weights for r in relaxed], np.ones((1, len(lmi.monomials))))
    labels = tuple(product(*(r.labels for r in relaxed)))
    return LMIFamily(
        lmi, weights, labels, tuple(r.method for r in relaxed), Soundness.weakest([r.soundness for r in relaxed])
    )


def _relax_axis(lmi: ParametricLMI, axis: Axis, part: Monomials, degree: int) -> AxisRelaxation:
    strange = [atom for atom in part.atoms if not isinstance(atom, sp.Symbol)]
    if strange:
        raise RelaxationError(
            f"{strange[0]} is not polynomial, so vertices and Pólya do not apply; use a grid", lmi.place
        )
    if int(part.exponents.sum(axis=1).max()) <= 1:
        return vertices(axis, part)
    if axis.domain.kind == "simplex":
        return polya(axis, part, degree)
    raise RelaxationError(f"the dependence on {axis.name} is not affine on a {axis.domain.kind}; use a grid", lmi.place)


def _degree(degrees: Mapping[str, int] | int, axis: Axis) -> int:
    """Pólya degree of an axis, by its own name or that of its parameter."""
    if isinstance(degrees, int):
        return degrees
    return degrees.get(axis.name, degrees.get(axis.name.rstrip("+").split("[")[0], 0))


def _combine(first: NDArray[Any], second: NDArray[Any]) -> NDArray[Any]:
    """Weights of all pairs: the product of the two, monomial by monomial."""
    return (first[:, None, :] * second[None, :, :]).reshape(-1, first.shape[1])
