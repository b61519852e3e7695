"""The same problems for CVXPY and PICOS: the theorem's matrix written out with their expressions, one LMI per point.

This is the plain reading of the statement (as in :mod:`lmic.recover.evaluate`) with a modelling tool's variables in
place of numbers: what a user of the tool would write by hand.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any, Protocol

import numpy as np
import sympy as sp
from problems import Problem

from lmic.compiler.assemble import ConicProblem
from lmic.compiler.bind import Binding
from lmic.language.lmi import LMI
from lmic.language.nodes import (
    Block,
    Hermitian,
    Identity,
    Leaf,
    MatrixProduct,
    MatrixSum,
    Node,
    Transposed,
    Zero,
)
from lmic.language.parameters import instance_symbol
from lmic.language.star import Star
from lmic.relax.grid import grid_points
from lmic.relax.relax import Relaxation, chosen_grid
from lmic.relax.space import space


class Tool(Protocol):
    """A modelling tool: its variables, constants and block matrices, and its way to compile and to solve."""

    name: str

    def variable(self, name: str, shape: tuple[int, int], symmetric: bool) -> Any: ...
    def constant(self, matrix: np.ndarray) -> Any: ...
    def product(self, left: Any, right: Any) -> Any: ...
    def block(self, rows: list[list[Any]]) -> Any: ...
    def model(self, objective: Any, matrices: list[Any]) -> Any: ...
    def compile(self, model: Any) -> None: ...
    def solve(self, model: Any) -> float: ...


class Cvxpy:
    name = "CVXPY"

    def variable(self, name: str, shape: tuple[int, int], symmetric: bool) -> Any:
        import cvxpy as cp

        return cp.Variable(name=name) if shape == (1, 1) else cp.Variable(shape, name=name, symmetric=symmetric)

    def constant(self, matrix: np.ndarray) -> Any:
        return matrix

    def product(self, left: Any, right: Any) -> Any:
        return left @ right

    def block(self, rows: list[list[Any]]) -> Any:
        import cvxpy as cp

        return cp.bmat(rows)

    def model(self, objective: Any, matrices: list[Any]) -> Any:
        import cvxpy as cp

        return cp.Problem(cp.Minimize(objective), [matrix >> 0 for matrix in matrices])

    def compile(self, model: Any) -> None:
        import cvxpy as cp

        model.get_problem_data(cp.CLARABEL)

    def solve(self, model: Any) -> float:
        import cvxpy as cp

        return float(model.solve(solver=cp.CLARABEL))


class Picos:
    name = "PICOS"

    def variable(self, name: str, shape: tuple[int, int], symmetric: bool) -> Any:
        import picos

        if symmetric and shape != (1, 1):
            return picos.SymmetricVariable(name, shape)
        return picos.RealVariable(name, shape)

    def constant(self, matrix: np.ndarray) -> Any:
        import picos

        return picos.Constant(matrix)

    def product(self, left: Any, right: Any) -> Any:
        return left * right

    def block(self, rows: list[list[Any]]) -> Any:
        import picos

        return picos.block(rows)

    def model(self, objective: Any, matrices: list[Any]) -> Any:
        import picos

        model = picos.Problem()
        model.set_objective("min", objective)
        for matrix in matrices:
            model.add_constraint(matrix >> 0)
        return model

    def compile(self, model: Any) -> None:
        from picos.solvers import get_solver

        # the step of its solve() that writes the arrays of the solver
        get_solver("cvxopt")(model.prepared(solver="cvxopt"))._load_problem()

    def solve(self, model: Any) -> float:
        model.solve(solver="cvxopt", abs_prim_fsb_tol=1e-7, abs_dual_fsb_tol=1e-7, rel_ipm_opt_tol=1e-7)
        return float(model.value)


def written(problem: Problem, compiled: ConicProblem, tool: Tool) -> Any:
    """The problem in a tool's own expressions; ``compiled`` only says which points were meant."""
    binding = compiled.binding
    theorem, layout = binding.theorem, binding.layout
    variables: dict[str, list[Any]] = {}
    for name, unknown in layout.unknowns.items():
        symmetric = name in theorem.unknowns and theorem.unknowns[name].symmetric
        rows, cols = unknown.coordinate.shape
        variables[name] = [tool.variable(f"{name}_{k}", (rows, cols), symmetric) for k in range(len(unknown.functions))]
    matrices = [
        _matrix(theorem.lmis[name], binding, tool, variables, point)
        for name in binding.lmis
        for point in points(binding, compiled, name, problem.relaxation)
    ]
    objective = _scalar(sp.sympify(theorem.minimise), variables, {})
    return tool.model(objective, matrices)


def points(
    binding: Binding, compiled: ConicProblem, name: str, choice: Relaxation
) -> Iterator[Mapping[sp.Symbol, float]]:
    """The values of all symbols at every LMI of a family that was gridded or put on vertices."""
    family = next(family for family in compiled.families if family.lmi.place.lmi == name)
    geometry = space(binding, choice.ties)
    occurring = {s for atom in family.lmi.monomials.atoms for s in atom.free_symbols}
    axes = [axis for axis in geometry.axes if occurring & set(axis.symbols)]
    idle = {s: float(v) for axis in geometry.axes for s, v in zip(axis.symbols, axis.domain.vertices[0], strict=True)}
    rows = []
    for axis, relaxed in zip(axes, family.axes, strict=True):
        gridded = relaxed.method.startswith("grid")
        rows.append(grid_points(axis, chosen_grid(axis, choice)) if gridded else axis.domain.vertices)
    for chosen in product(*rows):
        values = dict(idle) | dict(binding.values)
        for axis, row in zip(axes, chosen, strict=True):
            values |= {symbol: float(value) for symbol, value in zip(axis.symbols, row, strict=True)}
        yield values | {symbol: values[other] for symbol, other in geometry.equal.items()}


def _matrix(
    lmi: LMI, binding: Binding, tool: Tool, variables: Mapping[str, list[Any]], values: Mapping[sp.Symbol, float]
) -> Any:
    """One LMI at one point, stars filled, as F ≻ 0."""
    size = len(lmi.rows)
    blocks: list[list[Any]] = [[None] * size for _ in range(size)]
    for i, row in enumerate(lmi.rows):
        for j, entry in enumerate(row):
            if isinstance(entry, Node):
                blocks[i][j] = _expression(entry, binding, tool, variables, values)
    for i, row in enumerate(lmi.rows):
        for j, entry in enumerate(row):
            if isinstance(entry, Star) and blocks[j][i] is not None:
                blocks[i][j] = blocks[j][i].T
    orders = [blocks[k][k].shape[0] if blocks[k][k].shape else 1 for k in range(size)]
    full = [
        [tool.constant(np.zeros((orders[i], orders[j]))) if block is None else block for j, block in enumerate(row)]
        for i, row in enumerate(blocks)
    ]
    matrix = tool.block(full) if size > 1 else full[0][0]
    return matrix if lmi.sense > 0 else -matrix


def _expression(
    node: Node, binding: Binding, tool: Tool, variables: Mapping[str, list[Any]], values: Mapping[sp.Symbol, float]
) -> Any:
    def of(inner: Node) -> Any:
        return _expression(inner, binding, tool, variables, values)

    match node:
        case Leaf():
            return _leaf(node, binding, tool, variables, values)
        case Identity():
            return tool.constant(np.eye(int(node.shape[0].subs(binding.sizes))))
        case Zero():
            return tool.constant(np.zeros([int(s.subs(binding.sizes)) for s in node.shape]))
        case MatrixSum():
            total = of(node.nodes[0])
            for operand in node.nodes[1:]:
                total = total + of(operand)
            return total
        case MatrixProduct():
            result = of(node.nodes[0])
            for operand in node.nodes[1:]:
                result = tool.product(result, of(operand))
            return result if node.coefficient == 1 else _scalar(node.coefficient, variables, values) * result
        case Transposed():
            return of(node.nodes[0]).T
        case Hermitian():
            inner = of(node.nodes[0])
            return inner + inner.T
        case Block():
            return tool.block([[of(entry) for entry in row] for row in node.grid])
    raise TypeError(f"{type(node).__name__} is in none of the measured theorems")


def _leaf(
    leaf: Leaf, binding: Binding, tool: Tool, variables: Mapping[str, list[Any]], values: Mapping[sp.Symbol, float]
) -> Any:
    here = {
        sp.Symbol(c): values[instance_symbol(c, parameter.instance)]
        for parameter in leaf.arguments
        if parameter.name in binding.domains
        for c in binding.domains[parameter.name].components
    }
    if leaf.role == "data":
        return tool.constant(binding.plant.matrices[leaf.name].evaluate({s: np.array([v]) for s, v in here.items()})[0])
    functions = binding.layout.unknowns[leaf.name].functions
    total = None
    for function, variable in zip(functions, variables[leaf.name], strict=True):
        weight = float(sp.sympify(function).subs(here))
        term = variable if weight == 1 else weight * variable
        total = term if total is None else total + term
    return total


def _scalar(expression: sp.Expr, variables: Mapping[str, list[Any]], values: Mapping[sp.Symbol, float]) -> Any:
    """A number, or an affine expression of scalar unknowns."""
    by_name = {symbol.name: value for symbol, value in values.items()}
    symbols = sorted(expression.free_symbols, key=str)
    if not symbols:
        return float(expression)
    given = [by_name[s.name] if s.name in by_name else variables[s.name][0] for s in symbols]
    return sp.lambdify(symbols, expression, "math")(*given)
