"""Dimensions: the values of the symbolic sizes, from the shapes of the plant's matrices."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import sympy as sp

from lmic.errors import Place, PlantError, ShapeError
from lmic.faults import Checked, demand
from lmic.language.nodes import Leaf, Node
from lmic.language.theorem import Theorem
from lmic.plants.plant import Plant


def solve_sizes(theorem: Theorem, plant: Plant, sizes: Mapping[str, int], place: Place) -> dict[sp.Symbol, int]:
    """Values of the symbolic dimensions, from the shapes of the plant's matrices; raises where they do not fit."""
    return demand(sizes_of(theorem, plant, sizes, place))


def sizes_of(theorem: Theorem, plant: Plant, sizes: Mapping[str, int], place: Place) -> Checked[dict[sp.Symbol, int]]:
    """The same with every matrix that is missing, unknown or of the wrong shape."""
    values: dict[sp.Symbol, int] = {}
    witness: dict[sp.Symbol, str] = {}
    for name, leaf in theorem.data.items():
        if name not in plant.matrices:
            has = ", ".join(sorted(plant.matrices)) or "none"
            yield PlantError(
                f"the matrix {name} ({leaf.shape[0]} x {leaf.shape[1]}) is missing in {plant.name}, which has {has}; "
                "add it",
                place,
            )
            continue
        for expression, found in zip(leaf.shape, plant.matrices[name].shape, strict=True):
            if expression.is_Symbol and expression not in values:
                values[expression], witness[expression] = found, name
    unknown = sorted(set(plant.matrices) - set(theorem.data) - plant.ingredients)
    for name in unknown:
        yield PlantError(
            f"{plant.name} gives the matrix {name}, which the theorem does not use; "
            f"it uses {', '.join(theorem.data)}: rename or remove it",
            place,
        )
    symbols = set().union(*(size.free_symbols for node in _all_nodes(theorem) for size in node.shape))
    for name, size in sizes.items():
        symbol = next((s for s in symbols if s.name == name), None)
        if symbol is None:
            known = ", ".join(sorted(s.name for s in symbols))
            yield ShapeError(f"{name} is no dimension of the theorem, which has {known}; correct the name", place)
        elif values.get(symbol, size) != size:
            yield ShapeError(
                f"{name} = {size} is asked for, but {witness[symbol]} has {name} = {values[symbol]}; "
                "leave the size out",
                place,
            )
    values |= {symbol: sizes[symbol.name] for symbol in symbols if symbol.name in sizes and symbol not in values}
    for name, leaf in theorem.data.items():
        if name not in plant.matrices:
            continue
        found_shape = plant.matrices[name].shape
        for axis, expression in enumerate(leaf.shape):
            expected = expression.subs(values)
            if expected != found_shape[axis]:
                because = ", ".join(
                    f"{s} = {values[s]} from {witness.get(s, 'sizes')}"
                    for s in sorted(expression.free_symbols, key=str)
                )
                yield ShapeError(
                    f"the matrix {name} of {plant.name} is {found_shape[0]} x {found_shape[1]}, "
                    f"but {leaf.shape[0]} x {leaf.shape[1]} is needed, where {because}; correct the matrix",
                    place,
                )
    missing = {symbol for name in set(theorem.data) - set(plant.matrices) for symbol in _symbols(theorem.data[name])}
    for free in sorted((s for s in symbols - missing if s not in values), key=str):
        yield ShapeError(
            f"no matrix of {plant.name} fixes the dimension {free}; give it, as sizes={{'{free}': 2}}", place
        )
    return values


def _symbols(leaf: Leaf) -> set[sp.Symbol]:
    return set().union(*(size.free_symbols for size in leaf.shape))


def _all_nodes(theorem: Theorem) -> Iterator[Node]:
    """Every matrix expression and all that it is made of: an identity's size may stand nowhere else."""
    for node in theorem.nodes:
        yield from (part for part in sp.preorder_traversal(node) if isinstance(part, Node))
