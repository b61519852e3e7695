"""The geometry behind a relaxation: which symbols vary, and over what, independently of each other."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import sympy as sp

from lmic.compiler.bind import Binding
from lmic.errors import DomainError, Place
from lmic.language.parameters import NEXT, Parameter, instance_symbol, rate_symbol
from lmic.plants.domains import Bounds, BoxDomain, Domain, joint_step, rate_polytope


@dataclass(frozen=True)
class Axis:
    """Symbols that vary together over a polytope; different axes vary independently.

    ``parameter`` and ``instance`` say where the symbols come from, for labels and options.
    """

    parameter: str
    instance: str
    domain: Domain
    symbols: tuple[sp.Symbol, ...]

    @property
    def name(self) -> str:
        """How labels and messages call the axis."""
        if len(self.symbols) == 1:
            return str(self.symbols[0])
        return str(Parameter(self.parameter, instance=self.instance))

    @property
    def keys(self) -> tuple[str, ...]:
        """Names under which an option may be given for this axis, the most special first."""
        place = Parameter(self.parameter, instance=self.instance)
        return (*map(str, self.symbols), str(place), self.parameter)


@dataclass(frozen=True)
class Space:
    """Independent axes, and the symbols that a tie or a constant parameter makes equal to others."""

    axes: tuple[Axis, ...]
    equal: Mapping[sp.Symbol, sp.Symbol]


def space(binding: Binding, ties: Mapping[str, str] | None = None, joint: frozenset[str] = frozenset()) -> Space:
    """The axes of a bound theorem.

    Instances are independent unless the plant bounds the step (their joint polytope is one axis)
    or calls the parameter constant, or ``ties`` equates one instance with another, as
    {"b": "a"}. The components of a box are axes of their own, except for the parameters and
    instances (``r[c]``) in ``joint``, whose points are given together.
    """
    ties = _roots(binding, ties or {})
    axes: list[Axis] = []
    equal: dict[sp.Symbol, sp.Symbol] = {}
    for name, domain in binding.domains.items():
        instances = [parameter.instance for parameter in binding.instances[name]]
        step = _step(binding, name) if NEXT in instances and NEXT not in ties else "free"
        same = {**ties, NEXT: ""} if step == "constant" else ties
        free = [instance for instance in instances if instance not in same]
        for instance in set(instances) - set(free):
            equal |= {instance_symbol(c, instance): instance_symbol(c, same[instance]) for c in domain.components}
        if not isinstance(step, str):
            axes += _stepping(name, domain, step)
            free = [instance for instance in free if instance not in ("", NEXT)]
        for instance in free:
            axes += _split(name, instance, domain, joint)
        axes += _rates(binding, name, domain)
    return Space(tuple(axes), equal)


def _roots(binding: Binding, ties: Mapping[str, str]) -> dict[str, str]:
    """Every tied instance with the one it equals in the end; raises for unknown names and circles."""
    place = Place(binding.theorem.name)
    known = {p.instance for found in binding.instances.values() for p in found}
    for instance in (*ties, *ties.values()):
        if instance not in known:
            raise DomainError(
                f"'{instance}' is no instance of a parameter; the instances are {', '.join(sorted(known - {''}))}",
                place,
            )
    roots = {}
    for instance in ties:
        path = [instance]
        while path[-1] in ties:
            path.append(ties[path[-1]])
            if path[-1] in path[:-1]:
                raise DomainError(
                    f"the ties {' = '.join(path)} go in a circle; tie to one instance that is free", place
                )
        roots[instance] = path[-1]
    return roots


def _step(binding: Binding, name: str) -> str | Bounds:
    """How far a parameter moves in a step: what the plant says, else what the theorem itself states."""
    motion = binding.plant.motions.get(name)
    if motion is not None and motion.step is not None:
        return motion.step
    for parameter in binding.instances[name]:
        if parameter.step:
            return parameter.step
    raise DomainError(
        f"{name} one step later occurs, but nothing says how far {name} moves in a step; "
        f"give step = 'free', 'constant' or bounds for {name} in {binding.plant.name}",
        Place(binding.theorem.name),
    )


def _split(name: str, instance: str, domain: Domain, joint: frozenset[str]) -> Iterator[Axis]:
    """A box's components one by one, any other domain whole."""
    if isinstance(domain, BoxDomain) and not {name, str(Parameter(name, instance=instance))} & joint:
        for side in domain.sides:
            yield Axis(name, instance, side, (instance_symbol(side.components[0], instance),))
    else:
        yield Axis(name, instance, domain, tuple(instance_symbol(c, instance) for c in domain.components))


def _stepping(name: str, domain: Domain, bounds: Bounds) -> Iterator[Axis]:
    """The parameter and its next value together: a box component by component, a simplex whole."""
    parts = domain.sides if isinstance(domain, BoxDomain) else (domain,)
    for part in parts:
        symbols = [instance_symbol(c, i) for i in ("", NEXT) for c in part.components]
        yield Axis(name, "", joint_step(part, bounds), tuple(symbols))


def _rates(binding: Binding, name: str, domain: Domain) -> Iterator[Axis]:
    """Rates of change, where a derivative along the trajectory occurs."""
    rates = {component: rate_symbol(component) for component in domain.components}
    occurring = {s for lmi in binding.lmis.values() for atom in lmi.monomials.atoms for s in atom.free_symbols}
    if not occurring & set(rates.values()):
        return
    if NEXT in [parameter.instance for parameter in binding.instances[name]]:
        raise DomainError(
            f"{name} is taken both one step later and with its derivative; state the theorem in one kind of time",
            Place(binding.theorem.name),
        )
    motion = binding.plant.motions.get(name)
    if motion is None or motion.rate is None:
        raise DomainError(
            f"the derivative of {name} occurs, but {binding.plant.name} gives no rate bound for it; "
            f"give rate = {{...}} for {name}, or make its unknowns constant",
            Place(binding.theorem.name),
        )
    polytope = rate_polytope(domain, motion.rate)
    parts = polytope.sides if isinstance(polytope, BoxDomain) else (polytope,)
    for part in parts:
        yield Axis(name, "", part, tuple(rates[c] for c in part.components))
