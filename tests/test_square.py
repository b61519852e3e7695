"""The square: evaluating the symbolic matrix directly equals what the compiler assembled.

For every theorem of the library, and for domains, bases and relaxations of every kind.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy as sp
from conftest import EXAMPLE_1, direct

from lmic import library
from lmic.algebra.polynomials import homogeneous_exponents
from lmic.compiler.assemble import ConicProblem
from lmic.pipeline import finish, prepare
from lmic.plants.domains import BoxDomain, Motion
from lmic.plants.plant import Plant
from lmic.plants.random import random_plant
from lmic.relax.family import AxisRelaxation
from lmic.relax.grid import Grid, grid_points
from lmic.relax.relax import Relaxation
from lmic.relax.space import Axis, space


@dataclass(frozen=True)
class Draw:
    """A random point of an axis and the weight of each of its LMIs there: Σ_k weight_k F_k = F(point)."""

    point: np.ndarray
    weights: np.ndarray


def draw(axis: Axis, relaxed: AxisRelaxation, choice: Relaxation, generator: np.random.Generator) -> Draw:
    corners, count = axis.domain.vertices, len(relaxed.labels)
    if relaxed.method.startswith("grid"):
        option = next(choice.grid[key] for key in axis.keys if key in choice.grid)
        points = grid_points(axis, option if isinstance(option, Grid) else Grid(option))
        chosen = int(generator.integers(count))
        return Draw(points[chosen], np.eye(count)[chosen])
    barycentric = generator.dirichlet(np.ones(len(corners)))
    if relaxed.method == "vertices":
        return Draw(barycentric @ corners, barycentric)
    degree = next(d for d in range(20) if len(homogeneous_exponents(len(corners), d)) == count)
    return Draw(barycentric @ corners, np.prod(barycentric ** homogeneous_exponents(len(corners), degree), axis=1))


def assert_square(problem: ConicProblem, choice: Relaxation, seed: int = 0) -> None:
    generator = np.random.default_rng(seed)
    binding = problem.binding
    joint = frozenset(name for name, g in choice.grid.items() if isinstance(g, Grid) and g.joint)
    geometry = space(binding, choice.ties, joint)
    x = generator.standard_normal(problem.size)
    for family in problem.families:
        values: dict[sp.Symbol, float] = dict(binding.values)
        weights, relaxed = np.ones(1), list(family.axes)
        occurring = {s for atom in family.lmi.monomials.atoms for s in atom.free_symbols}
        for axis in geometry.axes:
            if occurring & set(axis.symbols):
                drawn = draw(axis, relaxed.pop(0), choice, generator)
                point, weights = drawn.point, np.outer(weights, drawn.weights).ravel()
            else:
                point = axis.domain.sample(1, generator)[0]
            values |= dict(zip(axis.symbols, point.tolist(), strict=True))
        values |= {symbol: values[other] for symbol, other in geometry.equal.items()}
        assert not relaxed
        expected = direct(binding.theorem.lmis[family.lmi.place.lmi], binding, x, values)
        found = np.tensordot(weights, family.matrices(x), axes=1)
        assert np.allclose(found, expected, rtol=1e-10, atol=1e-10 * (1 + np.abs(expected).max()))


def box_plant(theorem: Any, seed: int = 0) -> Plant:
    """A random plant on boxes of two components wherever the theorem allows a box."""
    plant = random_plant(theorem, vertices=3, seed=seed)
    domains, rename = {}, {}
    for name, domain in plant.domains.items():
        if theorem.parameters[name][0].required == "simplex":
            domains[name] = domain
            continue
        rename[sp.Symbol(f"{name}3")] = sp.Symbol(f"{name}1")
        low, high = (Fraction(-1, 2), Fraction(0)), (Fraction(1), Fraction(3, 2))
        domains[name] = BoxDomain((f"{name}1", f"{name}2"), low, high)
    matrices = {key: matrix.renamed(rename).merged() for key, matrix in plant.matrices.items()}
    motions = {n: Motion(rate=dict.fromkeys(d.components, 1)) for n, d in domains.items()}
    return replace(plant, matrices=matrices, domains=domains, motions=motions)


def givens(theorem: Any) -> dict[str, str]:
    return {symbol.name: "7/3" for symbol in theorem.givens}


# Every theorem ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", library.names())
def test_every_theorem_on_a_simplex(name: str) -> None:
    theorem = library.theorem(name)
    problem = finish(prepare(theorem, random_plant(theorem, vertices=3, seed=1)), givens(theorem))
    assert_square(problem, Relaxation())


@pytest.mark.parametrize("name", library.names())
def test_every_theorem_on_a_box(name: str) -> None:
    theorem = library.theorem(name)
    parameters = list(theorem.parameters)
    choice = Relaxation(grid=dict.fromkeys(parameters, 3))
    problem = finish(prepare(theorem, box_plant(theorem)), givens(theorem), choice)
    assert_square(problem, choice)


@pytest.mark.parametrize("polya", [0, 1, 2])
@pytest.mark.parametrize("vertices", [2, 3, 4])
@pytest.mark.parametrize("name", ["peixoto2025.theorem1", "peixoto2025.corollary1"])
def test_vertices_and_polya_degrees(name: str, vertices: int, polya: int) -> None:
    theorem = library.theorem(name)
    plant = random_plant(theorem, {"nx": 3, "nw": 2, "ny": 2, "nz": 1}, vertices, seed=vertices)
    choice = Relaxation(polya=polya)
    assert_square(finish(prepare(theorem, plant), {"eps": "7/3"}, choice), choice)


# Every domain, basis and relaxation ----------------------------------------------------------------

RELAXATIONS = {
    "vertices or Pólya": Relaxation(polya={"rho": 1}),
    "grid": Relaxation(method={"rho": "grid"}, grid={"rho": 3}),
    "Chebyshev": Relaxation(grid={"rho": Grid(4, "chebyshev")}),
    "random": Relaxation(method={"rho": "grid"}, grid={"rho": Grid(5, "random", seed=2)}),
    "points": Relaxation(method={"rho": "grid"}, grid={"rho": Grid.at([[0.1, 0.2], [0.5, 0.9]])}),
    "grid now, vertices next": Relaxation(grid={"rho": 3}, method={"rho1": "grid", "rho2": "grid"}),
}
BASES: dict[str, Any] = {
    "constant": "constant",
    "affine": 1,
    "quadratic": 2,
    "functions": ["1", "rho1", "rho1*rho2", "rho2**2"],
}
STEPS: dict[str, Any] = {
    "free": "free",
    "constant": "constant",
    "bounded": {"rho1": Fraction(1, 4), "rho2": [Fraction(-1, 10), Fraction(1, 2)]},
}


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("relaxation", RELAXATIONS)
def test_discrete_time_on_a_box(relaxation: str, basis: str, step: str) -> None:
    theorem = library.theorem("standard.bounded_real_discrete")
    choice = RELAXATIONS[relaxation]
    if step == "bounded" and any(isinstance(g, Grid) and g.joint for g in choice.grid.values()):
        pytest.skip("a joint grid is of one instance, a bounded step joins two")
    plant = replace(box_plant(theorem), motions={"rho": Motion(step=STEPS[step])})
    problem = finish(prepare(theorem, plant, {"P": BASES[basis]}), {}, choice)
    assert_square(problem, choice)


@pytest.mark.parametrize("step", [None, {"rho1": 0.2, "rho2": 0.3, "rho3": [-0.1, 0.4]}])
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_discrete_time_on_a_simplex(degree: int, step: Any) -> None:
    theorem = library.theorem("standard.bounded_real_discrete")
    plant = replace(random_plant(theorem, vertices=3), motions={"rho": Motion(step=step or "free")})
    choice = Relaxation(polya=1)
    assert_square(finish(prepare(theorem, plant, {"P": degree}), {}, choice), choice)


@pytest.mark.parametrize("basis", [1, 2, ["1", "rho1", "sin(rho2)"]])
def test_continuous_time_with_rates(basis: Any) -> None:
    theorem = library.theorem("standard.bounded_real_continuous")
    choice = Relaxation(grid={"rho": 3})
    assert_square(finish(prepare(theorem, box_plant(theorem), {"P": basis}), {}, choice), choice)


@pytest.mark.parametrize("ties", [{}, {"b": "a"}, {"b": "a", "c": "a"}])
def test_copies_and_ties(ties: dict[str, str]) -> None:
    theorem = library.theorem("wu2007.theorem3")
    choice = Relaxation(grid={"r": 2}, ties=ties)
    assert_square(finish(prepare(theorem, box_plant(theorem)), {}, choice), choice)


@pytest.mark.parametrize("degree", [0, 2])
def test_other_degrees_of_the_unknowns(degree: int) -> None:
    theorem = library.theorem("peixoto2025.theorem1")
    choice = Relaxation(polya=1)
    binding = prepare(theorem, random_plant(theorem, None, 3), {"P1": 2, "H": degree, "X3": 3})
    assert_square(finish(binding, {"eps": 2}, choice), choice)


# The conic rows, and Lemma 1 -------------------------------------------------------------------------


def test_rows_of_the_conic_problem_are_the_families(example_1: Plant) -> None:
    problem = finish(prepare(library.theorem("peixoto2025.theorem1"), example_1), {"eps": 150})
    x = np.random.default_rng(5).standard_normal(problem.size)
    packed = problem.matrix @ x + problem.offset
    matrices = [matrix for family in problem.families for matrix in family.matrices(x)]
    for index, matrix in enumerate(matrices):
        rows = slice(problem.starts[index], problem.starts[index + 1])
        # svec keeps the inner product, so the norm too
        assert np.isclose(np.linalg.norm(packed[rows]), np.linalg.norm(matrix))


def test_polya_degree_zero_is_lemma_1(example_1: Plant) -> None:
    """Peixoto et al. (2025), Lemma 1: Γ_iil and Γ_ijl + Γ_jil, with Γ_ijl from the paper's Φ_ijl."""
    problem = finish(prepare(library.theorem("peixoto2025.theorem1"), example_1), {"eps": 150})
    x = np.random.default_rng(1).standard_normal(problem.size)
    family = problem.families[0]
    phi = -phi_vertices(problem.layout, x, eps=150.0)
    expected = {"alpha1^2": phi[0, 0], "alpha1 alpha2": phi[0, 1] + phi[1, 0], "alpha2^2": phi[1, 1]}
    assert len(family) == 6
    for k, matrix in enumerate(family.matrices(x)):
        now, following = family.label(k)
        vertex = int(following.split()[-1]) - 1
        assert np.allclose(matrix, expected[now.split(": ")[1]][vertex], rtol=1e-12, atol=1e-9)


def phi_vertices(layout: Any, x: np.ndarray, eps: float) -> np.ndarray:
    """Φ_ijl of the paper (data i, unknowns j, next vertex l), dense; P3 in Φ21 at l as in its (8)."""
    data = {k: [np.array(v, dtype=float) for v in (m if np.ndim(m) == 3 else [m] * 2)] for k, m in EXAMPLE_1.items()}
    u = {name: [np.array(m) for m in unknown.matrices(x)] for name, unknown in layout.unknowns.items()}
    delta, z = float(u["delta"][0][0, 0]), np.zeros
    result = np.empty((2, 2, 2, 11, 11))
    for i, j, k in np.ndindex(2, 2, 2):
        A, Bw, Cz, Dz, Cy, Dy = (data[key][i] for key in ("A", "B_w", "C_z", "D_z", "C_y", "D_y"))
        X1, X2, X3, X4, X5, X6 = (u[f"X{number}"][j] for number in range(1, 7))
        H, Af, Bf, Cf, Df = (u[key][j] for key in ("H", "A_f", "B_f", "C_f", "D_f"))
        P1, P2, P3 = (u[key] for key in ("P1", "P2", "P3"))
        lower = [
            [P1[k] - X1 - X1.T, z((2, 2)), z((2, 2)), z((2, 2)), z((2, 2)), z((2, 1))],
            [-X2 - eps * H.T + P3[k].T, P2[k] - H - H.T, z((2, 2)), z((2, 2)), z((2, 2)), z((2, 1))],
            [-X3 + (X1 @ A + eps * Bf @ Cy).T, -H + (X2 @ A + Bf @ Cy).T,
             -P1[j] + X3 @ A + Bf @ Cy + (X3 @ A + Bf @ Cy).T, z((2, 2)), z((2, 2)), z((2, 1))],
            [-X4 + eps * Af.T, Af.T, X4 @ A + Af.T - P3[j].T, -P2[j], z((2, 2)), z((2, 1))],
            [-X5, z((2, 2)), X5 @ A + Cz - Df @ Cy, -Cf, -np.eye(2), z((2, 1))],
            [-X6 + (X1 @ Bw + eps * Bf @ Dy).T, (X2 @ Bw + Bf @ Dy).T, X6 @ A + (X3 @ Bw + Bf @ Dy).T,
             Bw.T @ X4.T, (X5 @ Bw - Df @ Dy + Dz).T, X6 @ Bw + (X6 @ Bw).T - delta * np.eye(1)],
        ]  # fmt: skip
        full = np.block(lower)
        result[i, j, k] = np.tril(full) + np.tril(full, -1).T
    return result
