"""SDPA sparse files: exact to the last digit, and another program finds the same optimum."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lmic import library, svec
from lmic.assemble import ConicProblem
from lmic.errors import LmicError
from lmic.export import write_sdpa
from lmic.pipeline import compile
from lmic.plants.plant import Plant
from lmic.solve.solve import solve


def parse(path: Path) -> tuple[np.ndarray, list[np.ndarray], np.ndarray]:
    """An independent reader: cost, and F as an array (blocks)[unknown, row, col]."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith('"')]
    unknowns, blocks = int(lines[0]), int(lines[1])
    orders = [int(word) for word in lines[2].split()]
    assert len(orders) == blocks
    matrices = [np.zeros((unknowns + 1, n, n)) for n in orders]
    for line in lines[4:]:
        k, block, i, j = map(int, line.split()[:4])
        matrices[block - 1][k, i - 1, j - 1] = matrices[block - 1][k, j - 1, i - 1] = float(line.split()[4])
    return np.array(lines[3].split(), dtype=float), matrices, np.array(orders)


@pytest.fixture
def problem(example_1: Plant) -> ConicProblem:
    return compile(library.theorem("peixoto2025.theorem1"), example_1, {"eps": 10})


def test_file_holds_the_problem(problem: ConicProblem, tmp_path: Path) -> None:
    write_sdpa(problem, tmp_path / "F.dat-s")
    cost, matrices, orders = parse(tmp_path / "F.dat-s")
    assert (cost == problem.cost).all()
    assert (orders == problem.orders).all()
    x = np.random.default_rng(0).standard_normal(problem.size)
    packed = problem.matrix @ x + problem.offset
    for k, (matrix, order) in enumerate(zip(matrices, orders, strict=True)):
        value = np.tensordot(x, matrix[1:], axes=1) - matrix[0]
        i, j = svec.triangle(int(order))
        assert np.allclose(
            value[i, j] * svec.weights(int(order)), packed[problem.starts[k] : problem.starts[k + 1]], rtol=1e-14
        )


def test_another_program_finds_the_same_optimum(tmp_path: Path) -> None:
    """CVXPY with SCS, from the file alone: x⁺ = ±x/2 + w, z = x has the l2 gain 1/(1 − 1/2) = 2."""
    import cvxpy as cp

    lag = Plant.polytopic("rho", A=[[[0.5]], [[-0.5]]], B=[[1]], C=[[1]], D=[[0]])
    problem = compile(library.theorem("standard.bounded_real_discrete"), lag)
    write_sdpa(problem, tmp_path / "F.dat-s")
    cost, matrices, _ = parse(tmp_path / "F.dat-s")
    x = cp.Variable(len(cost))
    slacks = [cp.Variable(matrix.shape[1:], PSD=True) for matrix in matrices]
    constraints = [
        cp.vec(slack, order="C") == matrix[1:].reshape(len(cost), -1).T @ x - matrix[0].ravel()
        for slack, matrix in zip(slacks, matrices, strict=True)
    ]
    program = cp.Problem(cp.Minimize(cost @ x), constraints)
    program.solve(solver=cp.SCS, eps=1e-8)
    assert program.value == pytest.approx(2, rel=1e-5)
    assert solve(problem).value == pytest.approx(2, rel=1e-8)


def test_nothing_half_written_is_left_behind(problem: ConicProblem, tmp_path: Path) -> None:
    with pytest.raises(LmicError, match="cannot be written"):
        write_sdpa(problem, tmp_path / "nowhere" / "F.dat-s")
    assert list(tmp_path.iterdir()) == []
