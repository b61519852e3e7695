"""The plant: exact matrices as polynomials in the parameters' components, and the domains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp

from lmic.algebra.polynomials import MatrixPolynomial, Monomials
from lmic.errors import PlantError
from lmic.plants.domains import Domain, Motion, SimplexDomain
from lmic.plants.expressions import quoted, rational


@dataclass(frozen=True)
class Plant:
    """Data of a system.

    ``matrices`` have exact coefficients; their atoms are components of the ``domains``, names of
    ``scalars`` and functions of both. ``motions`` say how far a parameter moves in a step or per
    unit of time, where a theorem asks. ``scalars`` hold the values used unless others are set.
    ``exponentials`` say of matrices that are made of others how: {"Phi": {"exponential": "A", "time": "h"}}.
    """

    matrices: Mapping[str, MatrixPolynomial]
    domains: Mapping[str, Domain] = field(default_factory=dict)
    motions: Mapping[str, Motion] = field(default_factory=dict)
    scalars: Mapping[str, Fraction] = field(default_factory=dict)
    name: str = "plant"
    source: str = ""
    exponentials: Mapping[str, Mapping[str, str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        owners = dict.fromkeys(self.scalars, "the scalars")
        for parameter, domain in self.domains.items():
            for component in domain.components:
                if component in owners:
                    raise PlantError(
                        f"{self.name}: {component} is a component of {parameter} and also of {owners[component]}; "
                        "rename one"
                    )
                owners[component] = parameter

    @property
    def ingredients(self) -> set[str]:
        """Matrices that others are made of: a theorem need not use them itself."""
        return {made[key] for made in self.exponentials.values() for key in ("exponential", "input") if key in made}

    @classmethod
    def polytopic(cls, parameter: str = "alpha", name: str = "plant", **vertices: Sequence[Any]) -> Plant:
        """Matrices by their vertices, ``Plant.polytopic(A=[A1, A2], B=[B1, B2])``.

        A matrix given once (two-dimensional) is the same at every vertex.
        """
        arrays = {key: exact_array(value, f"{name}: {key}") for key, value in vertices.items()}
        counts = {key: array.shape[0] for key, array in arrays.items() if array.ndim == 3}
        if len(set(counts.values())) > 1:
            raise PlantError(f"{name}: the numbers of vertices differ: {counts}; give every matrix the same number")
        domain = SimplexDomain.named(parameter, next(iter(counts.values()), 1))
        matrices = {
            key: vertex_polynomial(array, domain) if array.ndim == 3 else MatrixPolynomial.constant(array)
            for key, array in arrays.items()
        }
        return cls(matrices, {parameter: domain}, name=name)


def vertex_polynomial(vertices: Any, domain: Domain) -> MatrixPolynomial:
    """Σ_i alpha_i · vertices[i] over a simplex; a constant where all vertices agree."""
    if all((vertices[0] == vertex).all() for vertex in vertices[1:]):
        return MatrixPolynomial.constant(vertices[0])
    atoms = [sp.Symbol(component) for component in domain.components]
    return MatrixPolynomial(Monomials.of(*atoms), vertices)


def exact_number(value: Any) -> Fraction:
    """An exact rational: the float 0.1 as written, 1/10, and a text such as "1/3"."""
    value = value.item() if isinstance(value, np.generic) else value
    if isinstance(value, str):
        return rational(value)
    if isinstance(value, (bool, complex)):
        raise PlantError(f"{value!r} is not a real number; give a number such as 0.5 or 1/3")
    try:
        number = Fraction(repr(value)) if isinstance(value, float) else Fraction(value)
        float(number)
    except (TypeError, ValueError, OverflowError) as error:
        raise PlantError(f"{quoted(value)} is not a finite number; give a number such as 0.5 or 1/3") from error
    return number


def exact_array(value: Any, what: str) -> Any:
    """A matrix (2-D) or a stack of matrices (3-D) of fractions."""
    array = np.array(value, dtype=object)
    if array.ndim not in (2, 3) or array.size == 0:
        raise PlantError(f"{what} has {array.ndim} dimensions; give a matrix [[...], ...] or a list of such matrices")
    return np.array([exact_number(entry) for entry in array.flat], dtype=object).reshape(array.shape)
