"""Draw the papers' figures: signals over time or the plane, responses as maps, sweeps as curves."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.analysis.norms import frozen_magnitude
from lmic.errors import LibraryError
from lmic.files import write_figure
from lmic.language.systems import DelayedFornasiniMarchesini, FornasiniMarchesini
from lmic.papers.cases import CaseTable, Curve, Panel, Response, Simulation
from lmic.papers.reproduce import Outcome
from lmic.simulate.trajectory import Trajectory
from lmic.sweeps.axes import Axis
from lmic.sweeps.swept import Swept

Array: TypeAlias = NDArray[Any]
Trajectories: TypeAlias = Mapping[str, Trajectory]

#: frequencies in each direction at which a response is drawn
FREQUENCIES = 121
#: maps in one row of a figure
COLUMNS = 4


def draw(
    simulation: Simulation, trajectories: Trajectories, outcomes: Mapping[str, Outcome], folder: Path
) -> list[Path]:
    """One PNG for each figure of the simulation, named by its id."""
    folder.mkdir(parents=True, exist_ok=True)
    return [_figure(panel, trajectories, outcomes, folder) for panel in simulation.figures]


def draw_responses(table: CaseTable, outcomes: Mapping[str, Outcome], folder: Path) -> list[Path]:
    """One PNG for each response of the table whose case has a design, named by its id."""
    return [
        _response(response, outcomes[response.case], folder)
        for response in table.responses
        if outcomes[response.case].result.solution.status.usable
    ]


def draw_curve(curve: Curve, swept: Mapping[str, Swept], folder: Path) -> list[Path]:
    """One PNG for the curve and one for its improvement, and the table of every sweep as CSV."""
    reported = {name: sweep.values(curve.report) for name, sweep in swept.items()}
    labels = {name: f"{s.plan.theorem.source.statement}, {s.plan.theorem.title}" for name, s in swept.items()}
    across = next(iter(swept.values())).plan.axes[0]
    symbol = sp.latex(sp.Symbol(curve.report))
    written = [
        _curves(curve.id, curve.title, across, {labels[n]: v for n, v in reported.items()}, f"${symbol}$", folder)
    ]
    if curve.improvement:
        best, *others = reported.items()
        gains = {f"against {labels[name]}": 100 * (1 - best[1] / values) for name, values in others}
        what = f"smaller ${symbol}$ (%)"
        written.append(_curves(curve.improvement.id, curve.improvement.title, across, gains, what, folder))
    for name, sweep in swept.items():
        sweep.write_table(folder / f"{curve.id}.{name.rpartition('.')[2]}.csv")
    return written


def _curves(name: str, title: str, across: Axis, curves: Mapping[str, Array], what: str, folder: Path) -> Path:
    figure = _canvas()
    figure.set_size_inches(7, 4.2)
    axis = figure.add_subplot()
    for number, (label, values) in enumerate(curves.items()):
        axis.plot(across.shown, values, "-" if number == 0 else "--", marker=".", linewidth=1.4, label=label)
    axis.set_xlabel(f"${sp.latex(sp.Symbol(across.column))}$")
    axis.set_ylabel(what)
    axis.grid(alpha=0.3)
    axis.legend(frameon=False, fontsize=8)
    return _saved(figure, name, title, folder)


def _figure(panel: Panel, trajectories: Trajectories, outcomes: Mapping[str, Outcome], folder: Path) -> Path:
    figure = _canvas()
    first = next(iter(trajectories.values()))
    if first.w.ndim == 3:
        _surface(figure, _shown(first, panel.show[0])[..., 0])
    else:
        _steps(figure, _rows(panel, trajectories, outcomes))
    return _saved(figure, panel.id, panel.title, folder)


def _response(response: Response, outcome: Outcome, folder: Path) -> Path:
    """A map of the magnitude for each row of parameter values, and the maxima beside the bound."""
    result = outcome.result
    bounds = [b for b in result.theorem.guarantees if b.norm == "l2 gain"]
    system = bounds[0].system if bounds else None
    if not isinstance(system, (FornasiniMarchesini, DelayedFornasiniMarchesini)):
        raise LibraryError(
            f"{outcome.case.theorem} bounds the l2 gain of no 2-D system; give {response.id} a case whose theorem does"
        )
    axis = np.linspace(-np.pi, np.pi, FREQUENCIES)
    frequencies = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
    values = frozen_magnitude(result.design, system, response.parameters, frequencies, response.delay)
    bound, labels = result.reports[bounds[0].report], _labels(response.parameters)
    figure = _canvas()
    _maps(figure, values.reshape(-1, FREQUENCIES, FREQUENCIES), labels, bound)
    return _saved(figure, response.id, response.title, folder)


def _labels(parameters: Mapping[str, Any]) -> list[str]:
    """What the parameters are at each of the rows, as one line."""
    rows = zip(*parameters.values(), strict=True)
    return [", ".join(f"({', '.join(f'{value:g}' for value in values)})" for values in row) for row in rows]


def _maps(figure: Any, values: Array, labels: list[str], bound: float) -> None:
    rows = -(-(len(values) + 1) // COLUMNS)
    figure.set_size_inches(2.6 * COLUMNS + 1, 2.6 * rows + 0.4)
    axes = figure.subplots(rows, COLUMNS).ravel()
    maps = axes[: len(values)]
    for axis, magnitude, label in zip(maps, values, labels, strict=True):
        image = axis.imshow(
            magnitude.T, origin="lower", extent=(-np.pi, np.pi, -np.pi, np.pi), vmin=0, vmax=bound, cmap="viridis"
        )
        axis.set_title(f"at {label}", fontsize=9)
        axis.set_xticks([-np.pi, 0, np.pi], ["−π", "0", "π"])
        axis.set_yticks([-np.pi, 0, np.pi], ["−π", "0", "π"])
        axis.set_xlabel(r"$\omega_1$ (rad/step)", fontsize=8)
        axis.set_ylabel(r"$\omega_2$ (rad/step)", fontsize=8)
    figure.colorbar(image, ax=list(axes), label=f"gain from w to e; the scale ends at the bound {bound:.4g}")
    _maxima(axes[len(values)], values.max(axis=(1, 2)), labels, bound)
    for axis in axes[len(values) + 1 :]:
        axis.set_axis_off()


def _maxima(axis: Any, maxima: Array, labels: list[str], bound: float) -> None:
    places = np.arange(len(maxima))
    axis.plot(places, maxima, "o", markersize=4)
    axis.axhline(bound, color="tab:red", linestyle="--", linewidth=1.2)
    axis.annotate(f"bound {bound:.4g}", (0, bound), (0, -10), textcoords="offset points", color="tab:red", fontsize=8)
    axis.set_ylim(0, 1.08 * bound)
    axis.set_xticks(places, labels, rotation=90, fontsize=7)
    axis.set_title("largest gain at each", fontsize=9)
    axis.grid(alpha=0.3)


def _canvas() -> Any:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _saved(figure: Any, name: str, title: str, folder: Path) -> Path:
    figure.suptitle(title, fontsize=11)
    path = folder / f"{name}.png"
    write_figure(path, figure)
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
