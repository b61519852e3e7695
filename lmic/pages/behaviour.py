"""What the system of a result does: norms at frozen parameters, poles, a simulation."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.analysis.norms import frozen_gain, frozen_peak
from lmic.analysis.spectra import spectra
from lmic.analysis.walk import Walk
from lmic.language.systems import (
    ContinuousSystem,
    DelayedFornasiniMarchesini,
    DelaySystem,
    FornasiniMarchesini,
    System,
)
from lmic.pages import plots
from lmic.pages.figures import Figure
from lmic.pipeline import Result
from lmic.simulate.typical import typical

Array: TypeAlias = NDArray[Any]

#: points of a walk at which a norm is computed: one of a 2-D system takes a tenth of a second, with delays far longer
NORMS, PLANE_NORMS, DELAYED_NORMS = 41, 17, 3
#: points at which poles are drawn
POLES = 31


def figures(result: Result, path: Walk) -> list[Figure]:
    """The pictures that there are: norms beside their bounds, poles, a simulation."""
    return [figure for figure in (_norms(result, path), _poles(result, path), _simulation(result)) if figure]


def remarks(result: Result, path: Walk) -> list[str]:
    """What no picture shows: norms where nothing varies, and why a picture is missing."""
    systems = [bound.system for bound in result.theorem.guarantees]
    found = []
    if len(path) == 1:
        _, values, bounds = frozen_norms(result, path)
        found += [f"{name} {values[name][0]:.5g}, bound {bounds[name]:.5g}." for name in values]
    if any(isinstance(system, (DelaySystem, DelayedFornasiniMarchesini)) for system in systems):
        found.append("Nothing is simulated: the statement leaves the delays open.")
    elif any(isinstance(system, ContinuousSystem) for system in systems):
        found.append("Nothing is simulated: trajectories are computed in discrete time and over the plane.")
    if any(isinstance(system, (FornasiniMarchesini, DelayedFornasiniMarchesini)) for system in systems):
        found.append("There is no picture of poles: those of a 2-D system are curves in two variables.")
    return found


def frozen_norms(result: Result, path: Walk) -> tuple[Walk, dict[str, Array], dict[str, float]]:
    """Norms of the systems of all guarantees at points of the walk, shape (K,), and what bounds them, by name."""
    guarantees = result.theorem.guarantees
    path = path.thinned(min((_points(bound.system) for bound in guarantees), default=1))
    found: dict[str, Array] = {}
    bounds: dict[str, float] = {}
    for bound in guarantees:
        norm = frozen_peak if bound.norm == "energy to peak" else frozen_gain
        values = norm(result.design, bound.system, path.points)
        if values is None:  # with a delay that varies there is no frozen system
            continue
        name = "energy-to-peak norm" if bound.norm == "energy to peak" else "H∞ norm"
        name += f" for {bound.report}" if name in found else ""
        found[name], bounds[name] = np.broadcast_to(values, (len(path),)), result.reports[bound.report]
    return path, found, bounds


def _points(system: System) -> int:
    if isinstance(system, DelayedFornasiniMarchesini):
        return DELAYED_NORMS
    return PLANE_NORMS if isinstance(system, FornasiniMarchesini) else NORMS


def _norms(result: Result, path: Walk) -> Figure | None:
    if len(path) == 1:
        return None
    path, found, bounds = frozen_norms(result, path)
    return plots.norms(path, found, bounds) if found else None


def _poles(result: Result, path: Walk) -> Figure | None:
    path = path.thinned(POLES)
    found = spectra(result.design, path)
    return plots.poles(found, path) if found else None


def _simulation(result: Result) -> Figure | None:
    found = typical(result)
    if found is None:
        return None
    bound = result.theorem.guarantees[0]
    return plots.simulation(found, result.reports[bound.report], bound.norm)
