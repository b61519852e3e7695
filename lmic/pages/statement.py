"""What a page says of a theorem, taken from the theorem itself."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp
from markupsafe import Markup

from lmic.language.theorem import Theorem
from lmic.papers.cases import Case, CaseTable
from lmic.typeset import latex
from lmic.typeset import mathml as writer


@dataclass(frozen=True)
class Statement:
    """A theorem ready to be shown: formulas as MathML, the rest as text.

    ``data`` and ``unknowns`` hold (name, dimensions), ``formulas`` the recovery, by name.
    """

    name: str
    title: str
    source: str
    derived: str
    description: str
    lmis: tuple[tuple[str, Markup], ...]
    objective: Markup | None
    data: tuple[tuple[str, str], ...]
    unknowns: tuple[tuple[str, str], ...]
    given: tuple[str, ...]
    formulas: tuple[tuple[str, Markup], ...]
    bounds: tuple[str, ...]
    assumptions: tuple[str, ...]


def statement(theorem: Theorem) -> Statement:
    """The statement of a theorem."""
    unknowns = {symbol.name: "scalar" for symbol in theorem.scalar_unknowns}
    unknowns |= {name: _size(leaf.shape, theorem.dependence(name)) for name, leaf in theorem.unknowns.items()}
    return Statement(
        name=theorem.name,
        title=theorem.title,
        source=str(theorem.source),
        derived=theorem.source.derived,
        description=theorem.description,
        lmis=tuple((name, mathml(latex.matrix(lmi))) for name, lmi in latex.statement_lmis(theorem).items()),
        objective=None if theorem.minimise is None else mathml(sp.latex(theorem.minimise)),
        data=tuple((name, _size(leaf.shape, ())) for name, leaf in theorem.data.items()),
        unknowns=tuple(unknowns.items()),
        given=tuple(symbol.name for symbol in theorem.givens),
        formulas=tuple(
            (name, mathml(f"{sp.latex(sp.Symbol(name))} = {latex.entry(node)}"))
            for name, node in theorem.recover.items()
        ),
        bounds=tuple(f"the {bound.norm} is at most {bound.report}" for bound in theorem.guarantees),
        assumptions=tuple(f"{c.matrix} has {c.word} below {c.limit:g}: {c.because}" for c in theorem.assumes),
    )


def cases_of(theorem: str, tables: list[CaseTable]) -> list[tuple[CaseTable, Case]]:
    """The papers' numbers that a theorem gives."""
    return [(table, case) for table in tables for case in table.cases if case.theorem == theorem]


def mathml(text: str) -> Markup:
    """LaTeX as MathML for a display."""
    return Markup(writer.display(text))


def _size(shape: tuple[sp.Expr, ...], parameters: tuple[str, ...]) -> str:
    depends = f", function of {', '.join(parameters)}" if parameters else ""
    return f"{shape[0]} × {shape[1]}{depends}"
