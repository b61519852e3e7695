"""The square: evaluating the symbolic matrix directly equals what the compiler assembled."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from conftest import direct, random_point

from lmic import library
from lmic.pipeline import finish, prepare
from lmic.plants.random import random_plant
from lmic.relax.family import LMIFamily
from lmic.relax.polya import multinomial
from lmic.relax.relax import Relaxation
from lmic.relax.space import Axis, space


def recombined(
    family: LMIFamily, axes: tuple[Axis, ...], values: dict[sp.Symbol, np.ndarray], x: np.ndarray
) -> np.ndarray:
    """The parametric matrix put together again from the family: Σ_k weight_k(θ) F_k(x)."""
    weights = np.ones(1)
    used = [
        axis
        for axis in axes
        if set(axis.symbols) & {s for atom in family.lmi.monomials.atoms for s in atom.free_symbols}
    ]
    for axis, relaxed in zip(used, family.axes, strict=True):
        point = np.array([float(values[s][0]) for s in axis.symbols])
        found = []
        for label in relaxed.labels:
            text = label.split(": ")[1]
            if text.startswith("vertex"):
                found.append(point[int(text.split()[1]) - 1])
            else:
                powers = {str(s): 0 for s in axis.symbols}
                for factor in text.split():
                    name, _, power = factor.partition("^")
                    powers[name] = int(power or 1)
                found.append(np.prod(point ** np.array(list(powers.values()))))
        weights = np.outer(weights, found).ravel()
    return np.tensordot(weights, family.matrices(x), axes=1)


@pytest.mark.parametrize("polya", [0, 1, 2])
@pytest.mark.parametrize("vertices", [2, 3, 4])
@pytest.mark.parametrize("name", ["peixoto2025.theorem1", "peixoto2025.corollary1"])
def test_compiled_equals_symbolic(name: str, vertices: int, polya: int) -> None:
    generator = np.random.default_rng(7)
    theorem = library.theorem(name)
    sizes = {"nx": 3, "nw": 2, "ny": 2, "nz": 1}
    problem = finish(
        prepare(theorem, random_plant(theorem, sizes, vertices, seed=vertices)), {"eps": "7/3"}, Relaxation(polya=polya)
    )
    binding = problem.binding
    axes = space(binding).axes
    x = generator.standard_normal(problem.size)
    for family in problem.families:
        values = random_point(binding, generator)
        expected = direct(theorem.lmis[family.lmi.place.lmi], binding, x, values)
        assert np.allclose(
            recombined(family, axes, values, x), expected, rtol=1e-11, atol=1e-11 * np.abs(expected).max()
        )


@pytest.mark.parametrize("degree", [0, 2])
def test_square_with_other_degrees_of_the_unknowns(degree: int) -> None:
    generator = np.random.default_rng(3)
    theorem = library.theorem("peixoto2025.theorem1")
    dependence = {"P1": 2, "H": degree, "X3": 3}
    problem = finish(prepare(theorem, random_plant(theorem, None, 3), dependence), {"eps": 2}, Relaxation(polya=1))
    axes = space(problem.binding).axes
    x = generator.standard_normal(problem.size)
    for family in problem.families:
        values = random_point(problem.binding, generator)
        expected = direct(theorem.lmis[family.lmi.place.lmi], problem.binding, x, values)
        assert np.allclose(
            recombined(family, axes, values, x), expected, rtol=1e-11, atol=1e-11 * np.abs(expected).max()
        )


def test_rows_of_the_conic_problem_are_the_families(example_1) -> None:
    generator = np.random.default_rng(5)
    problem = finish(prepare(library.theorem("peixoto2025.theorem1"), example_1), {"eps": 150})
    x = generator.standard_normal(problem.size)
    packed = problem.matrix @ x + problem.offset
    index = 0
    for family in problem.families:
        for matrix in family.matrices(x):
            rows = slice(problem.starts[index], problem.starts[index + 1])
            # svec keeps the inner product, so the norm too
            assert np.isclose(np.linalg.norm(packed[rows]), np.linalg.norm(matrix))
            index += 1


def test_polya_degree_zero_is_lemma_1(example_1) -> None:
    """Peixoto et al. (2025), Lemma 1: Γ_iil and Γ_ijl + Γ_jil, with Γ_ijl from the paper's Φ_ijl."""
    theorem = library.theorem("peixoto2025.theorem1")
    problem = finish(prepare(theorem, example_1), {"eps": 150})
    x = np.random.default_rng(1).standard_normal(problem.size)
    family = problem.families[0]
    assert len(family) == 6
    phi = -phi_vertices(problem.layout, x, eps=150.0)
    expected = {
        "alpha1^2": phi[0, 0],
        "alpha1 alpha2": phi[0, 1] + phi[1, 0],
        "alpha2^2": phi[1, 1],
    }
    for (now, following), matrix in zip(map(family.label, range(6)), family.matrices(x), strict=True):
        vertex = int(following.split()[-1]) - 1
        assert np.allclose(matrix, expected[now.split(": ")[1]][vertex], rtol=1e-12, atol=1e-9)


def phi_vertices(layout, x: np.ndarray, eps: float) -> np.ndarray:
    """Φ_ijl of the paper (data i, unknowns j, next vertex l), dense; P3 in Φ21 at l as in its (8)."""
    from conftest import EXAMPLE_1

    data = {
        key: [np.array(v, dtype=float) for v in (value if np.ndim(value) == 3 else [value] * 2)]
        for key, value in EXAMPLE_1.items()
    }
    u = {name: [np.array(m) for m in unknown.matrices(x)] for name, unknown in layout.unknowns.items()}
    delta = float(u["delta"][0][0, 0])
    result = np.empty((2, 2, 2, 11, 11))
    for i, j, l in np.ndindex(2, 2, 2):
        A, Bw, Cz, Dz, Cy, Dy = (data[key][i] for key in ("A", "B_w", "C_z", "D_z", "C_y", "D_y"))
        X1, X2, X3, X4, X5, X6 = (u[f"X{k}"][j] for k in range(1, 7))
        H, Af, Bf, Cf, Df = (u[key][j] for key in ("H", "A_f", "B_f", "C_f", "D_f"))
        P1, P2, P3 = (u[key] for key in ("P1", "P2", "P3"))
        z = np.zeros
        lower = [
            [P1[l] - X1 - X1.T, z((2, 2)), z((2, 2)), z((2, 2)), z((2, 2)), z((2, 1))],
            [-X2 - eps * H.T + P3[l].T, P2[l] - H - H.T, z((2, 2)), z((2, 2)), z((2, 2)), z((2, 1))],
            [-X3 + (X1 @ A + eps * Bf @ Cy).T, -H + (X2 @ A + Bf @ Cy).T,
             -P1[j] + X3 @ A + Bf @ Cy + (X3 @ A + Bf @ Cy).T, z((2, 2)), z((2, 2)), z((2, 1))],
            [-X4 + eps * Af.T, Af.T, X4 @ A + Af.T - P3[j].T, -P2[j], z((2, 2)), z((2, 1))],
            [-X5, z((2, 2)), X5 @ A + Cz - Df @ Cy, -Cf, -np.eye(2), z((2, 1))],
            [-X6 + (X1 @ Bw + eps * Bf @ Dy).T, (X2 @ Bw + Bf @ Dy).T, X6 @ A + (X3 @ Bw + Bf @ Dy).T,
             Bw.T @ X4.T, (X5 @ Bw - Df @ Dy + Dz).T, X6 @ Bw + (X6 @ Bw).T - delta * np.eye(1)],
        ]  # fmt: skip
        full = np.block(lower)
        result[i, j, l] = np.tril(full) + np.tril(full, -1).T
    return result


def test_multinomials_sum_to_the_power_of_the_sum() -> None:
    point = np.array([0.2, 0.3, 0.5])
    from lmic.relax.polya import homogeneous_exponents

    total = sum(
        multinomial(tuple(p)) * np.prod(point**p)
        for p in homogeneous_exponents(3, 4).astype(int).tolist()
        for p in [np.array(p)]
    )
    assert np.isclose(total, 1.0)
