"""The problems that are measured, each as a function of its size."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np

from lmic import library
from lmic.algebra.polynomials import MatrixPolynomial, Monomials
from lmic.compiler.assemble import ConicProblem
from lmic.dsl import ND, PD, Data, He, I, Scalar, Simplex, Source, Symmetric, Theorem, dims, star
from lmic.pipeline import compile
from lmic.plants.domains import BoxDomain
from lmic.plants.files import read_plant
from lmic.plants.plant import Plant
from lmic.plants.random import random_plant
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation


@dataclass(frozen=True)
class Problem:
    """A theorem with everything that compiling it needs; ``series`` and ``size`` place it in a plot."""

    series: str
    size: str
    theorem: Theorem
    plant: Plant
    relaxation: Relaxation
    given: Mapping[str, Any] = field(default_factory=dict)
    dependence: Mapping[str, Any] = field(default_factory=dict)

    def compiled(self) -> ConicProblem:
        """The conic problem with its arrays."""
        problem = compile(self.theorem, self.plant, self.given, self.dependence, self.relaxation)
        _ = problem.columns
        return problem


def filter_2d(points: int, theorem: str = "wu2007.theorem3") -> Problem:
    """S1: the 2-D H∞ filter of Wu et al. (2007), its parameter at three places, on so many points."""
    choices = {
        25: Relaxation({"r": "grid"}, grid={"r": 5}, ties={"b": "a", "c": "a"}),
        64: Relaxation({"r": "grid"}, grid={"r": 2}),
        625: Relaxation({"r": "grid"}, grid={"r": 5}, ties={"b": "a"}),
        15_625: Relaxation({"r": "grid"}, grid={"r": 5}),
        # a mesh of 7 x 9 points at each of the three places
        250_047: Relaxation(
            {"r": "grid"}, grid={"r": Grid.at(list(product(np.linspace(-1, 1, 7), np.linspace(0, 1, 9))))}
        ),
    }
    plant = read_plant(library.root() / "wu2007" / "example.toml")
    return Problem("S1, 2-D H∞ filter", str(points), library.theorem(theorem), plant, choices[points])


def polytopic_filter(nx: int, vertices: int, seed: int = 0) -> Problem:
    """S2: the filter of Peixoto et al. (2025) for a random plant, on as many points as Pólya degree 0 has terms."""
    theorem = library.theorem("peixoto2025.theorem1")
    plant = random_plant(theorem, {"nx": nx, "nw": 2, "ny": 2, "nz": 2}, vertices, seed)
    choice = Relaxation({"alpha": "grid", "alpha+": "vertices"}, grid={"alpha": 3})
    return Problem("S2, polytopic H∞ filter", f"nx = {nx}, N = {vertices}", theorem, plant, choice, {"eps": 1})


def multi_simplex(degree: int) -> Problem:
    """A bounded-real lemma with P of a degree in each of three simplexes of two vertices, by coefficients."""
    n, nw, nz = dims("n nw nz")
    at = Simplex("alpha"), Simplex("beta"), Simplex("zeta")
    A, B = Data("A", n, n)(*at), Data("B", n, nw)(*at)
    C, D = Data("C", nz, n)(*at), Data("D", nz, nw)(*at)
    P, gamma = Symmetric("P", n)(*at), Scalar("gamma")
    dissipation = ND([[He(P * A), P * B, C.T], [star, -gamma * I(nw), D.T], [star, star, -gamma * I(nz)]])
    theorem = Theorem(
        title="Bounded-real lemma on three simplexes",
        minimise=gamma,
        lmis={"dissipation": dissipation, "P": PD(P)},
        reports={"gamma": gamma},
        source=Source("benchmark", "", "", 2026),
        name="multi_simplex",
    )
    plant = random_plant(theorem, {"n": 4}, 2)
    return Problem("bounded-real lemma, 3 simplexes", str(degree), theorem, plant, Relaxation(), {}, {"P": degree})


def gridded(points: int, nx: int = 10) -> Problem:
    """A discrete-time bounded-real lemma of order nx with P quadratic in one parameter, on a grid."""
    theorem = library.theorem("standard.bounded_real_discrete")
    plant = random_plant(theorem, {"n": nx, "nw": 2, "nz": 2}, 2, seed=1)
    domain = BoxDomain(("rho1",), (Fraction(0),), (Fraction(1),))
    symbols = Monomials.of(*domain_symbols(domain))
    matrices = {name: _on(symbols, matrix) for name, matrix in plant.matrices.items()}
    plant = Plant(matrices, {"rho": domain}, name="gridded")
    choice = Relaxation({"rho": "grid"}, grid={"rho": points}, ties={"+": ""})
    return Problem(f"gridded bounded-real lemma, nx = {nx}", str(points), theorem, plant, choice, {}, {"P": 2})


def domain_symbols(domain: BoxDomain) -> list[Any]:
    import sympy as sp

    return [sp.Symbol(component) for component in domain.components]


def _on(symbols: Monomials, matrix: MatrixPolynomial) -> MatrixPolynomial:
    """The first coefficient as a constant, a fifth of the second with the parameter."""
    exponents = np.array([[0], [1]], dtype=np.int64)
    first, second = matrix.coefficients[0], matrix.coefficients[-1]
    return MatrixPolynomial(Monomials(symbols.atoms, exponents), np.stack([first / 2, second / 5]))
