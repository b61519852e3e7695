"""Diagonal unknowns of any size: compiled, certified, and diagonal where they are proven."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lmic.certify.certificate import Unknown
from lmic.certify.certify import certify
from lmic.certify.verify import verify
from lmic.dsl import PD, Data, Diagonal, I, Scalar, Source, Theorem, Variant, dims, trace
from lmic.pipeline import compile, run
from lmic.plants.plant import Plant

(n,) = dims("n")
M, T, mu = Data("M", n, n, symmetric=True), Diagonal("T", n), Scalar("mu")
LEAST = Theorem(
    lmis={"above": PD(T - M), "trace": PD(mu * I(1) - trace(T))},
    minimise=mu,
    reports={"least": mu},
    variants={"full": Variant("Any T", full=(T,))},
    source=Source("N. N.", "A test", "unpublished", 2026),
    name="least",
)


def ones(size: int) -> Plant:
    """Ones beside the diagonal: the eigenvalues are size - 1 and -1."""
    return Plant.polytopic(M=np.ones((size, size), dtype=int) - np.eye(size, dtype=int))


@pytest.mark.parametrize("size", [1, 2, 3, 5])
def test_the_least_diagonal_above_a_matrix(size: int) -> None:
    """By symmetry a multiple of the identity, (size - 1) I; an unknown that need not be diagonal is M itself."""
    result = run(compile(LEAST, ones(size)))
    assert result.problem.size == size + 1
    assert result.reports["least"] == pytest.approx(size * (size - 1), abs=1e-6)
    assert run(compile(LEAST.variant("full"), ones(size))).reports["least"] == pytest.approx(0, abs=1e-6)


def test_a_certificate_has_a_diagonal() -> None:
    found = certify(run(compile(LEAST, ones(3))))
    assert verify(found, LEAST).holds
    lower, upper = found.ends("least", LEAST)
    assert lower is not None
    assert upper is not None
    assert lower <= 6 <= upper
    assert upper - lower < 1e-5
    (matrix,) = found.unknowns["T"].matrices
    beside = matrix.copy()
    beside[0, 1] = beside[1, 0] = 1
    bent = {**found.unknowns, "T": Unknown(found.unknowns["T"].functions, (beside,))}
    assert "outside its blocks" in verify(replace(found, unknowns=bent), LEAST).reason
