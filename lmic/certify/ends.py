"""The ends of an enclosure: a certificate with nothing proven, and then with points and dual matrices that hold."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from importlib.metadata import version
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic import __version__, library
from lmic.certify import document
from lmic.certify.candidates import (
    DualCandidate,
    Exact,
    in_double_precision,
    interior_points,
)
from lmic.certify.certificate import Certificate, Lower, Unknown, Upper
from lmic.certify.dual import bounded_dual, exact_dual
from lmic.certify.finite import FiniteProblem, Functional, finite_problem
from lmic.certify.region import region
from lmic.certify.relaxed import functionals
from lmic.certify.statement import Statement, fractions
from lmic.certify.verify import UnprovenError, point, proven
from lmic.compiler.assemble import ConicProblem
from lmic.errors import CertificateError, Place
from lmic.index import plants
from lmic.language.theorem import Theorem, radicand
from lmic.pipeline import Result
from lmic.plants.files import read_plant
from lmic.plants.plant import Plant, exact_number
from lmic.relax.family import Soundness
from lmic.relax.relax import Relaxation
from lmic.solve.attainment import RADII, REACHED

Array: TypeAlias = NDArray[Any]

#: bound on the unknowns for which a lower end is proven where no exact dual is found
RADIUS = Fraction(RADII[-1])


def blank(
    result: Result,
    relaxation: Relaxation,
    given: Mapping[str, Any] | None = None,
    sizes: Mapping[str, int] | None = None,
) -> Certificate:
    """The certificate of a result before anything is proven."""
    problem, plant = result.problem, result.problem.binding.plant
    return Certificate(
        theorem=result.theorem.name,
        plant=plant,
        library_plant=library_plant(plant),
        scalars=exact_scalars(plant, result.theorem, given or {}),
        dimensions=dict(sizes or {}),
        ties=dict(relaxation.ties),
        unknowns=_unknowns(problem, None),
        upper=None,
        lower=None,
        infeasible=None,
        notes=(),
        solver="",
        versions={"lmic": __version__, "python-flint": version("python-flint")},
    )


def exact_scalars(plant: Plant, theorem: Theorem, given: Mapping[str, Any]) -> dict[str, Fraction]:
    """Exact values of the given scalars and the plant's, of which the compiler's ``scalar_values`` takes floats."""
    values = {name: exact_number(value) for name, value in given.items()}
    missing = sorted({symbol.name for symbol in theorem.givens} - set(values))
    if missing:
        raise CertificateError(f"the scalar {missing[0]} has no exact value; give the values that were compiled with")
    return {**plant.scalars, **values}


def library_plant(plant: Plant) -> str:
    """The file of the library that has these data, or an empty text."""
    for file in plants().values():
        if document.same_plant(read_plant(file), plant):
            return file.relative_to(library.root()).as_posix()
    return ""


def _unknowns(problem: ConicProblem, x: Array | None) -> dict[str, Unknown]:
    """The unknowns of the layout with their matrices at x."""
    found = {}
    for name, unknown in problem.layout.unknowns.items():
        matrices = () if x is None else tuple(map(fractions, unknown.matrices(x)))
        found[name] = Unknown(tuple(map(sp.sympify, unknown.functions)), matrices)
    return found


def _statement(certificate: Certificate, theorem: Theorem) -> Statement:
    return Statement(theorem, certificate.plant, certificate.scalars, certificate.dimensions)


# Upper bounds ---------------------------------------------------------------------------------------


def with_upper(
    certificate: Certificate, result: Result, relaxation: Relaxation, budget: int, points: Iterable[Array]
) -> Certificate:
    """With the first point that is proven on the whole domain, or that fails there and is proven at the grid.

    Raises CertificateError where no point is proven.
    """
    reason = CertificateError("no strictly feasible point was found near the solution")
    for x in points:
        found = at_point(certificate, result, x)
        try:
            proven(found, result.theorem, budget)
        except CertificateError as error:
            reason = error
        else:
            return found
        if result.problem.soundness is Soundness.SAMPLED:
            at_points = _at_points(found, result.problem, result.theorem, relaxation)
            if at_points is not None:
                return at_points
    raise reason


def proven_or_point(
    certificate: Certificate, result: Result, share: float, budget: int
) -> Certificate | Mapping[sp.Symbol, Fraction]:
    """The certificate for the whole domain, with ``share`` of the objective given away, or where its proof fails.

    Raises CertificateError where not even the finite LMIs hold.
    """
    for x in interior_points(result, (share,)):
        found = at_point(certificate, result, x)
        try:
            proven(found, result.theorem, budget)
        except UnprovenError as failure:
            return failure.point
        return found
    raise CertificateError("no strictly feasible point was found near the solution", Place(result.theorem.name))


def at_point(certificate: Certificate, result: Result, x: Array) -> Certificate:
    """The certificate with the unknowns at x, and their reports, on the whole domain; nothing is proven yet."""
    found = replace(certificate, unknowns=_unknowns(result.problem, x))
    return replace(found, upper=Upper(_upper_reports(found, result.theorem), ()))


def _at_points(
    certificate: Certificate, problem: ConicProblem, theorem: Theorem, relaxation: Relaxation
) -> Certificate | None:
    """The same point, proven where the finite LMIs are values at points; None where that fails."""
    assert certificate.upper is not None
    domain = region(_statement(certificate, theorem), relaxation.ties)
    points = [_as_point(functional) for functional in functionals(problem, relaxation, domain)]
    found = replace(certificate, upper=replace(certificate.upper, functionals=tuple(p for p in points if p)))
    try:
        proven(found, theorem)
    except CertificateError:
        return None
    return found


def _as_point(functional: Functional) -> Functional | None:
    """The functional with single corners, if it is the value at a point."""
    points = [axis.point for axis in functional.axes]
    axes = [
        replace(axis, corners=(where,), powers=(sum(axis.powers),))
        for axis, where in zip(functional.axes, points, strict=True)
        if where is not None
    ]
    return replace(functional, axes=tuple(axes)) if len(axes) == len(points) else None


def _upper_reports(certificate: Certificate, theorem: Theorem) -> dict[str, Fraction]:
    """Decimals that are no better than what the theorem reports at the certificate's point."""
    statement = _statement(certificate, theorem)
    unknowns = point(certificate, statement)
    found = {}
    for name, expression in theorem.reports.items():
        inner, root = radicand(expression)
        value = statement.expression(inner, unknowns)
        found[name] = _rounded(Fraction(value.coefficients[0, 0, 0]), root, up=not theorem.maximised(name))
    return found


def _rounded(value: Fraction, root: bool, up: bool) -> Fraction:
    """A decimal beside the value, or beside its root."""
    if root:
        return (document.root_above if up else document.root_below)(value)
    return (document.decimal_above if up else document.decimal_below)(value)


# Lower bounds ---------------------------------------------------------------------------------------


def exact_problems(certificate: Certificate, result: Result, relaxation: Relaxation) -> tuple[list[Functional], Exact]:
    """The functional of every LMI, and the exact finite problem of any of them by their numbers."""
    statement = _statement(certificate, result.theorem)
    domain = region(statement, relaxation.ties)
    every = functionals(result.problem, relaxation, domain)
    functions = {name: unknown.functions for name, unknown in certificate.unknowns.items()}

    def exact(chosen: Sequence[int]) -> FiniteProblem:
        return finite_problem(statement, functions, domain.equal, [every[k] for k in chosen])

    return every, exact


def with_lower(
    certificate: Certificate, result: Result, every: Sequence[Functional], duals: Iterable[DualCandidate]
) -> Certificate:
    """With the first dual that can be made exact, or else the best one for unknowns of bounded size.

    Raises CertificateError where there is none.
    """
    reason = CertificateError("the solver gave no dual")
    tried = []
    for candidate in duals:
        try:
            dual, bound = exact_dual(candidate.problem, candidate.matrices, candidate.faces)
        except CertificateError as error:
            reason = error
            if candidate.faces is None:
                tried.append(candidate)
        else:
            mine = tuple(every[k] for k in candidate.chosen)
            return replace(certificate, lower=Lower(_lower_reports(result.theorem, bound), mine, dual))
    grown = np.flatnonzero(np.abs(result.solution.x) >= REACHED * float(RADIUS))
    bounded = []
    for candidate in tried:
        with suppress(CertificateError):
            dual, bound = bounded_dual(candidate.problem, candidate.matrices, RADIUS, grown)
            bounded.append((bound, dual, tuple(every[k] for k in candidate.chosen)))
    if not bounded:
        raise reason
    bound, dual, mine = max(bounded, key=lambda found: found[0])
    return replace(certificate, lower=Lower(_lower_reports(result.theorem, bound), mine, dual, RADIUS))


def _lower_reports(theorem: Theorem, bound: Fraction) -> dict[str, Fraction]:
    """Decimals that no report is better than, from a bound on what is minimised."""
    reports = {}
    for name, expression in theorem.reports.items():
        factor, root = theorem.factor(name), radicand(expression)[1]
        if factor is not None:
            value = Fraction(int(factor.p), int(factor.q)) * bound
            reports[name] = _rounded(max(value, Fraction(0)) if root else value, root, up=theorem.maximised(name))
    return reports


def lower_only(certificate: Certificate, result: Result, relaxation: Relaxation) -> Certificate:
    """The certificate with a lower end from double precision."""
    every, exact = exact_problems(certificate, result, relaxation)
    candidates = in_double_precision(result, exact)
    return with_lower(replace(certificate, solver=candidates.solver), result, every, candidates.duals)
