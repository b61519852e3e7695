"""What a result's page draws: norms, eigenvalues, poles, a simulation, and where the unknowns stand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.analysis.margins import Margin
from lmic.analysis.spectra import Spectra
from lmic.analysis.walk import Chart, Walk
from lmic.compiler.assemble import ConicProblem
from lmic.pages.figures import BLUE, INK, RED, SOFT, Figure, drawn, symbol
from lmic.relax.family import LMIFamily
from lmic.simulate.trajectory import Trajectory
from lmic.typeset.latex import notation

Array: TypeAlias = NDArray[Any]

#: relative eigenvalues below this are shown on a linear scale, or below this share of the largest one
LINEAR, SHARE = 1e-8, 1e-4
#: small matrices in one row of a figure
PANELS = 6
#: cells of the picture of the solver's matrix, at most
CELLS = (260, 420)


def norms(path: Walk, found: Mapping[str, Array], bounds: Mapping[str, float]) -> Figure:
    """Norms at frozen parameters along a walk, each beside the number that bounds it."""
    largest = {name: float(np.max(values)) for name, values in found.items()}

    def draw(canvas: Any) -> None:
        axis = canvas.add_subplot()
        for number, (name, values) in enumerate(found.items()):
            color = (BLUE, SOFT)[number % 2]
            axis.plot(path.position, values, color=color, marker="." if len(path) < 30 else "", label=name)
            axis.axhline(bounds[name], color=RED, linestyle="--", linewidth=1)
            axis.annotate(
                f"bound {bounds[name]:.5g}", (path.position[-1], bounds[name]), (0, 3), textcoords="offset points",
                color=RED, fontsize=8, ha="right",
            )  # fmt: skip
        finite = [value for value in (*largest.values(), *bounds.values()) if np.isfinite(value)]
        axis.set_ylim(0, 1.12 * max(finite))
        axis.set_ylabel(" and ".join(found))
        _stops(axis, path)

    words = "; ".join(f"{name} at most {largest[name]:.4g} of {bounds[name]:.5g}" for name in found)
    caption = f"Norm at frozen parameters beside its bound: {words}. Time-varying parameters may come closer to it."
    return drawn(draw, 2.1, words, caption)


def eigenvalues(path: Walk, found: Sequence[Margin]) -> Figure:
    """Least relative eigenvalue of every LMI along a walk."""
    along = np.array([margin.along for margin in found])
    linear = _linear(along)

    def draw(canvas: Any) -> None:
        axis = canvas.add_subplot()
        for number, margin in enumerate(found):
            (line,) = axis.plot(
                path.position, margin.along, label=margin.lmi, linestyle=("-", "--", ":", "-.")[number % 4]
            )
            if len(margin.held):
                held = np.isin(path.position, margin.held)
                axis.plot(path.position[held], margin.along[held], ".", color=line.get_color(), markersize=6)
        low = min(0.0, float(along.min()))
        axis.set_yscale("symlog", linthresh=linear)
        if low < -linear:
            axis.axhspan(2 * low, 0, color=RED, alpha=0.08, linewidth=0)
            axis.set_ylim(bottom=2 * low)
        axis.axhline(0, color=INK, linewidth=0.8)
        low, high = axis.get_ylim()
        decades = [sign * 10.0**power for sign in (-1, 1) for power in range(-14, 1, 2)]
        axis.set_yticks([0.0, *(tick for tick in decades if low <= tick <= high and abs(tick) > linear)])
        axis.set_ylabel("least relative eigenvalue")
        axis.legend(ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
        _stops(axis, path)

    words = "; ".join(f"{margin.lmi} at least {margin.along.min():.1e}" for margin in found)
    held = " Dots mark where an LMI was imposed." if any(len(margin.held) for margin in found) else ""
    caption = (
        "Least eigenvalue of each LMI scaled to unit diagonal, over everything but what walks; below zero it fails. "
        f"The scale is linear between ±{linear:.0e}.{held}"
    )
    return drawn(draw, 2.4, words, caption)


def over(place: Chart, margin: Margin, held: tuple[Array, Array]) -> Figure:
    """Least relative eigenvalue of one LMI over a domain of two free components; ``held`` as of :class:`Margin`."""
    values = np.full(place.inside.shape, np.nan)
    values[place.inside] = margin.along
    size = float(np.abs(margin.along).max())
    linear = _linear(margin.along)

    def draw(canvas: Any) -> None:
        from matplotlib.colors import SymLogNorm

        axis = canvas.add_subplot()
        norm = SymLogNorm(linear, vmin=-size, vmax=size)
        image = axis.pcolormesh(place.u, place.v, values, cmap="RdBu", norm=norm, shading="nearest", rasterized=True)
        dots = np.array(np.meshgrid(*held)).reshape(2, -1)
        axis.plot(*dots, ".", color=INK, markersize=4, clip_on=False)
        axis.grid(visible=False)
        axis.set_xlabel(symbol(place.names[0]))
        axis.set_ylabel(symbol(place.names[1]))
        decades = [sign * 10.0**power for sign in (-1, 1) for power in range(-14, 1, 2)]
        bar = canvas.colorbar(image, ax=axis, label=f"least relative eigenvalue of {margin.lmi}")
        bar.set_ticks([0.0, *(tick for tick in decades if linear < abs(tick) <= size)], minor=False)
        bar.minorticks_off()

    words = f"{margin.lmi} at least {margin.along.min():.1e}"
    dotted = " Dots mark where it was imposed." if all(map(len, held)) else ""
    caption = f"The same over the whole domain for {margin.lmi}: red where it fails, {words}.{dotted}"
    return drawn(draw, 2.9, words, caption)


def poles(found: Spectra, path: Walk) -> Figure:
    """Poles, and zeros of each channel of what was recovered, over the walk."""
    columns = [kind for kind in ("closed", "design") if (found.closed if kind == "closed" else found.poles) is not None]

    def draw(canvas: Any) -> None:
        axes = canvas.subplots(1, len(columns), squeeze=False)[0]
        for axis, kind in zip(axes, columns, strict=True):
            values = found.closed if kind == "closed" else found.poles
            assert values is not None
            axis.set_title("whole system" if kind == "closed" else "recovered: × poles, ○ zeros")
            colors = np.repeat(np.linspace(0, 1, len(path)), values.shape[1])
            image = axis.scatter(values.real, values.imag, c=colors, marker="x", s=16, linewidths=1, cmap="viridis")
            if kind == "design":
                share = np.concatenate([np.full(len(z), k) for k, z in enumerate(found.zeros)]) / max(1, len(path) - 1)
                zeros = np.concatenate(found.zeros)
                near = np.abs(zeros) < 3 * max(1.0, float(np.abs(values).max()))
                axis.scatter(
                    zeros.real[near], zeros.imag[near], s=18, facecolors="none",
                    edgecolors=image.cmap(share[near]), linewidths=0.9,
                )  # fmt: skip
            _region(axis, found.discrete)
        axes[0].set_ylabel("imaginary part")

    sizes = "" if found.closed is None else _spread(found)
    caption = f"Poles at frozen parameters, coloured from the beginning of the walk (dark) to its end{sizes}. " + (
        "Zeros are those of each channel; those far out are left out." if found.poles is not None else ""
    )
    return drawn(draw, 2.5, f"poles{sizes}", caption)


def _spread(found: Spectra) -> str:
    assert found.closed is not None
    if found.discrete:
        return f"; spectral radius at most {np.abs(found.closed).max():.4g}"
    return f"; largest real part {found.closed.real.max():.4g}"


def _region(axis: Any, discrete: bool) -> None:
    if discrete:
        angle = np.linspace(0, 2 * np.pi, 181)
        axis.plot(np.cos(angle), np.sin(angle), color=SOFT, linewidth=0.8)
        axis.set_aspect("equal", adjustable="datalim")
    else:
        axis.axvline(0, color=SOFT, linewidth=0.8)
    axis.set_xlabel("real part")


def simulation(found: Trajectory, bound: float, norm: str) -> Figure:
    """Disturbance, parameters and output over time, or the output over the plane."""
    reached = found.peak if norm == "energy to peak" else found.gain
    what = "largest |e| over ‖w‖₂" if norm == "energy to peak" else "‖e‖₂ over ‖w‖₂"
    words = f"{what} is {reached:.4g}, bound {bound:.5g}"
    moving = any(np.ptp(values.reshape(-1, values.shape[-1]), axis=0).any() for values in found.parameters.values())
    meanwhile = "the parameters take their walk" if moving else "the parameters rest at the centre of their domain"
    when = f", while {meanwhile}" if found.parameters else ""
    if found.w.ndim == 3:
        caption = f"A pulse w and the bounded output e over the plane, from rest{when}; {words}."
        return drawn(lambda canvas: _plane(canvas, found), 2.3, words, caption)
    rows = {**found.parameters, "w": found.w, "e": found.e} | dict(found.others)
    caption = f"A pulse w and the bounded output e, from rest{when}; {words}."
    return drawn(lambda canvas: _steps(canvas, rows), 0.5 + 0.85 * len(rows), words, caption)


def _steps(canvas: Any, rows: Mapping[str, Array]) -> None:
    axes = canvas.subplots(len(rows), squeeze=False, sharex=True)[:, 0]
    for axis, (name, values) in zip(axes, rows.items(), strict=True):
        for column in values.T:
            axis.step(np.arange(len(column)), column, where="post", linewidth=1)
        axis.set_ylabel(symbol(name), rotation=0, ha="right", va="center", fontsize=11)
    axes[-1].set_xlabel("step")


def _plane(canvas: Any, found: Trajectory) -> None:
    axes = canvas.subplots(1, 2)
    for axis, values, label in zip(axes, (found.w, found.e), ("|w|", "|e|"), strict=True):
        image = axis.imshow(np.linalg.norm(values, axis=-1).T, origin="lower", cmap="Blues", interpolation="nearest")
        axis.grid(visible=False)
        axis.set_title(label)
        axis.set_xlabel("i")
        canvas.colorbar(image, ax=axis, shrink=0.8)
    axes[0].set_ylabel("j")


# Where the unknowns stand ----------------------------------------------------------------------------


def entries(problem: ConicProblem) -> Figure:
    """For every LMI, which of its entries the data and each unknown reach."""
    panels = [(f, name, mask) for f in problem.families for name, mask in reached(problem, f).items() if mask.any()]
    rows, written = -(-len(panels) // PANELS), notation(problem.binding.theorem)

    def draw(canvas: Any) -> None:
        axes = canvas.subplots(rows, PANELS, squeeze=False).ravel()
        for axis, (family, name, mask) in zip(axes, panels, strict=False):
            axis.imshow(
                mask, cmap=_two_colours(BLUE if name != "data" else SOFT), vmin=0, vmax=1, interpolation="nearest"
            )
            for edge in np.cumsum(family.lmi.partition)[:-1] - 0.5:
                axis.axhline(edge, color=SOFT, linewidth=0.4)
                axis.axvline(edge, color=SOFT, linewidth=0.4)
            axis.set(xticks=[], yticks=[])
            axis.grid(visible=False)
            axis.spines[:].set_visible(True)
            axis.set_title(f"${written[name]}$" if name in written else name, fontsize=9, pad=2)
            axis.set_xlabel(family.lmi.place.lmi, fontsize=7, labelpad=2, color=SOFT)
        for axis in axes[len(panels) :]:
            axis.set_axis_off()

    words = "; ".join(
        f"{family.lmi.place.lmi}: " + ", ".join(name for f, name, _ in panels if f is family)
        for family in problem.families
    )
    caption = "Entries of each LMI that an unknown reaches; lines part the blocks of the statement."
    return drawn(draw, 0.15 + 0.95 * rows, words, caption)


def reached(problem: ConicProblem, family: LMIFamily) -> dict[str, Array]:
    """Entries of the matrix that the data and each unknown reach at some parameter, as (order, order) masks."""
    lmi = family.lmi
    used = np.zeros(len(lmi.rows), dtype=bool)
    used[np.unique(lmi.coefficients.tocoo().coords[1][lmi.coefficients.tocoo().data != 0])] = True
    places = {"data": lmi.columns == 0}
    for name, unknown in problem.layout.unknowns.items():
        places[name] = (lmi.columns > unknown.offset) & (lmi.columns <= unknown.offset + unknown.size)
    found = {}
    for name, mine in places.items():
        packed = np.zeros(svec.length(lmi.order), dtype=bool)
        packed[lmi.rows[mine & used]] = True
        found[name] = svec.unpack(packed, lmi.order)
    return found


def sparsity(problem: ConicProblem) -> Figure:
    """The solver's matrix: a row for each entry of all LMIs, a column for each scalar unknown."""
    matrix = problem.matrix.tocoo()
    rows, columns = matrix.shape
    cells = (min(rows, CELLS[0]), min(columns, CELLS[1]))
    density, _, _ = np.histogram2d(matrix.row, matrix.col, bins=cells, range=((0, rows), (0, columns)))
    share, written = matrix.nnz / (rows * columns), notation(problem.binding.theorem)

    def draw(canvas: Any) -> None:
        axis = canvas.add_subplot()
        axis.imshow(
            density > 0, cmap=_two_colours(BLUE), vmin=0, vmax=1, aspect="auto", interpolation="nearest",
            extent=(0, columns, rows, 0),
        )  # fmt: skip
        axis.grid(visible=False)
        axis.spines[:].set_visible(True)
        ticks, names = [], []
        for name, unknown in problem.layout.unknowns.items():
            axis.axvline(unknown.offset, color=SOFT, linewidth=0.3)
            if unknown.size >= columns / 30 or len(problem.layout.unknowns) <= 8:
                ticks.append(unknown.offset + unknown.size / 2)
                names.append(f"${written[name]}$")
        axis.set_xticks(ticks, names)
        axis.tick_params(length=0)
        start, middles, lmis = 0, [], []
        for family in problem.families:
            end = start + len(family) * svec.length(family.lmi.order)
            axis.axhline(start, color=SOFT, linewidth=0.5)
            if end - start >= rows / 20:
                middles.append((start + end) / 2)
                lmis.append(family.lmi.place.lmi)
            start = end
        axis.set_yticks(middles, lmis)

    words = f"{rows} rows, {columns} columns, {matrix.nnz} entries ({share:.1%})"
    caption = f"The solver's matrix, a row for each entry of all LMIs, a column for each scalar unknown: {words}."
    return drawn(draw, 2.4, words, caption)


def _two_colours(color: str) -> Any:
    from matplotlib.colors import ListedColormap

    return ListedColormap(["#00000000", color])


def _linear(values: Array) -> float:
    """Where the scale of relative eigenvalues is linear."""
    return float(10.0 ** np.floor(np.log10(max(min(LINEAR, SHARE * float(np.abs(values).max())), 1e-16))))


def _stops(axis: Any, path: Walk) -> None:
    if path.component:
        axis.set_xlabel(symbol(path.component))
    elif path.stops:
        axis.set_xticks(range(len(path.stops)), path.stops, rotation=30 if len(path.stops) > 4 else 0, ha="center")
        axis.set_xlabel("the parameters' walk through their domain")
    axis.set_xlim(path.position[0], path.position[-1] if len(path) > 1 else 1)
