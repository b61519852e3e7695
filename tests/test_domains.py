"""Domains and motions: the polytopes against brute force, and an error of its own for every bad input."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import linprog

from lmic import library
from lmic.algebra.polynomials import MatrixPolynomial
from lmic.dsl import ND, PD, Data, He, Parameter, Source, Symmetric, Theorem, dims, dot, star
from lmic.errors import BasisError, DomainError, LmicError, PlantError, RelaxationError
from lmic.pipeline import finish, prepare
from lmic.plants.domains import BoxDomain, Domain, Motion, SimplexDomain, joint_step, rate_polytope
from lmic.plants.files import read_plant
from lmic.plants.plant import Plant
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation

INTERVAL = BoxDomain(("r",), (Fraction(-1),), (Fraction(1),))
UNIT_BOX = BoxDomain(("r1", "r2"), (Fraction(-1), Fraction(0)), (Fraction(1), Fraction(1)))


def inside(point: np.ndarray, corners: np.ndarray) -> bool:
    """Whether a point is a convex combination of corners."""
    system = np.vstack([corners.T, np.ones(len(corners))])
    return bool(linprog(np.zeros(len(corners)), A_eq=system, b_eq=[*point, 1.0]).success)


def limits(bounds: Mapping[str, Any], components: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    pairs = [(-bounds[c], bounds[c]) if np.ndim(bounds[c]) == 0 else bounds[c] for c in components]
    low, high = np.array(pairs, dtype=float).T
    return low, high


def within(points: np.ndarray, low: Any, high: Any) -> np.ndarray:
    return ((points >= np.asarray(low) - 1e-9) & (points <= np.asarray(high) + 1e-9)).all(axis=1)


# Polytopes of the motion -----------------------------------------------------------------------------

SIMPLEX_2, SIMPLEX_3 = SimplexDomain.named("a", 2), SimplexDomain.named("a", 3)
STEPS: dict[str, tuple[Domain, dict[str, Any]]] = {
    "interval": (INTERVAL, {"r": 0.3}),
    "interval, one side": (INTERVAL, {"r": (-0.2, 0.5)}),
    "interval, always upwards": (INTERVAL, {"r": (0.1, 0.4)}),
    "interval, bound without effect": (INTERVAL, {"r": 5}),
    "simplex of 2": (SIMPLEX_2, {"a1": 0.4, "a2": 0.3}),
    "simplex of 3": (SIMPLEX_3, {"a1": 0.4, "a2": 0.5, "a3": (-0.3, 0.45)}),
}


@pytest.mark.parametrize("name", STEPS)
def test_joint_step_against_brute_force(name: str) -> None:
    domain, bounds = STEPS[name]
    polytope = joint_step(domain, bounds)
    corners, count = polytope.vertices, len(domain.components)
    assert polytope.components == (*domain.components, *(f"{c}+" for c in domain.components))
    ends = domain.vertices.min(axis=0), domain.vertices.max(axis=0)
    step = limits(bounds, domain.components)

    def admissible(points: np.ndarray) -> np.ndarray:
        now, following = points[:, :count], points[:, count:]
        found = within(now, *ends) & within(following, *ends) & within(following - now, *step)
        if domain.kind == "simplex":
            found &= np.isclose(now.sum(axis=1), 1) & np.isclose(following.sum(axis=1), 1)
        return found

    assert admissible(corners).all()
    generator = np.random.default_rng(0)
    pairs = np.concatenate([domain.sample(1500, generator), domain.sample(1500, generator)], axis=1)
    drawn = pairs[admissible(pairs)][:60]
    assert len(drawn) == 60
    assert all(inside(point, corners) for point in drawn)
    # no corner is superfluous, and random combinations stay admissible
    assert not any(inside(corner, np.delete(corners, k, axis=0)) for k, corner in enumerate(corners))
    assert admissible(polytope.sample(200, generator)).all()


def test_joint_step_on_an_interval_by_hand() -> None:
    corners = {tuple(v) for v in np.round(joint_step(INTERVAL, {"r": (-0.2, 0.5)}).vertices, 12).tolist()}
    assert corners == {(-1, -1), (-1, -0.5), (0.5, 1), (1, 1), (1, 0.8), (-0.8, -1)}


def test_a_bound_as_wide_as_the_domain_is_no_bound() -> None:
    free = {(*v, *w) for v in INTERVAL.vertices.tolist() for w in INTERVAL.vertices.tolist()}
    wide = {tuple(v) for v in np.round(joint_step(INTERVAL, {"r": 2}).vertices, 12).tolist()}
    assert wide == {tuple(float(x) for x in corner) for corner in free}


@pytest.mark.parametrize("bounds", [{"a1": 1, "a2": 1, "a3": 1}, {"a1": 0.5, "a2": (-2, 1), "a3": (-1, 0.25)}])
def test_rates_on_a_simplex_sum_to_zero(bounds: dict[str, Any]) -> None:
    polytope = rate_polytope(SIMPLEX_3, bounds)
    corners, low_high = polytope.vertices, limits(bounds, SIMPLEX_3.components)
    assert np.allclose(corners.sum(axis=1), 0)
    assert within(corners, *low_high).all()
    generator = np.random.default_rng(1)
    rates = generator.uniform(*low_high, size=(400, 3))
    rates[:, 2] = -rates[:, :2].sum(axis=1)
    admissible = rates[within(rates, *low_high)][:60]
    assert len(admissible) == 60
    assert all(inside(rate, corners) for rate in admissible)


def test_rates_on_a_simplex_of_two_and_on_a_box() -> None:
    assert sorted(rate_polytope(SIMPLEX_2, {"a1": 0.4, "a2": 0.3}).vertices.tolist()) == [[-0.3, 0.3], [0.3, -0.3]]
    box = rate_polytope(UNIT_BOX, {"r1": 2, "r2": (-1, 3)})
    assert sorted(box.vertices.tolist()) == [[-2, -1], [-2, 3], [2, -1], [2, 3]]
    assert rate_polytope(SIMPLEX_2, {"a1": 0, "a2": 0}).vertices.tolist() == [[0, 0]]


def test_an_interval_of_one_point_has_one_vertex() -> None:
    box = BoxDomain(("r", "s"), (Fraction(1), Fraction(0)), (Fraction(1), Fraction(2)))
    assert box.vertices.tolist() == [[1, 0], [1, 2]]


@pytest.mark.parametrize("domain", [INTERVAL, UNIT_BOX, SIMPLEX_3, joint_step(INTERVAL, {"r": 0.3})])
def test_samples_are_in_the_domain(domain: Domain) -> None:
    points = domain.sample(30, np.random.default_rng(0))
    assert points.shape == (30, len(domain.components))
    assert all(inside(point, domain.vertices) for point in points)


# Bad domains and motions in a plant file -------------------------------------------------------------

MATRICES = '\n[matrices]\nA = [["r1/4"]]\nB = [[1]]\nC = [[1]]\nD = [[0]]\n'
VERTICES = "\n[matrices]\nA = { vertices = [[[0.25]], [[0]]] }\nB = [[1]]\nC = [[1]]\nD = [[0]]\n"

BAD_FILES = {
    "inverted": ("box = { r1 = [1, -1] }", "the interval of r1 is empty: .* lower end first"),
    "no component": ("box = {}", "a box has no component; give at least one interval"),
    "no domain": ("step = 0.1", "has no domain; give either simplex"),
    "two domains": ("simplex = 2\nbox = { r1 = [0, 1] }", "has no domain; give either simplex"),
    "no interval": ("box = { r1 = 1 }", "component r1: 1 is not an interval"),
    "three ends": ("box = { r1 = [0, 1, 2] }", "component r1: .* is not an interval"),
    "unbounded above": ("box = { r1 = [0, inf] }", "component r1: 'inf' .* give a finite one"),
    "unbounded below": ("box = { r1 = [-inf, 0] }", "component r1: '-inf' .* give a finite one"),
    "not a number": ("box = { r1 = [nan, 0] }", "component r1: 'nan' .* give a finite one"),
    "unbounded step": ("box = { r1 = [0, 1] }\nstep = inf", "step of r1: 'inf' .* give a finite one"),
    "unbounded rate": ("box = { r1 = [0, 1] }\nrate = [0, inf]", "rate of r1: 'inf' .* give a finite one"),
    "bound of another": ("box = { r1 = [0, 1] }\nstep = { r2 = 1 }", "step does not bound the components r1"),
    "no vertex": ("simplex = 0", "has 0 vertices; a simplex has from 1"),
    "negative": ("simplex = -1", "has -1 vertices; a simplex has from 1"),
    "too many": ("simplex = 1001", "has 1001 vertices; a simplex has from 1"),
    "half a vertex": ("simplex = 2.5", "has no domain; give either simplex = number of vertices"),
    "true": ("simplex = true", "has no domain; give either simplex = number of vertices"),
}


def plant_file(folder: Path, parameter: str, matrices: str = MATRICES) -> Plant:
    path = folder / "p.toml"
    path.write_text(f"[parameters.rho]\n{parameter}{matrices}")
    return read_plant(path)


@pytest.mark.parametrize("name", BAD_FILES)
def test_bad_domains_in_a_plant_file(name: str, tmp_path: Path) -> None:
    parameter, message = BAD_FILES[name]
    with pytest.raises(PlantError, match=rf"p\.toml: parameter rho: {message}"):
        plant_file(tmp_path, parameter)


def test_a_matrix_with_another_number_of_vertices(tmp_path: Path) -> None:
    with pytest.raises(PlantError, match="matrix A: has 2 vertices where its parameter has 3"):
        plant_file(tmp_path, "simplex = 3", VERTICES)
    with pytest.raises(PlantError, match="numbers of vertices differ"):
        Plant.polytopic(A=[[[1]], [[2]]], B=[[[1]], [[2]], [[3]]])


BAD_MOTIONS = {
    "negative step": ("bounded_real_discrete", "step = -0.1", "the bound on the step of r1 is empty"),
    "inverted step": ("bounded_real_discrete", "step = [0.2, 0.1]", "the bound on the step of r1 is empty"),
    "no step at all": ("bounded_real_discrete", "step = 0", "no interior; .* call the parameter constant"),
    "step beyond the domain": ("bounded_real_discrete", "step = [2, 3]", "leave no interior; widen them"),
    "negative rate": ("bounded_real_continuous", "rate = -1", "the bound on the rate of r1 is empty"),
    "rate missing": ("bounded_real_continuous", "", r"derivative of rho occurs, .* give rate = \{...\} for rho"),
    "a step for a rate": ("bounded_real_continuous", "step = 0.1", r"derivative of rho .* no rate bound .* give rate"),
}


@pytest.mark.parametrize("name", BAD_MOTIONS)
def test_bad_motions_in_a_plant_file(name: str, tmp_path: Path) -> None:
    theorem, motion, message = BAD_MOTIONS[name]
    binding = prepare(
        library.theorem(f"standard.{theorem}"), plant_file(tmp_path, f"box = {{ r1 = [0, 1] }}\n{motion}")
    )
    with pytest.raises(DomainError, match=message):
        finish(binding, {}, Relaxation(grid={"rho": 3}))


# Bad domains and motions in Python -------------------------------------------------------------------


def test_domains_check_themselves() -> None:
    with pytest.raises(DomainError, match="simplex has no vertex"):
        SimplexDomain(())
    with pytest.raises(DomainError, match="simplex has no vertex"):
        SimplexDomain.named("a", 0)
    with pytest.raises(DomainError, match="box has no component"):
        BoxDomain((), (), ())
    with pytest.raises(DomainError, match=r"interval of s is empty: \[1, 0\]"):
        BoxDomain(("r", "s"), (Fraction(0), Fraction(1)), (Fraction(1), Fraction(0)))


@pytest.mark.parametrize("end", [np.inf, np.nan])
def test_an_unbounded_box(end: Any) -> None:
    with pytest.raises(DomainError):
        BoxDomain(("r",), (Fraction(0),), (end,))


@pytest.mark.parametrize("bound", [np.inf, np.nan, (-np.inf, 1)])
@pytest.mark.parametrize("polytope", [joint_step, rate_polytope])
def test_an_unbounded_motion(polytope: Any, bound: Any) -> None:
    with pytest.raises(DomainError):
        polytope(INTERVAL, {"r": bound})


def test_motions_of_a_domain() -> None:
    with pytest.raises(DomainError, match="the step of a2 has no bound; give one for each component"):
        joint_step(SIMPLEX_2, {"a1": 1})
    with pytest.raises(DomainError, match="the rate of a2 has no bound; give one for each component"):
        rate_polytope(SIMPLEX_2, {"a1": 1})
    with pytest.raises(DomainError, match="component by component"):
        joint_step(UNIT_BOX, {"r1": 1, "r2": 1})
    with pytest.raises(DomainError, match="leave no interior"):  # both components cannot grow
        rate_polytope(SIMPLEX_2, {"a1": (0.1, 0.2), "a2": (0.1, 0.2)})


# Bad motions for a theorem ---------------------------------------------------------------------------

(n,) = dims("n")
rho = Parameter("rho")
A = Data("A", n, n)(rho)
P = Symmetric("P", n)
DECREASE = PD([[P(rho), A.T * P(rho.next)], [star, P(rho.next)]])
SHIFT = Theorem(title="a shift of which nothing is said", lmis={"decrease": DECREASE}, source=Source("", "", "", 2024))
MIXED = replace(SHIFT, lmis={"decrease": DECREASE, "decay": ND([[dot(P(rho)) + He(P(rho) * A)]])})


def moving(**motion: Any) -> Plant:
    matrix = MatrixPolynomial.from_sympy(sp.Matrix([[sp.Symbol("r") / 4]]))
    return Plant({"A": matrix}, {"rho": INTERVAL}, {"rho": Motion(**motion)}, name="moving")


@pytest.mark.parametrize("motion", [{}, {"rate": {"r": 1}}])
def test_a_shift_without_step_or_freedom(motion: dict[str, Any]) -> None:
    with pytest.raises(DomainError, match=r"nothing says how far rho moves in a step; give step .* in moving"):
        finish(prepare(SHIFT, moving(**motion)))


def test_a_shift_whose_freedom_is_stated() -> None:
    assert [len(f) for f in finish(prepare(SHIFT, moving(step="free"))).families] == [4]
    stated = replace(SHIFT, lmis={"decrease": _with_freedom()})
    assert [len(f) for f in finish(prepare(stated, moving())).families] == [4]


def _with_freedom() -> Any:
    free = Parameter("rho", step="free")
    return PD([[P(free), Data("A", n, n)(free).T * P(free.next)], [star, P(free.next)]])


def test_discrete_and_continuous_time_do_not_mix() -> None:
    """A theorem with both the next value and the derivative of one parameter is in neither time."""
    with pytest.raises(LmicError):
        finish(prepare(MIXED, moving(step={"r": 0.1}, rate={"r": 1})), {}, Relaxation(grid={"rho": 3}))


# Bad bases -------------------------------------------------------------------------------------------

BAD_BASES: dict[str, tuple[Any, str]] = {
    "empty": ([], "P: the basis is empty; give at least the constant 1"),
    "zero": (["0"], "P: the basis functions? 0"),
    "zero once simplified": (["1", "r1 - r1"], "linearly dependent on the domain"),
    "twice the same": (["1", "1"], "1, 1 are linearly dependent on the domain; leave one out"),
    "dependent": (["1", "r1", "2*r1 + 1"], "linearly dependent on the domain; leave one out"),
    "dependent by an identity": (["1", "sin(r1)**2", "cos(r1)**2"], "linearly dependent on the domain"),
    "not real": (["1", "sqrt(r1)"], r"sqrt\(r1\) is not finite on the domain; choose another"),
    "not finite": (["1", "log(r1)"], r"log\(r1\) is not finite on the domain; choose another"),
    "negative degree": (-1, "the degree -1 is negative"),
    "a word": ("affine", "'affine' is no dependence; give a degree, 'constant' or a list"),
    "foreign": ([sp.Symbol("s")], "uses s, which is no component of rho; the components are r1, r2"),
}


def on_box(**dependence: Any) -> Any:
    texts = {"A": "r1/4", "B": "1", "C": "1", "D": "r2"}
    matrices = {name: MatrixPolynomial.from_sympy(sp.Matrix([[sp.sympify(text)]])) for name, text in texts.items()}
    plant = Plant(matrices, {"rho": UNIT_BOX}, name="on a box")
    return prepare(library.theorem("standard.bounded_real_discrete"), plant, dependence)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("name", BAD_BASES)
def test_bad_bases(name: str) -> None:
    choice, message = BAD_BASES[name]
    with pytest.raises(BasisError, match=message):
        on_box(P=choice)


def test_a_basis_may_be_dependent_on_this_domain_only() -> None:
    simplex = Plant.polytopic(parameter="rho", A=[[[0.1]], [[0.2]]], B=[[1]], C=[[1]], D=[[0]])
    theorem = library.theorem("standard.bounded_real_discrete")
    with pytest.raises(BasisError, match="1, rho1, rho2 are linearly dependent on the domain"):
        prepare(theorem, simplex, {"P": ["1", "rho1", "rho2"]})
    assert prepare(theorem, simplex, {"P": ["rho1", "rho2"]}).layout.unknowns["P"].size == 2
    with pytest.raises(BasisError, match="X is no unknown of the theorem"):
        prepare(theorem, simplex, {"X": 1})


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("pole", ["1/r2", "1/r1"])
def test_a_basis_with_a_pole_never_reaches_the_solver(pole: str) -> None:
    """r2 = 0 is an end and r1 = 0 the middle of the domain: the grid meets both."""
    with pytest.raises(LmicError):
        finish(on_box(P=["1", pole]), {}, Relaxation(grid={"rho": 3}))


# Bad grids -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("row", [[0.1], [0.1, 0.2, 0.3], []])
def test_grid_points_of_wrong_length(row: list[float]) -> None:
    with pytest.raises(RelaxationError, match="the grid points of rho need 2 coordinates each"):
        finish(on_box(P="constant"), {}, Relaxation(method={"rho": "grid"}, grid={"rho": Grid.at([row])}))


@pytest.mark.parametrize("rows", [[], [[0.1, 0.2], [0.3]], [[np.nan, 0.2]], [[np.inf, 0.2]]])
def test_grid_points_that_are_no_points(rows: Any) -> None:
    with pytest.raises(RelaxationError):
        finish(on_box(P="constant"), {}, Relaxation(method={"rho": "grid"}, grid={"rho": Grid.at(rows)}))


def test_grid_counts_and_kinds() -> None:
    binding = on_box(P=2)
    for grid, message in (
        (Grid(3, "hexagonal"), "'hexagonal' is no kind of grid for rho; use uniform, chebyshev, random or points"),
        (Grid(0), "the grid for rho has no point; give a count of at least 1"),
        (-1, "the grid for rho has no point; give a count of at least 1"),
    ):
        with pytest.raises(RelaxationError, match=message):
            finish(binding, {}, Relaxation(grid={"rho": grid}))


def test_uniform_grids_are_nested_and_contain_the_ends() -> None:
    labels = []
    for count in (2, 3, 5, 9):
        families = finish(on_box(P=2), {}, Relaxation(grid={"rho": count})).families
        labels.append(set(families[0].axes[0].labels))
        assert len(labels[-1]) == count
    assert all(coarse < fine for coarse, fine in pairwise(labels))
    assert labels[0] == {"r1 = -1", "r1 = 1"}


@pytest.mark.parametrize("unit", [1e-6, 1e-9, 1e-13])
def test_a_step_on_a_small_interval_keeps_its_polytope(unit: float) -> None:
    """In any unit of the parameter the six vertices are those of a step of a tenth of the interval."""
    box = BoxDomain(("r",), (Fraction(0),), (Fraction(unit),))
    found = joint_step(box, {"r": unit / 10}).vertices / unit
    assert found == pytest.approx(np.array([[0, 0], [0, 0.1], [0.1, 0], [0.9, 1], [1, 0.9], [1, 1]]), abs=1e-9)
