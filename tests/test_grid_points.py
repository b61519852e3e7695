"""Grids of named points: how they are written, where they may lie, and what is proven with them."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.optimize import linprog

from lmic import library
from lmic.certify.certificate_file import read_certificate
from lmic.certify.region import inside, region
from lmic.certify.relaxed import functionals
from lmic.certify.statement import Statement
from lmic.certify.verify import verify
from lmic.cli import main
from lmic.commands.options import Choices
from lmic.errors import RelaxationError
from lmic.pipeline import compile
from lmic.plants.domains import BoxDomain, Domain, SimplexDomain, joint_step, rate_polytope
from lmic.plants.files import read_plant
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation

ROOT = library.root()
WU = ROOT / "wu2007" / "example.toml"
TIED = ["--tie", "b=a", "--tie", "c=a"]

INTERVAL = BoxDomain(("r",), (Fraction(-1),), (Fraction(1),))
SIMPLEX = SimplexDomain.named("a", 3)
DOMAINS: dict[str, Domain] = {
    "box": BoxDomain(("r", "s"), (Fraction(-1), Fraction(0)), (Fraction(1), Fraction(1, 3))),
    "simplex": SIMPLEX,
    "step on an interval": joint_step(INTERVAL, {"r": (-0.2, 0.5)}),
    "step on a simplex": joint_step(SIMPLEX, {"a1": 0.4, "a2": 0.5, "a3": (-0.3, 0.45)}),
    "rates on a simplex": rate_polytope(SIMPLEX, {"a1": 0.4, "a2": 0.5, "a3": 1}),
}


@pytest.mark.parametrize("name", list(DOMAINS))
def test_a_domain_contains_its_convex_combinations_alone(name: str) -> None:
    """Against a linear program at random points, some of them far away and some a little outside."""
    domain, generator = DOMAINS[name], np.random.default_rng(4)
    corners = domain.vertices
    middle = corners.mean(axis=0)
    samples = domain.sample(40, generator)
    points = np.concatenate([middle + stretch * (samples - middle) for stretch in (0.5, 1, 1.5, 3)])
    system = np.vstack([corners.T, np.ones(len(corners))])
    zero = np.zeros(len(corners))
    expected = [linprog(zero, A_eq=system, b_eq=[*point, 1.0]).success for point in points]
    found = domain.contains(points)
    assert found.tolist() == expected
    assert 40 < found.sum() < 160
    assert domain.contains(middle + (1 + 1e-13) * (corners - middle)).all()
    assert not domain.contains(middle + (1 + 1e-6) * (corners - middle)).any()


def test_points_are_read_as_they_are_written() -> None:
    chosen = Choices(grid=["r=(1/3, 0); (-1,1e-3)", "h=(0.05)", "q=chebyshev:3"]).relaxation(read_plant(WU))
    assert chosen.grid == {"r": Grid.at([[1 / 3, 0], [-1, 1e-3]]), "h": Grid.at([[0.05]]), "q": Grid(3, "chebyshev")}


@pytest.mark.parametrize(
    ("grid", "message"),
    [
        ("r=(1,0", "--grid r=(1,0: '(1,0' is no point; write points as '(1, 0); (0, 1)'"),
        ("r=(1,0);", "--grid r=(1,0);: '' is no point"),
        ("r=(1,0) (0,1)", "--grid r=(1,0) (0,1): '0) (0' in (1,0) (0,1) is no finite number"),
        ("r=(1,x)", "'x' in (1,x) is no finite number; write one such as 0.5 or 1/3"),
        ("r=(1,)", "'' in (1,) is no finite number"),
        ("r=(1,1e999)", "'1e999' in (1,1e999) is no finite number"),
        ("r=(1)", "the grid points of r[a] need 2 coordinates each; give (r1@a, r2@a)"),
        ("r=(1,0,0)", "the grid points of r[a] need 2 coordinates each; give (r1@a, r2@a)"),
        ("r=(1,0);(1)", "the grid points for r are not rows of finite numbers of one length"),
        ("r=(1,0);(0,-0.1)", "the grid point (0, -0.1) of r[a] lies outside its domain, r1 in [-1, 1] x r2 in [0, 1]"),
        ("r=(1.000001,0)", "the grid point (1.000001, 0) of r[a] lies outside its domain"),
    ],
)
def test_what_are_no_points_of_the_domain(grid: str, message: str) -> None:
    command = ["refute", "wu2007.theorem3", "--plant", str(WU), "--grid", grid, *TIED, "--below", "1"]
    answer = CliRunner().invoke(main, command)
    assert answer.exit_code == 1
    assert message in answer.stderr
    assert answer.stderr.count("\n") == 1


def test_a_simplex_has_no_chebyshev_points() -> None:
    plant = read_plant(ROOT / "peixoto2025" / "example1.toml")
    choice = Relaxation(method={"alpha": "grid"}, grid={"alpha": Grid(9, "chebyshev")})
    with pytest.raises(RelaxationError, match="a simplex, which has no Chebyshev points; use uniform ones"):
        compile(library.theorem("peixoto2025.theorem1"), plant, {"eps": 150}, relaxation=choice)


def test_points_off_the_domain_by_rounding_are_moved_to_it() -> None:
    plant = read_plant(ROOT / "peixoto2025" / "example1.toml")
    corners = plant.domains["alpha"].vertices
    points = corners.mean(axis=0) + (1 + 1e-12) * (corners - corners.mean(axis=0))
    assert points.min() < 0
    choice = Relaxation(method={"alpha": "grid"}, grid={"alpha": Grid.at(points.tolist())})
    problem = compile(library.theorem("peixoto2025.theorem1"), plant, {"eps": 150}, relaxation=choice)
    domain = region(Statement(problem.binding.theorem, plant, {"eps": Fraction(150)}, {}), {})
    found = functionals(problem, choice, domain)
    assert len(found) == len(problem.orders)
    assert all(inside(functional, domain) for functional in found)


def test_points_may_be_those_of_one_instance() -> None:
    """r at a and b on a grid of each component, r at c at two named points."""
    choice = Relaxation(method={"r[c]": "grid"}, grid={"r": 2, "r[c]": Grid.at([[1, 0], [0.5, 0.5]])}, ties={"b": "a"})
    theorem = library.theorem("wu2007.theorem3")
    family = compile(theorem, read_plant(WU), relaxation=choice).families[0]
    assert family.methods == ("grid of 2 points", "grid of 2 points", "grid of 2 points")
    assert [label.rpartition("r[c] = ")[2] for label in family.axes[-1].labels] == ["1, 0", "0.5, 0.5"]
    with pytest.raises(RelaxationError, match=r"\(1, 2\) of r\[c\] lies outside its domain"):
        compile(
            theorem, read_plant(WU), relaxation=Relaxation({"r[c]": "grid"}, 0, {"r": 2, "r[c]": Grid.at([[1, 2]])})
        )


@pytest.mark.parametrize(("name", "printed"), [("wu2007.theorem3", "1.8469"), ("wu2007.theorem6", "1.3632")])
def test_printed_values_are_refuted_at_a_named_point(name: str, printed: str, tmp_path: Path) -> None:
    """r = (1, 0) at all places, which every gridding of Wu et al.'s box contains (Table 1)."""
    path = tmp_path / "point.json"
    command = ["refute", name, "--plant", str(WU), "--grid", "r=(1,0)", *TIED, "--below", printed]
    answer = CliRunner().invoke(main, [*command, "-o", str(path)])
    assert answer.exit_code == 0, answer.output
    assert f"gamma = {printed}: gamma is at least" in answer.output
    assert "(proven), so it cannot be reached" in answer.output
    assert verify(read_certificate(path)).about_theorem
