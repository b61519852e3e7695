"""Where the parts of a theorem contradict one another; the matrices themselves are checked when they are lowered."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import sympy as sp

from lmic.errors import DefinitionError, Place
from lmic.language.lmi import LMI
from lmic.language.nodes import Leaf, Node
from lmic.language.systems import NORMS

if TYPE_CHECKING:
    from lmic.language.theorem import Theorem


def malformations(theorem: Theorem) -> Iterator[DefinitionError]:
    """LMIs and scalars that are none; with one of these nothing else can be looked at."""
    if not isinstance(theorem.lmis, Mapping) or not theorem.lmis:
        yield DefinitionError("the theorem states no LMI; give lmis={'name': PD([[...]])}")
        return
    for name, lmi in theorem.lmis.items():
        if not isinstance(lmi, LMI):
            yield DefinitionError(
                f"the LMI '{name}' is a {type(lmi).__name__}; wrap its block rows in PD(...) or ND(...)",
                Place(lmi=name),
            )
    for part, expression in _scalars(theorem).items():
        if isinstance(expression, (str, Node)) or not _is_scalar(expression):
            yield DefinitionError(
                f"'{part[-1]}' is {expression!r}; give a scalar expression such as mu or sqrt(mu)", Place(part=part)
            )


def contradictions(theorem: Theorem) -> Iterator[DefinitionError]:
    """Everything else that does not go together, each at its part of the theorem."""
    for part, node in theorem.formulas:
        if not isinstance(node, Node):
            yield DefinitionError(f"{node!r} is no matrix; write an expression or zeros(n, m)", Place(part=part))
    for key, variant in theorem.variants.items():
        if not all(isinstance(leaf, Leaf) for leaf in (*variant.constant, *variant.full)):
            yield DefinitionError(
                f"the variant '{key}' names its unknowns by text; give the unknowns themselves",
                Place(part=("variants", key)),
            )
    yield from _ambiguous_names(theorem)
    yield from _no_bisection(theorem)
    yield from _foreign_scalars(theorem)
    yield from _foreign_unknowns(theorem)
    yield from _missing_reports(theorem)


def _ambiguous_names(theorem: Theorem) -> Iterator[DefinitionError]:
    """Names that stand for two things, and unknowns that depend on two parameters."""
    declared: dict[str, Leaf] = {}
    for node in theorem.nodes + theorem.extras:
        for leaf in node.leaves():
            known = declared.setdefault(leaf.name, leaf.declaration)
            if known != leaf.declaration:
                yield DefinitionError(
                    f"{leaf.name} is declared twice, as {known.shape} {known.role} and {leaf.declaration.shape} "
                    f"{leaf.role}; give the two matrices different names"
                )
                declared[leaf.name] = leaf.declaration
    given = {symbol.name for symbol in theorem.givens}
    scalars = {symbol.name for symbol in theorem.scalar_unknowns}
    for name in sorted((scalars | given) & set(theorem.unknowns)):
        yield DefinitionError(f"{name} is both a scalar and a matrix unknown; give them different names")
    for name in sorted(scalars & given):
        yield DefinitionError(f"{name} is both a scalar unknown and a given scalar; give them different names")
    for name in theorem.unknowns:
        used = [f"{name}({', '.join(names)})" if names else name for names in sorted(theorem.arguments[name])]
        if len(used) > 1:
            yield DefinitionError(
                f"{name} is used with different parameters, as {' and '.join(used)}; use two unknowns"
            )


def _no_bisection(theorem: Theorem) -> Iterator[DefinitionError]:
    """What is bisected is a given scalar of the LMIs, for its largest or its least value."""
    sought, place = theorem.bisect, Place(part=("bisect",))
    if sought is None:
        return
    if not isinstance(getattr(sought, "scalar", None), sp.Symbol) or sought.goal not in ("maximise", "minimise"):
        yield DefinitionError(f"{sought!r} is no bisection; write Bisection(eps, 'maximise') or 'minimise'", place)
    elif sought.scalar not in theorem.givens:
        yield DefinitionError(
            f"{sought.scalar} is no given scalar of the LMIs; bisect one that given(...) declares", place
        )


def _foreign_scalars(theorem: Theorem) -> Iterator[DefinitionError]:
    """What is minimised or reported is made of scalars of the LMIs, and of given ones."""
    known = set().union(
        *(node.scalars() for node in theorem.nodes), *(entry.free_symbols for entry in theorem.scalar_entries)
    )
    for part, expression in _scalars(theorem).items():
        foreign = sp.sympify(expression).free_symbols - known - set(theorem.givens)
        if foreign:
            yield DefinitionError(
                f"{min(map(str, foreign))} occurs in no LMI, so that nothing determines it; use scalars of the LMIs",
                Place(part=part),
            )


def _foreign_unknowns(theorem: Theorem) -> Iterator[DefinitionError]:
    """Formulas are made of unknowns of the LMIs."""
    for part, node in theorem.formulas:
        for leaf in node.leaves() if isinstance(node, Node) else ():
            if leaf.role == "unknown" and leaf.name not in theorem.arguments:
                yield DefinitionError(
                    f"{leaf} occurs in no LMI, so that nothing determines it; use the unknowns of the LMIs",
                    Place(part=part),
                )


def _missing_reports(theorem: Theorem) -> Iterator[DefinitionError]:
    for bound in theorem.guarantees:
        if bound.norm not in NORMS:
            yield DefinitionError(
                f"{bound.norm!r} is no norm that is known here; promise a bound of {' or '.join(map(repr, NORMS))}",
                Place(part=("guarantees", bound.report)),
            )
        if bound.report not in theorem.reports:
            has = ", ".join(theorem.reports) or "none"
            yield DefinitionError(
                f"the theorem reports no {bound.report} (it reports: {has}); promise one of its reports",
                Place(part=("guarantees", bound.report)),
            )


def _scalars(theorem: Theorem) -> dict[tuple[str, ...], Any]:
    """What is minimised, and the reports."""
    minimised = {} if theorem.minimise is None else {("minimise",): theorem.minimise}
    return minimised | {("reports", name): expression for name, expression in theorem.reports.items()}


def _is_scalar(expression: Any) -> bool:
    try:
        return isinstance(sp.sympify(expression, strict=True), sp.Expr)
    except (sp.SympifyError, TypeError):
        return False
