"""What the tables of standard theorems share: plants of one parameter, and the question of feasibility."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from fnmatch import fnmatch
from typing import Any

import numpy as np
import pytest
import sympy as sp

from lmic import library
from lmic.algebra.polynomials import MatrixPolynomial
from lmic.errors import PlantError
from lmic.language.theorem import Theorem
from lmic.pipeline import Result, compile, run
from lmic.plants.domains import BoxDomain, Motion, SimplexDomain
from lmic.plants.plant import Plant, exact_number
from lmic.relax.relax import Relaxation
from lmic.solve.cone import Status

NAMES = [name.removeprefix("standard.") for name in library.names() if name.startswith("standard.")]

#: relative distance from a border at which feasibility is tried
DELTA = 1e-4

Matrices = Mapping[str, Any]

UNIT = (0, 1)

#: the LMIs where r is at the ends of its interval; affine LMIs hold between them as well
ENDS = Relaxation(grid={"rho": 2})
#: coefficients in the barycentric coordinates of r, sufficient on the whole interval
POLYA = Relaxation(polya={"rho": 0})
#: equidistant angles, the last that of the first
CIRCLE = Relaxation(grid={"rho": 9})


def plant(
    matrices: Matrices, interval: tuple[Any, Any] | None = None, rate: Any = None, step: Any = None, simplex: int = 0
) -> Plant:
    """A plant with ρ = r in an interval, with ρ in a simplex, or time-invariant."""
    domains: dict[str, Any] = {}
    if interval:
        domains["rho"] = BoxDomain(("r",), (exact_number(interval[0]),), (exact_number(interval[1]),))
    if simplex:
        domains["rho"] = SimplexDomain.named("rho", simplex)
    components = domains["rho"].components if domains else ()
    motion = Motion(
        step=dict.fromkeys(components, step) if isinstance(step, float) else step,
        rate=None if rate is None else dict.fromkeys(components, rate),
    )
    polynomials = {name: MatrixPolynomial.from_sympy(exact(value)) for name, value in matrices.items()}
    return Plant(polynomials, domains, {"rho": motion} if domains else {}, name="case")


def exact(rows: Any) -> sp.Matrix:
    """Decimals as the rationals they are written as."""
    return sp.Matrix([[sp.sympify(str(entry), rational=True) for entry in row] for row in rows])


def scalars(**values: Any) -> Matrices:
    """Matrices of one entry."""
    return {name: [[value]] for name, value in values.items()}


def theorem(name: str) -> Theorem:
    return library.theorem(f"standard.{name}")


def matching(pattern: str) -> list[str]:
    """Theorems and variants of the standard group; a pattern without any is a mistake in a table."""
    found = [name for name in NAMES if any(fnmatch(name, one) for one in pattern.split())]
    assert found, pattern
    return found


def cases(table: Iterable[Any]) -> list[Any]:
    """Every case with each of its theorems."""
    return [pytest.param(name, case, id=f"{name}-{case.what}") for case in table for name in matching(case.pattern)]


def feasible(
    posed: Theorem, subject: Plant, relaxation: Relaxation | None = None, dependence: Mapping[str, Any] | None = None
) -> Result | None:
    """The result of a feasibility condition, None where there is none."""
    used = {name: matrix for name, matrix in subject.matrices.items() if name in posed.data}
    problem = compile(posed, replace(subject, matrices=used), dependence=dependence, relaxation=relaxation)
    try:
        result = run(problem)
    except PlantError as error:
        assert "so no solution exists" in str(error)
        return None
    assert result.solution.status in (Status.SOLVED, Status.INFEASIBLE), result.solution.warnings
    return result if result.solution.status is Status.SOLVED else None


def closed_loops(result: Result) -> list[dict[str, Any]]:
    """The plant's matrices at the ends of r with the recovered gain closed by hand."""
    subject = result.problem.binding.plant
    closed = []
    points: Any = subject.domains["rho"].vertices if subject.domains else [[]]
    for point in points:
        at = {} if not subject.domains else {"rho": point}
        symbols = {sp.Symbol("r"): np.array([v]) for v in point}
        m = {name: matrix.evaluate(symbols)[0] for name, matrix in subject.matrices.items()}
        gains = {key: np.squeeze(value, 0) if value.ndim == 3 else value for key, value in result.design(**at).items()}
        if "L" in gains:
            m["A"] = m["A"] - gains["L"] @ m["C"]
        if "K" in gains:
            m["A"] = m["A"] + m.get("B_u", m.get("B")) @ gains["K"]
        if "D_zu" in m:
            m["C_z"] = m["C_z"] + m["D_zu"] @ gains["K"]
        closed.append(m)
    return closed


def stable(A: Any, discrete: bool) -> bool:
    poles = np.linalg.eigvals(A)
    return bool(np.abs(poles).max() < 1 if discrete else poles.real.max() < 0)
