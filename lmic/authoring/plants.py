"""Check a plant file beside its theorem."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from lmic.authoring.checkup import Finding
from lmic.compiler.bind import domains_of
from lmic.errors import LmicError, Place
from lmic.faults import collect
from lmic.language.theorem import Theorem
from lmic.pipeline import prepare
from lmic.plants.files import read_plant
from lmic.plants.sizes import sizes_of


def check_plant(theorem: Theorem, path: Path, sizes: Mapping[str, int]) -> list[Finding]:
    """Everything in a plant file that does not fit a sound theorem: matrices, their shapes, domains, dependence."""
    try:
        plant = read_plant(path)
        place = Place(theorem.name)
        faults = collect(domains_of(theorem, plant, place))[0] + collect(sizes_of(theorem, plant, sizes, place))[0]
        if not faults:
            prepare(theorem, plant, sizes=sizes)
    except LmicError as error:
        faults = [error]
    return [
        Finding(True, type(fault).__name__, path, None, fault.place, fault.reason.removeprefix(f"{path}: "))
        for fault in faults
    ]
