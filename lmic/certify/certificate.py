"""The record of stage 7, a certificate: what is proven, with everything that the proof needs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from typing import Any, TypeAlias

import sympy as sp
from numpy.typing import NDArray

from lmic.certify.finite import Functional
from lmic.certify.infeasible import Infeasible
from lmic.certify.lower import Dual
from lmic.language.theorem import Theorem
from lmic.plants.plant import Plant

Array: TypeAlias = NDArray[Any]


class Standing(StrEnum):
    """What is proven of a number."""

    CERTIFIED = "certified"
    GRID = "certified on the grid"
    NUMERICAL = "numerical"
    FAILED = "failed"


@dataclass(frozen=True)
class Unknown:
    """An unknown's basis functions and, at a certified point, its matrix of fractions for each."""

    functions: tuple[sp.Expr, ...]
    matrices: tuple[Array, ...]


@dataclass(frozen=True)
class Upper:
    """The LMIs hold at the point: on the whole domain, or where ``functionals`` are given, there.

    ``reports`` are no better than what the theorem reports at the point: no less, or no more where it is maximised.
    """

    reports: Mapping[str, Fraction]
    functionals: tuple[Functional, ...]


@dataclass(frozen=True)
class Lower:
    """No point does better than ``reports`` where the LMIs hold for the ``functionals``.

    With a ``radius``, no point whose unknowns are all up to that in size.
    """

    reports: Mapping[str, Fraction]
    functionals: tuple[Functional, ...]
    dual: Dual
    radius: Fraction | None = None


@dataclass(frozen=True)
class Certificate:
    """What is proven of a theorem for a plant, with everything that the proof needs.

    ``scalars`` are the values of the given scalars and of the plant's; ``ties`` equate instances of
    parameters; ``library_plant`` is the file of the library with these data, or empty; ``notes`` say
    which proof is missing, and why; ``solver`` says where the point and the dual matrices come from.
    """

    theorem: str
    plant: Plant
    library_plant: str
    scalars: Mapping[str, Fraction]
    dimensions: Mapping[str, int]
    ties: Mapping[str, str]
    unknowns: Mapping[str, Unknown]
    upper: Upper | None
    lower: Lower | None
    infeasible: Infeasible | None
    notes: tuple[str, ...]
    solver: str
    versions: Mapping[str, str]

    def ends(self, report: str, theorem: Theorem) -> tuple[Fraction | None, Fraction | None]:
        """What is proven of the best value of a report: its lower end and its upper one, None where nothing is."""
        reached = self.upper.reports.get(report) if self.upper else None
        bound = self.lower.reports.get(report) if self.lower else None
        return (reached, bound) if theorem.maximised(report) else (bound, reached)

    @property
    def standing(self) -> Standing:
        """What is proven: of the reported values, or that there is no solution, not even one of a tiny margin."""
        if self.infeasible is not None:
            return Standing.NUMERICAL if self.infeasible.margin else Standing.CERTIFIED
        if self.upper is None:
            return Standing.NUMERICAL
        return Standing.GRID if self.upper.functionals else Standing.CERTIFIED


def with_advice(said: str) -> str:
    """What is wrong with a certificate, and where that does not say it, what to do."""
    return said if ";" in said else f"{said}; it was changed, or made from other data: make it anew with --certify"
