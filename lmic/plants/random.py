"""Random plants that fit a theorem: for sizes before any data are at hand, and for tests."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

import numpy as np
import sympy as sp

from lmic.algebra.polynomials import MatrixPolynomial, Monomials
from lmic.language.theorem import Theorem
from lmic.plants.domains import BoxDomain, Domain, Motion, SimplexDomain
from lmic.plants.plant import Plant


def random_plant(
    theorem: Theorem,
    sizes: Mapping[str, int] | None = None,
    vertices: int = 2,
    seed: int = 0,
) -> Plant:
    """A plant with random rational data, affine in every parameter.

    ``sizes`` gives dimensions by name (2 for nx and n, 1 for the others where nothing is said);
    a simplex gets ``vertices`` vertices, any other domain is the box [-1, 1]^(vertices - 1); rates
    are bounded by 1.
    """
    generator = np.random.default_rng(seed)
    domains: dict[str, Domain] = {}
    for name, instances in theorem.parameters.items():
        if instances[0].required in ("", "simplex"):
            domains[name] = SimplexDomain.named(name, vertices)
        else:
            components = tuple(f"{name}{i + 1}" for i in range(max(vertices - 1, 1)))
            ends = (Fraction(1),) * len(components)
            domains[name] = BoxDomain(components, tuple(-end for end in ends), ends)
    chosen = dict(sizes or {})
    matrices = {}
    for name, leaf in theorem.data.items():
        shape = [
            int(size.subs({s: chosen.get(s.name, _default(s.name)) for s in size.free_symbols})) for size in leaf.shape
        ]
        depends = _arguments(theorem, name)
        atoms = [sp.Symbol(c) for parameter in depends for c in domains[parameter].components]
        monomials = Monomials.of(*atoms) if atoms else Monomials.one()
        values = generator.integers(-9, 10, size=(len(monomials), *shape))
        if leaf.symmetric:
            values = values + values.transpose(0, 2, 1)
        # small entries keep most plants stable
        coefficients = np.vectorize(lambda v: Fraction(int(v), 30), otypes=[object])(values)
        matrices[name] = MatrixPolynomial(monomials, coefficients)
    motions = {name: Motion(rate=dict.fromkeys(domain.components, 1)) for name, domain in domains.items()}
    return Plant(matrices, domains, motions, name=f"random plant (seed {seed})")


def _default(dimension: str) -> int:
    return 2 if dimension in ("nx", "n") else 1


def _arguments(theorem: Theorem, matrix: str) -> list[str]:
    nodes = theorem.nodes + theorem.extras
    leaves = [leaf for node in nodes for leaf in node.leaves() if leaf.name == matrix]
    return sorted({parameter.name for leaf in leaves for parameter in leaf.arguments})
