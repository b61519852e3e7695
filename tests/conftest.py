"""Shared helpers of the tests."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
import sympy as sp

from lmic import library
from lmic.algebra.polynomials import MatrixPolynomial
from lmic.certify.certificate import Certificate
from lmic.certify.certify import certify
from lmic.compiler.bind import Binding
from lmic.language.lmi import LMI
from lmic.language.nodes import Leaf, Node
from lmic.language.parameters import instance_symbol, rate_symbol
from lmic.language.star import Star
from lmic.pipeline import compile, run
from lmic.plants.files import read_plant
from lmic.plants.plant import Plant, exact_array
from lmic.recover.evaluate import evaluate

# Example 1 of Peixoto et al. (2025), typed here once more so that the shipped file is checked too
EXAMPLE_1: Mapping[str, Any] = {
    "A": [[[0.43, 0], [1, 0.48]], [[0.1, 0.9], [0, 0.05]]],
    "B_w": [[[2], [0.1]], [[1], [0.1]]],
    "C_y": [[1, 0]],
    "D_y": [[1]],
    "C_z": [[1, 0], [0, 1]],
    "D_z": [[0], [0]],
}

Values = Mapping[sp.Symbol, float]


@pytest.fixture
def example_1() -> Plant:
    return Plant.polytopic(name="example 1", **EXAMPLE_1)


@pytest.fixture(scope="session")
def first_order() -> Certificate:
    """x⁺ = x/2 + w, z = x: the gain is 1/(1 − 1/2) = 2."""
    matrices = {"A": [[0.5]], "B": [[1]], "C": [[1]], "D": [[0]]}
    plant = Plant({k: MatrixPolynomial.constant(exact_array(m, k)) for k, m in matrices.items()}, name="first order")
    return certify(run(compile(library.theorem("standard.bounded_real_discrete"), plant)))


@pytest.fixture(scope="session")
def table_1() -> Certificate:
    """Table 1 of Peixoto et al. (2025), parameter-dependent."""
    plant = read_plant(library.root() / "peixoto2025" / "example1.toml")
    result = run(compile(library.theorem("peixoto2025.theorem1"), plant, {"eps": 150}))
    return certify(result, given={"eps": 150})


def leaf_values(binding: Binding, x: np.ndarray, values: Values) -> Callable[[Leaf], np.ndarray]:
    """The value of a named matrix, read off the plant or the unknown's definition, not the compiler."""

    def value(leaf: Leaf) -> np.ndarray:
        here = dict(values)
        arguments = [p for p in leaf.arguments if p.name in binding.domains]
        components = [(c, p.instance) for p in arguments for c in binding.domains[p.name].components]
        here |= {sp.Symbol(c): values[instance_symbol(c, instance)] for c, instance in components}
        if leaf.role == "data":
            return binding.plant.matrices[leaf.name].evaluate({s: np.array([v]) for s, v in here.items()})[0]
        unknown = binding.layout.unknowns[leaf.name]
        functions = [sp.sympify(f) for f in unknown.functions]
        if leaf.derivative:
            functions = [sum(sp.diff(f, sp.Symbol(c)) * rate_symbol(c) for c, _ in components) for f in functions]
        weights = [float(sp.sympify(f).subs(here)) for f in functions]
        return sum(w * m for w, m in zip(weights, unknown.matrices(x), strict=True))

    return value


def direct(lmi: LMI, binding: Binding, x: np.ndarray, values: Values) -> np.ndarray:
    """The theorem's block matrix evaluated entry by entry, stars filled, turned to F ≻ 0."""
    leaf = leaf_values(binding, x, values)
    scalars = {s.name: float(v) for s, v in values.items()}
    scalars |= {s.name: float(x[binding.layout.unknowns[s.name].offset]) for s in binding.theorem.scalar_unknowns}
    size = len(lmi.rows)
    blocks: list[list[Any]] = [[None] * size for _ in range(size)]
    for i, row in enumerate(lmi.rows):
        for j, entry in enumerate(row):
            if isinstance(entry, Node):
                blocks[i][j] = evaluate(entry, leaf, scalars, binding.sizes)
            elif not isinstance(entry, Star) and entry != 0:
                blocks[i][j] = np.array([[float(sp.sympify(entry).subs(scalars))]])
    for i, row in enumerate(lmi.rows):
        for j, entry in enumerate(row):
            if isinstance(entry, Star) and blocks[j][i] is not None:
                blocks[i][j] = blocks[j][i].T
    orders = [blocks[k][k].shape[0] for k in range(size)]
    full = [
        [np.zeros((orders[i], orders[j])) if block is None else block for j, block in enumerate(row)]
        for i, row in enumerate(blocks)
    ]
    return lmi.sense * np.block(full)
