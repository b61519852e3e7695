"""Parameters: what the data and the unknowns of a theorem depend on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import sympy as sp

NEXT = "+"


@dataclass(frozen=True)
class Parameter:
    """A time-varying parameter on any domain; the plant says which.

    ``rho.next`` is the parameter one step later, ``rho.copy("b")`` its value at another place
    (2-D systems). ``step="free"`` states that the next value is anywhere in the domain; without
    it the plant says how far the parameter moves. Copies range over the domain independently of
    one another unless they are tied when compiling.
    """

    name: str
    latex: str = ""
    latex_next: str = ""
    instance: str = ""
    step: str = ""

    #: kind of domain the theorem is stated on; ``""`` accepts every kind
    required: ClassVar[str] = ""

    @property
    def next(self) -> Parameter:
        """The parameter one time step later."""
        base = self.latex or sp.latex(sp.Symbol(self.name))
        return replace(self, instance=NEXT, latex=self.latex_next or f"{base}^{{+}}")

    def copy(self, instance: str, latex: str = "") -> Parameter:
        """The same parameter at another place or instant, called ``instance``."""
        return replace(self, instance=instance, latex=latex or instance)

    def __str__(self) -> str:
        suffix = self.instance if self.instance in ("", NEXT) else f"[{self.instance}]"
        return self.name + suffix

    def to_latex(self) -> str:
        """How the paper writes the parameter."""
        return self.latex or sp.latex(sp.Symbol(self.name))


class Simplex(Parameter):
    """A parameter in the unit simplex: nonnegative components that sum to one."""

    required: ClassVar[str] = "simplex"


class Box(Parameter):
    """A parameter in a box: every component in its own interval."""

    required: ClassVar[str] = "box"


def instance_symbol(component: str, instance: str) -> sp.Symbol:
    """Symbol of a parameter's component at an instance: ``alpha1``, ``alpha1+``, ``r1@b``."""
    if not instance:
        return sp.Symbol(component)
    return sp.Symbol(component + (NEXT if instance == NEXT else f"@{instance}"))


def rate_symbol(component: str) -> sp.Symbol:
    """Symbol of the time derivative of a parameter's component (continuous time)."""
    return sp.Symbol(f"d{component}/dt")
