"""Necessary conditions on the data, checked before anything is solved."""

from __future__ import annotations

import numpy as np

from lmic.compiler.bind import Binding
from lmic.errors import Place, PlantError
from lmic.language.systems import Schur
from lmic.plants.domains import vertex_points
from lmic.recover.recover import Design


def check_assumptions(binding: Binding) -> None:
    """Raise PlantError where a frozen vertex of the plant already rules out every solution."""
    data = Design(binding, np.zeros(binding.layout.size))
    points = vertex_points(binding.domains)
    for condition in binding.theorem.assumes:
        matrices = data.at(condition.matrix, points)
        if not np.isfinite(matrices).all():
            raise PlantError(
                f"{condition.matrix} of {binding.plant.name} is not finite at a vertex of the domain; "
                "shrink the domain away from the pole",
                Place(binding.theorem.name),
            )
        eigenvalues = np.linalg.eigvals(matrices)
        sizes = np.abs(eigenvalues) if isinstance(condition, Schur) else eigenvalues.real
        found = sizes.max(axis=-1)
        worst = int(np.argmax(found))
        if found[worst] >= condition.limit:
            where = ", ".join(f"{name} = {np.array2string(values[worst])}" for name, values in points.items())
            raise PlantError(
                f"{condition.matrix} of {binding.plant.name} is unstable{' at ' + where if where else ''} "
                f"({condition.word} {found[worst]:.4g}), and {condition.because}, so no solution exists; "
                "stabilise the plant or shrink the domain",
                Place(binding.theorem.name),
            )
