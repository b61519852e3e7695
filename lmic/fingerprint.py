"""What identifies a theorem and a plant: the parts of a digest by which a file knows its problem."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from lmic.language.nodes import Leaf
from lmic.language.systems import System
from lmic.language.theorem import Theorem
from lmic.plants.plant import Plant


def digest(parts: Any) -> str:
    """SHA-256 of plain data in canonical JSON."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def statement(theorem: Theorem) -> list[str]:
    """Everything in a theorem that decides a number."""
    leaves = {**theorem.unknowns, **theorem.data}
    return [
        *(f"{name}: {lmi.sense} {lmi.rows}" for name, lmi in theorem.lmis.items()),
        *(_declaration(leaf) for leaf in leaves.values()),
        *(f"{name}: {[repr(p) for p in found]}" for name, found in theorem.parameters.items()),
        f"{theorem.minimise} {theorem.bisect} {dict(theorem.reports)}",
        f"{sorted(theorem.constant)} {sorted(theorem.full)}",
    ]


def promises(theorem: Theorem) -> list[str]:
    """What a theorem makes of a solution: the design, and what is said of which system."""
    return [
        *(f"{name}: {node}" for name, node in theorem.recover.items()),
        *(f"{bound.norm} {bound.report} {_system(bound.system)}" for bound in theorem.guarantees),
        *(f"{name}: {_system(system)}" for name, system in theorem.signals.items()),
    ]


def plant_data(plant: Plant) -> list[str]:
    """Everything in a plant that decides a number, and its name, by which a sweep tells it."""
    return [
        plant.name,
        *(f"{name}: {matrix.to_sympy().tolist()}" for name, matrix in plant.matrices.items()),
        *(f"{name}: {domain!r}" for name, domain in plant.domains.items()),
        *(f"{name}: {motion!r}" for name, motion in plant.motions.items()),
        *(f"{name} = {value}" for name, value in plant.scalars.items()),
    ]


def _declaration(leaf: Leaf) -> str:
    return f"{leaf.name} {leaf.shape} {leaf.role} {leaf.symmetric} {leaf.blocks}"


def _system(system: System) -> str:
    return f"{type(system).__name__} { ({name: str(node) for name, node in vars(system).items()}) }"
