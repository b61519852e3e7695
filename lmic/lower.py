"""Stage 1, lower: a theorem's LMI with stars filled, its sign turned to F ≻ 0, shapes checked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeAlias

import sympy as sp

from lmic.errors import AsymmetryError, DefinitionError, Place, ShapeError
from lmic.expand import canonical
from lmic.language.declarations import Star
from lmic.language.nodes import (
    Block,
    Hermitian,
    Identity,
    Inverse,
    MatrixProduct,
    MatrixSum,
    Node,
    Trace,
    is_zero,
)
from lmic.language.theorem import LMI, Theorem

Size: TypeAlias = sp.Expr


@dataclass(frozen=True)
class SymbolicLMI:
    """F ≻ 0 by its upper blocks: ``blocks[i, j]`` with i ≤ j (from 0), zero blocks left out.

    ``partition`` are the symbolic sizes of the block rows; ``sense`` is +1 where the theorem
    states F ≻ 0 and -1 where it states −F ≺ 0.
    """

    place: Place
    partition: tuple[Size, ...]
    sense: int
    blocks: Mapping[tuple[int, int], Node]


def lower(theorem: Theorem) -> dict[str, SymbolicLMI]:
    """Every LMI of the theorem, checked and turned to F ≻ 0."""
    return {name: lower_lmi(lmi, Place(theorem.name, name)) for name, lmi in theorem.lmis.items()}


def lower_lmi(lmi: LMI, place: Place) -> SymbolicLMI:
    """One LMI; raises when it is not square, not symmetric, or its blocks do not fit."""
    size = len(lmi.rows)
    for i, row in enumerate(lmi.rows):
        if len(row) != size:
            raise DefinitionError(
                f"row {i + 1} has {len(row)} blocks but the LMI has {size} rows; write star for each mirrored block",
                place,
            )
    entries = {
        (i, j): _entry(entry, place.at((i + 1, j + 1))) for i, row in enumerate(lmi.rows) for j, entry in enumerate(row)
    }
    for (i, j), entry in entries.items():
        if i == j and isinstance(entry, Star):
            raise DefinitionError("a diagonal block cannot be a star; write the block", place.at((i + 1, i + 1)))
        if isinstance(entry, Node):
            check_shapes(entry, place.at((i + 1, j + 1)))
    partition = _partition(entries, size, place)
    blocks: dict[tuple[int, int], Node] = {}
    for i in range(size):
        for j in range(i, size):
            block = _upper_block(entries, i, j, place)
            if block is not None:
                blocks[i, j] = block if lmi.sense > 0 else MatrixProduct.of(-1, block)
    return SymbolicLMI(place, partition, lmi.sense, blocks)


def _entry(entry: Any, place: Place) -> Node | Star | None:
    """A block as an expression, a star, or None for a literal zero."""
    if isinstance(entry, (Node, Star)):
        return entry
    if is_zero(entry):
        return None
    if isinstance(entry, (int, float, sp.Expr)) and not isinstance(entry, sp.MatrixExpr):
        return MatrixProduct.of(entry, Identity(1))
    raise DefinitionError(f"{entry!r} is not a block; give a matrix expression, 0 or star", place)


def _partition(entries: Mapping[tuple[int, int], Any], size: int, place: Place) -> tuple[Size, ...]:
    """Sizes of the block rows, from the diagonal blocks or else from any block of the row or column."""
    sizes: list[Size] = []
    for k in range(size):
        candidates = [entries[k, k]] if isinstance(entries[k, k], Node) else []
        row = [(entries[k, j].shape[0], (k, j)) for j in range(size) if isinstance(entries[k, j], Node)]
        column = [(entries[i, k].shape[1], (i, k)) for i in range(size) if isinstance(entries[i, k], Node)]
        if not row + column:
            raise ShapeError(f"row {k + 1} holds no matrix, so its size is unknown; use zeros(n, n) in it", place)
        sizes.append(candidates[0].shape[0] if candidates else (row + column)[0][0])
        for found, (i, j) in row + column:
            if not same_size(found, sizes[k]):
                rows, cols = entries[i, j].shape
                raise ShapeError(
                    f"{entries[i, j]} is {rows} x {cols} but block row {k + 1} has size {sizes[k]}; "
                    "transpose it or correct its declaration",
                    place.at((i + 1, j + 1)),
                )
    return tuple(sizes)


def _upper_block(entries: Mapping[tuple[int, int], Any], i: int, j: int, place: Place) -> Node | None:
    """The block (i, j), i ≤ j, from itself or its mirrored star; symmetric pairs are compared."""
    here, mirrored = entries[i, j], entries[j, i]
    if i == j:
        if here is not None:
            _require_symmetric(here, place.at((i + 1, i + 1)))
        return here
    if isinstance(here, Star) and isinstance(mirrored, Star):
        raise DefinitionError(
            f"this block and its mirror ({j + 1},{i + 1}) are both star; write one of them", place.at((i + 1, j + 1))
        )
    if isinstance(mirrored, Star):
        return here
    if isinstance(here, Star):
        return mirrored.T if mirrored is not None else None
    if not _same(here, mirrored.T if mirrored is not None else None):
        raise AsymmetryError(
            f"{here or 0} is not the transpose of block ({j + 1},{i + 1}), {mirrored or 0}; "
            "write one of the two and star for the other",
            place.at((i + 1, j + 1)),
        )
    return here


def _require_symmetric(block: Node, place: Place) -> None:
    if block.shape[0] != 1 and not _same(block, block.T):
        raise AsymmetryError(f"{block} is not symmetric; wrap it in He(...) or declare its matrix Symmetric", place)


def _same(first: Node | None, second: Node | None) -> bool:
    return (canonical(first) if first is not None else {}) == (canonical(second) if second is not None else {})


def same_size(first: Size, second: Size) -> bool:
    """Whether two symbolic sizes are equal."""
    return bool(sp.expand(first - second) == 0)


def check_shapes(node: Node, place: Place) -> None:
    """Raise ShapeError naming the smallest expression whose operands do not fit."""
    for operand in node.nodes:
        check_shapes(operand, place)
    for first, second, relation in _pairs(node):
        if not same_size(first[1], second[1]):
            raise ShapeError(
                f"in {node}, {first[0]} and {second[0]} do not {relation}: {first[1]} against {second[1]}; "
                "correct the declared sizes or transpose one of them",
                place,
            )


Sized: TypeAlias = tuple[str, Size]


def _pairs(node: Node) -> Iterator[tuple[Sized, Sized, str]]:
    """Sizes that must agree in an expression."""
    operands: Sequence[Node] = node.nodes
    if isinstance(node, MatrixSum):
        for other in operands[1:]:
            for axis in (0, 1):
                yield _sized(operands[0], axis), _sized(other, axis), "add"
    elif isinstance(node, MatrixProduct):
        for left, right in pairwise(operands):
            yield _sized(left, 1), _sized(right, 0), "multiply"
    elif isinstance(node, (Hermitian, Inverse, Trace)):
        yield _sized(operands[0], 0), _sized(operands[0], 1), "make a square matrix"
    elif isinstance(node, Block):
        for i, row in enumerate(node.grid):
            for j, entry in enumerate(row):
                yield _sized(row[0], 0), _sized(entry, 0), "share block row " + str(i + 1)
                yield _sized(node.grid[0][j], 1), _sized(entry, 1), "share block column " + str(j + 1)


def _sized(node: Node, axis: int) -> Sized:
    return f"{node} ({node.shape[0]} x {node.shape[1]})", node.shape[axis]
