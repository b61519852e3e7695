"""How unknowns depend on the parameters: a choice made when compiling, one per unknown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations_with_replacement, product
from typing import Any, TypeAlias

import numpy as np
import sympy as sp

from lmic.algebra.polynomials import atom_values
from lmic.errors import BasisError
from lmic.plants.domains import Domain
from lmic.plants.expressions import parse, whole_number

#: a polynomial degree, "constant", or the basis functions themselves
Choice: TypeAlias = int | str | Sequence[str | sp.Expr]

DEFAULT: Choice = 1


def read_choice(text: str) -> Choice:
    """A choice as the command line writes it: ``2``, ``constant`` or ``1; rho1; sin(rho1)``."""
    if (degree := whole_number(text)) is not None:
        return degree
    return text.strip() if text.strip() == "constant" else [part.strip() for part in text.split(";")]


def basis_functions(unknown: str, choice: Choice, domains: Mapping[str, Domain]) -> tuple[sp.Expr, ...]:
    """Basis functions of an unknown that may depend on the given parameters.

    A degree d means all monomials of degree d in a simplex's components (homogeneous) and of
    degree at most d in any other domain's components; several parameters multiply.
    """
    if choice == "constant" or not domains:
        return (sp.Integer(1),)
    if isinstance(choice, str) or not isinstance(choice, (int, Sequence)):
        raise BasisError(
            f"{unknown}: {choice!r} is no dependence; give a degree, 'constant' or a list of basis functions"
        )
    if isinstance(choice, int):
        if choice < 0:
            raise BasisError(f"{unknown}: the degree {choice} is negative; give 0 or more")
        factors = [monomials_of_degree(domain, choice) for domain in domains.values()]
        return tuple(sp.Mul(*parts) for parts in product(*factors))
    symbols = {c: sp.Symbol(c) for domain in domains.values() for c in domain.components}
    functions = tuple(parse(f, symbols) if isinstance(f, str) else sp.sympify(f) for f in choice)
    _require_independent(unknown, functions, domains)
    return functions


def monomials_of_degree(domain: Domain, degree: int) -> list[sp.Expr]:
    """Monomials of the degree in the components; on other domains than a simplex, up to the degree."""
    symbols = [sp.Symbol(component) for component in domain.components]
    pool = symbols if domain.kind == "simplex" else [sp.Integer(1), *symbols]
    return [sp.Mul(*chosen) for chosen in combinations_with_replacement(pool, degree)]


def _require_independent(unknown: str, functions: Sequence[sp.Expr], domains: Mapping[str, Domain]) -> None:
    """Functions that are dependent on the domain would leave unknowns undetermined."""
    if not functions:
        raise BasisError(f"{unknown}: the basis is empty; give at least the constant 1")
    generator = np.random.default_rng(0)
    count = 4 * len(functions) + 8
    values: dict[sp.Symbol, Any] = {}
    for domain in domains.values():
        # random points tell dependence, vertices tell poles at the ends
        corners = domain.vertices
        points = np.concatenate([corners[np.arange(count) % len(corners)], domain.sample(count, generator)])
        values |= {sp.Symbol(c): points[:, k] for k, c in enumerate(domain.components)}
    for function in functions:
        foreign = function.free_symbols - set(values)
        if foreign:
            raise BasisError(
                f"{unknown}: the basis function {function} uses {min(map(str, foreign))}, which is no component of "
                f"{', '.join(domains)}; the components are {', '.join(sorted(map(str, values)))}"
            )
    table = np.column_stack([np.broadcast_to(atom_values(f, values), (2 * count,)) for f in functions])
    if not np.isfinite(table).all():
        bad = functions[int(np.argmin(np.isfinite(table).all(axis=0)))]
        raise BasisError(f"{unknown}: the basis function {bad} is not finite on the domain; choose another")
    if np.linalg.matrix_rank(table, tol=1e-10 * max(1.0, float(np.abs(table).max()))) < len(functions):
        raise BasisError(
            f"{unknown}: the basis functions {', '.join(map(str, functions))} are linearly dependent on the domain; "
            "leave one out"
        )
