"""What compiling does, in counts and sizes: nothing is done twice, nothing is stored that need not be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import nnls

from lmic import library
from lmic.compiler.assemble import ConicProblem
from lmic.pipeline import compile, finish, prepare, symbolic
from lmic.plants.files import read_plant
from lmic.plants.random import random_plant
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation
from lmic.solve.exchange import implying_lmis
from lmic.solve.solve import solve


def filter_2d(choice: Relaxation) -> ConicProblem:
    plant = read_plant(library.root() / "wu2007" / "example.toml")
    return compile(library.theorem("wu2007.theorem3"), plant, relaxation=choice)


def test_terms_are_made_once_for_a_theorem() -> None:
    theorem = library.theorem("peixoto2025.theorem1")
    assert symbolic(theorem) is symbolic(theorem)
    assert symbolic(replace(theorem)) is not symbolic(theorem)


def test_plants_of_one_shape_share_their_layout_and_others_do_not() -> None:
    theorem = library.theorem("peixoto2025.theorem1")
    first, second = (prepare(theorem, random_plant(theorem, None, 2, seed)) for seed in (0, 1))
    assert first.layout is second.layout
    assert prepare(theorem, random_plant(theorem, None, 3)).layout is not first.layout
    assert prepare(theorem, random_plant(theorem, None, 2), {"H": 2}).layout.size > first.layout.size


def test_long_and_short_families_give_the_same_columns() -> None:
    """The same points, above and below the number from which the columns are written one by one."""
    many = Grid.at([[x, y] for x in np.linspace(-1, 1, 20) for y in np.linspace(0, 1, 15)])
    whole = filter_2d(Relaxation({"r": "grid"}, grid={"r": many}, ties={"b": "a", "c": "a"}))
    assert len(whole.families[0]) == 300
    x = np.random.default_rng(0).standard_normal(whole.size)
    rows = whole.matrix @ x + whole.offset
    for first in (0, 150):
        part = whole.restricted(np.arange(first, first + 150))
        assert len(part.families[0]) == 150
        mine = rows[whole.starts[first] : whole.starts[first + 150]]
        assert np.allclose(part.matrix @ x + part.offset, mine, rtol=1e-12, atol=1e-12)


def test_arrays_hold_nothing_but_the_entries() -> None:
    problem = filter_2d(Relaxation({"r": "grid"}, grid={"r": 3}))
    columns = problem.columns
    assert columns.nnz == np.count_nonzero(columns.data) == len(columns.indices)
    assert columns.indices.dtype == np.int32
    assert np.shares_memory(problem.matrix.data, columns.data)


def test_points_between_the_ends_of_an_affine_axis_are_implied() -> None:
    """c occurs in P(c) alone, affine: of its 5 x 5 points the 4 corners are enough."""
    problem = filter_2d(Relaxation({"r": "grid"}, grid={"r": 5}))
    assert [len(family) for family in problem.families] == [15_625, 25, 25]
    assert [len(family.implying) for family in problem.families] == [2_500, 4, 4]
    family = problem.families[1]
    corners = family.weights[family.implying]
    for weights in family.weights:
        assert nnls(np.vstack([corners.T, np.ones(4)]), np.append(weights, 1))[1] < 1e-12


def test_repeated_points_are_implied_and_a_curved_axis_keeps_its_own() -> None:
    repeated = Grid.at([[0.0, 0.5], [0.0, 0.5], [1.0, 0.0]])
    problem = filter_2d(Relaxation({"r": "grid"}, grid={"r": repeated}, ties={"b": "a", "c": "a"}))
    assert [len(family.implying) for family in problem.families] == [2, 2, 2]
    curved = filter_2d(Relaxation({"r": "grid"}, grid={"r": 3}, ties={"b": "a", "c": "a"}))
    assert len(curved.families[0].implying) == 9


def test_the_optimum_is_that_of_all_lmis() -> None:
    """Leaving implied LMIs out of the solver leaves none out of the measurement, or of the dual."""
    problem = filter_2d(Relaxation({"r": "grid"}, grid={"r": 3}, ties={"b": "a", "c": "a"}))
    assert len(implying_lmis(problem)) < len(problem.orders)
    found = solve(problem)
    assert found.status.usable
    assert len(found.dual) == problem.starts[-1]
    assert -(problem.offset @ found.dual) + problem.constant == pytest.approx(found.value, rel=1e-6)
    least = min(np.linalg.eigvalsh(matrix)[0] for family in problem.families for matrix in family.matrices(found.x))
    assert least > -1e-8


def test_a_scalar_is_set_without_compiling_again() -> None:
    theorem = library.theorem("peixoto2025.theorem1")
    binding = prepare(theorem, random_plant(theorem))
    first, second = finish(binding, {"eps": 1}), finish(binding, {"eps": 2})
    assert first.layout is second.layout
    assert abs(first.columns - second.columns).max() > 0
