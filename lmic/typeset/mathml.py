"""MathML of formulas, for pages that need no script: from the same LaTeX that papers get."""

from __future__ import annotations

from latex2mathml.converter import convert

from lmic.language.lmi import LMI
from lmic.language.theorem import Theorem
from lmic.typeset import latex


def display(text: str) -> str:
    """A formula of LaTeX as a ``math`` element in display style."""
    found: str = convert(text, display="block")
    return found


def matrix(lmi: LMI) -> str:
    """The block matrix of one LMI with its sign."""
    return display(latex.matrix(lmi))


def theorem(statement: Theorem) -> str:
    """All LMIs of a theorem, one element after another."""
    return "\n".join(matrix(lmi) for lmi in latex.statement_lmis(statement).values())
