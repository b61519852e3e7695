"""What can go wrong, one class for each thing the user can mend.

Every message is one sentence: the place (theorem / LMI / block), the cause, the offending
expression, and what to do about it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any


@dataclass(frozen=True)
class Place:
    """Where in a theorem an error was found; blocks count from 1 as in the printed matrix.

    ``part`` is a place outside the LMIs: ("reports", "gamma"), ("recover", "K"), ("minimise",).
    """

    theorem: str = ""
    lmi: str = ""
    block: tuple[int, int] | None = None
    part: tuple[str, ...] = ()

    def at(self, block: tuple[int, int]) -> Place:
        """The same LMI, at a block (counted from 1)."""
        return replace(self, block=block)

    def __str__(self) -> str:
        block = f"block ({self.block[0]},{self.block[1]})" if self.block else ""
        return " / ".join(part for part in (self.theorem, self.lmi, block, *self.part) if part)


class LmicError(Exception):
    """Base of every error that lmic raises on purpose; ``reason`` is its message without the place."""

    def __init__(self, message: str, place: Place | None = None) -> None:
        self.reason, self.place = message, place or Place()
        prefix = f"{place}: " if place and str(place) else ""
        super().__init__(prefix + message)


class DefinitionError(LmicError):
    """A theorem file does not state a theorem (missing name, bad block list, faulty Python).

    Where a :class:`~lmic.language.theorem.Theorem` cannot be made, ``faults`` is everything that is wrong with it,
    and ``theorem`` what was stated, if that much is in order.
    """

    theorem: Any = None
    faults: Sequence[LmicError] = ()


class ShapeError(LmicError):
    """Two matrices do not fit together, or a block does not fit its row and column."""


class AsymmetryError(LmicError):
    """A diagonal block is not symmetric, or a mirrored pair states two different entries."""


class NotAffineError(LmicError):
    """The unknowns do not enter affinely."""


class PlantError(LmicError):
    """A plant's data are missing, unknown, malformed or do not fit the theorem."""


class ExpressionError(PlantError):
    """A text does not parse as one of the permitted expressions."""


class DomainError(LmicError):
    """A parameter's domain is empty, unbounded or not the one the theorem is stated on."""


class BasisError(LmicError):
    """The chosen dependence of an unknown on the parameters makes no sense."""


class RelaxationError(LmicError):
    """The requested relaxation does not apply to the dependence at hand."""


class RecoveryError(LmicError):
    """The design cannot be formed from the solution (a singular matrix to invert, for instance)."""


class LibraryError(LmicError):
    """A theorem, plant or case of that name does not exist."""


class CertificateError(LmicError):
    """A certificate is malformed, or states what cannot be proven."""


class ResultError(LmicError):
    """The file of a result is damaged, or its theorem is another by now."""


class FormatError(LmicError):
    """A file of a semidefinite program is damaged, or states what lmic does not take."""


class SolverError(LmicError):
    """A solver is not installed, has no licence, or broke down without an answer."""


class SweepError(LmicError):
    """A sweep cannot be planned or resumed, or those who should compute it are gone."""
