"""The geometry behind a relaxation: which symbols vary, and over what, independently of each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from lmic.domains import Domain
from lmic.language.parameters import Parameter, instance_symbol


@dataclass(frozen=True)
class Axis:
    """Symbols that vary together over a domain; different axes vary independently."""

    name: str
    domain: Domain
    symbols: tuple[sp.Symbol, ...]


def axes(instances: Mapping[str, Sequence[Parameter]], domains: Mapping[str, Domain]) -> list[Axis]:
    """One axis for every instance of every parameter: shifted copies are independent."""
    return [
        Axis(
            str(parameter),
            domains[name],
            tuple(instance_symbol(component, parameter.instance) for component in domains[name].components),
        )
        for name, found in instances.items()
        for parameter in found
    ]
