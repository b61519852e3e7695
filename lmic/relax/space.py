"""The geometry behind a relaxation: which symbols vary, and over what, independently of each other."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import sympy as sp

from lmic.bind import Binding
from lmic.domains import BoxDomain, Domain, joint_step, rate_polytope
from lmic.errors import DomainError, Place
from lmic.language.parameters import NEXT, Parameter, instance_symbol, rate_symbol


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
    {"b": "a"}. The components of a box are axes of their own, except for the parameters in
    ``joint``, whose points are given together.
    """
    ties = dict(ties or {})
    axes: list[Axis] = []
    equal: dict[sp.Symbol, sp.Symbol] = {}
    place = Place(binding.theorem.name)
    known = {p.instance for found in binding.instances.values() for p in found}
    for instance in (*ties, *ties.values()):
        if instance not in known:
            raise DomainError(
                f"'{instance}' is no instance of a parameter; the instances are {', '.join(sorted(known - {''}))}",
                place,
            )
    for name, domain in binding.domains.items():
        instances = [parameter.instance for parameter in binding.instances[name]]
        motion = binding.plant.motions.get(name)
        bounded = False
        for instance in instances:
            target = ties.get(instance)
            if instance == NEXT and target is None:
                step = motion.step if motion and motion.step is not None else _stated(binding, name)
                if step == "constant":
                    target = ""
                bounded = not isinstance(step, str)
            if target is not None:
                equal |= {instance_symbol(c, instance): instance_symbol(c, target) for c in domain.components}
        free = [i for i in instances if i not in ties and instance_symbol(domain.components[0], i) not in equal]
        if bounded:
            assert motion is not None and not isinstance(motion.step, (str, type(None)))
            axes += _stepping(name, domain, motion.step)
            free = [i for i in free if i not in ("", NEXT)]
        for instance in free:
            axes += _split(name, instance, domain, joint)
        axes += _rates(binding, name, domain)
    return Space(tuple(axes), equal)


def _stated(binding: Binding, name: str) -> str:
    """The freedom of a parameter's next value that the theorem itself states."""
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
    if isinstance(domain, BoxDomain) and name not in joint:
        for side in domain.sides:
            yield Axis(name, instance, side, (instance_symbol(side.components[0], instance),))
    else:
        yield Axis(name, instance, domain, tuple(instance_symbol(c, instance) for c in domain.components))


def _stepping(name: str, domain: Domain, bounds: Mapping[str, object]) -> Iterator[Axis]:
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
