"""The solvers by name. To add one, write a file with a ConeSolver, name it here, and the tests of all solvers take it.

Solvers under copyleft or commercial licences are optional; their packages are imported when they are asked for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module, metadata

from lmic.errors import SolverError
from lmic.solve.cone import ConeSolver


@dataclass(frozen=True)
class Entry:
    """Where a solver is, the package that it needs and the extra of lmic that installs it, and a few words."""

    module: str
    attribute: str
    package: str
    extra: str
    about: str


SOLVERS: Mapping[str, Entry] = {
    "clarabel": Entry("lmic.solve.clarabel", "Clarabel", "clarabel", "", "interior point"),
    "scs": Entry("lmic.solve.scs", "SCS", "scs", "", "first order: few digits"),
    "cvxopt": Entry("lmic.solve.cvxopt", "CVXOPT", "cvxopt", "cvxopt", "interior point, GPL-3"),
    "sdpa": Entry(
        "lmic.solve.sdpa", "SDPA", "sdpa-multiprecision", "multiprecision", "interior point in 200 bits, GPL-2"
    ),
    "mosek": Entry("lmic.solve.mosek", "Mosek", "Mosek", "mosek", "interior point, commercial: needs a licence"),
    "copt": Entry(
        "lmic.solve.copt", "COPT", "coptpy", "copt", "interior point, commercial: small problems without a licence"
    ),
}
#: who solves where nothing is said, and takes over where the chosen ones fail
DEFAULT = ("clarabel", "scs")


def solver(name: str) -> ConeSolver:
    """The solver of that name; raises SolverError where there is none or its package is not installed."""
    entry = SOLVERS.get(name.strip().lower())
    if entry is None:
        raise SolverError(f"'{name}' is no solver; choose from {', '.join(SOLVERS)}")
    if not installed(entry.package):
        raise SolverError(
            f"the solver {name} needs the package {entry.package}; install it with pip install 'lmic[{entry.extra}]'"
        )
    found: ConeSolver = getattr(import_module(entry.module), entry.attribute)()
    return found


def solvers(names: Sequence[str] = ()) -> tuple[ConeSolver, ...]:
    """The named solvers in their order, and after them those of the default that are not named.

    Names are those of :data:`SOLVERS <lmic.solve.registry.SOLVERS>`. Raises SolverError for an unknown name, and for a
    package that is not installed.
    """
    chosen = [name.strip().lower() for name in names]
    return tuple(solver(name) for name in (*chosen, *(name for name in DEFAULT if name not in chosen)))


def installed(package: str) -> bool:
    """Whether a package is installed, without importing it."""
    try:
        metadata.version(package)
    except metadata.PackageNotFoundError:
        return False
    return True
