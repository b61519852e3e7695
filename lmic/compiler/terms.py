"""Stage 2, terms: every block as a sum of coefficient · L · X · R with one unknown X in each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import sympy as sp

from lmic.compiler.expand import Factor, Factors, Selector, Stacked, canonical
from lmic.compiler.lower import SymbolicLMI
from lmic.errors import NotAffineError, Place
from lmic.faults import Checked, collect, demand
from lmic.language.declarations import ScalarUnknown
from lmic.language.nodes import Inverse, Node
from lmic.language.theorem import Theorem

Size: TypeAlias = sp.Expr
AffineParts: TypeAlias = tuple[sp.Expr, Mapping[ScalarUnknown, sp.Expr]]


@dataclass(frozen=True)
class Term:
    """coefficient · left · unknown · right; a scalar unknown multiplies left, and right is empty.

    ``coefficient`` is a scalar in the given scalars. Without unknown the term is data.
    """

    coefficient: sp.Expr
    left: Factors
    unknown: Factor | ScalarUnknown | None = None
    right: Factors = ()


@dataclass(frozen=True)
class TermList:
    """An LMI F ≻ 0 by the terms of its upper blocks (i ≤ j, from 0)."""

    place: Place
    partition: tuple[Size, ...]
    blocks: Mapping[tuple[int, int], tuple[Term, ...]]


def term_lists(lowered: Mapping[str, SymbolicLMI]) -> dict[str, TermList]:
    """The terms of every LMI; raises NotAffineError where unknowns multiply."""
    return {
        name: TermList(
            lmi.place,
            lmi.partition,
            {(i, j): terms(block, lmi.place.at((i + 1, j + 1))) for (i, j), block in lmi.blocks.items()},
        )
        for name, lmi in lowered.items()
    }


def terms(block: Node, place: Place) -> tuple[Term, ...]:
    """One block as a sum of terms; raises NotAffineError where unknowns multiply."""
    return demand(split(block, place))


def split(block: Node, place: Place) -> Checked[tuple[Term, ...]]:
    """One block as a sum of terms, with every product that is not affine (of two transposed ones the first)."""
    found: list[Term] = []
    told: set[Factors] = set()
    for factors, coefficient in canonical(block).items():
        faults, parts = collect(_split(coefficient, factors, place))
        if faults and tuple(factor.T for factor in reversed(factors)) not in told:
            told.add(factors)
            yield from faults
        found += parts
    return tuple(found)


def _split(coefficient: sp.Expr, factors: Factors, place: Place) -> Checked[list[Term]]:
    """The expanded product as terms: one for each scalar unknown in the coefficient, one without."""
    places = [k for k, factor in enumerate(factors) if factor.unknown]
    scalars = sorted((s for s in coefficient.free_symbols if isinstance(s, ScalarUnknown)), key=str)
    if len(places) > 1 or (places and scalars):
        names = [str(factors[k].matrix) for k in places] + [str(s) for s in scalars]
        yield NotAffineError(
            f"{_text(coefficient, factors)} multiplies the unknowns {' and '.join(names)}; "
            "introduce a new unknown for the product, or give one of them as data",
            place,
        )
        return []
    for factor in factors:
        yield from _inverted_unknown(factor, place)
    if places:
        (k,) = places
        return [Term(coefficient, factors[:k], factors[k], factors[k + 1 :])]
    if not scalars:
        return [Term(coefficient, factors)]
    return (yield from _scalar_terms(coefficient, scalars, factors, place))


def _scalar_terms(
    coefficient: sp.Expr, scalars: list[ScalarUnknown], factors: Factors, place: Place
) -> Checked[list[Term]]:
    found = affine_parts(coefficient, scalars)
    if found is None:
        yield NotAffineError(
            f"the coefficient {coefficient} is not affine in {', '.join(map(str, scalars))}; "
            "introduce a new scalar unknown, as delta = gamma**2",
            place,
        )
        return []
    constant, slopes = found
    parts = [Term(slope, factors, scalar) for scalar, slope in slopes.items() if slope != 0]
    return parts + ([Term(constant, factors)] if constant != 0 else [])


def objective(theorem: Theorem) -> Checked[AffineParts | None]:
    """Constant and slopes of what is minimised; None where nothing is, or where it is not affine."""
    if theorem.minimise is None:
        return None
    parts = affine_parts(sp.sympify(theorem.minimise), theorem.scalar_unknowns)
    if parts is None:
        yield NotAffineError(
            f"{theorem.minimise} is not affine in {', '.join(map(str, theorem.scalar_unknowns))}; "
            "minimise a scalar unknown that bounds it",
            Place(theorem.name, part=("minimise",)),
        )
    return parts


def affine_parts(expression: sp.Expr, scalars: list[ScalarUnknown]) -> AffineParts | None:
    """Constant and slopes of an expression affine in the scalars, None where it is not."""
    slopes = {scalar: sp.diff(expression, scalar) for scalar in scalars}
    if any(slope.free_symbols & set(scalars) for slope in slopes.values()):
        return None
    return sp.expand(expression.xreplace({scalar: sp.Integer(0) for scalar in scalars})), slopes


def _inverted_unknown(factor: Factor, place: Place) -> Checked[None]:
    if not isinstance(factor.matrix, Inverse):
        return
    hidden = [leaf for leaf in factor.matrix.leaves() if leaf.role == "unknown"]
    hidden += sorted((s for s in factor.matrix.scalars() if isinstance(s, ScalarUnknown)), key=str)
    if hidden:
        yield NotAffineError(
            f"{factor.matrix} inverts the unknown {hidden[0]}; use a Schur complement or a congruence to remove it",
            place,
        )


def _text(coefficient: sp.Expr, factors: Factors) -> str:
    named = [
        f"{f.matrix}{'.T' if f.transposed else ''}" for f in factors if not isinstance(f.matrix, Selector | Stacked)
    ]
    return "*".join(([] if coefficient == 1 else [str(coefficient)]) + named)
