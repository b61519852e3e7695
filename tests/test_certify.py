"""Enclosures against independent values, infeasibility, and grids refined until the whole domain is proven."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from lmic import library
from lmic.algebra.polynomials import MatrixPolynomial
from lmic.certify import document
from lmic.certify.certificate import Certificate, Standing, Unknown
from lmic.certify.certify import certify, refutation
from lmic.certify.finite import Coefficient, Functional
from lmic.certify.infeasible import Infeasible
from lmic.certify.lower import Dual, Pivot
from lmic.certify.refine import certify_domain
from lmic.certify.statement import fractions
from lmic.certify.verify import verify
from lmic.dsl import PD, Bisection, Box, Data, I, Scalar, Source, Theorem, given, star
from lmic.papers.enclosures import Enclosure
from lmic.pipeline import compile, prepare, run
from lmic.plants.domains import BoxDomain
from lmic.plants.files import read_plant
from lmic.plants.plant import Plant
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation
from lmic.reporting import infeasibility, unproven

ROOT = library.root()
EXAMPLE_1 = ROOT / "peixoto2025" / "example1.toml"
SECTION_5 = ROOT / "wu2007" / "example.toml"

#: optima of the relaxed problems from an independent SDPA solution in 200-bit arithmetic
REFERENCE = {"peixoto2025.theorem1": "1.213769249285198035", "peixoto2025.corollary1": "8.171543751332294879"}

#: r = (1, 0) alone at all three places
POINT = Relaxation(grid={"r": Grid.at([[1, 0]])}, ties={"b": "a", "c": "a"})


@pytest.mark.parametrize("name", list(REFERENCE))
def test_table_1_is_enclosed(name: str) -> None:
    result = run(compile(library.theorem(name), read_plant(EXAMPLE_1), {"eps": 150}))
    found = certify(result, given={"eps": 150})
    assert found.standing is Standing.CERTIFIED
    assert found.lower and found.upper
    lower, upper = found.lower.reports["gamma"], found.upper.reports["gamma"]
    assert lower <= Fraction(REFERENCE[name]) <= upper
    assert (upper - lower) / upper <= 1e-6


def test_a_norm_known_by_hand_is_enclosed(first_order: Certificate) -> None:
    assert first_order.lower and first_order.upper
    lower, upper = first_order.lower.reports["gamma"], first_order.upper.reports["gamma"]
    assert lower <= 2 <= upper
    assert upper - lower <= 2e-6
    assert verify(first_order).holds


@pytest.mark.parametrize(("name", "printed"), [("wu2007.theorem3", "1.8469"), ("wu2007.theorem6", "1.3632")])
def test_printed_values_are_refuted_at_one_point(name: str, printed: str) -> None:
    """At the frozen r = (1, 0), which every gridding of the paper's box contains."""
    result = run(compile(library.theorem(name), read_plant(SECTION_5), relaxation=POINT))
    found, report, lower = refutation(result, POINT)
    assert report == "gamma"
    assert lower > Fraction(printed)
    verdict = verify(found)
    assert verdict.holds, verdict.reason
    assert verdict.about_theorem


def test_a_lower_bound_is_never_above_what_is_reached(table_1: Certificate) -> None:
    """The dual proves its bound for the exact problem; a claim one unit larger is refused."""
    assert table_1.lower
    larger = {name: value * (1 + Fraction(1, 10**7)) for name, value in table_1.lower.reports.items()}
    assert not verify(replace(table_1, lower=replace(table_1.lower, reports=larger))).holds
    assert table_1.upper
    smaller = {name: value * (1 - Fraction(1, 10**7)) for name, value in table_1.upper.reports.items()}
    assert not verify(replace(table_1, upper=replace(table_1.upper, reports=smaller))).holds


def largest_root() -> Theorem:
    """The largest x with x² < 2, which is √2, and its multiple and root."""
    x = Scalar("x")
    return Theorem(
        lmis={"square": PD([[2 * I(1), x * I(1)], [star, I(1)]])},
        source=Source("N. N.", "A test", "unpublished", 2026),
        minimise=-x,
        reports={"x": x, "twice": 2 * x, "root": sp.sqrt(x)},
        name="largest",
    )


def test_what_is_maximised_is_enclosed() -> None:
    """The point proves the lower end and the dual matrices the upper one; neither can be claimed a bit better."""
    theorem = largest_root()
    found = certify(run(compile(theorem, Plant({}, name="none"))))
    assert verify(found, theorem).holds
    for report, square in {"x": 2, "twice": 8, "root": 2}.items():
        power = 4 if report == "root" else 2
        lower, upper = found.ends(report, theorem)
        assert lower is not None
        assert upper is not None
        assert lower**power <= square <= upper**power
        assert upper - lower <= 1e-6
        assert found.lower and found.upper
        better = {**found.upper.reports, report: lower * (1 + Fraction(1, 10**7))}
        assert not verify(replace(found, upper=replace(found.upper, reports=better)), theorem).holds
        smaller = {**found.lower.reports, report: upper * (1 - Fraction(1, 10**7))}
        assert not verify(replace(found, lower=replace(found.lower, reports=smaller)), theorem).holds


def test_a_bisected_scalar_is_bounded_on_the_side_where_the_lmis_hold() -> None:
    """k = 1.4 is reached, so the largest k is at least that; nothing is said of how large it can be."""
    k, x = given("k"), Scalar("x")
    theorem = Theorem(
        lmis={"square": PD([[2 * I(1), k * I(1)], [star, x * I(1)]]), "x": PD(I(1) - x * I(1))},
        source=Source("N. N.", "A test", "unpublished", 2026),
        bisect=Bisection(k, "maximise"),
        reports={"k": k},
        name="largest",
    )
    values = {"k": Fraction(7, 5)}
    found = certify(run(compile(theorem, Plant({}, name="none"), values)), given=values)
    assert verify(found, theorem).holds
    assert found.ends("k", theorem) == (Fraction(7, 5), None)
    assert unproven(theorem, "k") == "given, and the LMIs hold"


def contradiction(largest: int) -> tuple[Certificate, Theorem]:
    """1 ≤ x ≤ ``largest``, with the dual that adds the two LMIs up: (x − 1) + (largest − x)."""
    x = Scalar("x")
    theorem = Theorem(
        lmis={"low": PD([[x * I(1) - I(1)]]), "high": PD([[largest * I(1) - x * I(1)]])},
        title="Contradiction",
        source=Source("N. N.", "A test", "unpublished", 2026),
        minimise=x,
        reports={"x": x},
    )
    dual = Dual((fractions([[1]]), fractions([[1]])), (None, None), (Pivot(0, 0, 0, 0),))
    claim = Infeasible((Functional("low", ()), Functional("high", ())), dual, None, Fraction(0))
    unknowns = {"x": Unknown((sp.Integer(1),), ())}
    found = Certificate("contradiction", Plant({}), "", {}, {}, {}, unknowns, None, None, claim, (), "by hand", {})
    return found, theorem


def test_infeasibility_needs_a_dual_that_shows_it() -> None:
    assert verify(*contradiction(0)).holds
    assert verify(*contradiction(1)).holds  # x > 1 and x < 1
    assert verify(*contradiction(2)).reason.endswith("do not show that the LMIs have no solution")
    certificate, theorem = contradiction(0)
    assert certificate.infeasible
    crooked = Dual((fractions([[1]]), fractions([[2]])), (None, None), ())
    assert not verify(replace(certificate, infeasible=replace(certificate.infeasible, dual=crooked)), theorem).holds
    nothing = Dual((fractions(np.zeros((0, 0))),) * 2, (np.zeros((1, 0), dtype=object),) * 2, ())
    assert not verify(replace(certificate, infeasible=replace(certificate.infeasible, dual=nothing)), theorem).holds


def test_a_face_that_makes_every_dual_matrix_zero_shows_nothing() -> None:
    """Z = V W Vᵀ with V = 0 satisfies every equality, whatever the LMIs are; 1 ≤ x ≤ 2 has solutions."""
    certificate, theorem = contradiction(2)
    assert certificate.infeasible
    empty = np.zeros((1, 1), dtype=object)
    dual = Dual((fractions([[1]]), fractions([[1]])), (empty, empty), ())
    assert not verify(replace(certificate, infeasible=replace(certificate.infeasible, dual=dual)), theorem).holds


def test_an_upper_bound_on_a_margin_is_rounded_upwards() -> None:
    certificate, _ = contradiction(0)
    assert certificate.infeasible
    claim = replace(certificate.infeasible, radius=Fraction(1), margin=Fraction(124, 10**9))
    assert "a least eigenvalue above 1.3e-07" in infeasibility(replace(certificate, infeasible=claim))


@pytest.fixture
def above() -> tuple[Certificate, Theorem]:
    """The certificate of the least μ above ρ on [1, 2], which is 2, and its theorem."""
    mu, rho = Scalar("mu"), Box("rho")
    theorem = Theorem(
        lmis={"above": PD(mu * I(1) - Data("A", 1, 1)(rho))},
        source=Source("N. N.", "A test", "unpublished", 2026),
        minimise=mu,
        reports={"mu": mu},
        name="above",
    )
    r = sp.Symbol("r")
    plant = Plant(
        {"A": MatrixPolynomial.from_sympy(sp.Matrix([[r]]))}, {"rho": BoxDomain(("r",), (Fraction(1),), (Fraction(2),))}
    )
    return certify(run(compile(theorem, plant))), theorem


def test_one_symbol_on_two_axes_is_no_point_of_the_domain(above: tuple[Certificate, Theorem]) -> None:
    """Twice ρ = 2 would be the LMI at ρ = 4, from which the false bound 4 follows."""
    certificate, theorem = above
    assert certificate.lower
    assert verify(certificate, theorem).holds
    axis = Coefficient((sp.Symbol("r"),), ((Fraction(2),),), (1,))
    dual = Dual((fractions([[1]]),), (None,), ())
    at_two = replace(
        certificate.lower, reports={"mu": Fraction(2)}, functionals=(Functional("above", (axis,)),), dual=dual
    )
    assert verify(replace(certificate, lower=at_two), theorem).holds
    at_four = replace(at_two, reports={"mu": Fraction(4)}, functionals=(Functional("above", (axis, axis)),))
    assert "outside the domain" in verify(replace(certificate, lower=at_four), theorem).reason


def test_a_file_that_a_certificate_names_is_not_run(first_order: Certificate, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text("from pathlib import Path\nPath(__file__).with_name('run').touch()\n")
    for name in (str(tmp_path / "mine.py"), f"{tmp_path / 'mine.py'}:robust"):
        verdict = verify(replace(first_order, theorem=name))
        assert verdict.reason.endswith("is not one of the library; name its file with --theorem")
    assert not (tmp_path / "run").exists()
    assert "with --theorem" in verify(replace(first_order, theorem="mine")).reason


def test_shown_ends_are_rounded_outwards() -> None:
    ends = Enclosure(Standing.CERTIFIED, Fraction(2, 3), Fraction(2, 3), True)
    assert str(ends) == "[0.666666666, 0.666666667]"
    for value in (Fraction(1, 10**400), Fraction(10**400, 3)):
        assert 0 < document.decimal_below(value) <= value <= document.decimal_above(value)
        assert 0 < document.root_below(value) ** 2 <= value <= document.root_above(value) ** 2
    for value in (Fraction(2, 3), Fraction(-1, 10), Fraction(1, 4)):
        assert Fraction(document.float_below(value)) <= value <= Fraction(document.float_above(value))
    assert document.float_below(Fraction(1, 4)) == document.float_above(Fraction(1, 4)) == 0.25


@pytest.fixture
def bent() -> Plant:
    """x⁺ = w, z = (1 + ρ − ρ²)x with ρ in [0, 1]: the gain is 5/4, at ρ = 1/2, and 1 at both ends."""
    rho = sp.Symbol("rho1")
    matrices = {"A": [[0]], "B": [[1]], "C": [[1 + rho - rho**2]], "D": [[0]]}
    domain = BoxDomain(("rho1",), (Fraction(0),), (Fraction(1),))
    return Plant({k: MatrixPolynomial.from_sympy(sp.Matrix(m)) for k, m in matrices.items()}, {"rho": domain})


def test_a_grid_is_refined_until_the_whole_domain_is_proven(bent: Plant) -> None:
    binding = prepare(library.theorem("standard.bounded_real_discrete"), bent)
    found = certify_domain(binding, Relaxation(grid={"rho": 2}))
    assert found.values[0] == pytest.approx(1, rel=1e-6)
    assert found.certificate.standing is Standing.CERTIFIED
    assert found.certificate.upper
    upper = found.certificate.upper.reports["gamma"]
    assert Fraction(5, 4) <= upper <= Fraction(5, 4) * (1 + Fraction(1, 1000))
    assert verify(found.certificate).holds


def test_a_grid_alone_is_certified_on_the_grid(bent: Plant) -> None:
    """γ = 1 holds at both ends and not between them: it is never called certified on the domain."""
    relaxation = Relaxation(grid={"rho": 2})
    problem = compile(library.theorem("standard.bounded_real_discrete"), bent, relaxation=relaxation)
    found = certify(run(problem), relaxation)
    assert found.standing is Standing.GRID
    assert verify(found).holds
    assert found.upper
    widened = replace(found, upper=replace(found.upper, functionals=()))
    assert "does not hold at" in verify(widened).reason
