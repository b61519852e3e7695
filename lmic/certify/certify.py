"""Stage 7, certify: from a solver's answer to a proven enclosure of what the theorem reports.

A strictly feasible point a little above the optimum, proven on the whole domain, gives the upper
end, exact dual matrices a little below it give the lower end. Both come from double precision where
that encloses the optimum narrowly, else from 200 bits. Where the LMIs have no solution, exact dual
matrices prove that.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.certify.candidates import (
    Candidates,
    binding_part,
    double_precision,
    in_double_precision,
    in_multiprecision,
)
from lmic.certify.certificate import Certificate
from lmic.certify.dual import infeasibility
from lmic.certify.ends import blank, exact_problems, lower_only, with_lower, with_upper
from lmic.certify.verify import BUDGET
from lmic.errors import CertificateError, LmicError
from lmic.language.theorem import Theorem
from lmic.pipeline import Result
from lmic.relax.relax import Relaxation
from lmic.solve.cone import Status
from lmic.solve.exchange import SHARE
from lmic.solve.scaling import affordable, slack_matrices
from lmic.solve.solution import ABSOLUTE

Array: TypeAlias = NDArray[Any]

#: relative width of an enclosure from which on the next means is tried
WIDTH = Fraction(1, 10**6)


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
    start = blank(result, relaxation, given, sizes)
    if result.solution.status is Status.INFEASIBLE:
        return _infeasible(start, result, relaxation)
    if not result.solution.status.usable:
        return replace(start, notes=(f"the solver's answer is '{result.solution.status}', of which nothing is proven",))
    means = [in_double_precision, in_multiprecision]
    if not (result.solution.on_face or affordable(binding_part(result))):  # no good coordinates in double precision
        means.reverse()
    best: Certificate | None = None
    for candidates_of in means:
        found = _attempted(start, result, relaxation, budget, candidates_of)
        best = found if best is None else _better(best, found, result.theorem)
        if _width(best, result.theorem) <= WIDTH:
            break
    assert best is not None
    return best


def _attempted(
    certificate: Certificate, result: Result, relaxation: Relaxation, budget: int, candidates_of: Any
) -> Certificate:
    """The certificate with the ends that these candidates prove, and notes on those that they do not."""
    notes = []
    try:
        every, exact = exact_problems(certificate, result, relaxation)
        candidates: Candidates = candidates_of(result, exact)
    except LmicError as error:
        return replace(certificate, notes=(f"{error}",))
    found = replace(certificate, solver=candidates.solver)
    try:
        found = with_upper(found, result, relaxation, budget, candidates.points)
    except LmicError as error:
        notes.append(f"no upper bound is proven: {error}")
    if result.theorem.minimise is not None:
        try:
            found = with_lower(found, result, every, candidates.duals)
        except LmicError as error:
            notes.append(f"no lower bound is proven: {error}")
    return replace(found, notes=tuple(notes))


def _width(certificate: Certificate, theorem: Theorem) -> Fraction | float:
    """Relative width of the enclosure of the first report; infinite where an end is missing."""
    upper, lower = certificate.upper, certificate.lower
    if upper and theorem.minimise is None:
        return 0.0
    if not (upper and lower and lower.reports):
        return float("inf")
    name, bound = next(iter(lower.reports.items()))
    reached = upper.reports[name]
    return abs(reached - bound) / max(abs(reached), Fraction(ABSOLUTE))


def _better(first: Certificate, second: Certificate, theorem: Theorem) -> Certificate:
    """The narrower one, else the one with more ends."""
    widths = [_width(one, theorem) for one in (first, second)]
    if widths[0] != widths[1]:
        return (first, second)[int(widths[1] < widths[0])]
    return max(first, second, key=lambda one: bool(one.upper) + bool(one.lower))


def _infeasible(certificate: Certificate, result: Result, relaxation: Relaxation) -> Certificate:
    """With a proof that the LMIs have no solution, from the dual matrices that carry the solver's claim."""
    try:
        every, exact = exact_problems(certificate, result, relaxation)
        duals = slack_matrices(result.solution.dual, result.problem.orders) if len(result.solution.dual) else []
        sizes = np.array([np.trace(dual) for dual in duals])
        chosen = np.flatnonzero(sizes > SHARE * sizes.max(initial=0.0)).tolist()
        if not chosen:
            raise CertificateError("the solver gave no dual matrices")
        claim = infeasibility(exact(chosen), [every[k] for k in chosen], [duals[k] for k in chosen])
    except LmicError as error:
        return replace(certificate, notes=(f"that the LMIs have no solution is not proven: {error}",))
    return replace(certificate, infeasible=claim, solver=double_precision(result.solution.solver))


def without_unproven_claim(result: Result, certificate: Certificate | None) -> Result:
    """The result; where the solver calls the LMIs infeasible and that is not proven, as a failure."""
    if result.solution.status is not Status.INFEASIBLE or (certificate and certificate.infeasible):
        return result
    return replace(result, solution=replace(result.solution, status=Status.FAILED))


def refutation(
    result: Result,
    relaxation: Relaxation,
    given: Mapping[str, Any] | None = None,
    sizes: Mapping[str, int] | None = None,
) -> tuple[Certificate, str, Fraction]:
    """A certificate of the bound by dual matrices alone, the report that it bounds, and the bound.

    Raises CertificateError where no bound is proven.
    """
    if not result.solution.status.usable:
        raise CertificateError(
            f"the solver's answer is '{result.solution.status}', from which no bound is proven; "
            f"{result.solution.status.advice}"
        )
    found = lower_only(blank(result, relaxation, given, sizes), result, relaxation)
    assert found.lower is not None
    if not found.lower.reports:
        raise CertificateError(
            "the theorem reports no multiple of what it minimises, nor the root of one, so none is bounded; report one"
        )
    report, bound = next(iter(found.lower.reports.items()))
    return found, report, bound
