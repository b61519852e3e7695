"""Stage 8, recover: the filter's or controller's matrices as functions of the parameter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.algebra.polynomials import MatrixPolynomial
from lmic.compiler.assemble import ConicProblem
from lmic.compiler.bind import Binding
from lmic.errors import DomainError, Place
from lmic.language.nodes import Leaf, Node
from lmic.language.parameters import instance_symbol
from lmic.language.systems import System
from lmic.recover.evaluate import evaluate

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class Design:
    """What the theorem recovers from a solution: call it with parameter values.

    ``design(alpha=[0.3, 0.7])["A_F"]`` is a matrix, shape (rows, cols); with K rows of values it is a stack of K,
    shape (K, rows, cols). ``x`` holds the unknowns' coordinates as ``binding.layout`` numbers them.
    """

    binding: Binding
    x: Array

    def __call__(self, **parameters: Any) -> dict[str, Array]:
        """The recovered matrices at the given parameter values, by name.

        A parameter is given by its components, ``alpha=[0.3, 0.7]``, or K rows of them. Raises DomainError for a
        parameter that is missing or has another number of components.
        """
        single = all(np.ndim(value) <= 1 for value in parameters.values())
        values = {name: self.at(node, parameters) for name, node in self.binding.theorem.recover.items()}
        return {name: value[0] if single and value.ndim == 3 else value for name, value in values.items()}

    def state_spaces(self, **parameters: Any) -> list[Any]:
        """The recovered filter or controller as a ``control.StateSpace`` at each parameter value.

        See :func:`lmic.recover.statespace.state_spaces`; calling the design gives the same matrices as plain arrays.
        """
        from lmic.recover.statespace import state_spaces

        return state_spaces(self, **parameters)

    @cached_property
    def unknowns(self) -> dict[str, MatrixPolynomial]:
        """Every matrix unknown as a polynomial in the parameters' components."""
        return {name: unknown.polynomial(self.x) for name, unknown in self.binding.layout.unknowns.items()}

    @cached_property
    def scalars(self) -> dict[str, float]:
        """Scalar unknowns at the solution, and the given scalars."""
        layout = self.binding.layout.unknowns
        found = {s.name: float(self.x[layout[s.name].offset]) for s in self.binding.theorem.scalar_unknowns}
        return found | {symbol.name: value for symbol, value in self.binding.values.items()}

    def frozen(self, system: System, parameters: Mapping[str, Any]) -> dict[str, Array]:
        """The matrices of a system at K parameter values, by name, each of shape (K, rows, cols)."""
        matrices = {name: self.at(node, parameters) for name, node in vars(system).items()}
        length = max(len(matrix) for matrix in matrices.values())
        return {name: np.broadcast_to(m, (length, *m.shape[1:])) for name, m in matrices.items()}

    def at(self, node: Node, parameters: Mapping[str, Any]) -> Array:
        """Value of an expression of the theorem, shape (K, rows, cols)."""
        symbols = self._symbol_values(parameters)
        value = evaluate(node, lambda leaf: self._leaf(leaf, symbols), self.scalars, self.binding.sizes)
        return value if value.ndim == 3 else value[None]

    def _leaf(self, leaf: Leaf, symbols: Mapping[sp.Symbol, Array]) -> Array:
        matrices = self.unknowns if leaf.role == "unknown" else self.binding.plant.matrices
        return matrices[leaf.name].evaluate(symbols)

    def _symbol_values(self, parameters: Mapping[str, Any]) -> dict[sp.Symbol, Array]:
        """Components of the parameters, and the fixed scalars, as arrays of length K (or 1)."""
        values: dict[sp.Symbol, Array] = {s: np.array([v]) for s, v in self.binding.values.items()}
        for name, domain in self.binding.domains.items():
            if name not in parameters:
                raise DomainError(
                    f"{name} has no value; give {name}=[...] with its {len(domain.components)} components",
                    Place(self.binding.theorem.name),
                )
            points = np.atleast_2d(np.asarray(parameters[name], dtype=float))
            if points.shape[1] != len(domain.components):
                raise DomainError(
                    f"{points.shape[1]} values are given for {name}; its components are {', '.join(domain.components)}",
                    Place(self.binding.theorem.name),
                )
            values |= {instance_symbol(c, ""): points[:, k] for k, c in enumerate(domain.components)}
        return values


def recover(problem: ConicProblem, x: Array) -> Design:
    """The design at a solution."""
    return Design(problem.binding, x)
