"""Plots and a page of what ``run.py`` and ``certify.py`` wrote: reports/benchmarks.html."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from lmic.files import write_whole
from lmic.pages.report import embedded
from lmic.pages.site import render

MARKS = {"lmic": "o-", "CVXPY": "s--", "PICOS": "^--"}


def write_page(folder: Path) -> Path:
    """The page of the figures in ``folder``; needs ``benchmarks.json``, shows ``certify.json`` where it is."""
    found = json.loads((folder / "benchmarks.json").read_text(encoding="utf-8"))
    certified = folder / "benchmarks-certify.json"
    proofs = json.loads(certified.read_text(encoding="utf-8")) if certified.exists() else []
    plots = [plot_compile(found, folder / "benchmarks-compile.png"), plot_solve(found, folder / "benchmarks-solve.png")]
    captions = [
        "Time from the theorem to the solver's arrays. lmic on all sizes, CVXPY and PICOS where they were run; "
        "the grey line is the time of copying lmic's arrays.",
        "Time to a checked optimum of S1, all LMIs measured at it.",
    ]
    if proofs:
        plots.append(plot_certify(proofs, folder / "benchmarks-certify.png"))
        captions.append("Time to the optimum, to its certificate, and of proving the certificate anew.")
    page = folder / "benchmarks.html"
    shown = [(embedded(plot), caption) for plot, caption in zip(plots, captions, strict=True)]
    write_whole(
        page, render("benchmarks.html", title="lmic: how long it takes", found=found, plots=shown, proofs=proofs)
    )
    return page


def plot_compile(found: dict[str, Any], path: Path) -> Path:
    figure, axes = plt.subplots(figsize=(7.5, 4.5), layout="constrained")
    growth = found["growth"]
    points = [row["points"] for row in growth]
    axes.loglog(points, [row["first"]["cpu"] for row in growth], MARKS["lmic"], label="lmic, first compile")
    axes.loglog(points, [row["new grid"]["cpu"] for row in growth], "o:", color="C0", label="lmic, another grid")
    axes.loglog(points[1:], [row["copy"]["cpu"] for row in growth[1:]], color="0.6", label="copying the arrays")
    for color, name in (("C1", "CVXPY"), ("C2", "PICOS")):
        rows = [row for row in found["compared"] if row["series"].startswith("S1") and name in row]
        seconds = [row[name]["first"]["cpu"] for row in rows]
        axes.loglog([int(row["size"]) for row in rows], seconds, MARKS[name], color=color, label=name)
    axes.set(xlabel="points of S1 Theorem 3", ylabel="processor time / s")
    return _saved(figure, axes, path)


def plot_solve(found: dict[str, Any], path: Path) -> Path:
    figure, axes = plt.subplots(figsize=(7.5, 4), layout="constrained")
    solved = found["solved"]
    for kind, mark in (("wall", "o-"), ("cpu", "o:")):
        label = {"wall": "wall time", "cpu": "processor time"}[kind]
        axes.loglog([row["points"] for row in solved], [row[kind] for row in solved], mark, color="C0", label=label)
    axes.set(xlabel="points of S1 Theorem 3", ylabel="time to the optimum / s")
    return _saved(figure, axes, path)


def plot_certify(proofs: list[dict[str, Any]], path: Path) -> Path:
    figure, axes = plt.subplots(figsize=(7.5, 0.9 + 0.55 * len(proofs)), layout="constrained")
    kinds = ("solve", "certify", "verify")
    for k, kind in enumerate(kinds):
        places = [row + 0.25 * (k - 1) for row in range(len(proofs))]
        axes.barh(places, [proof[kind] for proof in proofs], height=0.23, label=kind)
    axes.set_yticks(range(len(proofs)), [proof["what"] for proof in proofs])
    axes.invert_yaxis()
    axes.set_xscale("log")
    axes.set_xlabel("processor time / s")
    return _saved(figure, axes, path)


def _saved(figure: Any, axes: Any, path: Path) -> Path:
    axes.set_axisbelow(True)
    axes.grid(True, which="major", color="0.9")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    figure.savefig(path, dpi=130)
    plt.close(figure)
    return path
