"""Shared helpers of the tests."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
import sympy as sp

from lmic.bind import Binding
from lmic.domains import Domain
from lmic.evaluate import evaluate
from lmic.language.declarations import Star
from lmic.language.nodes import Leaf, Node
from lmic.language.parameters import instance_symbol
from lmic.language.theorem import LMI
from lmic.plants.plant import Plant

# Example 1 of Peixoto et al. (2025), typed here once more so that the shipped file is checked too
EXAMPLE_1: Mapping[str, Any] = {
    "A": [[[0.43, 0], [1, 0.48]], [[0.1, 0.9], [0, 0.05]]],
    "B_w": [[[2], [0.1]], [[1], [0.1]]],
    "C_y": [[1, 0]],
    "D_y": [[1]],
    "C_z": [[1, 0], [0, 1]],
    "D_z": [[0], [0]],
}


@pytest.fixture
def example_1() -> Plant:
    return Plant.polytopic(name="example 1", **EXAMPLE_1)


def random_point(binding: Binding, generator: np.random.Generator) -> dict[sp.Symbol, np.ndarray]:
    """A random admissible value for every instance of every parameter."""
    values: dict[sp.Symbol, np.ndarray] = {s: np.array([v]) for s, v in binding.values.items()}
    for name, instances in binding.instances.items():
        domain: Domain = binding.domains[name]
        for parameter in instances:
            point = domain.sample(1, generator)[0]
            values |= {
                instance_symbol(c, parameter.instance): np.array([v])
                for c, v in zip(domain.components, point, strict=True)
            }
    return values


def leaf_values(
    binding: Binding, x: np.ndarray, values: Mapping[sp.Symbol, np.ndarray]
) -> Callable[[Leaf], np.ndarray]:
    """The value of a named matrix, read off the plant or the unknown's definition, not the compiler."""

    def value(leaf: Leaf) -> np.ndarray:
        here = dict(values)
        for parameter in leaf.arguments:
            for component in binding.domains[parameter.name].components:
                here[sp.Symbol(component)] = values[instance_symbol(component, parameter.instance)]
        if leaf.role == "data":
            return binding.plant.matrices[leaf.name].evaluate(here)[0]
        unknown = binding.layout.unknowns[leaf.name]
        weights = [float(sp.sympify(f).subs({s: float(v[0]) for s, v in here.items()})) for f in unknown.functions]
        return sum(w * m for w, m in zip(weights, unknown.matrices(x), strict=True))

    return value


def direct(lmi: LMI, binding: Binding, x: np.ndarray, values: Mapping[sp.Symbol, np.ndarray]) -> np.ndarray:
    """The theorem's block matrix evaluated entry by entry, stars filled, turned to F ≻ 0."""
    leaf = leaf_values(binding, x, values)
    scalars = {s.name: float(v[0]) for s, v in values.items()}
    scalars |= {s.name: float(x[binding.layout.unknowns[s.name].offset]) for s in binding.theorem.scalar_unknowns}
    size = len(lmi.rows)
    blocks: list[list[Any]] = [[None] * size for _ in range(size)]
    for i, row in enumerate(lmi.rows):
        for j, entry in enumerate(row):
            if isinstance(entry, Node):
                blocks[i][j] = evaluate(entry, leaf, scalars, binding.sizes)
            elif not isinstance(entry, Star):
                blocks[i][j] = float(sp.sympify(entry).subs(scalars)) * np.ones((1, 1)) if entry != 0 else 0
    for i, row in enumerate(lmi.rows):
        for j, entry in enumerate(row):
            if isinstance(entry, Star):
                mirrored = blocks[j][i]
                blocks[i][j] = mirrored.T if isinstance(mirrored, np.ndarray) else 0
    orders = [blocks[k][k].shape[0] for k in range(size)]
    full = [
        [b if isinstance(b, np.ndarray) else np.zeros((orders[i], orders[j])) for j, b in enumerate(row)]
        for i, row in enumerate(blocks)
    ]
    return lmi.sense * np.block(full)
