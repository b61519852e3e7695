"""Necessary conditions on the data, checked before anything is solved."""

from __future__ import annotations

import numpy as np

from lmic.bind import Binding
from lmic.errors import Place, PlantError
from lmic.recover import Design


def check_assumptions(binding: Binding) -> None:
    """Raise PlantError where a frozen vertex of the plant already rules out every solution."""
    data = Design(binding, np.zeros(binding.layout.size))
    points = {name: domain.vertices for name, domain in binding.domains.items()}
    for condition in binding.theorem.assumes:
        for name, vertices in points.items():
            # other parameters are held at their first vertex: each point is admissible on its own
            values = {other: np.repeat(found[:1], len(vertices), axis=0) for other, found in points.items()}
            matrices = data.at(condition.matrix, values | {name: vertices})
            radii = np.abs(np.linalg.eigvals(matrices)).max(axis=-1)
            worst = int(np.argmax(radii))
            if radii[worst] >= 1:
                raise PlantError(
                    f"{condition.matrix} of {binding.plant.name} is unstable at vertex {worst + 1} of {name} "
                    f"(spectral radius {radii[worst]:.4g}), and {condition.because}, so no solution exists; "
                    "stabilise the plant or shrink the domain",
                    Place(binding.theorem.name),
                )
