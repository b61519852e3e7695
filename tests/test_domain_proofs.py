"""Proofs on whole domains: matrices whose sign is known by construction are never judged wrongly."""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np
import pytest
import sympy as sp

from lmic.algebra.functions import exponential
from lmic.algebra.polynomials import MatrixPolynomial, atom_values
from lmic.certify.domain import ProofAxis, ProofDomain, Proven, Undecided, Witness, proof_domain, prove_positive
from lmic.certify.polytopes import joint_step, rates
from lmic.errors import CertificateError
from lmic.language.parameters import Parameter
from lmic.plants import domains
from lmic.plants.domains import BoxDomain, Motion, SimplexDomain
from lmic.plants.expressions import Where

F, Q = Fraction, sp.Rational
x, y = sp.symbols("x y")
BOX = ProofDomain((ProofAxis((x,), ((F(0),), (F(1),))), ProofAxis((y,), ((F(-1),), (F(1),)))))
SIMPLEX = proof_domain({"alpha": SimplexDomain.named("alpha", 3)}, {"alpha": [Parameter("alpha")]})
a1, a2, a3 = sp.symbols("alpha1:4")


def prove(matrix: object, domain: ProofDomain = BOX, budget: int = 2000) -> Proven | Witness | Undecided:
    return prove_positive(MatrixPolynomial.from_sympy(sp.Matrix(matrix)), domain, budget)


def value(matrix: object, witness: Witness) -> sp.Matrix:
    return sp.Matrix(matrix).xreplace({s: Q(v.numerator, v.denominator) for s, v in witness.point.items()})


def test_affine_is_decided_at_the_vertices() -> None:
    assert prove([[2, x], [x, 1]]) == Proven("vertices", 2)
    assert prove([[1, x], [x, 1]]).point[x] == 1  # type: ignore[union-attr]
    assert prove([[Q(1)]]) == Proven("vertices", 1)
    assert isinstance(prove([[Q(0)]]), Witness)


def squares(seed: int) -> sp.Matrix:
    """Σ of squares vᵀv with entries that vanish at one point of the box, so the sum touches zero there."""
    generator = random.Random(seed)
    order = generator.randint(1, 3)
    point = {s: Q(generator.randint(1, 6), 7) for s in (x, y)}
    rows = [
        [sum(generator.randint(-3, 3) * (s - point[s]) for s in (x, y)) for _ in range(order)] for _ in range(order)
    ]
    return (sp.Matrix(rows).T * sp.Matrix(rows)).applyfunc(sp.expand)


@pytest.mark.parametrize("start", range(0, 350, 50))
def test_polynomials_of_known_sign(start: int) -> None:
    """Squares + ε are proven; what touches zero or dips below it never is. 1,050 cases in all."""
    for seed in range(start, start + 50):
        matrix = squares(seed)
        one = sp.eye(matrix.rows)
        assert isinstance(prove(matrix + one / 50, budget=3000), Proven), seed
        for shift in (0, -Q(1, 10**9)):
            verdict = prove(matrix + shift * one, budget=25)
            assert not isinstance(verdict, Proven), seed
            if isinstance(verdict, Witness):
                at = value(matrix + shift * one, verdict)
                assert not all(at[:k, :k].det() > 0 for k in range(1, at.rows + 1)), seed


def test_a_tiny_negative_region_is_found() -> None:
    dip = [[(x - Q(1, 3)) ** 2 + y**2 - Q(1, 10**6)]]
    verdict = prove(dip)
    assert isinstance(verdict, Witness)
    assert value(dip, verdict)[0] <= 0


def test_a_touching_zero_off_every_corner_stays_undecided_near_it() -> None:
    verdict = prove([[(x - Q(1, 3)) ** 2]], budget=100)
    assert isinstance(verdict, Undecided)
    assert abs(verdict.point[x] - F(1, 3)) < F(1, 1000)


def test_on_a_simplex_the_sum_is_one() -> None:
    """Σα² ≥ 1/3, with equality in the middle."""
    form = a1**2 + a2**2 + a3**2 - Q(1, 3)
    assert isinstance(prove([[form + Q(1, 100)]], SIMPLEX), Proven)
    assert isinstance(prove([[form - Q(1, 10**5)]], SIMPLEX), Witness)


@pytest.mark.parametrize("turn", [1, 3, 7])
def test_rotations(turn: int) -> None:
    """R diag(1, d) Rᵀ has the eigenvalues 1 and d at every angle; d is negative on a short interval, or nowhere."""
    c, s = sp.cos(turn * x), sp.sin(turn * x)
    rotation = sp.Matrix([[c, -s], [s, c]])
    for dip, wanted in ((Q(1, 100), Proven), (-Q(1, 10**4), Witness)):
        turned = (rotation * sp.diag(1, (x - Q(1, 3)) ** 2 + dip) * rotation.T).applyfunc(sp.expand)
        verdict = prove(turned)
        assert isinstance(verdict, wanted)
        assert not isinstance(verdict, Proven) or verdict.method == "balls"


@pytest.mark.parametrize(
    ("function", "least"),
    [
        (sp.exp(x) - x, 1),
        (sp.sin(3 * x) - x, sp.sin(3) - 1),
        (sp.sqrt(1 + x) - x / 2, sp.sqrt(2) - Q(1, 2)),
        (sp.log(1 + x) - x, sp.log(2) - 1),
        (1 / (1 + x), Q(1, 2)),
        (sp.cosh(x) - sp.sinh(x), sp.exp(-1)),
        (sp.tanh(x) - x, sp.tanh(1) - 1),
        (sp.tan(x) - x, 0),
        (sp.Abs(x - Q(1, 3)), 0),
        (-sp.Abs(x - Q(1, 2)), -Q(1, 2)),
        (x * sp.exp(-sp.Abs(y)), 0),
        (sp.sin(x * y), -sp.sin(1)),
        (sp.exp(x + y) * sp.cos(y), sp.exp(-1) * sp.cos(1)),
        (Where(x, Q(1, 3), sp.Integer(2), sp.Integer(1)) + y, 0),
        (sp.pi * x + sp.sqrt(2), sp.sqrt(2)),
    ],
)
def test_functions_against_their_least_values(function: sp.Expr, least: sp.Expr) -> None:
    least = Q(str(sp.N(least, 20)))
    assert isinstance(prove([[function - least + Q(1, 100)]]), Proven)
    below = prove([[function - least - Q(1, 100)]])
    assert isinstance(below, Witness)
    assert float(value([[function - least]], below)[0]) < 0.01 + 1e-12


def test_random_transcendental_matrices_are_never_proven_below_zero() -> None:
    """A Gram matrix of functions of (f(x) − f(p)) is singular at p, whatever f is: 200 cases."""
    functions = (sp.exp(x), sp.sin(2 * x), sp.cos(3 * x), sp.log(1 + x), sp.sqrt(2 + x), 1 / (2 + x))
    for seed in range(200):
        generator = random.Random(seed)
        point = Q(generator.randint(1, 6), 7)
        column = sp.Matrix([f - f.subs(x, point) for f in generator.sample(functions, 2)])
        gram = (column * column.T).applyfunc(sp.expand) + sp.diag(0, 1)
        assert not isinstance(prove(gram, budget=20), Proven), seed


def test_matrix_exponentials_are_enclosed() -> None:
    """Of rotations exp(xM) is a cosine, least at cos 3; of random M it is never proven above a value it takes."""
    interval = ProofDomain((ProofAxis((x,), ((F(0),), (F(3),))),))
    cosine = exponential(sp.Matrix([[0, -1], [1, 0]]), x, 1, slice(0, 1))[0]
    assert prove([[cosine + Q(1)]], interval) == Proven("balls", prove([[cosine + Q(1)]], interval).cells)
    assert isinstance(prove([[cosine + Q(98, 100)]], interval), Witness)
    for seed in range(50):
        generator = random.Random(seed)
        M = sp.Matrix(3, 3, [Q(generator.randint(-9, 9), 4) for _ in range(9)])
        entry = exponential(M, x, 3, slice(None))[generator.randrange(9)]
        values = atom_values(entry, {x: np.linspace(0, 1, 101)})
        unit = 1 + np.abs(values).max()
        least = Q(float(values.min()))
        assert not isinstance(prove([[entry - least - Q(unit) / 10**6]], budget=200), Proven), seed
        assert isinstance(prove([[entry - least + Q(unit) / 20]]), Proven), seed


def test_instances_ties_and_motion_become_axes() -> None:
    box = BoxDomain(("r1", "r2"), (F(-1), F(0)), (F(1), F(1)))
    r = Parameter("r")
    free = proof_domain({"r": box}, {"r": [r, r.copy("a"), r.copy("b")]}, ties={"b": "a"})
    assert [str(axis.symbols[0]) for axis in free.axes] == ["r1", "r2", "r1@a", "r2@a"]
    assert free.equal == {sp.Symbol("r1@b"): sp.Symbol("r1@a"), sp.Symbol("r2@b"): sp.Symbol("r2@a")}
    constant = proof_domain({"r": box}, {"r": [r, r.next]}, {"r": Motion("constant")})
    assert len(constant.axes) == 2
    bounded = proof_domain({"r": box}, {"r": [r, r.next]}, {"r": Motion({"r1": F(1, 3), "r2": F(1, 7)})})
    assert [len(axis.points) for axis in bounded.axes] == [6, 6]
    moved, now = sp.symbols("r1+ r1")
    assert isinstance(prove([[Q(1, 3) + Q(1, 100) - (moved - now)]], bounded), Proven)
    assert isinstance(prove([[Q(1, 3) - (moved - now)]], bounded), Witness)
    assert isinstance(prove([[Q(1, 9) + Q(1, 100) - (moved - now) ** 2]], bounded), Proven)


def test_circular_ties_are_an_error() -> None:
    r = Parameter("r")
    with pytest.raises(CertificateError, match="circle"):
        proof_domain(
            {"r": BoxDomain(("r",), (F(0),), (F(1),))},
            {"r": [r.copy("a"), r.copy("b")]},
            ties={"a": "b", "b": "a"},
        )


@pytest.mark.parametrize("size", [2, 3])
def test_exact_polytopes_agree_with_the_floating_ones(size: int) -> None:
    simplex = SimplexDomain.named("alpha", size)
    bounds = dict.fromkeys(simplex.components, F(1, 10))
    for exact, rounded in (
        (joint_step(simplex, bounds), domains.joint_step(simplex, bounds)),
        (rates(simplex, bounds), domains.rate_polytope(simplex, bounds)),
    ):
        mine = np.array(sorted(exact.vertices), dtype=float)
        assert np.allclose(mine, np.array(sorted(map(tuple, np.round(rounded.vertices, 9)))), atol=1e-8)


def test_errors_say_what_is_missing() -> None:
    with pytest.raises(CertificateError, match="z has no domain"):
        prove([[sp.Symbol("z")]])
    with pytest.raises(CertificateError, match="not symmetric"):
        prove([[1, x], [0, 1]])
    with pytest.raises(CertificateError, match="no ball arithmetic"):
        prove([[sp.gamma(1 + x)]])
