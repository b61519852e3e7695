"""Stage 7, certify: from a solver's answer to a proven enclosure of what the theorem reports.

A strictly feasible point a little above the optimum, proven on the whole domain, gives the upper
end, exact dual matrices a little below it give the lower end. How much is given away for the proofs
is tried in turn, the least first.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from importlib.metadata import version
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic import __version__, library
from lmic.assemble import ConicProblem
from lmic.certify import document
from lmic.certify.certificate import Certificate, Lower, Unknown, Upper
from lmic.certify.finite import Functional, finite_problem
from lmic.certify.interior import inner_dual, inner_point
from lmic.certify.lower import exact_dual, lower_bound
from lmic.certify.region import region
from lmic.certify.relaxed import functionals
from lmic.certify.statement import Statement, fractions
from lmic.certify.verify import BUDGET, UnprovenError, point, proven
from lmic.errors import CertificateError, LmicError, Place
from lmic.language.theorem import Theorem
from lmic.pipeline import Result
from lmic.plants.files import read_plant
from lmic.plants.plant import Plant, exact_number
from lmic.relax.family import Soundness
from lmic.relax.relax import Relaxation
from lmic.solve.exchange import binding_lmis, relative_eigenvalues
from lmic.solve.solution import Solution

Array: TypeAlias = NDArray[Any]

#: shares of the objective that are given away for a proof
SHARES = (1e-8, 1e-7, 1e-6, 1e-5, 1e-4)
#: LMIs up to which the dual of all is tried before that of the binding ones
FEW = 40


def certify(
    result: Result,
    relaxation: Relaxation | None = None,
    given: Mapping[str, Any] | None = None,
    sizes: Mapping[str, int] | None = None,
    budget: int = BUDGET,
) -> Certificate:
    """The certificate of a result; ``relaxation``, ``given`` and ``sizes`` are those it was compiled with.

    Where a proof fails the bound is missing and ``notes`` say why.
    """
    relaxation = relaxation or Relaxation()
    found = blank(result, relaxation, given, sizes)
    if not result.solution.status.usable:
        return replace(found, notes=(f"the solver's answer is '{result.solution.status}', of which nothing is proven",))
    notes = []
    try:
        found = with_upper(found, result, relaxation, budget)
    except LmicError as error:
        notes.append(f"no upper bound is proven: {error}")
    if result.theorem.minimise is not None:
        try:
            found = with_lower(found, result, relaxation)
        except LmicError as error:
            notes.append(f"no lower bound is proven: {error}")
    return replace(found, notes=tuple(notes))


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
        notes=(),
        versions={"lmic": __version__, "python-flint": version("python-flint")},
    )


def exact_scalars(plant: Plant, theorem: Theorem, given: Mapping[str, Any]) -> dict[str, Fraction]:
    """Exact values of the given scalars and the plant's, as :func:`lmic.bind.scalar_values` has them in floats."""
    values = {name: exact_number(value) for name, value in given.items()}
    missing = sorted({symbol.name for symbol in theorem.givens} - set(values))
    if missing:
        raise CertificateError(f"the scalar {missing[0]} has no exact value; give the values that were compiled with")
    return {**plant.scalars, **values}


def library_plant(plant: Plant) -> str:
    """The file of the library that has these data, or an empty text."""
    for file in sorted(library.root().glob("*/*.toml")):
        if file.name != "cases.toml" and document.same_plant(read_plant(file), plant):
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


def with_upper(certificate: Certificate, result: Result, relaxation: Relaxation, budget: int) -> Certificate:
    """With the nearest point that is proven on the whole domain, or that fails there and is proven at the grid.

    Raises CertificateError where no point is proven.
    """
    reason = CertificateError("no strictly feasible point was found near the solution")
    for x in _points(result, SHARES):
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
    for x in _points(result, (share,)):
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


def _points(result: Result, shares: Sequence[float]) -> Iterator[Array]:
    """Points at which the finite LMIs hold strictly in floating point, the nearest to the optimum first."""
    if result.theorem.minimise is None:
        yield result.solution.x
        return
    for share in shares:
        x = inner_point(result.problem, result.solution, share)
        if np.isfinite(x).all() and relative_eigenvalues(result.problem, x).min() > 0:
            yield x


def _upper_reports(certificate: Certificate, theorem: Theorem) -> dict[str, Fraction]:
    """Decimals that are no less than what the theorem reports at the certificate's point."""
    statement = _statement(certificate, theorem)
    unknowns = point(certificate, statement)
    found = {}
    for name, expression in theorem.reports.items():
        root = isinstance(expression, sp.Pow) and expression.exp == sp.Rational(1, 2)
        value = statement.expression(expression.base if root else expression, unknowns)
        exact = Fraction(value.coefficients[0, 0, 0])
        found[name] = document.root_above(exact) if root else document.decimal_above(exact)
    return found


# Lower bounds ---------------------------------------------------------------------------------------


def with_lower(certificate: Certificate, result: Result, relaxation: Relaxation) -> Certificate:
    """With an exact dual: of all LMIs, or of those alone that carry the solver's dual.

    Raises CertificateError where none is positive definite.
    """
    reason = CertificateError("the solver gave no dual")
    theorem, statement = result.theorem, _statement(certificate, result.theorem)
    domain = region(statement, relaxation.ties)
    every = functionals(result.problem, relaxation, domain)
    for problem, solution, chosen in _parts(result):
        mine = [every[k] for k in chosen]
        functions = {name: unknown.functions for name, unknown in certificate.unknowns.items()}
        exact = finite_problem(statement, functions, domain.equal, mine)
        for share in SHARES:
            try:
                dual = exact_dual(exact, inner_dual(problem, solution, share), problem.matrix)
                bound = lower_bound(exact, dual)
            except CertificateError as error:
                reason = error
                continue
            reports = {}
            for name, expression in theorem.reports.items():
                if expression == theorem.minimise:
                    reports[name] = document.decimal_below(bound)
                elif expression == sp.sqrt(theorem.minimise):
                    reports[name] = document.root_below(max(bound, Fraction(0)))
            return replace(certificate, lower=Lower(reports, tuple(mine), dual, infeasible=False))
    raise reason


def _parts(result: Result) -> Iterator[tuple[ConicProblem, Solution, Array]]:
    """Problems to take the dual of: all LMIs if they are few, then the binding ones; with their numbers."""
    problem, solution = result.problem, result.solution
    binding = np.flatnonzero(binding_lmis(problem, solution))
    everything = np.arange(len(problem.orders))
    for chosen in (everything, binding) if len(everything) <= FEW else (binding,):
        rows = np.concatenate([np.arange(problem.starts[k], problem.starts[k + 1]) for k in chosen])
        yield problem.restricted(chosen), replace(solution, dual=solution.dual[rows]), chosen


def refutation(
    result: Result,
    relaxation: Relaxation,
    given: Mapping[str, Any] | None = None,
    sizes: Mapping[str, int] | None = None,
) -> tuple[Certificate, str, Fraction]:
    """A certificate of the lower bound alone, the report that it bounds, and the bound.

    Raises CertificateError where no bound is proven.
    """
    if not result.solution.status.usable:
        raise CertificateError(
            f"the solver's answer is '{result.solution.status}', from which no bound is proven; "
            f"{result.solution.status.advice}"
        )
    found = with_lower(blank(result, relaxation, given, sizes), result, relaxation)
    assert found.lower is not None
    if not found.lower.reports:
        raise CertificateError("the theorem reports neither what it minimises nor its root, so no report is bounded")
    report, lower = next(iter(found.lower.reports.items()))
    return found, report, lower
