"""Names ↔ columns: where the coordinates of every unknown stand in the vector x."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.algebra.polynomials import MatrixPolynomial, row_polynomial
from lmic.compiler.bases import DEFAULT, Choice, basis_functions
from lmic.errors import BasisError, Place, ShapeError
from lmic.language.nodes import Leaf
from lmic.language.theorem import Theorem
from lmic.plants.domains import Domain

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class UnknownLayout:
    """Columns of one unknown: basis function b and coordinate c sit at offset + b·count + c.

    ``coordinate[i, j]`` is the coordinate of the matrix entry (i, j), -1 where it is always zero.
    """

    name: str
    offset: int
    coordinate: Array
    functions: tuple[sp.Expr, ...]

    @property
    def count(self) -> int:
        """Free coordinates of the matrix."""
        return int(self.coordinate.max()) + 1

    @property
    def size(self) -> int:
        """Scalars: coordinates times basis functions."""
        return self.count * len(self.functions)

    @property
    def columns(self) -> slice:
        """The columns of this unknown in x."""
        return slice(self.offset, self.offset + self.size)

    def matrices(self, x: Array) -> Array:
        """The unknown's matrix for each basis function, shape (functions, rows, cols)."""
        coordinates = x[self.columns].reshape(len(self.functions), self.count)
        padded = np.concatenate([coordinates, np.zeros((len(self.functions), 1))], axis=1)
        return padded[:, self.coordinate]

    def polynomial(self, x: Array) -> MatrixPolynomial:
        """The unknown at the solution x, as a polynomial in the parameters' components."""
        total = combination(self.functions)
        values = np.tensordot(total.coefficients[:, 0, :], self.matrices(x), axes=1)
        return MatrixPolynomial(total.monomials, values)


@dataclass(frozen=True)
class Layout:
    """Names ↔ columns: where every unknown's coordinates stand in x."""

    unknowns: Mapping[str, UnknownLayout]

    @property
    def size(self) -> int:
        """Scalars: coordinates times basis functions."""
        return sum(unknown.size for unknown in self.unknowns.values())

    def label(self, column: int) -> str:
        """The name of a column: ``P1[1,2] * alpha1``."""
        for unknown in self.unknowns.values():
            if unknown.offset <= column < unknown.offset + unknown.size:
                function, coordinate = divmod(column - unknown.offset, unknown.count)
                if unknown.coordinate.shape == (1, 1) and len(unknown.functions) == 1:
                    return unknown.name
                i, j = np.argwhere(unknown.coordinate == coordinate)[0] + 1
                basis = unknown.functions[function]
                return f"{unknown.name}[{i},{j}]" + ("" if basis == 1 else f" * {basis}")
        raise IndexError(column)


@lru_cache(maxsize=1024)
def combination(functions: tuple[sp.Expr, ...]) -> MatrixPolynomial:
    """The basis functions as a 1 x B polynomial."""
    return row_polynomial(dict(enumerate(functions)), len(functions))


def coordinates(leaf: Leaf, shape: tuple[int, int], blocks: Sequence[int]) -> Array:
    """Coordinate of each entry of an unknown: shared by symmetric pairs, -1 outside the blocks."""
    rows, cols = np.indices(shape)
    inside = np.ones(shape, dtype=bool)
    if blocks:
        member = np.repeat(np.arange(len(blocks)), blocks)
        inside = member[rows] == member[cols]
    key = np.where(leaf.symmetric, np.minimum(rows, cols) * shape[1] + np.maximum(rows, cols), rows * shape[1] + cols)
    result = np.full(shape, -1)
    _, inverse = np.unique(key[inside], return_inverse=True)
    result[inside] = inverse
    return result


def make_layout(
    theorem: Theorem,
    domains: Mapping[str, Domain],
    sizes: Mapping[sp.Symbol, int],
    dependence: Mapping[str, Choice],
    place: Place,
) -> Layout:
    """Number the coordinates: scalar unknowns first, then the matrices in the order of appearance."""
    unknowns = theorem.unknowns
    foreign = sorted(set(dependence) - set(unknowns))
    if foreign:
        raise BasisError(
            f"{foreign[0]} is no unknown of the theorem, which has {', '.join(unknowns)}; correct the name", place
        )
    layout: dict[str, UnknownLayout] = {}
    offset = 0
    for scalar in theorem.scalar_unknowns:
        layout[scalar.name] = UnknownLayout(scalar.name, offset, np.zeros((1, 1), dtype=int), (sp.Integer(1),))
        offset += 1
    for name, leaf in unknowns.items():
        parameters = {p: domains[p] for p in theorem.dependence(name) if p in domains}
        functions = basis_functions(name, dependence.get(name, DEFAULT), parameters)
        shape = tuple(int(size.subs(sizes)) for size in leaf.shape)
        blocks = [] if name in theorem.full else leaf.block_sizes(lambda size: int(size.subs(sizes)))
        if blocks and sum(blocks) != shape[0]:
            raise ShapeError(
                f"the blocks of {name} have the sizes {' + '.join(map(str, blocks))}, but {name} has {shape[0]} rows; "
                "give blocks that add up",
                place,
            )
        layout[name] = UnknownLayout(name, offset, coordinates(leaf, (shape[0], shape[1]), blocks), functions)
        offset += layout[name].size
    return Layout(layout)
