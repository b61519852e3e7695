"""Stage 0, the theorem: block matrices over symbolic dimensions and what is made of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import sympy as sp

from lmic.errors import DefinitionError
from lmic.language.contradictions import contradictions, malformations
from lmic.language.declarations import Given, ScalarUnknown
from lmic.language.lmi import LMI
from lmic.language.nodes import Leaf, Node
from lmic.language.parameters import Parameter
from lmic.language.source import Source
from lmic.language.systems import Bound, Stable, System


@dataclass(frozen=True)
class Bisection:
    """The best value of a given scalar: LMIs that hold on one side of it are bisected.

    ``goal`` is "maximise" where the LMIs hold below the best value, "minimise" where above.
    """

    scalar: Given
    goal: str


@dataclass(frozen=True)
class Variant:
    """The same condition with a choice: unknowns made constant, or their block structure lifted."""

    title: str
    statement: str = ""
    constant: tuple[Leaf, ...] = ()
    full: tuple[Leaf, ...] = ()


@dataclass(frozen=True)
class Theorem:
    """A condition as published.

    ``lmis`` maps a name to :func:`PD` or :func:`ND` of a block matrix; ``minimise`` is affine in
    the scalar unknowns (``None``: a feasibility condition); ``bisect`` names a given scalar whose
    best value is sought; ``reports`` are scalar expressions in the optimal unknowns; ``recover``
    are the formulas of the design; ``guarantees`` say what is promised of which closed loop;
    ``signals`` are further outputs worth seeing in a simulation; ``assumes`` are necessary
    conditions on the data; ``variants`` are choices that make another theorem of the same matrix.
    """

    lmis: Mapping[str, LMI]
    source: Source
    title: str = ""
    minimise: sp.Expr | None = None
    bisect: Bisection | None = None
    reports: Mapping[str, sp.Expr] = field(default_factory=dict)
    recover: Mapping[str, Node] = field(default_factory=dict)
    guarantees: Sequence[Bound] = ()
    signals: Mapping[str, System] = field(default_factory=dict)
    assumes: Sequence[Stable] = ()
    variants: Mapping[str, Variant] = field(default_factory=dict)
    name: str = ""
    description: str = ""
    constant: frozenset[str] = frozenset()
    full: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        malformed = list(malformations(self))
        faults = malformed or list(contradictions(self))
        if faults:
            first = DefinitionError(faults[0].reason, faults[0].place)
            first.theorem, first.faults = None if malformed else self, faults
            raise first

    def variant(self, key: str, name: str = "") -> Theorem:
        """The theorem with one of its declared choices made."""
        choice = self.variants[key]
        return replace(
            self,
            name=name or key,
            title=choice.title,
            source=replace(self.source, statement=choice.statement or self.source.statement),
            constant=frozenset(leaf.name for leaf in choice.constant),
            full=frozenset(leaf.name for leaf in choice.full),
            variants={},
        )

    def _repr_latex_(self) -> str:
        """The block matrices, for notebooks."""
        from lmic.typeset.latex import matrix

        return "$$" + r" \qquad ".join(matrix(lmi) for lmi in self.lmis.values()) + "$$"

    def _repr_html_(self) -> str:
        """The statement, for notebooks that show MathML."""
        from lmic.pages.notebook import theorem_html

        return theorem_html(self)

    # What occurs in the statement -----------------------------------------------------------

    @cached_property
    def nodes(self) -> list[Node]:
        """Every matrix expression of the LMIs."""
        return [entry for lmi in self.lmis.values() for row in lmi.rows for entry in row if isinstance(entry, Node)]

    @cached_property
    def formulas(self) -> list[tuple[tuple[str, ...], Node]]:
        """Matrix expressions outside the LMIs, each with its place: recovery, guarantees, signals, assumptions."""
        systems = [(("guarantees", bound.report), bound.system) for bound in self.guarantees]
        systems += [(("signals", name), system) for name, system in self.signals.items()]
        return [
            *((("recover", name), node) for name, node in self.recover.items()),
            *(((*part, name), node) for part, system in systems for name, node in vars(system).items()),
            *((("assumes", str(number)), condition.matrix) for number, condition in enumerate(self.assumes, 1)),
        ]

    def factor(self, report: str) -> sp.Rational | None:
        """c where the report is c times what is minimised, or the root of that; None where it is neither."""
        inner, _ = radicand(self.reports[report])
        ratio = sp.cancel(inner / sp.sympify(self.minimise)) if self.minimise is not None else None
        return ratio if isinstance(ratio, sp.Rational) and ratio != 0 else None

    def maximised(self, report: str) -> bool:
        """Whether the theorem seeks the largest value of a report; what follows from no objective is minimised."""
        factor = self.factor(report)
        if factor is not None:
            return bool(factor < 0)
        if self.bisect is None:
            return False
        return self.bisect.goal == "maximise" and radicand(self.reports[report])[0] == self.bisect.scalar

    @property
    def extras(self) -> list[Node]:
        """Matrix expressions outside the LMIs."""
        return [node for _, node in self.formulas if isinstance(node, Node)]

    def _declarations(self, role: str, nodes: Sequence[Node]) -> dict[str, Leaf]:
        leaves = [leaf for node in nodes for leaf in node.leaves() if leaf.role == role]
        return {leaf.name: leaf.declaration for leaf in leaves}

    @cached_property
    def data(self) -> dict[str, Leaf]:
        """The matrices that a plant must give, in the order of appearance."""
        return self._declarations("data", self.nodes + self.extras)

    @cached_property
    def unknowns(self) -> dict[str, Leaf]:
        """The matrix unknowns, in the order of appearance."""
        return self._declarations("unknown", self.nodes)

    @cached_property
    def scalar_symbols(self) -> set[sp.Symbol]:
        """Every scalar symbol of the statement."""
        symbols = set().union(*(node.scalars() for node in self.nodes + self.extras))
        if self.minimise is not None:
            symbols |= sp.sympify(self.minimise).free_symbols
        return symbols.union(*(entry.free_symbols for entry in self.scalar_entries))

    @cached_property
    def scalar_entries(self) -> list[sp.Expr]:
        """Blocks of size one that are written as a scalar."""
        return [
            entry
            for lmi in self.lmis.values()
            for row in lmi.rows
            for entry in row
            if isinstance(entry, sp.Expr) and not isinstance(entry, Node)
        ]

    @cached_property
    def scalar_unknowns(self) -> list[ScalarUnknown]:
        """The scalar unknowns by name."""
        return sorted((s for s in self.scalar_symbols if isinstance(s, ScalarUnknown)), key=str)

    @cached_property
    def givens(self) -> list[Given]:
        """The scalars that are fixed when compiling, by name."""
        return sorted((s for s in self.scalar_symbols if isinstance(s, Given)), key=str)

    @cached_property
    def parameters(self) -> dict[str, list[Parameter]]:
        """For each parameter, the instances (now, next, copies) at which something is taken."""
        found: dict[str, dict[str, Parameter]] = {}
        for node in self.nodes + self.extras:
            for leaf in node.leaves():
                for parameter in leaf.arguments:
                    found.setdefault(parameter.name, {})[parameter.instance] = parameter
        return {name: [found[name][key] for key in sorted(found[name])] for name in sorted(found)}

    def dependence(self, unknown: str) -> tuple[str, ...]:
        """Names of the parameters on which an unknown may depend."""
        return () if unknown in self.constant else next(iter(self.arguments.get(unknown, ())), ())

    @cached_property
    def arguments(self) -> dict[str, set[tuple[str, ...]]]:
        """For each matrix of the LMIs, the names of the parameters at which it is taken; of an unknown there is one."""
        found: dict[str, set[tuple[str, ...]]] = {}
        for node in self.nodes:
            for leaf in node.leaves():
                found.setdefault(leaf.name, set()).add(tuple(parameter.name for parameter in leaf.arguments))
        return found


def radicand(expression: sp.Expr) -> tuple[sp.Expr, bool]:
    """What a report is the root of, and whether it is one; else the report itself."""
    expression = sp.sympify(expression)
    root = isinstance(expression, sp.Pow) and expression.exp == sp.Rational(1, 2)
    return (expression.base, True) if root else (expression, False)
