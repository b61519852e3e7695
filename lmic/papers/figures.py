"""Draw the papers' figures: signals over time as steps, over the plane as surfaces."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.papers.cases import Panel, Simulation
from lmic.papers.reproduce import Outcome
from lmic.simulate.trajectory import Trajectory

Array: TypeAlias = NDArray[Any]
Trajectories: TypeAlias = Mapping[str, Trajectory]


def draw(
    simulation: Simulation, trajectories: Trajectories, outcomes: Mapping[str, Outcome], folder: Path
) -> list[Path]:
    """One PNG for each figure of the simulation, named by its id."""
    folder.mkdir(parents=True, exist_ok=True)
    return [_figure(panel, trajectories, outcomes, folder) for panel in simulation.figures]


def _figure(panel: Panel, trajectories: Trajectories, outcomes: Mapping[str, Outcome], folder: Path) -> Path:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(layout="constrained")
    FigureCanvasAgg(figure)
    first = next(iter(trajectories.values()))
    if first.w.ndim == 3:
        _surface(figure, _shown(first, panel.show[0])[..., 0])
    else:
        _steps(figure, _rows(panel, trajectories, outcomes))
    figure.suptitle(panel.title, fontsize=11)
    path = folder / f"{panel.id}.png"
    figure.savefig(path, dpi=130)
    return path


def _surface(figure: Any, values: Array) -> None:
    figure.set_size_inches(7, 5)
    axis = figure.add_subplot(projection="3d")
    i, j = np.indices(values.shape)
    axis.plot_surface(i, j, values, cmap="viridis", linewidth=0.2, edgecolor="black", alpha=0.9)
    axis.set_xlabel("i")
    axis.set_ylabel("j")


def _steps(figure: Any, rows: list[tuple[str, dict[str, Array]]]) -> None:
    figure.set_size_inches(7, 1.0 + 2.1 * len(rows))
    axes = np.atleast_1d(figure.subplots(len(rows), sharex=True))
    for axis, (label, curves) in zip(axes, rows, strict=True):
        for name, values in curves.items():
            axis.step(np.arange(len(values)), values, where="post", label=name, linewidth=1.4)
        axis.set_ylabel(label)
        axis.grid(alpha=0.3)
        if len(curves) > 1:
            axis.legend(frameon=False, fontsize=8)
    axes[-1].set_xlabel("k")


def _shown(trajectory: Trajectory, name: str) -> Array:
    """A signal by the name that a case table gives it."""
    if re.fullmatch(r"x\d+", name):
        return trajectory.state[..., int(name[1:]) - 1, None]
    if name in ("e", "w"):
        return trajectory.e if name == "e" else trajectory.w
    return trajectory.others[name] if name in trajectory.others else trajectory.parameters[name]


def _rows(
    panel: Panel, trajectories: Trajectories, outcomes: Mapping[str, Outcome]
) -> list[tuple[str, dict[str, Array]]]:
    """Axes of a figure, (label, curves by name): one per component of what the filters decide."""
    first = next(iter(trajectories.values()))
    rows: list[tuple[str, dict[str, Array]]] = []
    for name in panel.show:
        label, values = sp.latex(sp.Symbol(name)), _shown(first, name)
        if name == "w" or name in first.parameters:
            rows.append((f"${label}(k)$", {f"${label}_{{{c + 1}}}$": values[:, c] for c in range(values.shape[1])}))
            continue
        for c in range(values.shape[1]):
            index = f"_{{{c + 1}}}" if values.shape[1] > 1 else ""
            curves = {outcomes[case].case.what: _shown(t, name)[:, c] for case, t in trajectories.items()}
            rows.append((f"${{{label}}}{index}(k)$", curves))
    return rows
