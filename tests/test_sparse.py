"""The exact sparse matrix polynomials against sympy, and the problems that are read with them."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

from lmic import library
from lmic.algebra.polynomials import MatrixPolynomial
from lmic.certify.finite import finite_problem
from lmic.certify.region import region
from lmic.certify.relaxed import functionals
from lmic.certify.sparse import SparsePolynomial
from lmic.certify.statement import Statement
from lmic.errors import CertificateError
from lmic.pipeline import compile
from lmic.plants.files import read_plant
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation

ROOT = library.root()
a, b, c = sp.symbols("a b c")


def random_matrix(generator: random.Random, rows: int, cols: int) -> sp.Matrix:
    """Entries of up to three terms in a, b, sin(a) and cos(b), about a third of them zero."""
    atoms = [sp.Integer(1), a, b, a * b, a**2, sp.sin(a), a * sp.cos(b)]

    def entry() -> sp.Expr:
        terms = generator.choices(atoms, k=generator.choice([0, 1, 3]))
        return sp.Add(*(sp.Rational(generator.randint(-3, 3), generator.randint(1, 4)) * term for term in terms))

    return sp.Matrix(rows, cols, lambda i, j: entry())


def sparse(matrix: sp.Matrix) -> SparsePolynomial:
    """Entry by entry, put together as blocks."""
    rows, cols = matrix.shape
    entries = [[SparsePolynomial.scalar(matrix[i, j]) for j in range(cols)] for i in range(rows)]
    return SparsePolynomial.joined(entries, [1] * rows, [1] * cols)


def assert_equal(found: SparsePolynomial, expected: sp.Matrix) -> None:
    """Equal to sympy's matrix, nothing zero kept, and the dense form the one that sympy's has."""
    dense, again = found.dense(), MatrixPolynomial.from_sympy(sp.Matrix(expected).applyfunc(sp.expand))
    assert dense.to_sympy().applyfunc(sp.expand) == sp.Matrix(expected).applyfunc(sp.expand)
    assert all(value for _, _, value in found.terms())
    assert all(found.entries.values())
    assert dense.monomials.atoms == again.monomials.atoms
    assert (dense.monomials.exponents == again.monomials.exponents).all()
    assert (dense.coefficients == again.coefficients).all()
    assert SparsePolynomial.from_dense(dense) == found


OPERATIONS: dict[str, tuple[Callable[..., SparsePolynomial], Callable[..., sp.Matrix]]] = {
    "sum": (lambda A, B, C: A + B, lambda A, B, C: A + B),
    "difference with itself": (lambda A, B, C: A + -A, lambda A, B, C: A - A),
    "product": (lambda A, B, C: A @ C, lambda A, B, C: A * C),
    "product of sums": (lambda A, B, C: (A + B).T @ (A + -B), lambda A, B, C: (A + B).T * (A - B)),
    "Kronecker": (lambda A, B, C: A.kronecker(C), lambda A, B, C: sp.kronecker_product(A, C)),
    "trace": (lambda A, B, C: (A @ B.T).trace, lambda A, B, C: sp.Matrix([[(A * B.T).trace()]])),
    "Hermitian part": (lambda A, B, C: A @ B.T + (A @ B.T).T, lambda A, B, C: A * B.T + B * A.T),
    "scaled": (
        lambda A, B, C: A.scaled(SparsePolynomial.scalar(a - b / 3)),
        lambda A, B, C: (a - b / 3) * A,
    ),
    "renamed apart": (lambda A, B, C: A.renamed({a: c}), lambda A, B, C: A.xreplace({a: c})),
    "renamed together": (lambda A, B, C: (A @ C).renamed({a: b}), lambda A, B, C: (A * C).xreplace({a: b})),
    "blocks": (
        lambda A, B, C: SparsePolynomial.joined([[A, None], [B, C.T]], [2, 2], [3, 3]),
        lambda A, B, C: sp.Matrix(sp.BlockMatrix([[A, sp.zeros(2, 3)], [B, C.T]])),
    ),
}


@pytest.mark.parametrize("name", list(OPERATIONS))
def test_the_algebra_is_that_of_sympy(name: str) -> None:
    ours, theirs = OPERATIONS[name]
    generator = random.Random(name)
    for _ in range(20):
        A, B, C = (random_matrix(generator, *shape) for shape in [(2, 3), (2, 3), (3, 2)])
        assert_equal(ours(*map(sparse, (A, B, C))), theirs(A, B, C))


def test_symmetry_is_seen_exactly() -> None:
    generator = random.Random(2)
    for _ in range(20):
        A = random_matrix(generator, 3, 3)
        assert sparse(A + A.T).is_symmetric
        off = sp.zeros(3, 3)
        off[0, 2] = a * sp.Rational(1, 10**30)
        assert not sparse(A + A.T + off).is_symmetric
    assert not sparse(random_matrix(generator, 2, 3)).is_symmetric


def test_constants_are_dyadic_and_shapes_are_checked() -> None:
    found = SparsePolynomial.constant(np.array([[0.1, 0], [2, -0.25]]))
    assert dict(found.entries) == {
        (0, 0): {frozenset(): Fraction(0.1)},
        (1, 0): {frozenset(): Fraction(2)},
        (1, 1): {frozenset(): Fraction(-1, 4)},
    }
    wide, tall = SparsePolynomial((2, 3), {}), SparsePolynomial((3, 2), {})
    with pytest.raises(CertificateError, match="2 x 3 and 3 x 2 matrices are added"):
        wide + tall
    with pytest.raises(CertificateError, match="2 x 3 and 2 x 3 matrices are multiplied"):
        wide @ wide
    with pytest.raises(CertificateError, match="a block is 2 x 3 where 3 x 2 is needed"):
        SparsePolynomial.joined([[wide]], [3], [2])


@pytest.mark.parametrize(
    ("name", "plant", "given", "relaxation"),
    [
        (
            "wu2007.theorem6",
            ROOT / "wu2007" / "example.toml",
            {},
            Relaxation(grid={"r": Grid.at([[1, 0], [0.3, 0.1]])}, ties={"b": "a"}),
        ),
        ("peixoto2025.theorem1", ROOT / "peixoto2025" / "example1.toml", {"eps": 150}, Relaxation(polya={"alpha": 1})),
        ("chen2006.theorem4", ROOT / "chen2006" / "example1_nft.toml", {}, Relaxation()),
    ],
)
def test_the_symbolic_problem_is_the_one_with_numbers_put_in(
    name: str, plant: Path, given: Mapping[str, Any], relaxation: Relaxation
) -> None:
    """Exactly, at a random point: first the unknowns' values and then the matrix, or the other way round."""
    problem = compile(library.theorem(name), read_plant(plant), dict(given), relaxation=relaxation)
    theorem, data = problem.binding.theorem, problem.binding.plant
    statement = Statement(theorem, data, {**data.scalars, **{k: Fraction(v) for k, v in given.items()}}, {})
    domain = region(statement, relaxation.ties)
    chosen = functionals(problem, relaxation, domain)
    basis = {key: tuple(map(sp.sympify, u.functions)) for key, u in problem.layout.unknowns.items()}
    exact = finite_problem(statement, basis, domain.equal, chosen)
    generator = random.Random(name)
    x = [Fraction(generator.randint(-50, 50), generator.randint(1, 9)) for _ in range(exact.size)]
    unknowns, start = {}, 0
    for key, functions in basis.items():
        numbers = statement.coordinates(key)
        matrices = {}
        for function in functions:
            values = np.array([*x[start : start + numbers.max() + 1], Fraction(0)], dtype=object)
            matrices[function] = values[numbers]
            start += int(numbers.max()) + 1
        unknowns[key] = statement.value(key, matrices)
    assert start == exact.size
    matrices = {lmi: statement.matrix(lmi, unknowns).renamed(domain.equal) for lmi in theorem.lmis}
    for functional, lmi in zip(chosen, exact.lmis, strict=True):
        matrix = matrices[functional.lmi]
        weights = functional.weights(matrix)
        assert (lmi.at(x) == sum(w * m for w, m in zip(weights, matrix.coefficients, strict=True))).all()
    objective = statement.expression(theorem.minimise, unknowns).coefficients[0, 0, 0]
    assert objective == sum(c * x for c, x in zip(exact.cost, x, strict=True)) + exact.constant
