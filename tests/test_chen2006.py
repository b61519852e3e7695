"""S3: the models of Chen and Fong's examples are their polynomials, and their values come out."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy as sp

from lmic.library import root
from lmic.papers.cases import CaseTable, select
from lmic.papers.reproduce import Verdict, reproduce, verdict
from lmic.plants.files import read_plant
from lmic.plants.plant import Plant

# (56): Γ_0, …, Γ_6 and Υ_0, …, Υ_6
GAMMA = [
    [[0, 0.08], [-0.1, 0]],
    [[0.02, 0.12], [0.1, 0.16]],
    [[-0.02, 0.12], [0.1, 0.16]],
    [[0, 0.12], [0.1, 0.16]],
    [[0.02, 0.06], [0.01, 0]],
    [[0.05, 0], [0.01, 0.08]],
    [[0.02, 0.05], [0.01, 0.06]],
]
UPSILON = [
    [[0.1, 0], [0.02, 0.06]],
    [[0.12, 0.1], [0.12, 0.15]],
    [[-0.12, 0.1], [0.12, 0.15]],
    [[0, 0.1], [0.12, 0.15]],
    [[0.07, 0], [0.08, 0.06]],
    [[0.09, 0.05], [0.03, 0]],
    [[0, 0.06], [0.03, 0.05]],
]


def polynomial(coefficients: Any, alpha: Any) -> Any:
    """(54): constant, linear and squared terms."""
    return np.tensordot(np.concatenate([[1], alpha, alpha**2]), np.array(coefficients), axes=1)


def heat(alpha: Any) -> tuple[Any, Any]:
    """Example 2 from the thermal diffusivity (64) itself, not from the expansion (70)."""
    c = 0.8 - 0.4 * alpha[0] + 0.32 * alpha[1] + 0.16 * alpha[0] ** 2 - 0.12 * alpha[1] ** 2
    return np.array([[0, 0], [0.5 * c, 0]]), np.array([[0.1 * c, -0.2], [0.5, 0]])


def plant(name: str) -> Plant:
    return read_plant(root() / "chen2006" / f"{name}.toml")


def closed_form(name: str, alpha: Any) -> tuple[Any, Any]:
    """A_i + B_Δi Δ (I − D_Δz Δ)⁻¹ C_Δ of (6), i = 1, 2."""
    point = {sp.Symbol(f"alpha{k + 1}"): np.array([value]) for k, value in enumerate(alpha)}
    matrix = {key: value.evaluate(point)[0] for key, value in plant(name).matrices.items()}
    delta = matrix["Delta"]
    loop = delta @ np.linalg.solve(np.eye(len(delta)) - matrix["D_Delta_z"] @ delta, matrix["C_Delta"])
    return matrix["A_1"] + matrix["B_Delta_1"] @ loop, matrix["A_2"] + matrix["B_Delta_2"] @ loop


def exact(coefficient: Any) -> Any:
    """A coefficient of (56) as written."""
    return np.vectorize(lambda value: Fraction(str(value)), otypes=[object])(coefficient)


def at_vertex(name: str, k: int) -> dict[str, Any]:
    """The exact matrices at α = e_k."""
    found = plant(name)
    point = {sp.Symbol(component): int(i == k) for i, component in enumerate(found.domains["alpha"].components)}
    matrices = {key: value.to_sympy().xreplace(point) for key, value in found.matrices.items()}
    return {
        key: np.array([Fraction(int(entry.p), int(entry.q)) for entry in matrix], dtype=object).reshape(matrix.shape)
        for key, matrix in matrices.items()
    }


@pytest.mark.parametrize("k", range(3))
def test_the_nft_model_of_example_1_is_the_printed_one(k: int) -> None:
    """(57)-(59), vertex k: Γ_{3+k} stands in block k."""
    built, block = at_vertex("example1_nft", k), slice(2 * k, 2 * k + 2)
    for i, coefficients in ((1, GAMMA), (2, UPSILON)):
        entering = np.zeros((2, 6), dtype=object)
        entering[:, block] = exact(coefficients[4 + k])
        assert (built[f"A_{i}"] == exact(coefficients[0]) + exact(coefficients[1 + k])).all()
        assert (built[f"B_Delta_{i}"] == entering).all()
    assert (built["Delta"] == np.kron(np.diag(np.eye(3)[k]), np.eye(2))).all()
    assert (built["C_Delta"] == np.vstack([np.eye(2)] * 3)).all()
    assert built["D_Delta_z"].shape == (6, 6)
    assert built["D_z"].shape == (6, 1)
    assert built["D_Delta"].shape == (1, 6)
    assert not any(built[name].any() for name in ("D_Delta_z", "D_z", "D_Delta"))


@pytest.mark.parametrize("k", range(3))
def test_the_lft_model_of_example_1_is_the_printed_one_in_other_coordinates(k: int) -> None:
    """(60)-(62): for each α_k the columns [Γ_{3+k}, Γ_k − Γ_{3+k}], C_Δ = [I; I] and D_Δz = [[0, I], [0, 0]].

    With w_Δ = (α_k x, α_k² x) of the built model, the printed one has T w_Δ = (α_k x + α_k² x, α_k x).
    """
    built, eye = at_vertex("example1_lft", k), np.eye(2, dtype=int)
    T, T_inverse = (np.kron(np.eye(3, dtype=int), np.kron(t, eye)) for t in ([[1, 1], [1, 0]], [[0, 1], [1, -1]]))
    assert (T @ T_inverse == np.eye(12)).all()
    assert (built["Delta"] == np.kron(np.diag(np.eye(3)[k]), np.eye(4))).all()
    assert (T @ built["Delta"] == built["Delta"] @ T).all()
    for i, coefficients in ((1, GAMMA), (2, UPSILON)):
        linear, squared = (np.array([exact(c) for c in part]) for part in (coefficients[1:4], coefficients[4:]))
        printed = np.hstack([np.hstack(pair) for pair in zip(squared, linear - squared, strict=True)])
        assert (built[f"A_{i}"] == exact(coefficients[0])).all()
        assert (built[f"B_Delta_{i}"] @ T_inverse == printed).all()
    assert (T @ built["C_Delta"] == np.vstack([eye] * 6)).all()
    assert (T @ built["D_Delta_z"] @ T_inverse == np.kron(np.eye(3), np.kron([[0, 1], [0, 0]], eye))).all()
    assert not built["D_z"].any()
    assert not built["D_Delta"].any()


def test_the_nft_and_lft_files_state_one_plant() -> None:
    stated = [tomllib.loads((root() / "chen2006" / f"example1_{model}.toml").read_text()) for model in ("nft", "lft")]
    assert stated[0]["matrices"] == stated[1]["matrices"]
    assert [document["fractional"].pop("model") for document in stated] == ["nft", "lft"]
    assert stated[0]["fractional"] == stated[1]["fractional"]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("model", ["example1_nft", "example1_lft"])
def test_example_1_models_are_the_polynomial(model: str, seed: int) -> None:
    alpha = np.random.default_rng(seed).dirichlet(np.ones(3))
    first, second = closed_form(model, alpha)
    np.testing.assert_allclose(first, polynomial(GAMMA, alpha), atol=1e-14)
    np.testing.assert_allclose(second, polynomial(UPSILON, alpha), atol=1e-14)


@pytest.mark.parametrize("seed", range(5))
def test_without_delta_the_squares_are_gone(seed: int) -> None:
    alpha = np.random.default_rng(seed).dirichlet(np.ones(3))
    first, second = closed_form("example1_no_delay", alpha)
    np.testing.assert_allclose(first, polynomial(GAMMA[:4] + [np.zeros((2, 2))] * 3, alpha), atol=1e-14)
    np.testing.assert_allclose(second, polynomial(UPSILON[:4] + [np.zeros((2, 2))] * 3, alpha), atol=1e-14)


def test_without_delay_nothing_else_differs() -> None:
    """B_i, C, D and L are common, A_di is zero, and one channel of zeros stands for Δ."""
    nft, no_delay = (plant(f"example1_{model}").matrices for model in ("nft", "no_delay"))
    for name in ("A_d1", "A_d2", "B_1", "B_2", "C", "D", "L"):
        expected = 0 * nft[name].coefficients if name.startswith("A_d") else nft[name].coefficients
        assert (no_delay[name].coefficients == expected).all()
    assert no_delay["Delta"].shape == (1, 1)
    for name in ("Delta", "B_Delta_1", "B_Delta_2", "D_Delta", "C_Delta", "D_Delta_z", "D_z"):
        assert not no_delay[name].coefficients.any()


@pytest.mark.parametrize("seed", range(5))
def test_example_2_is_the_heat_equation(seed: int) -> None:
    alpha = np.random.default_rng(seed).dirichlet(np.ones(2))
    for ours, expected in zip(closed_form("example2", alpha), heat(alpha), strict=True):
        np.testing.assert_allclose(ours, expected, atol=1e-14)


def cases(prefix: str, without: str = "full") -> CaseTable:
    (table,) = select((f"chen2006.{prefix}",))
    return replace(table, cases=tuple(case for case in table.cases if without not in case.id))


def check(table: CaseTable) -> list[Verdict]:
    """Every case within 1e-4 of its reference, and known to 1e-5; the verdicts."""
    assert table.cases
    outcomes = list(reproduce(table))
    for outcome in outcomes:
        solution = outcome.result.solution
        assert solution.uncertainty <= 1e-5
        assert outcome.value == pytest.approx(float(outcome.case.reference), rel=1e-4)
        assert solution.bound <= outcome.value * (1 + 1e-9)
        # the references are rounded to five or six digits
        assert solution.bound <= float(outcome.case.reference) * (1 + 2e-5)
    return [outcome.verdict for outcome in outcomes]


@pytest.mark.parametrize("prefix", ["nft.hinf", "nft.h2", "nft.mixed5"])
def test_the_nft_model_as_printed(prefix: str) -> None:
    """The paper's values lie below the dual bound, that of an objective that is a sum among them."""
    assert check(cases(prefix)) == [Verdict.REFUTED]


@pytest.mark.long
@pytest.mark.parametrize("prefix", ["nft", "lft.hinf", "lft.h2"])
def test_all_of_example_1(prefix: str) -> None:
    check(cases(prefix, without="none"))


@pytest.mark.parametrize("prefix", ["no_delay", "example2"])
def test_the_small_cases_to_all_digits_of_their_reference(prefix: str) -> None:
    for outcome in reproduce(cases(prefix)):
        assert outcome.value == pytest.approx(float(outcome.case.reference), rel=1e-5)


def test_a_solution_where_the_paper_found_none_is_better() -> None:
    (table,) = select(("chen2006.lft.mixed5",))
    assert verdict(table.cases[0], 19.7, 0.0, {}) is Verdict.BETTER
    assert verdict(table.cases[0], float("nan"), float("inf"), {}) is Verdict.UNTRUSTED
