"""The canonical expansion of a matrix expression: a sum of scalar · product of factors.

``kron`` and ``block`` dissolve into factors I ⊗ M ⊗ I and 0/1 selectors, so that one form of
product serves every structure. L and R stay products of named matrices until numbers enter.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import sympy as sp

from lmic.language.nodes import (
    Block,
    Hermitian,
    Identity,
    Inverse,
    Kronecker,
    Leaf,
    MatrixProduct,
    MatrixSum,
    Node,
    Trace,
    Transposed,
    Zero,
)

Size: TypeAlias = sp.Expr
ONE = sp.Integer(1)


@dataclass(frozen=True)
class Selector:
    """Rows ``offset … offset+size`` of an identity of order ``total``, as a total x size matrix."""

    total: Size
    offset: Size
    size: Size


@dataclass(frozen=True)
class Stacked:
    """The columns of an identity of order ``size`` below one another: s with tr M = sᵀ (I ⊗ M) s."""

    size: Size


@dataclass(frozen=True)
class Factor:
    """I_before ⊗ M ⊗ I_after, where M is a named matrix, an inverse or a selector, or its transpose."""

    matrix: Leaf | Inverse | Selector | Stacked
    transposed: bool = False
    before: Size = ONE
    after: Size = ONE

    @property
    def unknown(self) -> bool:
        """Whether the factor is an unknown of the theorem."""
        return isinstance(self.matrix, Leaf) and self.matrix.role == "unknown"

    @property
    def T(self) -> Factor:
        """The transposed factor; a symmetric matrix is its own."""
        if isinstance(self.matrix, Leaf) and self.matrix.symmetric:
            return self
        return replace(self, transposed=not self.transposed)

    def kron(self, before: Size, after: Size) -> Factor:
        """I_before ⊗ self ⊗ I_after."""
        return replace(self, before=sp.expand(before * self.before), after=sp.expand(self.after * after))


Factors: TypeAlias = tuple[Factor, ...]
Expansion: TypeAlias = dict[Factors, sp.Expr]


def canonical(node: Node) -> Expansion:
    """Fully expanded sum: products of factors and their coefficients, equal products merged.

    Equal expressions have equal expansions (identities dropped, symmetric matrices never
    transposed), which is how mirrored blocks are compared.
    """
    return {factors: c for factors, c in _expand(node).items() if c != 0}


def _expand(node: Node) -> Expansion:
    match node:
        case Leaf():
            return {(Factor(node),): ONE}
        case Inverse():
            return {(Factor(node),): ONE}
        case Identity():
            return {(Factor(Selector(node.shape[0], sp.Integer(0), node.shape[0])),): ONE}
        case Zero():
            return {}
        case MatrixSum():
            return _merge([_expand(operand) for operand in node.nodes])
        case MatrixProduct():
            product: Expansion = {(): node.coefficient}
            for operand in node.nodes:
                product = _multiply(product, _expand(operand))
            return product if node.nodes else {}
        case Transposed():
            return _transpose(_expand(node.nodes[0]))
        case Hermitian():
            expansion = _expand(node.nodes[0])
            return _merge([expansion, _transpose(expansion)])
        case Kronecker():
            left, right = node.nodes
            outer = _kron(_expand(left), ONE, right.shape[0])
            return _multiply(outer, _kron(_expand(right), left.shape[1], ONE))
        case Trace():
            size = node.nodes[0].shape[0]
            columns: Expansion = {(Factor(Stacked(size)),): ONE}
            return _multiply(_multiply(_transpose(columns), _kron(_expand(node.nodes[0]), size, ONE)), columns)
        case Block():
            return _merge(_block_parts(node))
    raise NotImplementedError(f"no expansion for {type(node).__name__}")


def _block_parts(node: Block) -> list[Expansion]:
    rows, cols = node.shape
    parts = []
    for i, row in enumerate(node.grid):
        for j, entry in enumerate(row):
            tall = Factor(Selector(rows, sp.Add(*node.heights[:i]), node.heights[i]))
            wide = Factor(Selector(cols, sp.Add(*node.widths[:j]), node.widths[j])).T
            parts.append(_multiply(_multiply({(tall,): ONE}, _expand(entry)), {(wide,): ONE}))
    return parts


def _merge(expansions: list[Expansion]) -> Expansion:
    total: Expansion = {}
    for expansion in expansions:
        for factors, coefficient in expansion.items():
            total[factors] = sp.expand(total.get(factors, sp.Integer(0)) + coefficient)
    return total


def _multiply(first: Expansion, second: Expansion) -> Expansion:
    return _merge([{_simplified(a + b): sp.expand(ca * cb)} for a, ca in first.items() for b, cb in second.items()])


def _simplified(factors: Factors) -> Factors:
    """Without identities, except where nothing else would be left."""
    kept = tuple(factor for factor in factors if not _is_identity(factor))
    return kept or factors[:1]


def _is_identity(factor: Factor) -> bool:
    return isinstance(factor.matrix, Selector) and factor.matrix.total == factor.matrix.size


def _transpose(expansion: Expansion) -> Expansion:
    return _merge([{_straight(tuple(f.T for f in reversed(factors))): c} for factors, c in expansion.items()])


def _straight(factors: Factors) -> Factors:
    """An identity is its own transpose."""
    return tuple(replace(f, transposed=False) if _is_identity(f) else f for f in factors)


def _kron(expansion: Expansion, before: Size, after: Size) -> Expansion:
    return _merge([{tuple(f.kron(before, after) for f in factors): c} for factors, c in expansion.items()])
