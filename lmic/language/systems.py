"""The systems that a theorem speaks of, and what it promises of them.

Matrices are expressions in data, recovered unknowns and parameters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from lmic.language.nodes import Node


@dataclass(frozen=True)
class DiscreteSystem:
    """x⁺ = A x + B w, z = C x + D w."""

    A: Node
    B: Node
    C: Node
    D: Node


@dataclass(frozen=True)
class ContinuousSystem:
    """ẋ = A x + B w, z = C x + D w."""

    A: Node
    B: Node
    C: Node
    D: Node


@dataclass(frozen=True)
class DelaySystem:
    """x⁺ = A x + A_d x(k − d) + B w, z = C x + C_d x(k − d) + D w with a delay d."""

    A: Node
    A_d: Node
    B: Node
    C: Node
    C_d: Node
    D: Node


@dataclass(frozen=True)
class FornasiniMarchesini:
    """x_{i+1,j+1} = A1 x_{i,j+1} + A2 x_{i+1,j} + B1 w_{i,j+1} + B2 w_{i+1,j}, z = C x at (i,j).

    Each matrix is taken at the parameter of its own place.
    """

    A1: Node
    A2: Node
    B1: Node
    B2: Node
    C: Node


@dataclass(frozen=True)
class DelayedFornasiniMarchesini:
    """A :class:`FornasiniMarchesini` system with A_d1 x_{i−d1,j+1} + A_d2 x_{i+1,j−d2} more in x_{i+1,j+1}.

    The delays d1 along i and d2 along j are fixed steps, each any nonnegative integer.
    """

    A1: Node
    A2: Node
    A_d1: Node
    A_d2: Node
    B1: Node
    B2: Node
    C: Node


PlaneSystem: TypeAlias = FornasiniMarchesini | DelayedFornasiniMarchesini
System: TypeAlias = DiscreteSystem | ContinuousSystem | DelaySystem | PlaneSystem


#: norms that a theorem can promise a bound of
NORMS = ("l2 gain", "energy to peak")


@dataclass(frozen=True)
class Bound:
    """What the theorem promises: the ``norm`` from w to z of ``system`` is below ``report``.

    ``norm`` is "l2 gain" (on frozen parameters the H∞ norm) or "energy to peak", the largest Euclidean norm of z at
    one time or place, over ‖w‖₂. A system with delays keeps the promise for each of them.
    """

    norm: str
    system: System
    report: str


@dataclass(frozen=True)
class Schur:
    """The matrix must be Schur stable at every frozen parameter, else no solution exists."""

    matrix: Node
    because: str
    word: ClassVar[str] = "spectral radius"
    limit: ClassVar[float] = 1.0


@dataclass(frozen=True)
class Hurwitz:
    """The matrix must be Hurwitz at every frozen parameter, else no solution exists."""

    matrix: Node
    because: str
    word: ClassVar[str] = "spectral abscissa"
    limit: ClassVar[float] = 0.0


Stable: TypeAlias = Schur | Hurwitz
