"""Prove a certificate anew, from the statement and the file alone: no solver, nothing of the compiler.

What is proven: every LMI of the theorem is positive definite at the certificate's point, for every
parameter of the domain (or at the points that it lists), and the reported values follow from that
point; no point does better than the lower bound, by dual matrices that satisfy their equalities
exactly; or there is no point at all.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
import numpy as np
import sympy as sp

from lmic import library
from lmic.algebra.polynomials import MatrixPolynomial
from lmic.certify import document
from lmic.certify.balls import PRECISION, balls, has_balls
from lmic.certify.certificate import Certificate, Lower, Standing, Upper
from lmic.certify.definite import is_positive_definite, proves_positive_definite
from lmic.certify.domain import ProofDomain, Proven, Witness, prove_positive
from lmic.certify.finite import FiniteProblem, Functional, finite_problem
from lmic.certify.infeasible import check_infeasible
from lmic.certify.lower import bounded_lower_bound, lower_bound
from lmic.certify.region import inside, region
from lmic.certify.statement import Statement, to_flint
from lmic.errors import CertificateError, LmicError, Place
from lmic.language.theorem import Theorem, radicand
from lmic.plants.files import read_plant

#: cells of the domain over all LMIs that a proof may take
BUDGET = 20_000


@dataclass(frozen=True)
class Verdict:
    """What a certificate proves, or why it does not hold; ``cells`` is how many pieces the domain took.

    ``theorem`` is the statement that it holds for, None where it does not hold; ``about_theorem`` says that
    the bound by dual matrices holds for the theorem itself, at points of the domain, and not only for its relaxation.
    """

    reason: str
    standing: Standing
    cells: int = 0
    about_theorem: bool = False
    theorem: Theorem | None = None

    @property
    def holds(self) -> bool:
        """Whether everything that the certificate states is proven."""
        return self.theorem is not None


class UnprovenError(CertificateError):
    """An LMI that is not proven on the whole domain; ``point`` is where it fails, or where a proof is hardest."""

    def __init__(self, message: str, place: Place, point: Mapping[sp.Symbol, Fraction]) -> None:
        super().__init__(message, place)
        self.point = point


def verify(certificate: Certificate, theorem: Theorem | None = None) -> Verdict:
    """Prove a certificate anew, in exact arithmetic, from the theorem's matrix and the certificate's data alone.

    ``theorem`` is the statement where it is not one of the library: a file that a certificate names is not run. The
    verdict tells what does not hold, and why; nothing is raised for that.
    """
    try:
        stated = theorem or library.shipped(certificate.theorem)
        cells, about_theorem = proven(certificate, stated)
    except LmicError as error:
        return Verdict(str(error), Standing.FAILED)
    return Verdict("", certificate.standing, cells, about_theorem, stated)


def proven(certificate: Certificate, theorem: Theorem, budget: int = BUDGET) -> tuple[int, bool]:
    """Cells used, and whether the lower bound is one on the theorem; raises where a proof fails."""
    if certificate.upper is None and certificate.lower is None and certificate.infeasible is None:
        raise CertificateError("it states nothing that could be proven")
    _check_data(certificate, theorem)
    statement = Statement(theorem, certificate.plant, certificate.scalars, certificate.dimensions)
    domain = region(statement, certificate.ties)
    cells = _prove_upper(certificate, certificate.upper, statement, domain, budget) if certificate.upper else 0
    used: list[Functional] = []
    if certificate.lower:
        lower = certificate.lower
        problem = _finite(certificate, lower.functionals, statement, domain)
        if lower.radius is None:
            bound = lower_bound(problem, lower.dual)
        else:
            bound = bounded_lower_bound(problem, lower.dual, lower.radius)
        _check_reports(lower, bound, statement.theorem)
        used += lower.functionals
    if certificate.infeasible:
        claim = certificate.infeasible
        check_infeasible(_finite(certificate, claim.functionals, statement, domain), claim)
        used += claim.functionals
    return cells, bool(used) and all(functional.at_point for functional in used)


def _check_data(certificate: Certificate, theorem: Theorem) -> None:
    """The plant is the library's where it is said to be, and the scalars and unknowns are the theorem's."""
    if certificate.library_plant:
        file = (library.root() / certificate.library_plant).resolve()
        if not file.is_relative_to(library.root().resolve()) or not file.is_file():
            raise CertificateError(f"the library has no plant {certificate.library_plant}")
        if not document.same_plant(read_plant(file), certificate.plant):
            raise CertificateError(f"the data are not those of the library's {certificate.library_plant}")
    wanted = {symbol.name for symbol in theorem.givens} | set(certificate.plant.scalars)
    if set(certificate.scalars) != wanted:
        raise CertificateError(f"the scalars are {_names(certificate.scalars)} where {_names(wanted)} are needed")
    components = {component for domain in certificate.plant.domains.values() for component in domain.components}
    if wanted & components:
        raise CertificateError(f"{min(wanted & components)} is a scalar and a component of a parameter; rename one")
    unknowns = {symbol.name for symbol in theorem.scalar_unknowns} | set(theorem.unknowns)
    if set(certificate.unknowns) != unknowns:
        raise CertificateError(f"the unknowns are {_names(certificate.unknowns)} where {_names(unknowns)} are needed")


def _names(names: Any) -> str:
    return ", ".join(sorted(names)) or "none"


# Upper bounds ---------------------------------------------------------------------------------------


def point(certificate: Certificate, statement: Statement) -> dict[str, MatrixPolynomial]:
    """The unknowns of the certificate as polynomials; raises where they are not of their form."""
    found = {}
    for name, unknown in certificate.unknowns.items():
        if len(unknown.matrices) != len(unknown.functions) or len(set(unknown.functions)) < len(unknown.functions):
            raise CertificateError(f"the unknown {name} does not have one matrix for each basis function")
        found[name] = statement.value(name, dict(zip(unknown.functions, unknown.matrices, strict=True)))
    return found


def _prove_upper(
    certificate: Certificate,
    upper: Upper,
    statement: Statement,
    domain: ProofDomain,
    budget: int,
) -> int:
    unknowns = point(certificate, statement)
    for name, claimed in upper.reports.items():
        if name not in statement.theorem.reports:
            raise CertificateError(f"the theorem reports no {name}")
        if not attained(claimed, name, statement, unknowns):
            far = "smaller" if statement.theorem.maximised(name) else "larger"
            raise CertificateError(f"{name} at the point is {far} than {document.decimal(claimed)}")
    matrices = {lmi: statement.matrix(lmi, unknowns).renamed(domain.equal).merged() for lmi in statement.theorem.lmis}
    if upper.functionals:
        _prove_at(upper.functionals, matrices, domain)
        return len(upper.functionals)
    cells = 0
    for lmi, matrix in matrices.items():
        proof = prove_positive(matrix, domain, budget - cells)
        cells += proof.cells
        if isinstance(proof, Proven):
            continue
        where = ", ".join(f"{symbol} = {float(value):.4g}" for symbol, value in proof.point.items())
        what = (
            f"the LMI does not hold at {where}; refine the grid there"
            if isinstance(proof, Witness)
            else f"{budget} cells of the domain do not suffice for a proof, the worst being at {where}; allow more"
        )
        raise UnprovenError(what, Place(statement.theorem.name, lmi), proof.point)
    return cells


def _prove_at(functionals: Sequence[Functional], matrices: Mapping[str, MatrixPolynomial], domain: ProofDomain) -> None:
    """Positive definiteness at listed points of the domain."""
    missing = set(matrices) - {functional.lmi for functional in functionals}
    if missing:
        raise CertificateError(f"the LMI '{min(missing)}' is proven at no point")
    for functional in functionals:
        if functional.lmi not in matrices or any(len(axis.corners) != 1 for axis in functional.axes):
            raise CertificateError("a grid point is no point of one of the theorem's LMIs")
        if not inside(functional, domain):
            raise CertificateError(f"a grid point of the LMI '{functional.lmi}' lies outside the domain")
        matrix = matrices[functional.lmi]
        if not _is_positive(functional, matrix):
            raise CertificateError(f"the LMI '{functional.lmi}' is not positive definite at one of the grid points")


def _is_positive(functional: Functional, matrix: MatrixPolynomial) -> bool:
    """Whether the matrix is proven positive definite at the functional's point."""
    with flint.ctx.workprec(PRECISION):
        weights = np.array([None, *functional.weights(matrix)], dtype=object)[1:]
        coefficients = matrix.coefficients
        if not has_balls(weights):
            return is_positive_definite(to_flint(np.tensordot(weights, coefficients, axes=1)))
        value = np.tensordot(balls(weights), balls(coefficients), axes=1)
        return proves_positive_definite(flint.arb_mat(value.tolist()))


def attained(claimed: Fraction, name: str, statement: Statement, unknowns: Mapping[str, MatrixPolynomial]) -> bool:
    """Whether a value is proven to be no better than a report, which is a polynomial or the root of one."""
    expression = statement.theorem.reports[name]
    inner, root = radicand(expression)
    value = statement.expression(inner, unknowns)
    if value.monomials.atoms:
        raise CertificateError(f"the report {expression} has no exact value")
    exact = Fraction(value.coefficients[0, 0, 0])
    if root and exact < 0:
        return False
    return (_is_above if statement.theorem.maximised(name) else _is_below)(exact, claimed, root)


def _is_below(value: Fraction, claimed: Fraction, root: bool) -> bool:
    """Whether a value, or its root, is no more than what is claimed."""
    return (claimed >= 0 and value <= claimed**2) if root else value <= claimed


def _is_above(value: Fraction, claimed: Fraction, root: bool) -> bool:
    """Whether a value, or its root, is no less than what is claimed."""
    return (claimed <= 0 or claimed**2 <= value) if root else claimed <= value


# Lower bounds ---------------------------------------------------------------------------------------


def _finite(
    certificate: Certificate, functionals: Sequence[Functional], statement: Statement, domain: ProofDomain
) -> FiniteProblem:
    """The exact problem of the finite LMIs of a dual; raises where they are none of the theorem's on its domain."""
    if any(functional.lmi not in statement.theorem.lmis for functional in functionals):
        raise CertificateError("a dual matrix belongs to no LMI of the theorem")
    if not all(inside(functional, domain) for functional in functionals):
        raise CertificateError("a dual matrix belongs to a point outside the domain")
    functions = {name: unknown.functions for name, unknown in certificate.unknowns.items()}
    return finite_problem(statement, functions, domain.equal, functionals)


def _check_reports(lower: Lower, bound: Fraction, theorem: Theorem) -> None:
    for name, claimed in lower.reports.items():
        if not unbeaten(claimed, name, bound, theorem):
            most = "most" if theorem.maximised(name) else "least"
            raise CertificateError(
                f"the dual matrices do not show that {name} is at {most} {document.decimal(claimed)}"
            )


def unbeaten(claimed: Fraction, name: str, bound: Fraction, theorem: Theorem) -> bool:
    """Whether the report ``name`` is proven to be no better than a value, from a bound on the objective."""
    factor = theorem.factor(name) if name in theorem.reports else None
    if factor is None:
        raise CertificateError(f"{name} is neither a multiple of the objective nor the root of one, so it has no bound")
    value, root = Fraction(int(factor.p), int(factor.q)) * bound, radicand(theorem.reports[name])[1]
    return (_is_below if theorem.maximised(name) else _is_above)(value, claimed, root)
