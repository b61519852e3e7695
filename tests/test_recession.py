"""Recession: the face of the dual that growing unknowns leave, the optimum on it, and the way back to all LMIs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.algebra.integer_bases import integer_complement
from lmic.interchange.sdp import sdp_of_entries
from lmic.solve import scaling
from lmic.solve.clarabel import Clarabel
from lmic.solve.cone import ConeData
from lmic.solve.on_face import solve_on_face
from lmic.solve.recession import reduction
from lmic.solve.scaling import slack_matrices
from lmic.solve.solve import solve

Array = NDArray[Any]


def packed(matrix: Array) -> Array:
    rows, cols = svec.triangle(len(matrix))
    return np.asarray(matrix[rows, cols] * svec.weights(len(matrix)))


def problem_of(cost: list[float], *lmis: list[Array]) -> ConeData:
    """minimise cost·x, every LMI given by its constant and the coefficients of all unknowns."""
    columns = [np.concatenate([packed(np.asarray(lmi[i], dtype=float)) for lmi in lmis]) for i in range(len(lmis[0]))]
    orders = np.array([len(lmi[0]) for lmi in lmis])
    return ConeData(np.array(cost), sps.csc_array(np.column_stack(columns[1:])), columns[0], orders)


def planted(seed: int, mixing: Array | None = None) -> tuple[ConeData, float, Array]:
    """T [[C(x), B], [Bᵀ, tI]] Tᵀ ⪰ 0 with a fixed B: t grows at no cost, and the optimum is that of C(x) ⪰ 0.

    C(x) = [[x₁, c, 0], [c, x₂, 0], [0, 0, x₁ − x₂ + 3]] at cost x₁ + x₂: that is 2c, at x₁ = x₂ = c. The last is
    the directions that grow, the last two columns of T.
    """
    generator = np.random.default_rng(seed)
    if mixing is None:
        mixing = np.triu(generator.integers(-1, 2, size=(5, 5)), 1) + np.eye(5)
    c = float(generator.integers(1, 4))
    constant, first, second, growing = np.zeros((4, 5, 5))
    constant[0, 1] = constant[1, 0] = c
    constant[2, 2] = 3
    constant[:3, 3:] = generator.integers(-3, 4, size=(3, 2))
    constant[3:, :3] = constant[:3, 3:].T
    first[[0, 2], [0, 2]] = 1
    second[[1, 2], [1, 2]] = 1, -1
    growing[[3, 4], [3, 4]] = 1
    lmi = [mixing @ matrix @ mixing.T for matrix in (constant, first, second, growing)]
    return problem_of([1, 1, 0], lmi), 2 * c, mixing[:, 3:]


@pytest.mark.parametrize("seed", range(12))
def test_the_face_is_orthogonal_to_what_grows(seed: int) -> None:
    data, _, grows = planted(seed)
    found = reduction(data, Clarabel())
    assert found is not None
    (base,) = found.bases
    assert base is not None
    assert np.issubdtype(base.dtype, np.integer)
    assert np.linalg.matrix_rank(base) == 3
    assert np.abs(base.T @ grows).max() < 1e-12
    assert found.core.matrix.shape[1] == 2


@pytest.mark.parametrize("seed", range(12))
def test_the_core_has_the_optimum_and_a_point_of_it_comes_back_inside(seed: int) -> None:
    data, optimum, _ = planted(seed)
    answer = solve_on_face(data, Clarabel(), 6)
    assert answer is not None
    found = answer[0]
    assert found.step.bound == pytest.approx(optimum, rel=1e-8)
    assert optimum < found.step.value < optimum * (1 + 1e-6)
    slack = slack_matrices(data.matrix @ found.x + data.offset, data.orders)[0]
    root = 1 / np.sqrt(np.diag(slack))
    assert np.linalg.eigvalsh(root[:, None] * slack * root)[0] > -1e-14


@pytest.mark.parametrize("seed", range(12))
def test_dual_matrices_on_the_face_meet_every_equality_of_the_whole(seed: int) -> None:
    data, optimum, _ = planted(seed)
    answer = solve_on_face(data, Clarabel(), 6)
    assert answer is not None
    dual = answer[0].dual
    assert data.matrix.T @ dual == pytest.approx(data.cost, abs=1e-7)
    assert -data.offset @ dual == pytest.approx(optimum, rel=1e-7)
    optimal = answer[0].on_face
    assert optimal is not None
    for share in (1e-6, 1e-3):
        inner = optimal.dual_matrices(share, Clarabel())
        assert all(np.linalg.eigvalsh(matrix)[0] > 0 for matrix in inner)


def test_nested_faces_are_found_one_after_the_other() -> None:
    """u grows in the first LMI; only with it gone v, which stands beside −u in the second, grows at no cost.

    [[x, 1, 0], [1, x, 1], [0, 1, u]] and [[v, −u], [−u, x]]: for every u there is a v.
    """
    zero = np.zeros((3, 3))
    one, two = [zero.copy() for _ in range(4)], [np.zeros((2, 2)) for _ in range(4)]
    one[0][[0, 1, 1, 2], [1, 0, 2, 1]] = 1
    one[1][[0, 1], [0, 1]] = 1
    one[2][2, 2] = 1
    two[1][1, 1] = 1
    two[2][[0, 1], [1, 0]] = -1
    two[3][0, 0] = 1
    data = problem_of([1, 0, 0], one, two)
    answer = solve_on_face(data, Clarabel(), 6)
    assert answer is not None
    assert answer[0].step.bound == pytest.approx(1, rel=1e-7)
    assert answer[0].step.value == pytest.approx(1, rel=1e-5)
    assert answer[0].step.violation == 0
    assert answer[0].on_face is not None
    assert len(answer[0].on_face.reduction.faces) == 2


@pytest.mark.parametrize("seed", range(4))
def test_balanced_coordinates_are_those_of_one_diagonal_for_slack_and_dual(seed: int) -> None:
    data, *_ = planted(seed)
    generator = np.random.default_rng(seed)
    factors = generator.standard_normal((2, 5, 5)) * 10.0 ** generator.integers(-3, 3, size=(2, 5, 1))
    slack, dual = (packed(factor @ factor.T) for factor in factors)
    scaled, transform = scaling.balanced(data, slack, dual)
    (own,) = slack_matrices(scaling.scaled_slack(slack, transform, data.orders), data.orders)
    (other,) = slack_matrices(scaling.scaled_dual(dual, transform, data.orders), data.orders)
    assert np.diag(own) == pytest.approx(np.diag(other), rel=1e-9)
    y = generator.standard_normal(len(data.cost))
    there = scaling.scaled_slack(data.matrix @ transform.x(y) + data.offset, transform, data.orders)
    assert scaled.matrix @ y + scaled.offset == pytest.approx(there, rel=1e-9)
    assert scaled.cost @ y == pytest.approx(data.cost @ transform.x(y))
    assert scaled.matrix.nnz == data.matrix.nnz


def test_a_number_that_is_known_well_is_not_said_to_be_attained() -> None:
    """[[x, 1, 0], [1, x, 1], [0, 1, u]]: the infimum 1 of x² > 1 + x/u is that of u → ∞."""
    entries = [(0, 0, 1, 1), (0, 1, 2, 1), (1, 0, 0, 1), (1, 1, 1, 1), (2, 2, 2, 1)]
    unknown, row, column, value = map(np.array, zip(*entries, strict=True))
    sdp = sdp_of_entries(np.array([1.0, 0.0]), 0.0, np.array([3]), [unknown, 0 * unknown, row, column, value])
    found = solve(sdp, Clarabel())
    assert found.value == pytest.approx(1, rel=1e-6)
    assert not found.warnings
    assert found.attained is None


def test_an_lmi_that_grows_as_a_whole_is_left_out() -> None:
    """minimise x + y subject to [[x, 1], [1, y]] ⪰ 0 and [[t − 5x, 1], [1, t]] ⪰ 0."""
    pair = np.array([[0.0, 1], [1, 0]])
    nothing = np.zeros((2, 2))
    first = [pair, np.diag([1.0, 0]), np.diag([0, 1.0]), nothing]
    second = [pair, np.diag([-5.0, 0]), nothing, np.eye(2)]
    data = problem_of([1, 1, 0], first, second)
    answer = solve_on_face(data, Clarabel(), 6)
    assert answer is not None
    found = answer[0]
    assert found.step.bound == pytest.approx(2, rel=1e-7)
    assert found.step.value == pytest.approx(2, rel=1e-6)
    assert found.step.violation == 0
    assert data.matrix.T @ found.dual == pytest.approx(data.cost, abs=1e-7)


def test_where_nothing_grows_no_face_is_found() -> None:
    """minimise x + y subject to [[x, 1], [1, y]] ⪰ 0: no direction is free of cost."""
    pair = np.array([[0.0, 1], [1, 0]])
    data = problem_of([1, 1], [pair, np.diag([1.0, 0]), np.diag([0, 1.0])])
    assert reduction(data, Clarabel()) is None


def test_directions_that_are_no_small_fractions_are_left_alone() -> None:
    """A face of rounded directions would be another problem's."""
    mixing = np.random.default_rng(3).uniform(size=(5, 5)) + 2 * np.eye(5)
    data, _, _ = planted(3, mixing)
    assert reduction(data, Clarabel()) is None


@pytest.mark.parametrize("seed", range(20))
def test_an_integer_complement_is_one(seed: int) -> None:
    generator = np.random.default_rng(seed)
    rows = np.triu(generator.integers(-1, 2, size=(7, 7)), 1)[:3] + np.eye(7)[:3]
    rotated = np.linalg.qr(rows.T)[0].T  # orthonormal, as eigenvectors are
    base = integer_complement(rotated, 8, 1e-9)
    assert base is not None
    assert base.shape == (7, 4)
    assert np.linalg.matrix_rank(base) == 4
    assert np.abs(base.T @ rows.T).max() < 1e-12
