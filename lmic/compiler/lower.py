"""Stage 1, lower: a theorem's LMI with stars filled, its sign turned to F ≻ 0, shapes checked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeAlias

import sympy as sp

from lmic.compiler.expand import canonical
from lmic.errors import AsymmetryError, DefinitionError, Place, ShapeError
from lmic.faults import Checked, demand
from lmic.language.lmi import LMI
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
from lmic.language.star import Star
from lmic.language.theorem import Theorem

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


#: size of a block row of which no sound block is known
UNKNOWN_SIZE = sp.Symbol("?")

#: what a block is: an expression, a star, or None for a literal zero; faulty blocks are left out
Entries: TypeAlias = dict[tuple[int, int], Node | Star | None]


def lower(theorem: Theorem) -> dict[str, SymbolicLMI]:
    """Every LMI of the theorem, checked and turned to F ≻ 0; the formulas beside the LMIs are checked too."""
    found = {name: lower_lmi(lmi, Place(theorem.name, name)) for name, lmi in theorem.lmis.items()}
    demand(check_formulas(theorem))
    return found


def lower_lmi(lmi: LMI, place: Place) -> SymbolicLMI:
    """One LMI; raises when it is not square, not symmetric, or its blocks do not fit."""
    return demand(lowered(lmi, place))


def lowered(lmi: LMI, place: Place) -> Checked[SymbolicLMI]:
    """One LMI with all its faults; the blocks that have one are left out."""
    size = len(lmi.rows)
    entries: Entries = {}
    for i, row in enumerate(lmi.rows):
        if len(row) != size:
            yield DefinitionError(
                f"row {i + 1} has {len(row)} blocks but the LMI has {size} rows; write star for each mirrored block",
                place,
            )
    for i, row in enumerate(lmi.rows):
        for j, entry in enumerate(row[:size]):
            yield from _add_entry(entries, i, j, entry, place.at((i + 1, j + 1)))
    partition = yield from _partition(entries, size, place)
    blocks: dict[tuple[int, int], Node] = {}
    for i in range(size):
        for j in range(i, size):
            block = yield from _upper_block(entries, i, j, place)
            if block is not None:
                blocks[i, j] = block if lmi.sense > 0 else MatrixProduct.of(-1, block)
    return SymbolicLMI(place, partition, lmi.sense, blocks)


def check_formulas(theorem: Theorem) -> Checked[None]:
    """Shapes in what is recovered, promised and assumed."""
    for part, node in theorem.formulas:
        if not isinstance(node, Node):
            continue
        place = Place(theorem.name, part=part)
        faulty = yield from shape_faults(node, place)
        if part[0] == "assumes" and not faulty and not same_size(*node.shape):
            yield ShapeError(f"{node} is {node.shape[0]} x {node.shape[1]}; only a square matrix is stable", place)


def _add_entry(entries: Entries, i: int, j: int, entry: Any, place: Place) -> Checked[None]:
    """Enter a block that is sound in itself."""
    if i == j and isinstance(entry, Star):
        yield DefinitionError("a diagonal block cannot be a star; write the block", place)
        return
    try:
        block = _entry(entry, place)
    except DefinitionError as fault:
        yield fault
        return
    faults = list(shape_faults(block, place)) if isinstance(block, Node) else []
    yield from faults
    if not faults:
        entries[i, j] = block


def _entry(entry: Any, place: Place) -> Node | Star | None:
    """A block as an expression, a star, or None for a literal zero."""
    if isinstance(entry, (Node, Star)):
        return entry
    if is_zero(entry):
        return None
    if isinstance(entry, (int, float, sp.Expr)) and not isinstance(entry, sp.MatrixExpr):
        return MatrixProduct.of(entry, Identity(1))
    raise DefinitionError(f"{entry!r} is not a block; give a matrix expression, 0 or star", place)


def _partition(entries: Entries, size: int, place: Place) -> Checked[tuple[Size, ...]]:
    """Sizes of the block rows, from the diagonal blocks or else from any block of the row or column.

    Blocks that do not fit leave the entries.
    """
    sizes: list[Size] = []
    for k in range(size):
        row = [(node.shape[0], (k, j)) for j in range(size) if isinstance(node := entries.get((k, j)), Node)]
        column = [(node.shape[1], (i, k)) for i in range(size) if isinstance(node := entries.get((i, k)), Node)]
        whole = all((k, j) in entries and (j, k) in entries for j in range(size))
        if not row + column:
            sizes.append(UNKNOWN_SIZE)
            if whole:
                yield ShapeError(f"row {k + 1} holds no matrix, so its size is unknown; use zeros(n, n) in it", place)
            continue
        diagonal = entries.get((k, k))
        sizes.append(diagonal.shape[0] if isinstance(diagonal, Node) else (row + column)[0][0])
        for found, (i, j) in row + column:
            block = entries.get((i, j))
            if isinstance(block, Node) and not same_size(found, sizes[k]):
                rows, cols = block.shape
                yield ShapeError(
                    f"{block} is {rows} x {cols} but block row {k + 1} has size {sizes[k]}; "
                    "transpose it or correct its declaration",
                    place.at((i + 1, j + 1)),
                )
                del entries[i, j]
    return tuple(sizes)


def _upper_block(entries: Entries, i: int, j: int, place: Place) -> Checked[Node | None]:
    """The block (i, j), i ≤ j, from itself or its mirrored star; symmetric pairs are compared."""
    here, mirrored = entries.get((i, j)), entries.get((j, i))
    both = (i, j) in entries and (j, i) in entries
    place = place.at((i + 1, j + 1))
    if isinstance(here, Star) and isinstance(mirrored, Star):
        yield DefinitionError(f"this block and its mirror ({j + 1},{i + 1}) are both star; write one of them", place)
        return None
    if isinstance(here, Star):
        return mirrored.T if isinstance(mirrored, Node) else None
    if i == j:
        if here is not None and here.shape[0] != 1 and not _same(here, here.T):
            yield AsymmetryError(f"{here} is not symmetric; wrap it in He(...) or declare its matrix Symmetric", place)
            return None
        return here
    if isinstance(mirrored, Star) or not both:
        return here
    if not _same(here, mirrored.T if mirrored is not None else None):
        yield AsymmetryError(
            f"{here or 0} is not the transpose of block ({j + 1},{i + 1}), {mirrored or 0}; "
            "write one of the two and star for the other",
            place,
        )
        return None
    return here


def _same(first: Node | None, second: Node | None) -> bool:
    return (canonical(first) if first is not None else {}) == (canonical(second) if second is not None else {})


def same_size(first: Size, second: Size) -> bool:
    """Whether two symbolic sizes are equal."""
    return bool(sp.expand(first - second) == 0)


def shape_faults(node: Node, place: Place) -> Checked[bool]:
    """Every smallest expression whose operands do not fit; returns whether there was one."""
    faulty = False
    for operand in node.nodes:
        faulty |= yield from shape_faults(operand, place)
    if faulty:
        return True
    for first, second, relation in _pairs(node):
        if not same_size(first[1], second[1]):
            yield ShapeError(
                f"in {node}, {first[0]} and {second[0]} do not {relation}: {first[1]} against {second[1]}; "
                "correct the declared sizes or transpose one of them",
                place,
            )
            faulty = True
    return faulty


Sized: TypeAlias = tuple[str, Size]


def _pairs(node: Node) -> Iterator[tuple[Sized, Sized, str]]:
    """Sizes that must agree in an expression."""
    operands: Sequence[Node] = node.nodes
    if isinstance(node, MatrixSum):
        for other in operands[1:]:
            axis = 0 if not same_size(operands[0].shape[0], other.shape[0]) else 1
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
