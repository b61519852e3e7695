"""Where the parameters of a statement range, exactly, as a product of simplexes and intervals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

import sympy as sp

from lmic.certify.finite import Functional
from lmic.certify.statement import Statement
from lmic.domains import BoxDomain, Domain, SimplexDomain
from lmic.language.parameters import NEXT, instance_symbol, rate_symbol

Point = tuple[Fraction, ...]


@dataclass(frozen=True)
class Region:
    """A unit simplex in ``symbols``, or the box between ``lower`` and ``upper`` where these are given."""

    symbols: tuple[sp.Symbol, ...]
    lower: Point = ()
    upper: Point = ()

    @property
    def corners(self) -> tuple[Point, ...]:
        """The vertices."""
        if not self.lower:
            size = range(len(self.symbols))
            return tuple(tuple(Fraction(int(i == j)) for j in size) for i in size)
        ends = [sorted({low, high}) for low, high in zip(self.lower, self.upper, strict=True)]
        return tuple(product(*ends))

    def contains(self, point: Sequence[Fraction]) -> bool:
        """Whether a point lies in it."""
        if not self.lower:
            return min(point) >= 0 and sum(point) == 1
        return all(low <= value <= high for low, value, high in zip(self.lower, point, self.upper, strict=True))


def regions(statement: Statement, ties: Mapping[str, str]) -> tuple[tuple[Region, ...], dict[sp.Symbol, sp.Symbol]]:
    """The independent regions, and the symbols that are equal to others.

    ``ties`` equate instances of parameters. Raises where a parameter moves in a set that is no
    product of simplexes and intervals.
    """
    found: list[Region] = []
    equal: dict[sp.Symbol, sp.Symbol] = {}
    for name, parameters in statement.theorem.parameters.items():
        if name not in statement.plant.domains:
            if statement.plant.domains:
                raise statement.error(f"the parameter {name} has no domain in {statement.plant.name}")
            continue
        domain = statement.plant.domains[name]
        if any(p.required and p.required != domain.kind for p in parameters):
            raise statement.error(f"{name} ranges over a {domain.kind}, on which the theorem is not stated")
        instances = [p.instance for p in parameters]
        same = _same(statement, name, instances, ties)
        for instance in instances:
            if instance in same:
                equal |= {
                    instance_symbol(c, instance): instance_symbol(c, same[instance]) for c in domain.components
                }
            else:
                found += _of_domain(statement, domain, [instance_symbol(c, instance) for c in domain.components])
        found += _rates(statement, name, domain)
    return tuple(found), equal


def inside(functional: Functional, where: Sequence[Region]) -> bool:
    """Whether every corner of the functional lies where the parameters range."""
    for axis in functional.axes:
        mine = [region for region in where if set(region.symbols) & set(axis.symbols)]
        if {s for region in mine for s in region.symbols} != set(axis.symbols):
            return False
        for corner in axis.corners:
            values = dict(zip(axis.symbols, corner, strict=True))
            if not all(region.contains([values[s] for s in region.symbols]) for region in mine):
                return False
    return True


def _same(statement: Statement, name: str, instances: Sequence[str], ties: Mapping[str, str]) -> dict[str, str]:
    """Each instance that equals another one, with the one that it equals in the end."""
    same = dict(ties)
    if NEXT in instances and NEXT not in ties:
        step = _step(statement, name)
        if step == "constant":
            same[NEXT] = ""
        elif step != "free":
            raise statement.error(f"the bounded step of {name} has no exact proof yet; certify it with a free step")
    roots = {}
    for instance in same:
        root, seen = instance, set()
        while root in same:
            if root in seen or same[root] not in (*instances, ""):
                raise statement.error(f"the instance {instance!r} is tied to nothing that ranges freely")
            seen.add(root)
            root = same[root]
        roots[instance] = root
    return roots


def _step(statement: Statement, name: str) -> object:
    """How far a parameter moves in a step: what the plant says, else what the theorem states."""
    motion = statement.plant.motions.get(name)
    if motion is not None and motion.step is not None:
        return motion.step
    for parameter in statement.theorem.parameters[name]:
        if parameter.step:
            return parameter.step
    raise statement.error(f"nothing says how far {name} moves in a step")


def _of_domain(statement: Statement, domain: Domain, symbols: Sequence[sp.Symbol]) -> Iterator[Region]:
    match domain:
        case SimplexDomain():
            yield Region(tuple(symbols))
        case BoxDomain():
            for symbol, low, high in zip(symbols, domain.lower, domain.upper, strict=True):
                yield Region((symbol,), (low,), (high,))
        case _:
            raise statement.error(f"a {domain.kind} has no exact proof yet; state the domain as a simplex or a box")


def _rates(statement: Statement, name: str, domain: Domain) -> Iterator[Region]:
    """The rates of change, where the plant bounds them."""
    motion = statement.plant.motions.get(name)
    if motion is None or motion.rate is None or not any(leaf.derivative for node in statement.theorem.nodes for leaf in node.leaves()):
        return
    if not isinstance(domain, BoxDomain):
        raise statement.error(f"the rates on the {domain.kind} of {name} have no exact proof yet")
    for component in domain.components:
        bound = motion.rate[component]
        low, high = (-bound, bound) if isinstance(bound, (int, float, Fraction)) else bound
        yield Region((rate_symbol(component),), (_exact(low),), (_exact(high),))


def _exact(value: object) -> Fraction:
    return Fraction(repr(value)) if isinstance(value, float) else Fraction(value)  # type: ignore[arg-type]
