"""The statement read exactly for proofs: it is the theorem's matrix, and its finite problem the compiled one."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from conftest import direct

from lmic import library
from lmic.algebra import svec
from lmic.certify.finite import Coefficient, finite_problem
from lmic.certify.region import region
from lmic.certify.relaxed import functionals
from lmic.certify.statement import Statement, fractions
from lmic.language.parameters import instance_symbol
from lmic.pipeline import compile
from lmic.plants.files import read_plant
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation

ROOT = library.root()
EXAMPLE_1 = ROOT / "peixoto2025" / "example1.toml"
SECTION_5 = ROOT / "wu2007" / "example.toml"


@pytest.mark.parametrize(
    ("name", "plant", "given"),
    [
        ("peixoto2025.theorem1", EXAMPLE_1, {"eps": 150}),
        ("wu2007.theorem3", SECTION_5, {}),
        ("wu2007.theorem6", SECTION_5, {}),
        ("delay_lpv.theorem3", ROOT / "delay_lpv" / "stand_in.toml", None),
    ],
)
def test_exact_matrices_equal_the_theorem_evaluated_directly(name: str, plant: Path, given: Any) -> None:
    theorem, data = library.theorem(name), read_plant(plant)
    given = {symbol.name: 2 for symbol in theorem.givens} if given is None else given
    grid = Relaxation(grid={p: 2 for p, d in data.domains.items() if d.kind == "box"})
    problem = compile(theorem, data, given, relaxation=grid)
    generator = np.random.default_rng(3)
    x = generator.standard_normal(problem.size)
    statement = Statement(theorem, data, {**data.scalars, **{k: Fraction(v) for k, v in given.items()}}, {})
    unknowns = {
        key: statement.value(key, dict(zip(u.functions, map(fractions, u.matrices(x)), strict=True)))
        for key, u in problem.layout.unknowns.items()
    }
    symbols = {
        instance_symbol(component, p.instance)
        for parameter, found in problem.binding.instances.items()
        for p in found
        for component in data.domains[parameter].components
    }
    values: dict[sp.Symbol, float] = {s: float(generator.random()) for s in sorted(symbols, key=str)}
    values |= {sp.Symbol(key): float(value) for key, value in {**data.scalars, **given}.items()}
    for lmi in theorem.lmis:
        exact = statement.matrix(lmi, unknowns).evaluate({s: np.array([v]) for s, v in values.items()})[0]
        expected = direct(theorem.lmis[lmi], problem.binding, x, values)
        assert np.abs(exact - expected).max() <= 1e-12 * max(1.0, np.abs(expected).max())


@pytest.mark.parametrize(
    ("name", "plant", "given", "relaxation"),
    [
        ("peixoto2025.theorem1", EXAMPLE_1, {"eps": 150}, Relaxation(polya={"alpha": 1})),
        ("wu2007.theorem3", SECTION_5, {}, Relaxation(grid={"r": Grid.at([[1, 0]])}, ties={"b": "a", "c": "a"})),
    ],
)
def test_the_exact_finite_problem_is_the_compiled_one(
    name: str, plant: Path, given: dict[str, Any], relaxation: Relaxation
) -> None:
    problem = compile(library.theorem(name), read_plant(plant), given, relaxation=relaxation)
    statement = Statement(
        problem.binding.theorem, problem.binding.plant, {k: Fraction(v) for k, v in given.items()}, {}
    )
    domain = region(statement, relaxation.ties)
    chosen = functionals(problem, relaxation, domain)
    basis = {key: unknown.functions for key, unknown in problem.layout.unknowns.items()}
    exact = finite_problem(statement, basis, domain.equal, chosen)
    compiled = problem.columns.toarray()
    for k, lmi in enumerate(exact.lmis):
        dense = np.zeros((svec.length(lmi.order), problem.size + 1))
        dense[svec.packed_index(lmi.rows, lmi.cols), lmi.columns] = lmi.values.astype(float)
        rows = slice(problem.starts[k], problem.starts[k + 1])
        assert np.abs(dense * svec.weights(lmi.order)[:, None] - compiled[rows]).max() < 1e-12
    assert (exact.cost.astype(float) == problem.cost).all()


def test_coefficients_sum_to_the_polynomial() -> None:
    """Σ_k coefficient_k λ^k at any λ on the simplex is the monomial's value at Σ_v λ_v V_v."""
    corners = ((Fraction(1), Fraction(2)), (Fraction(-1), Fraction(1, 3)), (Fraction(1, 2), Fraction(0)))
    symbols = (sp.Symbol("a"), sp.Symbol("b"))
    weights = (Fraction(1, 2), Fraction(1, 3), Fraction(1, 6))
    place = [sum(w * c[i] for w, c in zip(weights, corners, strict=True)) for i in range(2)]
    for exponents in [(0, 0), (1, 0), (2, 1), (0, 3)]:
        total = Fraction(0)
        for powers in product(range(5), repeat=3):
            if sum(powers) == 4:
                monomial = np.prod([w**p for w, p in zip(weights, powers, strict=True)])
                total += Coefficient(symbols, corners, powers).weight(exponents) * monomial
        assert total == place[0] ** exponents[0] * place[1] ** exponents[1]
