"""What a result's page shows is computed right: margins, walks, poles, simulations; and notebooks show it too."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
import sympy as sp
from conftest import direct
from IPython.core.formatters import DisplayFormatter

import lmic
from lmic import library
from lmic.analysis.margins import eigenvalues, imposed, margins, over
from lmic.analysis.sampling import cover
from lmic.analysis.spectra import spectra
from lmic.analysis.walk import chart, walk
from lmic.dsl import PD, Box, Data, He, I, Scalar, Source, Symmetric, Theorem, dims
from lmic.pages import plots
from lmic.pages.result import report
from lmic.pipeline import Result
from lmic.plants.domains import BoxDomain, Motion, SimplexDomain
from lmic.plants.files import plant_of_tables
from lmic.plants.plant import Plant
from lmic.relax.relax import Relaxation
from lmic.simulate.typical import parameters_along, typical

ROOT = library.root()


@pytest.fixture(scope="module")
def filtered() -> Result:
    plant = lmic.read_plant(ROOT / "peixoto2025" / "example1.toml")
    return lmic.run(lmic.compile(library.theorem("peixoto2025.theorem1"), plant, {"eps": 50}))


@pytest.fixture(scope="module")
def sampled() -> Result:
    plant = lmic.read_plant(ROOT / "mustafa" / "example1.toml")
    gridded = Relaxation(grid={"h": cover(plant).grid})
    return lmic.run(lmic.compile(library.theorem("mustafa.theorem3"), plant, relaxation=gridded))


@pytest.fixture(scope="module")
def bounded() -> Result:
    """The bounded-real lemma of a first-order system whose parameter moves slowly in an interval."""
    plant = plant_of_tables(
        {
            "name": "slow",
            "parameters": {"rho": {"box": {"p": ["0", "1"]}, "step": {"p": "1/50"}}},
            "matrices": {"A": [["0.2 + 0.5*p"]], "B": [[1]], "C": [[1]], "D": [[0]]},
        },
        "slow",
    )
    return lmic.run(lmic.compile(library.theorem("standard.bounded_real_discrete"), plant))


# Margins --------------------------------------------------------------------------------------------


def test_eigenvalues_are_those_of_the_statement(filtered: Result) -> None:
    binding, x = filtered.problem.binding, filtered.solution.x
    generator = np.random.default_rng(3)
    names = [f"alpha{k}{i}" for i in ("", "+") for k in (1, 2)]
    points = np.hstack([generator.dirichlet([1, 1], 20), generator.dirichlet([1, 1], 20)])
    values = {sp.Symbol(name): points[:, k] for k, name in enumerate(names)}
    for name, lmi in binding.lmis.items():
        least, relative = eigenvalues(lmi, x, values)
        for k in range(20):
            here = {symbol: column[k] for symbol, column in values.items()} | dict(binding.values)
            matrix = direct(binding.theorem.lmis[name], binding, x, here)
            root = 1 / np.sqrt(np.diag(matrix))
            assert least[k % len(least)] == pytest.approx(np.linalg.eigvalsh(matrix)[0], rel=1e-6, abs=1e-12)
            scaled = np.linalg.eigvalsh(root[:, None] * matrix * root)[0]
            assert relative[k % len(relative)] == pytest.approx(scaled, rel=1e-6, abs=1e-12)


def test_a_sound_relaxation_holds_everywhere(filtered: Result) -> None:
    for margin in margins(filtered.problem, filtered.solution.x, walk(filtered.problem.binding.domains)):
        assert margin.holds
        assert margin.found == pytest.approx(min(margin.imposed, *margin.along), abs=1e-9)


def test_a_grid_is_caught_between_its_points(sampled: Result) -> None:
    problem, x = sampled.problem, sampled.solution.x
    path = walk(problem.binding.domains)
    line = path.through(imposed(problem, path))
    found = {margin.lmi: margin for margin in margins(problem, x, line)}
    performance = found["performance"]
    assert not performance.holds
    assert performance.imposed > -1e-9
    held = np.isin(line.position, performance.held)
    assert held.sum() == len(problem.families[0])
    assert (performance.along[held] > -1e-9).all()
    # the last point of the covering lies inside the domain: beyond it the LMI fails, as the statement itself shows
    h = float(re.fullmatch(r"h = (.*)", performance.where)[1])  # type: ignore[index]
    values = {sp.Symbol("h"): h} | dict(problem.binding.values)
    matrix = direct(sampled.theorem.lmis["performance"], problem.binding, x, values)
    assert h > performance.held.max()
    assert np.linalg.eigvalsh(matrix)[0] == pytest.approx(performance.least, rel=1e-2)
    page = report(sampled)
    assert "does not hold" in page
    assert 'class="fails"' in page


def test_a_constant_lmi_has_one_margin() -> None:
    n = dims("n")[0]
    A, P = Data("A", n, n), Symmetric("P", n)
    statement = Theorem({"P": PD(P - A.T * P * A - I(n))}, Source("A", "T", "V", 1996), name="constant")
    result = lmic.run(lmic.compile(statement, Plant.polytopic(A=[[0.5, 0], [0, 0.1]])))
    path = walk(result.problem.binding.domains)
    (margin,) = margins(result.problem, result.solution.x, path)
    assert len(path) == len(margin.along) == 1
    assert margin.where == ""
    assert "everywhere" in report(result)


def test_the_picture_of_entries_is_where_the_matrix_moves(filtered: Result) -> None:
    problem, x = filtered.problem, filtered.solution.x
    generator = np.random.default_rng(5)
    for family in problem.families:
        still = family.matrices(x)
        for name, mask in plots.reached(problem, family).items():
            if name == "data":
                moved = family.matrices(np.zeros_like(x)) != 0
            else:
                moved = family.matrices(x + _along(problem.layout.unknowns[name], len(x), generator)) != still
            assert (moved.any(axis=0) == mask).all(), name


def _along(unknown: object, size: int, generator: np.random.Generator) -> np.ndarray:
    direction = np.zeros(size)
    direction[unknown.columns] = generator.random(unknown.size) + 1  # type: ignore[attr-defined]
    return direction


# Walks ----------------------------------------------------------------------------------------------


def test_one_free_component_is_walked_from_end_to_end() -> None:
    path = walk({"alpha": SimplexDomain.named("alpha", 2)}, 11)
    assert path.component == "alpha2"
    assert path.position == pytest.approx(np.linspace(0, 1, 11))
    assert path.points["alpha"].sum(axis=1) == pytest.approx(1.0)
    path = path.through(np.array([0.25, 0.5]))
    assert len(path) == 12
    assert path.points["alpha"][3] == pytest.approx([0.75, 0.25])


def test_a_chart_covers_a_domain_of_two_free_components() -> None:
    box = BoxDomain(("p", "q", "s"), (0, -1, 2), (1, 3, 2))  # type: ignore[arg-type]
    place = chart({"rho": box}, 5)
    assert place is not None
    assert place.names == ("p", "q")
    assert place.inside.all()
    assert place.points.points["rho"].max(axis=0) == pytest.approx([1, 3, 2])
    place = chart({"alpha": SimplexDomain.named("alpha", 3)}, 5)
    assert place is not None
    assert place.inside.sum() == len(place.points) == 15  # the places of a triangle
    assert SimplexDomain.named("alpha", 3).contains(place.points.points["alpha"]).all()
    assert chart({"alpha": SimplexDomain.named("alpha", 2)}) is None
    assert chart({"alpha": SimplexDomain.named("alpha", 4)}) is None


def test_a_map_shows_where_a_grid_of_two_parameters_fails() -> None:
    # the least P above 1/2 + 2 p (1 − p) q at the corners of [0, 1]² is 1/2, and fails between them
    n = dims("n")[0]
    rho = Box("rho")
    U, P, t = Data("U", n, n)(rho), Symmetric("P", n), Scalar("t")
    statement = Theorem(
        {"above": PD(He(P) - He(U)), "size": PD(t * I(n) - P)}, Source("A", "T", "V", 1996), minimise=t, name="bump"
    )
    tables = {
        "name": "bump",
        "parameters": {"rho": {"box": {"p": ["0", "1"], "q": ["0", "1"]}}},
        "matrices": {"U": [["1/2 + 2*p*(1 - p)*q"]]},
    }
    plant = plant_of_tables(tables, "bump")
    result = lmic.run(lmic.compile(statement, plant, relaxation=Relaxation(grid={"rho": 2})))
    place = chart(result.problem.binding.domains, 5)
    assert place is not None
    margin, held = over(result.problem, result.solution.x, place, "above")
    assert [list(ends) for ends in held] == [[0, 1], [0, 1]]
    values = np.full((5, 5), np.nan)
    values[place.inside] = margin.along
    # P = 1/2 there, so that 2 (P − U) = −4 p (1 − p) q, which is −1 relative to its own size wherever it is not zero
    assert values[4, 2] == pytest.approx(-1.0)
    assert margin.least == pytest.approx(-1.0, abs=1e-6)
    assert "red where it fails" in report(result)


@pytest.mark.parametrize("count", [3, 5])
def test_a_walk_visits_every_vertex_and_the_centre(count: int) -> None:
    box = BoxDomain(("p", "q"), (0, -1), (1, 3))  # type: ignore[arg-type]
    domains = {"alpha": SimplexDomain.named("alpha", count)} if count == 5 else {"rho": box}
    path = walk(domains)
    (name, domain), points = next(iter(domains.items())), next(iter(path.points.values()))
    assert domain.contains(points).all()
    for wanted in (*domain.vertices, domain.vertices.mean(axis=0)):
        assert np.abs(points - wanted).max(axis=1).min() < 1e-12
    thin = path.thinned(3 * len(path.stops))
    assert set(range(len(path.stops))) <= set(thin.position)
    assert len(thin) < len(path)
    # along an edge of a box one component alone moves
    if name == "rho":
        edges = np.diff(domain.vertices[[0, 1]], axis=0)
        assert np.count_nonzero(edges) == 1
        legs = points[path.position <= len(domain.vertices)]
        assert ((np.abs(np.diff(legs, axis=0)) > 1e-12).sum(axis=1) == 1).all()


def test_a_parameter_walks_no_faster_than_it_may(bounded: Result) -> None:
    path = walk(bounded.problem.binding.domains)
    p = parameters_along(bounded, path, 200)["rho"][:, 0]
    assert np.abs(np.diff(p)).max() <= 1 / 50 + 1e-12
    assert (p[0], p[-1]) == pytest.approx((0.0, 1.0))
    short = parameters_along(bounded, path, 20)["rho"][:, 0]
    assert np.abs(np.diff(short)).max() <= 1 / 50 + 1e-12
    assert short[-1] < 0.5


def test_what_may_not_move_rests(bounded: Result) -> None:
    still = replace(bounded.problem.binding.plant, motions={"rho": Motion(step="constant")})
    problem = replace(bounded.problem, binding=replace(bounded.problem.binding, plant=still))
    path = walk(problem.binding.domains)
    assert (parameters_along(replace(bounded, problem=problem), path, 10)["rho"] == 0.5).all()


# Behaviour ------------------------------------------------------------------------------------------


def test_a_simulation_keeps_the_bound(filtered: Result, bounded: Result) -> None:
    for result in (filtered, bounded):
        found = typical(result)
        assert found is not None
        assert 0.1 * result.reports["gamma"] < found.gain <= result.reports["gamma"] * (1 + 1e-9)
        assert np.abs(found.e[-1]).max() < 1e-3 * np.abs(found.e).max()


def test_what_does_not_vary_has_numbers_in_place_of_curves() -> None:
    plant = Plant.polytopic("rho", A=[[0.5]], B=[[1]], C=[[1]], D=[[0]])
    still = replace(plant, domains={})
    result = lmic.run(lmic.compile(library.theorem("standard.bounded_real_discrete"), still))
    page = Words(report(result))
    assert "H∞ norm 2, bound 2." in page.words  # 1/(z - 0.5) at z = 1
    assert page.tags.count("img") == 4  # entries, the solver's matrix, poles, the simulation


def test_poles_and_zeros_of_the_filter(filtered: Result) -> None:
    path = walk(filtered.problem.binding.domains, 5)
    found = spectra(filtered.design, path)
    assert found is not None
    assert found.discrete
    assert found.closed is not None
    assert found.poles is not None
    plant = filtered.problem.binding.plant.matrices["A"]
    for k in range(5):
        alpha = path.points["alpha"][k]
        A, B, C, D = (filtered.design(alpha=alpha)[f"{name}_F"] for name in "ABCD")
        values = {sp.Symbol(f"alpha{i + 1}"): alpha[i : i + 1] for i in range(2)}
        parts = np.concatenate([np.linalg.eigvals(plant.evaluate(values)[0]), np.linalg.eigvals(A)])
        assert np.sort_complex(found.closed[k]) == pytest.approx(np.sort_complex(parts), abs=1e-9)
        for zero in found.zeros[k]:  # the channel's transfer function vanishes there, beside its size nearby
            response = C @ np.linalg.solve(zero * np.eye(2) - A, B) + D
            assert np.abs(response).min() < 1e-6 * np.abs(D).max()
    assert spectra(lmic.run(lmic.compile(*_h2())).design, path) is None


def _h2() -> tuple[Theorem, Plant]:
    plant = Plant.polytopic("rho", A=[[0.5, 0.1], [0, 0.3]], B=[[1], [1]], C=[[1, 0]], D=[[0]])
    return library.theorem("standard.h2_discrete"), plant


# Pages and notebooks --------------------------------------------------------------------------------


class Words(HTMLParser):
    def __init__(self, page: str) -> None:
        super().__init__()
        self.words, self.tags = "", []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)

    def handle_data(self, data: str) -> None:
        self.words += data


@pytest.fixture(scope="module")
def hostile(filtered: Result) -> Result:
    """The filter for a plant whose name would like to be a script."""
    plant = replace(filtered.problem.binding.plant, name="<script>alert(1)</script>")
    problem = replace(filtered.problem, binding=replace(filtered.problem.binding, plant=plant))
    return replace(filtered, problem=problem)


def test_the_page_says_what_is_known_and_runs_nothing(hostile: Result) -> None:
    text = report(hostile)
    page = Words(text)
    for wanted in ("1.2152486", "numerical", "sufficient", "97 scalar unknowns", "eps = 50", "no proof", "degree 0"):
        assert wanted in page.words
    assert page.tags.count("img") == text.count("data:image/svg+xml") == 6
    assert "script" not in page.tags
    assert "<script>alert(1)" in page.words


def test_names_are_escaped_in_notebooks(hostile: Result) -> None:
    for shown in (hostile._repr_html_(), hostile.problem._repr_html_()):
        assert "<script" not in shown
        assert "&lt;script&gt;" in shown


def test_notebooks_show_theorems_problems_and_results(filtered: Result) -> None:
    show = DisplayFormatter().format
    theorem, _ = show(filtered.theorem)
    assert {"text/html", "text/latex"} <= set(theorem)
    assert theorem["text/html"].count("<math") == 1 + 3 + 4  # objective, LMIs, recovery
    problem = Words(show(filtered.problem)[0]["text/html"])
    assert "97 scalar" in problem.words
    assert problem.tags.count("tr") == 1 + 3
    result = show(filtered)[0]["text/html"]
    assert "1.2152486" in result
    assert "numerical" in result
    assert result.count("<math") == 1 + 8  # the report, and four matrices at two vertices
