"""Certificates: enclosures against independent values, and no proof of anything false."""

from __future__ import annotations

import json
import random
import re
from dataclasses import replace
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from click.testing import CliRunner
from conftest import direct

from lmic import library
from lmic.algebra import svec
from lmic.algebra.polynomials import MatrixPolynomial
from lmic.certify import document
from lmic.certify.certificate import Certificate, Standing, Unknown
from lmic.certify.certificate_file import checksum, parsed, read_certificate, text, write_certificate
from lmic.certify.certify import certify, refutation
from lmic.certify.finite import Coefficient, Functional, finite_problem
from lmic.certify.infeasible import Infeasible
from lmic.certify.lower import Dual, Pivot
from lmic.certify.refine import certify_domain
from lmic.certify.region import region
from lmic.certify.relaxed import functionals
from lmic.certify.statement import Statement, fractions
from lmic.certify.verify import verify
from lmic.cli import main
from lmic.dsl import PD, Bisection, Box, Data, I, Scalar, Source, Theorem, given, star
from lmic.errors import CertificateError
from lmic.language.parameters import instance_symbol
from lmic.papers.enclosures import Enclosure
from lmic.pipeline import compile, prepare, run
from lmic.plants.domains import BoxDomain
from lmic.plants.files import read_plant
from lmic.plants.plant import Plant, exact_array
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


@pytest.fixture(scope="module")
def first_order() -> Certificate:
    """x⁺ = x/2 + w, z = x: the gain is 1/(1 − 1/2) = 2."""
    matrices = {"A": [[0.5]], "B": [[1]], "C": [[1]], "D": [[0]]}
    plant = Plant({k: MatrixPolynomial.constant(exact_array(m, k)) for k, m in matrices.items()}, name="first order")
    return certify(run(compile(library.theorem("standard.bounded_real_discrete"), plant)))


@pytest.fixture(scope="module")
def table_1() -> Certificate:
    """Table 1 of Peixoto et al. (2025), parameter-dependent."""
    result = run(compile(library.theorem("peixoto2025.theorem1"), read_plant(EXAMPLE_1), {"eps": 150}))
    return certify(result, given={"eps": 150})


# Enclosures -----------------------------------------------------------------------------------------


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


# The statement ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "plant", "given"),
    [
        ("peixoto2025.theorem1", EXAMPLE_1, {"eps": 150}),
        ("wu2007.theorem3", SECTION_5, {}),
        ("wu2007.theorem6", SECTION_5, {}),
        ("delay_lpv.theorem3", ROOT / "delay_lpv" / "stand_in.toml", None),
    ],
)
def test_exact_matrices_equal_the_theorem_evaluated_directly(name: str, plant: Path, given: Any) -> None:
    theorem, data = library.theorem(name), read_plant(plant)
    given = {symbol.name: 2 for symbol in theorem.givens} if given is None else given
    grid = Relaxation(grid={p: 2 for p, d in data.domains.items() if d.kind == "box"})
    problem = compile(theorem, data, given, relaxation=grid)
    generator = np.random.default_rng(3)
    x = generator.standard_normal(problem.size)
    statement = Statement(theorem, data, {**data.scalars, **{k: Fraction(v) for k, v in given.items()}}, {})
    unknowns = {
        key: statement.value(key, dict(zip(u.functions, map(fractions, u.matrices(x)), strict=True)))
        for key, u in problem.layout.unknowns.items()
    }
    symbols = {
        instance_symbol(component, p.instance)
        for parameter, found in problem.binding.instances.items()
        for p in found
        for component in data.domains[parameter].components
    }
    values: dict[sp.Symbol, float] = {s: float(generator.random()) for s in sorted(symbols, key=str)}
    values |= {sp.Symbol(key): float(value) for key, value in {**data.scalars, **given}.items()}
    for lmi in theorem.lmis:
        exact = statement.matrix(lmi, unknowns).evaluate({s: np.array([v]) for s, v in values.items()})[0]
        expected = direct(theorem.lmis[lmi], problem.binding, x, values)
        assert np.abs(exact - expected).max() <= 1e-12 * max(1.0, np.abs(expected).max())


@pytest.mark.parametrize(
    ("name", "plant", "given", "relaxation"),
    [
        ("peixoto2025.theorem1", EXAMPLE_1, {"eps": 150}, Relaxation(polya={"alpha": 1})),
        ("wu2007.theorem3", SECTION_5, {}, POINT),
    ],
)
def test_the_exact_finite_problem_is_the_compiled_one(
    name: str, plant: Path, given: dict[str, Any], relaxation: Relaxation
) -> None:
    problem = compile(library.theorem(name), read_plant(plant), given, relaxation=relaxation)
    statement = Statement(
        problem.binding.theorem, problem.binding.plant, {k: Fraction(v) for k, v in given.items()}, {}
    )
    domain = region(statement, relaxation.ties)
    chosen = functionals(problem, relaxation, domain)
    basis = {key: unknown.functions for key, unknown in problem.layout.unknowns.items()}
    exact = finite_problem(statement, basis, domain.equal, chosen)
    compiled = problem.columns.toarray()
    for k, lmi in enumerate(exact.lmis):
        dense = np.zeros((svec.length(lmi.order), problem.size + 1))
        dense[svec.packed_index(lmi.rows, lmi.cols), lmi.columns] = lmi.values.astype(float)
        rows = slice(problem.starts[k], problem.starts[k + 1])
        assert np.abs(dense * svec.weights(lmi.order)[:, None] - compiled[rows]).max() < 1e-12
    assert (exact.cost.astype(float) == problem.cost).all()


def test_coefficients_sum_to_the_polynomial() -> None:
    """Σ_k coefficient_k λ^k at any λ on the simplex is the monomial's value at Σ_v λ_v V_v."""
    corners = ((Fraction(1), Fraction(2)), (Fraction(-1), Fraction(1, 3)), (Fraction(1, 2), Fraction(0)))
    symbols = (sp.Symbol("a"), sp.Symbol("b"))
    weights = (Fraction(1, 2), Fraction(1, 3), Fraction(1, 6))
    place = [sum(w * c[i] for w, c in zip(weights, corners, strict=True)) for i in range(2)]
    for exponents in [(0, 0), (1, 0), (2, 1), (0, 3)]:
        total = Fraction(0)
        for powers in product(range(5), repeat=3):
            if sum(powers) == 4:
                monomial = np.prod([w**p for w, p in zip(weights, powers, strict=True)])
                total += Coefficient(symbols, corners, powers).weight(exponents) * monomial
        assert total == place[0] ** exponents[0] * place[1] ** exponents[1]


# Files -------------------------------------------------------------------------------------------------


def test_a_certificate_is_read_as_it_was_written(table_1: Certificate, tmp_path: Path) -> None:
    path = tmp_path / "table1.json"
    write_certificate(table_1, path)
    again = read_certificate(path)
    assert text(again) == text(table_1)
    verdict = verify(again)
    assert verdict.holds
    assert again.library_plant == "peixoto2025/example1.toml"


def test_a_thousand_corrupted_files_are_rejected(first_order: Certificate) -> None:
    """A digit, letter or sign changed, a byte lost or doubled, anywhere in the file."""
    content = text(first_order).encode()
    generator = random.Random(5)
    for number in range(1100):
        place = generator.randrange(len(content))
        if number % 2 == 0:
            place = generator.choice([m.start() for m in re.finditer(rb"\d", content)])
            other = generator.choice([d for d in b"0123456789" if d != content[place]])
            changed = content[:place] + bytes([other]) + content[place + 1 :]
        elif number % 4 == 1:
            changed = content[:place] + content[place + 1 :]
        else:
            changed = content[:place] + content[place : place + 1] + content[place:]
        if _same_json(changed, content):
            continue  # white space between the tokens, which states nothing
        with pytest.raises(CertificateError):
            verdict = verify(parsed(changed))
            raise CertificateError(verdict.reason) if not verdict.holds else AssertionError(changed)


def _same_json(first: bytes, second: bytes) -> bool:
    try:
        return bool(json.loads(first) == json.loads(second))
    except ValueError:
        return False


def _tables(certificate: Certificate) -> dict[str, Any]:
    tables = json.loads(text(certificate))
    del tables["sha256"]
    return tables


def test_without_the_checksum_what_is_accepted_is_true(first_order: Certificate) -> None:
    """A digit changed and the checksum made to fit: whatever still is proven holds by hand.

    The norm of d + cb/(z − a) is that at z = 1 or at z = −1.
    """
    body = json.dumps(_tables(first_order))
    digits = [m.start() for m in re.finditer(r"\d", body)]
    generator = random.Random(11)
    accepted = 0
    for _ in range(300):
        place = generator.choice(digits)
        changed = json.loads(body[:place] + generator.choice("0123456789") + body[place + 1 :])
        try:
            found = parsed(json.dumps(changed | {"sha256": checksum(changed)}).encode())
        except CertificateError:
            continue
        if not verify(found).holds:
            continue
        accepted += 1
        a, b, c, d = (found.plant.matrices[name].coefficients[0, 0, 0] for name in "ABCD")
        assert found.lower
        assert _holds_by_hand(found)
        assert found.lower.reports["gamma"] <= max(abs(d + c * b / (1 - a)), abs(d - c * b / (1 + a)))
    assert 20 < accepted < 280


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"theorem": "standard.stability_discrete"}, "report|unknowns|matrix"),
        ({"library_plant": "wu2007/example.toml"}, "are not those of the library"),
        ({"library_plant": "../pyproject.toml"}, "the library has no plant"),
        ({"scalars": {"eps": "1"}}, "the scalars are eps"),
        ({"unknowns": []}, "the unknowns are none"),
        ({"upper": None, "lower": None, "standing": "numerical"}, "states nothing"),
        ({"upper": None}, "calls itself"),
        ({"extra": 1}, "'extra'"),
        ({"scalars": {"eps": 1.5}}, "not exact"),
    ],
)
def test_damage_that_keeps_the_checksum_is_named(first_order: Certificate, change: dict[str, Any], reason: str) -> None:
    tables = _tables(first_order) | change
    content = json.dumps(tables | {"sha256": checksum(tables)}).encode()
    with pytest.raises(CertificateError, match=reason):
        verdict = verify(parsed(content))
        assert not verdict.holds
        raise CertificateError(verdict.reason)


@pytest.mark.parametrize("content", [b"", b"[]", b"{}", b"\xff", b"[" * 10_000, b'{"format": 1, "format": 2}', b"null"])
def test_what_is_no_certificate_is_refused(content: bytes) -> None:
    with pytest.raises(CertificateError):
        parsed(content)


def test_a_certificate_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    for name in ("absent.json", ".", "a\0b"):
        with pytest.raises(CertificateError, match=r"; (check|give) the path"):
            read_certificate(tmp_path / name)


def test_plants_survive_their_text() -> None:
    for file in sorted(ROOT.glob("*/*.toml")):
        if file.name != "cases.toml":
            plant = read_plant(file)
            assert document.same_plant(document.read_plant_tables(document.plant_tables(plant)), plant)


def test_numbers_survive_their_text() -> None:
    generator = random.Random(1)
    for _ in range(300):
        value = Fraction(generator.randint(-(10**9), 10**9), generator.choice([1, 3, 7, 2**5, 2**70, 10**6]))
        assert document.number(document.number_text(value)) == value
        assert document.decimal_below(value) <= value <= document.decimal_above(value)
        root = document.root_below(abs(value)), document.root_above(abs(value))
        assert root[0] ** 2 <= abs(value) <= root[1] ** 2
        assert root[1] - root[0] <= Fraction(1, 10**13) * root[1]


# Nothing false is proven -----------------------------------------------------------------------------


def test_mutated_problems_are_judged_as_exact_arithmetic_judges_them(first_order: Certificate) -> None:
    """1,000 certificates with an entry nudged, by a little or by much, against the LMI worked out by hand.

    The bounded-real lemma of x⁺ = ax + bw, z = cx + dw is
    [[P, 0, aP, c], [0, γ, bP, d], [aP, bP, P, 0], [c, d, 0, γ]] ≻ 0.
    """
    generator = random.Random(7)
    verdicts = []
    for _ in range(1000):
        nudge = Fraction(generator.choice([-1, 1]), 10 ** generator.randint(1, 12))
        changed = _nudged(first_order, generator.choice([*first_order.unknowns, "A", "B", "C", "D", "gamma"]), nudge)
        verdict = verify(replace(changed, lower=None))
        assert verdict.holds == _holds_by_hand(changed), verdict.reason
        verdicts.append(verdict.holds)
    assert 200 < sum(verdicts) < 800


def _nudged(certificate: Certificate, what: str, nudge: Fraction) -> Certificate:
    assert certificate.upper
    if what == "gamma":
        reports = {name: value + nudge for name, value in certificate.upper.reports.items()}
        return replace(certificate, upper=replace(certificate.upper, reports=reports))
    if what in certificate.unknowns:
        unknown = certificate.unknowns[what]
        moved = Unknown(unknown.functions, tuple(m + nudge for m in unknown.matrices))
        return replace(certificate, unknowns={**certificate.unknowns, what: moved})
    matrices = dict(certificate.plant.matrices)
    matrices[what] = replace(matrices[what], coefficients=matrices[what].coefficients + nudge)
    return replace(certificate, plant=replace(certificate.plant, matrices=matrices))


def _holds_by_hand(certificate: Certificate) -> bool:
    """By the leading minors of the 4 x 4 matrix, and the claim by comparison."""
    assert certificate.upper
    a, b, c, d = (certificate.plant.matrices[name].coefficients[0, 0, 0] for name in "ABCD")
    P, gamma = (certificate.unknowns[name].matrices[0][0, 0] for name in ("P", "gamma"))
    F = [[P, 0, a * P, c], [0, gamma, b * P, d], [a * P, b * P, P, 0], [c, d, 0, gamma]]
    minors = [_determinant([row[:k] for row in F[:k]]) for k in range(1, 5)]
    return min(minors) > 0 and certificate.upper.reports["gamma"] >= gamma


def _determinant(rows: list[list[Fraction]]) -> Fraction:
    if not rows:
        return Fraction(1)
    head, *tail = rows
    return sum(
        ((-1) ** j * entry * _determinant([row[:j] + row[j + 1 :] for row in tail]) for j, entry in enumerate(head)),
        Fraction(0),
    )


# Command line ------------------------------------------------------------------------------------------


def test_solve_certify_verify_refute(tmp_path: Path) -> None:
    runner, path = CliRunner(), tmp_path / "table1.json"
    command = ["solve", "peixoto2025.theorem1", "--plant", str(EXAMPLE_1), "--set", "eps=150"]
    record = json.loads(runner.invoke(main, [*command, "--certify", str(path), "--json"]).output)
    assert record["soundness"] == "certified"
    assert record["lower"]["gamma"] <= record["reports"]["gamma"] <= record["upper"]["gamma"]
    assert record["certificate"] == str(path)
    shown = runner.invoke(main, ["verify", str(path)])
    assert shown.exit_code == 0
    assert "certified" in shown.output
    path.write_text(path.read_text().replace("150", "151"))
    damaged = runner.invoke(main, ["verify", str(path)])
    assert damaged.exit_code == 1
    assert "checksum" in damaged.stderr
    printed = ["refute", "wu2007.theorem3", "--plant", str(SECTION_5), "--grid", "r=2", "--below"]
    assert runner.invoke(main, [*printed, "1.8469", "--set", "x=1"]).exit_code == 1


def test_what_is_reached_is_not_refuted(first_order: Certificate, tmp_path: Path) -> None:
    plant = tmp_path / "first_order.toml"
    plant.write_text("[matrices]\nA = [[0.5]]\nB = [[1]]\nC = [[1]]\nD = [[0]]\n")
    command = ["refute", "standard.bounded_real_discrete", "--plant", str(plant), "--below"]
    runner = CliRunner()
    assert runner.invoke(main, [*command, "1.9999"]).exit_code == 0
    assert runner.invoke(main, [*command, "2.0001"]).exit_code == 1


def test_what_is_maximised_is_refuted_above(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(
        "from lmic.dsl import *\n(n,) = dims('n')\n"
        "A, x = Data('A', n, n, symmetric=True), Scalar('x')\n"
        "theorem = Theorem(lmis={'size': PD(A - x*I(n))}, minimise=-x, reports={'least': x},\n"
        "    source=Source('N. N.', 'A test', 'unpublished', 2026))\n"
    )
    (tmp_path / "plant.toml").write_text("[matrices]\nA = [[2, 1], [1, 2]]\n")
    command = ["refute", str(tmp_path / "mine.py"), "--plant", str(tmp_path / "plant.toml")]
    reached = CliRunner().invoke(main, [*command, "--above", "1.01"])
    assert reached.exit_code == 0, reached.output
    assert "least is at most 1" in reached.output
    assert CliRunner().invoke(main, [*command, "--above", "0.99"]).exit_code == 1
    for option, words in (
        (["--below", "1"], "give that"),
        ([], "give one"),
        (["--below", "1", "--above", "1"], "give one"),
    ):
        refused = CliRunner().invoke(main, [*command, *option])
        assert refused.exit_code == 1
        assert words in refused.output


def test_a_bound_on_less_than_the_theorem_refutes_nothing(
    first_order: Certificate, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a relaxation's coefficients, or for unknowns up to a size, a bound is told and no more."""
    words = ["--plant", str(EXAMPLE_1), "--set", "eps=150", "--below", "1.2"]
    answer = CliRunner().invoke(main, ["refute", "peixoto2025.theorem1", *words])
    assert answer.exit_code == 1
    assert "(proven of the relaxation), which does not refute it" in answer.output
    assert first_order.lower
    bounded = replace(first_order, lower=replace(first_order.lower, radius=Fraction(10**6)))
    lower = first_order.lower.reports["gamma"]
    monkeypatch.setattr("lmic.certify.certify.refutation", lambda *_: (bounded, "gamma", lower))
    plant = tmp_path / "first_order.toml"
    plant.write_text("[matrices]\nA = [[0.5]]\nB = [[1]]\nC = [[1]]\nD = [[0]]\n")
    command = ["refute", "standard.bounded_real_discrete", "--plant", str(plant), "--below", "1.9"]
    answer = CliRunner().invoke(main, command)
    assert answer.exit_code == 1
    assert "(proven for unknowns up to 1e+06), which does not refute it" in answer.output
    record = json.loads(CliRunner().invoke(main, [*command, "--json"]).output)
    assert (record["refuted"], record["bound_of"]) == (False, "theorem")
    assert Fraction(record["lower"]) <= lower


def test_an_upper_bound_on_a_margin_is_rounded_upwards() -> None:
    certificate, _ = contradiction(0)
    assert certificate.infeasible
    claim = replace(certificate.infeasible, radius=Fraction(1), margin=Fraction(124, 10**9))
    assert "a least eigenvalue above 1.3e-07" in infeasibility(replace(certificate, infeasible=claim))
