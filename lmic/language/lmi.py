"""A matrix inequality as written: rows of blocks, and the sign."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import sympy as sp

from lmic.errors import DefinitionError
from lmic.language.nodes import Node


@dataclass(frozen=True)
class LMI:
    """``sense`` +1: the matrix is positive definite; -1: negative definite."""

    sense: int
    rows: tuple[tuple[Any, ...], ...]


def PD(rows: Any) -> LMI:
    """Positive definite: a list of block rows, ``PD([[P, A], [star, P]])``, or a single square expression.

    A block is an expression, ``star`` or a bare 0; a scalar is a block of size 1. Shapes and symmetry are checked when
    the theorem is lowered, and by ``lmic check``.
    """
    return LMI(+1, _rows(rows))


def ND(rows: Any) -> LMI:
    """Negative definite: as :func:`PD`, with the other sign."""
    return LMI(-1, _rows(rows))


def _rows(rows: Any) -> tuple[tuple[Any, ...], ...]:
    if isinstance(rows, (Node, sp.Expr)):
        return ((rows,),)
    if not isinstance(rows, (list, tuple)) or not all(isinstance(row, (list, tuple)) for row in rows):
        raise DefinitionError(f"{rows!r} is no list of block rows; write PD([[P, A], [star, P]])")
    return tuple(tuple(row) for row in rows)
