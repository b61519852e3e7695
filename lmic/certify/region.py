"""The domain over which a statement is to be proven, and which points lie in it."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from lmic.certify.domain import ProofAxis, ProofDomain, proof_domain
from lmic.certify.finite import Functional
from lmic.certify.statement import Statement


def region(statement: Statement, ties: Mapping[str, str]) -> ProofDomain:
    """The exact domain of the statement's parameters; ``ties`` equate instances, {"b": "a"}.

    Raises where the plant's domains are not those on which the theorem is stated.
    """
    plant, parameters = statement.plant, statement.theorem.parameters
    if not plant.domains:
        return ProofDomain(())
    for name, instances in parameters.items():
        if name not in plant.domains:
            raise statement.error(f"the parameter {name} has no domain in {plant.name}; add it there")
        kind = plant.domains[name].kind
        if any(parameter.required not in ("", kind) for parameter in instances):
            raise statement.error(f"{name} ranges over a {kind}, on which the theorem is not stated")
    known = {parameter.instance for instances in parameters.values() for parameter in instances}
    foreign = {instance for pair in ties.items() for instance in pair} - known
    if foreign:
        raise statement.error(f"'{min(foreign)}' is no instance of a parameter, so nothing can be tied to it")
    return proof_domain({name: plant.domains[name] for name in parameters}, parameters, plant.motions, ties)


def inside(functional: Functional, domain: ProofDomain) -> bool:
    """Whether every corner of the functional is known to lie in the domain.

    That is decided for intervals and unit simplexes, and for the vertices of any other axis.
    """
    symbols = [symbol for coefficient in functional.axes for symbol in coefficient.symbols]
    if len(set(symbols)) < len(symbols):  # its values on two axes would multiply to one outside
        return False
    for coefficient in functional.axes:
        axes = [axis for axis in domain.axes if set(axis.symbols) & set(coefficient.symbols)]
        if {symbol for axis in axes for symbol in axis.symbols} != set(coefficient.symbols):
            return False
        for corner in coefficient.corners:
            values = dict(zip(coefficient.symbols, corner, strict=True))
            if not all(_contains(axis, tuple(values[symbol] for symbol in axis.symbols)) for axis in axes):
                return False
    return True


def _contains(axis: ProofAxis, point: tuple[Fraction, ...]) -> bool:
    if point in axis.points:
        return True
    if len(point) == 1:
        ends = [value for (value,) in axis.points]
        return min(ends) <= point[0] <= max(ends)
    unit = {tuple(Fraction(int(i == j)) for j in range(len(point))) for i in range(len(point))}
    return set(axis.points) == unit and min(point) >= 0 and sum(point) == 1
