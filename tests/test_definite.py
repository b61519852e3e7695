"""Definiteness against an independent exact decision: the signs of the leading principal minors."""

from __future__ import annotations

import random
from collections.abc import Iterator
from fractions import Fraction

import flint
import numpy as np
import pytest

from lmic.certify.definite import decide, is_positive_definite, proves_positive_definite
from lmic.errors import CertificateError

TINY = flint.fmpq(1, 10**30)


def by_minors(matrix: flint.fmpq_mat) -> bool:
    """Sylvester: every leading principal minor is positive."""
    rows = matrix.tolist()
    return all(flint.fmpq_mat([row[:k] for row in rows[:k]]).det() > 0 for k in range(1, len(rows) + 1))


def gram(generator: random.Random, order: int, rank: int, size: int) -> flint.fmpq_mat:
    factor = flint.fmpq_mat(order, rank, [generator.randint(-size, size) for _ in range(order * rank)])
    return factor * factor.transpose()


def congruent(matrix: flint.fmpq_mat, scales: list[flint.fmpq]) -> flint.fmpq_mat:
    order = len(scales)
    diagonal = flint.fmpq_mat(order, order, [scales[i] if i == j else 0 for i in range(order) for j in range(order)])
    return diagonal * matrix * diagonal


def identity(order: int) -> flint.fmpq_mat:
    return flint.fmpq_mat(order, order, [int(i == j) for i in range(order) for j in range(order)])


def mutated(seed: int) -> Iterator[flint.fmpq_mat]:
    """On both sides of the boundary and on it, scaled over many magnitudes."""
    generator = random.Random(seed)
    order = generator.randint(2, 8)
    scales = [flint.fmpq(2) ** generator.randint(-60, 60) for _ in range(order)]
    size = generator.choice([2, 9, 10**6])
    singular = gram(generator, order, order - 1, size)
    regular = gram(generator, order, order, size)
    i, j = generator.randrange(order), generator.randrange(order)
    nudge = flint.fmpq_mat(order, order, [0] * order**2)
    nudge[i, j] = nudge[j, i] = generator.choice([-1, 1])
    for matrix in (
        singular,
        singular + identity(order) * TINY,
        singular - identity(order) * TINY,
        singular + nudge,
        singular + nudge * TINY,
        regular,
        regular + nudge,
        regular - identity(order) * generator.randint(1, size),
    ):
        yield congruent(matrix, scales)


@pytest.mark.parametrize("start", range(0, 400, 50))
def test_every_mutated_matrix_is_judged_as_its_minors_judge_it(start: int) -> None:
    """3,200 cases in all."""
    verdicts = set()
    for seed in range(start, start + 50):
        for matrix in mutated(seed):
            expected = by_minors(matrix)
            verdicts.add(expected)
            assert is_positive_definite(matrix) is expected
            with flint.ctx.workprec(128):
                ball = flint.arb_mat(matrix)
                assert decide(ball) in (expected, None)
                assert expected or not proves_positive_definite(ball)
    assert verdicts == {True, False}


def test_a_ball_is_proven_only_if_all_that_it_holds_is_definite() -> None:
    """The least eigenvalue of the midpoint is 1; a radius r on every entry can take n·r from it."""
    generator = np.random.default_rng(0)
    proven = 0
    for order in (2, 5, 9):
        factor = np.linalg.qr(generator.standard_normal((order, order)))[0]
        middle = factor @ np.diag(np.linspace(1, 3, order)) @ factor.T
        middle = (middle + middle.T) / 2
        for share in (0.01, 0.1, 0.3, 1.05, 2.0):
            radius = share / order
            balls = [[flint.arb(float(entry), radius) for entry in row] for row in middle]
            verdict = proves_positive_definite(flint.arb_mat(balls))
            proven += verdict
            lowest = np.linalg.eigh(middle)[1][:, 0]
            worst = middle - radius * np.sign(np.outer(lowest, lowest))
            if np.linalg.eigvalsh(worst)[0] < 0:
                assert not verdict
                assert decide(flint.arb_mat(balls)) is None
    assert proven >= 3


def test_what_is_not_finite_is_never_proven() -> None:
    nothing = flint.arb_mat([[flint.arb.nan(), flint.arb(0)], [flint.arb(0), flint.arb(1)]])
    assert decide(nothing) is None
    assert not proves_positive_definite(nothing)


def test_a_matrix_that_is_not_symmetric_is_an_error() -> None:
    with pytest.raises(CertificateError, match="not symmetric"):
        is_positive_definite(flint.fmpq_mat([[1, 1], [0, 1]]))


def test_the_hilbert_matrix_is_definite_whatever_floating_point_says() -> None:
    order = 40
    hilbert = flint.fmpq_mat(order, order, [flint.fmpq(1, i + j + 1) for i in range(order) for j in range(order)])
    assert np.linalg.eigvalsh([[1 / (i + j + 1) for j in range(order)] for i in range(order)])[0] < 1e-16
    assert is_positive_definite(hilbert)
    least = hilbert.det() / flint.fmpq_mat([row[:-1] for row in hilbert.tolist()[:-1]]).det()
    hilbert[order - 1, order - 1] -= least  # the last pivot: singular now, exactly
    assert not is_positive_definite(hilbert)
    hilbert[order - 1, order - 1] += flint.fmpq(Fraction(1, 10**60).numerator, 10**60)
    assert is_positive_definite(hilbert)
