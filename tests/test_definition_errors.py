"""Faulty statements: each fault has its own error, which names theorem, LMI, block and expression."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy as sp

from lmic.algebra.polynomials import MatrixPolynomial
from lmic.compiler.lower import lower
from lmic.compiler.terms import term_lists
from lmic.dsl import (
    ND,
    PD,
    Bisection,
    BlockDiagonal,
    Data,
    He,
    I,
    Matrix,
    Parameter,
    Scalar,
    Simplex,
    Source,
    Symmetric,
    Theorem,
    block,
    dims,
    dot,
    given,
    inv,
    star,
    zeros,
)
from lmic.errors import (
    AsymmetryError,
    BasisError,
    DefinitionError,
    DomainError,
    LmicError,
    NotAffineError,
    PlantError,
    ShapeError,
)
from lmic.pipeline import compile
from lmic.plants.domains import BoxDomain
from lmic.plants.plant import Plant, exact_number

n, m = dims("n m")
alpha = Simplex("alpha", step="free")
A, B = Data("A", n, n)(alpha), Data("B", n, m)(alpha)
P, G = Symmetric("P", n), Matrix("G", n, n)(alpha)
mu = Scalar("mu")
SOURCE = Source("nobody", "nothing", "nowhere", 2026)


def statement(rows: Any, **changes: Any) -> Theorem:
    return Theorem(lmis={"dissipation": PD(rows)}, source=SOURCE, name="faulty", **changes)


CASES: list[tuple[type[LmicError], Callable[[], Any], list[str]]] = [
    (NotAffineError, lambda: [[He(P(alpha) * G)]],
     ["faulty / dissipation / block (1,1)", "P(alpha)*G(alpha)", "new unknown"]),
    (NotAffineError, lambda: [[mu * P(alpha)]], ["block (1,1)", "mu", "P(alpha)"]),
    (NotAffineError, lambda: [[He(inv(mu * I(n)))]], ["block (1,1)", "inv(mu*I(n)) inverts the unknown mu"]),
    (NotAffineError, lambda: [[mu**2 * I(n)]], ["block (1,1)", "mu**2", "not affine"]),
    (NotAffineError, lambda: [[He(inv(G) * A)]], ["inv(G(alpha))", "Schur complement"]),
    (AsymmetryError, lambda: [[G]], ["block (1,1)", "G(alpha) is not symmetric", "He("]),
    (AsymmetryError, lambda: [[P(alpha), A], [A, P(alpha)]],
     ["block (1,2)", "not the transpose of block (2,1)", "star"]),
    (AsymmetryError, lambda: [[P(alpha), 0], [A, P(alpha)]], ["block (1,2)", "not the transpose"]),
    (ShapeError, lambda: [[P(alpha), B], [star, P(alpha)]], ["block (1,2)", "B(alpha)", "n x m"]),
    (ShapeError, lambda: [[He(P(alpha) * B)]], ["block (1,1)", "square"]),
    (ShapeError, lambda: [[P(alpha) + B]], ["block (1,1)", "do not add", "B(alpha)"]),
    (ShapeError, lambda: [[B * A]], ["do not multiply", "B(alpha)", "A(alpha)"]),
    (ShapeError, lambda: [[P(alpha), 0], [0, 0]], ["row 2", "zeros"]),
    (DefinitionError, lambda: [[P(alpha), star], [star, P(alpha)]], ["block (1,2)", "both star"]),
    (DefinitionError, lambda: [[star]], ["diagonal", "star"]),
    (DefinitionError, lambda: [[P(alpha), 0]], ["row 1 has 2 blocks", "1 rows"]),
    (DefinitionError, lambda: [["P"]], ["'P'", "block (1,1)"]),
]  # fmt: skip


@pytest.mark.parametrize(("error", "rows", "words"), CASES, ids=lambda value: getattr(value, "__name__", None))
def test_faulty_block(error: type[LmicError], rows: Callable[[], Any], words: list[str]) -> None:
    with pytest.raises(error) as caught:
        term_lists(lower(statement(rows())))
    assert type(caught.value) is error
    for word in words:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_block_written_twice_as_its_own_transpose_is_accepted() -> None:
    twice = statement([[P(alpha), A.T * P(alpha)], [P(alpha) * A, P(alpha)]])
    assert set(lower(twice)["dissipation"].blocks) == {(0, 0), (0, 1), (1, 1)}


def test_used_as_a_matrix() -> None:
    for wrong in (lambda: A + 1, lambda: A - 1, lambda: 1 - A, lambda: A - mu, lambda: mu + A):
        with pytest.raises(DefinitionError, match=r"I\(n\)"):
            wrong()
    assert A - 0 == A
    with pytest.raises(DefinitionError, match="different lengths"):
        block([[A, A], [A]])
    with pytest.raises(DefinitionError, match="no LMI"):
        Theorem(lmis={}, source=SOURCE)


FOREIGN: list[tuple[Callable[[], Any], str]] = [
    (lambda: P > 0, r"P is compared with 0; write PD"),
    (lambda: P >> 0, r"P is compared with 0; write PD"),
    (lambda: P << A, r"P is compared with A\(alpha\); write PD"),
    (lambda: P - A.transpose(), r"a matrix of type Transpose .* write X\.T"),
    (lambda: A.inverse() * P, r"a matrix of type Inverse .* inv\(X\)"),
    (lambda: P + np.eye(2), r"a matrix of type ndarray .* give numbers as data"),
    (lambda: P * sp.eye(2), r"a matrix of type \w+ .* give numbers as data"),
    (lambda: dot(P * A), r"dot\(P\*A\(alpha\)\) is the derivative of an expression; .* product rule"),
    (lambda: dot(mu), r"dot\(mu\) is zero"),
    (lambda: mu(alpha), r"the scalar mu is taken at a parameter; declare it as Symmetric\('mu', 1\)"),
]


@pytest.mark.parametrize(("written", "words"), FOREIGN)
def test_words_of_other_languages(written: Callable[[], Any], words: str) -> None:
    """What CVXPY, YALMIP and sympy write is refused with what to write here."""
    with pytest.raises(DefinitionError, match=words):
        written()


@pytest.mark.parametrize("size", [dims("n"), "n", A, 2.5, -1, None])
def test_a_size_that_is_no_dimension(size: Any) -> None:
    for declare in (lambda: Data("A", n, size), lambda: Matrix("A", size, n), lambda: I(size), lambda: zeros(n, size)):
        with pytest.raises(DefinitionError, match="dimension"):
            declare()
    with pytest.raises(DefinitionError, match="dimension"):
        BlockDiagonal("A", n, size)


def test_one_name_for_two_matrices() -> None:
    other = Matrix("G", n, m)(alpha)
    with pytest.raises(DefinitionError, match="declared twice"):
        _ = statement([[He(G)], [He(other * other.T)]]).unknowns


# Plants that do not fit -----------------------------------------------------------------------------

STABILITY = Theorem(
    lmis={"decrease": ND([[-P(alpha), star], [P(alpha.next) * A, -P(alpha.next)]]), "P": PD(P(alpha))},
    source=SOURCE,
    name="stability",
)


def plant(**matrices: Any) -> Plant:
    return Plant.polytopic(**matrices)


def test_missing_and_unknown_matrices() -> None:
    with pytest.raises(PlantError, match=r"A \(n x n\) is missing"):
        compile(STABILITY, plant())
    with pytest.raises(PlantError, match="gives the matrix Q, which the theorem does not use"):
        compile(STABILITY, plant(A=[[0.5]], Q=[[1]]))


def test_wrong_shape() -> None:
    with pytest.raises(ShapeError, match=r"A of plant is 1 x 2, but n x n is needed, where n = 1 from A"):
        compile(STABILITY, plant(A=[[0.5, 1]]))


@pytest.mark.parametrize("blocks", [(1,), (1, 1, 1)])
def test_blocks_that_do_not_add_up(blocks: tuple[int, ...]) -> None:
    scaled = statement([[Symmetric("S", n, blocks=blocks) - A * A.T]])
    with pytest.raises(ShapeError, match=r"faulty: the blocks of S have the sizes 1.*, but S has 2 rows"):
        compile(scaled, plant(A=[[0.5, 0], [0, 0.5]]))


def test_wrong_domain() -> None:
    with pytest.raises(DomainError, match="alpha has no domain"):
        compile(STABILITY, Plant.polytopic("rho", A=[[0.5]]))


def test_scalars_and_dependences_have_known_names() -> None:
    with pytest.raises(PlantError, match="eps is no scalar"):
        compile(STABILITY, plant(A=[[0.5]]), {"eps": 1})
    with pytest.raises(BasisError, match="R is no unknown"):
        compile(STABILITY, plant(A=[[0.5]]), dependence={"R": 1})
    with pytest.raises(BasisError, match="linearly dependent"):
        compile(STABILITY, plant(A=[[[0.5]], [[0.4]]]), dependence={"P": ["alpha1", "alpha2", "alpha1 + alpha2"]})
    with pytest.raises(BasisError, match="negative"):
        compile(STABILITY, plant(A=[[0.5]]), dependence={"P": -1})


def test_a_given_scalar_wants_a_value_or_a_search() -> None:
    beta = given("beta")
    sought = replace(STABILITY, lmis={"a": PD(beta * P)}, bisect=Bisection(beta, "maximise"))
    with pytest.raises(
        PlantError, match="beta has no value; give it, as beta=1, or an interval to search, as beta=0:1"
    ):
        compile(sought, plant(), sizes={"n": 1})
    with pytest.raises(
        PlantError, match="rename it in the plant, or remove it there and give the theorem's, as beta=1"
    ):
        compile(sought, Plant({}, scalars={"beta": exact_number(1)}), sizes={"n": 1})


def test_a_name_of_two_scalars_is_refused() -> None:
    with pytest.raises(DefinitionError, match="mu is both a scalar unknown and a given scalar"):
        statement([[mu * I(n) + given("mu") * I(n)]])
    with pytest.raises(DefinitionError, match="P is both a scalar and a matrix unknown"):
        statement([[P(alpha) + given("P") * I(n)]])


def test_a_given_scalar_that_is_a_component_is_refused() -> None:
    """Its value would be taken for the whole interval: at beta = 0 this plant is stable, at beta = 1 it is not."""
    rho, beta = Parameter("rho"), given("beta")
    X, F = Symmetric("P", n), Data("A", n, n)(rho)
    lmis = {"positive": PD(X), "decay": ND(He(X * F) + 2 * beta * X)}
    theorem = Theorem(lmis=lmis, source=SOURCE, name="clash")
    b = sp.Symbol("beta")
    box = BoxDomain(("beta",), (Fraction(0),), (Fraction(1),))
    unstable = Plant({"A": MatrixPolynomial.from_sympy(sp.Matrix([[2 * b - 1]]))}, {"rho": box})
    with pytest.raises(PlantError, match="beta is a scalar of the theorem and a component of rho in plant; rename it"):
        compile(theorem, unstable, {"beta": 0})


def test_not_a_number() -> None:
    with pytest.raises(PlantError, match="not a finite number"):
        plant(A=[[float("nan")]])
    with pytest.raises(PlantError, match="numbers of vertices differ"):
        plant(A=[[[1]], [[2]]], B=[[[1]], [[2]], [[3]]])


def test_one_vertex_is_a_time_invariant_system() -> None:
    problem = compile(STABILITY, plant(A=[[[0.5]]]))
    assert len(problem.orders) == 2
