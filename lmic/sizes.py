"""Dimensions: the values of the symbolic sizes, from the shapes of the plant's matrices."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from lmic.errors import Place, PlantError, ShapeError
from lmic.language.theorem import Theorem
from lmic.plants.plant import Plant


def solve_sizes(theorem: Theorem, plant: Plant, sizes: Mapping[str, int], place: Place) -> dict[sp.Symbol, int]:
    """Values of the symbolic dimensions, from the shapes of the plant's matrices."""
    values: dict[sp.Symbol, int] = {}
    witness: dict[sp.Symbol, str] = {}
    for name, leaf in theorem.data.items():
        if name not in plant.matrices:
            has = ", ".join(sorted(plant.matrices)) or "none"
            raise PlantError(
                f"the matrix {name} ({leaf.shape[0]} x {leaf.shape[1]}) is missing in {plant.name}, which has {has}; "
                "add it",
                place,
            )
        for expression, found in zip(leaf.shape, plant.matrices[name].shape, strict=True):
            if expression.is_Symbol and expression not in values:
                values[expression], witness[expression] = found, name
    unknown = sorted(set(plant.matrices) - set(theorem.data) - plant.ingredients)
    if unknown:
        raise PlantError(
            f"{plant.name} gives the matrix {unknown[0]}, which the theorem does not use; "
            f"it uses {', '.join(theorem.data)}: rename or remove it",
            place,
        )
    symbols = set().union(
        *(size.free_symbols for node in theorem.nodes for leaf in node.leaves() for size in leaf.shape)
    )
    for name, size in sizes.items():
        symbol = next((s for s in symbols if s.name == name), None)
        if symbol is None:
            known = ", ".join(sorted(s.name for s in symbols))
            raise ShapeError(f"{name} is no dimension of the theorem, which has {known}; correct the name", place)
        if values.get(symbol, size) != size:
            raise ShapeError(
                f"{name} = {size} is asked for, but {witness[symbol]} has {name} = {values[symbol]}", place
            )
    values |= {symbol: sizes[symbol.name] for symbol in symbols if symbol.name in sizes and symbol not in values}
    for name, leaf in theorem.data.items():
        found_shape = plant.matrices[name].shape
        for axis, expression in enumerate(leaf.shape):
            expected = expression.subs(values)
            if expected != found_shape[axis]:
                because = ", ".join(
                    f"{s} = {values[s]} from {witness.get(s, 'sizes')}"
                    for s in sorted(expression.free_symbols, key=str)
                )
                raise ShapeError(
                    f"the matrix {name} of {plant.name} is {found_shape[0]} x {found_shape[1]}, "
                    f"but {leaf.shape[0]} x {leaf.shape[1]} is needed, where {because}; correct the matrix",
                    place,
                )
    free = sorted((s for s in symbols if s not in values), key=str)
    if free:
        raise ShapeError(
            f"no matrix of {plant.name} fixes the dimension {free[0]}; give it, as sizes={{'{free[0]}': 2}}", place
        )
    return values
