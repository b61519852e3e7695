"""Draw the papers' figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

from lmic.papers.cases import Panel
from lmic.papers.reproduce import Outcome, Simulated
from lmic.simulate import Trajectory


def draw(simulated: Simulated, outcomes: dict[str, Outcome], folder: Path) -> list[Path]:
    """One PNG for each figure of the simulation, named by its id."""
    folder.mkdir(parents=True, exist_ok=True)
    return [_figure(panel, simulated, outcomes, folder) for panel in simulated.simulation.figures]


def _figure(panel: Panel, simulated: Simulated, outcomes: dict[str, Outcome], folder: Path) -> Path:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    rows = _rows(panel, simulated, outcomes)
    figure = Figure(figsize=(7, 1.0 + 2.1 * len(rows)), layout="constrained")
    FigureCanvasAgg(figure)
    for axis, (label, curves) in zip(np.atleast_1d(figure.subplots(len(rows), sharex=True)), rows, strict=True):
        for name, values in curves.items():
            axis.step(np.arange(len(values)), values, where="post", label=name, linewidth=1.4)
        axis.set_ylabel(label)
        axis.grid(alpha=0.3)
        if len(curves) > 1:
            axis.legend(frameon=False, fontsize=8)
        bottom = axis
    bottom.set_xlabel("k")
    figure.suptitle(panel.title, fontsize=11)
    path = folder / f"{panel.id}.png"
    figure.savefig(path, dpi=130)
    return path


def _rows(panel: Panel, simulated: Simulated, outcomes: dict[str, Outcome]) -> list[tuple[str, dict[str, Any]]]:
    """Axes of a figure: (label, curves by name); the error gets an axis per component."""
    first: Trajectory = next(iter(simulated.trajectories.values()))
    rows: list[tuple[str, dict[str, Any]]] = []
    for shown in panel.show:
        if shown == "e":
            for component in range(first.z.shape[1]):
                curves = {outcomes[case].case.what: t.z[:, component] for case, t in simulated.trajectories.items()}
                rows.append((f"$e_{{{component + 1}}}(k)$", curves))
        elif shown == "w":
            rows.append(("$w(k)$", _components("w", first.w)))
        else:
            name = sp.latex(sp.Symbol(shown))
            rows.append((f"${name}(k)$", _components(name, first.parameters[shown])))
    return rows


def _components(name: str, values: Any) -> dict[str, Any]:
    """Curves of a vector signal, one per component."""
    return {f"${name}_{{{i + 1}}}$": values[:, i] for i in range(values.shape[1])}
