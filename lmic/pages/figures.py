"""Pictures of a result in one restrained style, as SVG inside a page."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO
from typing import Any

#: what a figure is drawn with; a page turns the colours around where it is dark
STYLE: Any = {
    "axes.edgecolor": "#5b6575",
    "axes.grid": True,
    "axes.labelsize": 9,
    "axes.linewidth": 0.7,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 9,
    "font.size": 9,
    "grid.color": "#d8dde5",
    "grid.linewidth": 0.5,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "mathtext.fontset": "cm",
    "svg.hashsalt": "lmic",
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
}
INK, SOFT, BLUE, RED = "#1c2330", "#5b6575", "#1457a8", "#b3261e"
#: width of a figure in inches: little more than a phone's, so that its letters stay readable there
WIDTH = 4.4


@dataclass(frozen=True)
class Figure:
    """A picture as a data URI, what it shows for those who do not see it, and its caption."""

    source: str
    words: str
    caption: str


def drawn(draw: Callable[[Any], None], height: float, words: str, caption: str, width: float = WIDTH) -> Figure:
    """What ``draw`` draws on an empty matplotlib figure; the same picture is the same text."""
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure as Canvas

    with mpl.rc_context(STYLE):
        canvas = Canvas(figsize=(width, height), layout="constrained")
        FigureCanvasSVG(canvas)
        draw(canvas)
        stream = BytesIO()
        canvas.savefig(stream, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    return Figure(f"data:image/svg+xml;base64,{b64encode(stream.getvalue()).decode('ascii')}", words, caption)


def symbol(name: str) -> str:
    """A name as a formula: gamma as γ."""
    import sympy as sp

    return f"${sp.latex(sp.Symbol(name))}$"
