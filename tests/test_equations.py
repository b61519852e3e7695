"""Sparse exact systems: the solution is that of a dense solve, whatever can be eliminated one by one."""

from __future__ import annotations

import random

import flint
import pytest

from lmic.certify.equations import solve

System = dict[tuple[int, int], flint.fmpq]


def shuffled(core: int, before: int, after: int, seed: int) -> tuple[System, list[flint.fmpq]]:
    """A lower triangular block, a dense one that uses it, and one that uses both, in no order of rows and columns."""
    draw = random.Random(seed)
    size = core + before + after

    def number() -> flint.fmpq:
        return flint.fmpq(draw.choice([-3, -2, -1, 1, 2, 5]), draw.randint(1, 7))

    triangular = [*range(before), *range(before + core, size)]
    places = {(i, j) for i in triangular for j in range(i) if draw.random() < 0.3} | {(i, i) for i in triangular}
    inner = range(before, before + core)
    places |= {(i, j) for i in inner for j in range(before + core)}
    rows, columns = draw.sample(range(size), size), draw.sample(range(size), size)
    return {(rows[i], columns[j]): number() for i, j in sorted(places)}, [number() for _ in range(size)]


def dense(system: System, size: int) -> flint.fmpq_mat:
    return flint.fmpq_mat(size, size, [system.get((i, j), 0) for i in range(size) for j in range(size)])


@pytest.mark.parametrize("sizes", [(0, 12, 0), (6, 0, 0), (4, 7, 0), (4, 0, 7), (3, 8, 8), (0, 0, 1), (0, 0, 0)])
@pytest.mark.parametrize("seed", range(8))
def test_the_solution_is_that_of_the_dense_matrix(sizes: tuple[int, int, int], seed: int) -> None:
    system, right = shuffled(*sizes, seed)
    size = len(right)
    expected = dense(system, size).solve(flint.fmpq_mat(size, 1, right)).entries() if size else []
    assert solve(system, right, flint.fmpq_mat) == expected


def test_balls_hold_the_solution() -> None:
    system, right = shuffled(3, 8, 8, seed=1)
    exact = solve(system, right, flint.fmpq_mat)
    balls = {place: flint.arb(value) for place, value in system.items()}
    found = solve(balls, [flint.arb(value) for value in right], flint.arb_mat)
    assert all(ball.contains(flint.arb(value)) for ball, value in zip(found, exact, strict=True))
    assert all(ball.rad() < 1e-9 for ball in found)


def test_a_ball_that_holds_zero_is_no_zero() -> None:
    """x₀ + [±1]·x₁ = 1, x₁ = 1: x₀ is anything in [0, 2]."""
    system = {(0, 0): flint.arb(1), (0, 1): flint.arb(0, 1), (1, 1): flint.arb(1)}
    first, _ = solve(system, [flint.arb(1), flint.arb(1)], flint.arb_mat)
    assert first.contains(flint.arb(0))
    assert first.contains(flint.arb(2))


def test_a_triangular_system_needs_no_dense_matrix() -> None:
    system, right = shuffled(0, 40, 40, seed=3)

    def refuse(*_: object) -> None:
        raise AssertionError("nothing should be left for a dense matrix")

    found = solve(system, right, refuse)
    assert all(sum(v * found[j] for (i, j), v in system.items() if i == row) == right[row] for row in range(80))


@pytest.mark.parametrize(
    "entries",
    [
        {(0, 0): 1, (1, 0): 2},
        {(0, 0): 1, (0, 1): 2},
        {(0, 0): 1, (0, 1): 2, (1, 0): 2, (1, 1): 4},
        {(0, 0): 1, (1, 1): 0},
    ],
    ids=["no equation for the second", "no entry in the second equation", "dependent", "a zero on the diagonal"],
)
def test_a_singular_system_is_refused(entries: dict[tuple[int, int], int]) -> None:
    with pytest.raises(ZeroDivisionError):
        solve({place: flint.fmpq(value) for place, value in entries.items()}, [flint.fmpq(1)] * 2, flint.fmpq_mat)
