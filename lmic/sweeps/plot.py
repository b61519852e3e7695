"""Draw a sweep: a report over one axis, a curve for each value of the others, or a map over two."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.errors import SweepError
from lmic.files import write_figure
from lmic.pages.figures import STYLE
from lmic.sweeps.axes import Axis
from lmic.sweeps.swept import Swept

Array: TypeAlias = NDArray[Any]

#: curves that an eye can still tell apart; beyond that two axes make a map
CURVES = 8
PICTURES = (".png", ".pdf", ".svg")
#: ratio of neighbouring steps from which an axis is logarithmic
LOGARITHMIC = 3.0
#: ratio of the largest to the median value from which a map is logarithmic
STEEP = 30.0
#: width and height of the picture in inches
SIZE = (6.2, 3.9)


def check_picture(path: Path) -> None:
    """Raise SweepError for a path whose suffix names no picture."""
    if path.suffix.lower() not in PICTURES:
        raise SweepError(f"{path} cannot be drawn: its format is unknown; end the name in {' or '.join(PICTURES)}")


def plot(swept: Swept, path: Path, report: str | None = None, least_over: str | None = None) -> None:
    """Write a picture of one report (the first without ``report``) in the format that the path's suffix names.

    ``least_over`` is an axis along which only the least value counts.
    """
    import matplotlib as mpl

    check_picture(path)
    name = report or swept.reports[0]
    values, axes = swept.values(name), list(swept.plan.axes)
    if least_over is not None:
        values = swept.least(name, least_over)[0]
        del axes[swept.axis(least_over)]
        if not axes:
            raise SweepError(f"{least_over} is the only axis, so nothing is left to draw over; leave out --least-over")
    place = max(range(len(axes)), key=lambda k: (axes[k].numeric, len(axes[k].values)))
    across = axes.pop(place)
    values = np.moveaxis(values, place, -1)
    with mpl.rc_context(STYLE | {"axes.labelsize": 11}):
        write_figure(path, _drawn(swept, across, axes, values, name, least_over))


def _drawn(swept: Swept, across: Axis, axes: list[Axis], values: Array, name: str, least_over: str | None) -> Any:
    """The figure of values whose last axis is ``across``, a curve or a row of a map for each point of the others."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, layout="constrained")
    FigureCanvasAgg(figure)
    panel = figure.add_subplot()
    if len(axes) == 1 and axes[0].numeric and len(axes[0].values) > CURVES:
        _map(figure, panel, across, axes[0], values, name)
    else:
        _curves(panel, across, axes, values.reshape(-1, values.shape[-1]))
        panel.set_ylabel(_label(name))
    panel.set_xlabel(_label(across.column))
    sought = f", best {swept.plan.search[0]} at each point" if swept.plan.search else ""
    sought += f", least over {least_over}" if least_over else ""
    figure.suptitle(f"{swept.plan.theorem.title}{sought}", fontsize=10)
    return figure


def _curves(panel: Any, across: Axis, others: list[Axis], values: Array) -> None:
    position = np.asarray(across.shown, dtype=float) if across.numeric else np.arange(len(across.values))
    order = np.argsort(position)
    marker = "." if len(position) <= 40 else ""
    for labels, curve in zip(product(*(axis.labels for axis in others)), values, strict=True):
        named = ", ".join(f"{axis.column} = {label}" for axis, label in zip(others, labels, strict=True))
        panel.plot(position[order], curve[order], marker=marker, label=named)
    if not across.numeric:
        panel.set_xticks(position, across.labels, rotation=20 if len(position) > 4 else 0)
    elif _logarithmic(position[order]):
        panel.set_xscale("log")
    if others and len(values) <= 2 * CURVES:
        panel.legend()


def _map(figure: Any, panel: Any, across: Axis, along: Axis, values: Array, name: str) -> None:
    from matplotlib.colors import LogNorm

    x, y = np.asarray(across.shown, dtype=float), np.asarray(along.shown, dtype=float)
    by_x, by_y = np.argsort(x), np.argsort(y)
    shown = np.ma.masked_invalid(values[np.ix_(by_y, by_x)])
    steep = shown.count() and shown.min() > 0 and shown.max() > STEEP * float(np.median(shown.compressed()))
    norm = LogNorm(shown.min(), shown.max()) if steep else None
    image = panel.pcolormesh(x[by_x], y[by_y], shown, cmap="viridis", shading="nearest", norm=norm)
    if _logarithmic(x[by_x]):
        panel.set_xscale("log")
    if _logarithmic(y[by_y]):
        panel.set_yscale("log")
    panel.set_ylabel(_label(along.column))
    figure.colorbar(image, ax=panel, label=_label(name))


def _logarithmic(values: Array) -> bool:
    """Whether the steps grow so much that a logarithmic scale shows the points better."""
    steps = np.diff(values)
    return bool(len(steps) > 1 and values[0] > 0 and steps[-1] > LOGARITHMIC * steps[0])


def _label(name: str) -> str:
    """A name as a formula where it is one: gamma becomes γ."""
    import sympy as sp

    return f"${sp.latex(sp.Symbol(name))}$" if name.isidentifier() else name
