"""The page of a result: one file with the statement, the numbers, the design, and how far the LMIs hold."""

from __future__ import annotations

import os
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from lmic import latex, latex_results
from lmic.certify.certificate import Certificate
from lmic.files import write_whole
from lmic.language.systems import (
    ContinuousSystem,
    DelayedFornasiniMarchesini,
    DelaySystem,
    FornasiniMarchesini,
    System,
)
from lmic.margins import imposed, margins
from lmic.norms import frozen_gain, frozen_peak
from lmic.pages import plots
from lmic.pages.figures import Figure
from lmic.pages.report import machine
from lmic.pages.site import render
from lmic.pages.statement import mathml, statement
from lmic.pipeline import Result
from lmic.relax.family import Soundness
from lmic.reporting import enclosure, family_record, infeasibility
from lmic.simulate.typical import typical
from lmic.spectra import spectra
from lmic.walk import Walk, walk

#: matrices of a design that a page shows, and rows up to which it shows an unknown's
SHOWN, ROWS = 24, 12
#: points of a walk at which a norm is computed: one of a 2-D system takes a tenth of a second, with delays far longer
NORMS, PLANE_NORMS, DELAYED_NORMS = 41, 17, 3
#: points at which poles are drawn
POLES = 31

MEANING = {
    Soundness.EXACT: "the finite LMIs hold if and only if they hold on the whole domain",
    Soundness.SUFFICIENT: "where the finite LMIs hold, they hold on the whole domain",
    Soundness.SAMPLED: "the LMIs were imposed on a grid, and nothing is said between its points",
}


@dataclass(frozen=True)
class Reported:
    """One reported number: its formula, its digits, and what is known of it."""

    formula: Markup
    value: str
    known: str


def report(result: Result, certificate: Certificate | None = None, file: str | os.PathLike[str] | None = None) -> str:
    """The page of a result as HTML, which needs no other file and no network; written to ``file`` where one is given.

    Nothing is solved: everything is computed from the result. ``certificate`` is what was proven of it.
    """
    text = render("result.html", **_content(result, certificate))
    if file is not None:
        write_whole(Path(file), text)
    return text


def _content(result: Result, certificate: Certificate | None) -> dict[str, Any]:
    problem, solution = result.problem, result.solution
    usable = solution.status.usable
    path = walk(problem.binding.domains)
    line = path.through(imposed(problem, path))
    found = margins(problem, solution.x, line) if usable else []
    return {
        "title": result.theorem.title or result.theorem.name,
        "theorem": statement(result.theorem),
        "plant": problem.binding.plant,
        "problem": problem,
        "solution": solution,
        "seconds": result.seconds,
        "reported": reported(result, certificate),
        "proof": infeasibility(certificate) if certificate else "",
        "certificate": certificate,
        "meaning": MEANING[problem.soundness],
        "families": [family_record(family) for family in problem.families],
        "choices": choices(result),
        "structure": [plots.entries(problem), plots.sparsity(problem)],
        "margins": found,
        "failing": [margin for margin in found if not margin.holds],
        "eigenvalues": plots.eigenvalues(line, found) if usable and len(path) > 1 else None,
        "equations": equations(result)[:SHOWN],
        "left_out": max(0, len(equations(result)) - SHOWN),
        "behaviour": list(filter(None, _behaviour(result, path))) if usable else [],
        "absent": absent(result),
        "unknowns": unknowns(result) if usable else [],
        "machine": machine(),
        "made": datetime.now(UTC),
    }


def reported(result: Result, certificate: Certificate | None = None) -> list[Reported]:
    """What the theorem reports, and how well each number is known."""
    import sympy as sp

    known = "numerical" if result.theorem.minimise is not None else "at one feasible point, not optimised"
    return [
        Reported(
            mathml(" = ".join(dict.fromkeys([sp.latex(sp.Symbol(name)), sp.latex(result.theorem.reports[name])]))),
            f"{value:.8g}",
            enclosure(certificate, name).replace("\\[", "[") if certificate else known,
        )
        for name, value in result.reports.items()
    ]


def choices(result: Result) -> dict[str, str]:
    """Everything that was chosen when compiling, by name."""
    problem = result.problem
    relaxation = problem.relaxation
    polya = relaxation.polya
    degrees = {"all": polya} if isinstance(polya, int) else polya
    found = {
        "scalars": {symbol.name: f"{value:.10g}" for symbol, value in problem.binding.values.items()},
        "dimensions": {symbol.name: str(size) for symbol, size in problem.binding.sizes.items()},
        "domains": {name: str(domain) for name, domain in problem.binding.domains.items()},
        "relaxations asked for": relaxation.method,
        "Pólya degrees": {name: str(degree) for name, degree in degrees.items() if degree},
        "grids": {
            name: g if isinstance(g, int) else f"{len(g.points) or g.count} {g.kind}"
            for name, g in relaxation.grid.items()
        },
        "ties": relaxation.ties,
    }
    return {
        what: ", ".join(
            f"{name} = {value}" if what != "domains" else f"{name}: {value}" for name, value in named.items()
        )
        for what, named in found.items()
        if named
    }


def equations(result: Result) -> list[Markup]:
    """The recovered matrices at the vertices of the domain."""
    if not (result.theorem.recover and result.solution.status.usable):
        return []
    return [mathml(f"{left} = {right}") for left, right in latex_results.equations(result)]


def unknowns(result: Result) -> list[tuple[str, Markup]]:
    """The unknowns at the solution as sums over their basis functions; large ones are left out."""
    import sympy as sp

    found, written = [], latex.notation(result.theorem)
    for name, unknown in result.problem.layout.unknowns.items():
        if max(unknown.coordinate.shape) > ROWS or len(unknown.functions) > ROWS:
            continue
        terms = [
            ("" if function == 1 else sp.latex(function) + r"\,") + latex_results.matrix(matrix)
            if matrix.size > 1
            else latex_results.number(float(matrix[0, 0]), 8) + ("" if function == 1 else r"\," + sp.latex(function))
            for function, matrix in zip(unknown.functions, unknown.matrices(result.solution.x), strict=True)
        ]
        found.append((name, mathml(f"{written[name]} = {' + '.join(terms)}")))
    return found


# What the design does --------------------------------------------------------------------------------


def absent(result: Result) -> list[str]:
    """Why a figure is missing."""
    systems = [bound.system for bound in result.theorem.guarantees]
    found = []
    if any(isinstance(system, (DelaySystem, DelayedFornasiniMarchesini)) for system in systems):
        found.append("Nothing is simulated: the statement leaves the delays open.")
    elif any(isinstance(system, ContinuousSystem) for system in systems):
        found.append("Nothing is simulated: trajectories are computed in discrete time and over the plane.")
    if any(isinstance(system, (FornasiniMarchesini, DelayedFornasiniMarchesini)) for system in systems):
        found.append("There is no picture of poles: those of a 2-D system are curves in two variables.")
    return found


def _behaviour(result: Result, path: Walk) -> list[Figure | None]:
    return [_norms(result, path), _poles(result, path), _simulation(result)]


def _norms(result: Result, path: Walk) -> Figure | None:
    """Norms of the systems of all guarantees at frozen parameters; None where there is none to draw."""
    found: dict[str, Any] = {}
    bounds: dict[str, float] = {}
    drawn = path
    for bound in result.theorem.guarantees:
        drawn = path.thinned(_points(bound.system))
    for bound in result.theorem.guarantees:
        norm = frozen_peak if bound.norm == "energy to peak" else frozen_gain
        values = norm(result.design, bound.system, drawn.points)
        name = "energy-to-peak norm" if bound.norm == "energy to peak" else "H∞ norm"
        if values is not None:
            found[name], bounds[name] = np.broadcast_to(values, (len(drawn),)), result.reports[bound.report]
    return plots.norms(drawn, found, bounds) if found and len(drawn) > 1 else None


def _points(system: System) -> int:
    if isinstance(system, DelayedFornasiniMarchesini):
        return DELAYED_NORMS
    return PLANE_NORMS if isinstance(system, FornasiniMarchesini) else NORMS


def _poles(result: Result, path: Walk) -> Figure | None:
    drawn = path.thinned(POLES)
    found = spectra(result.design, drawn)
    return None if found is None else plots.poles(found, drawn)


def _simulation(result: Result) -> Figure | None:
    found = typical(result)
    if found is None:
        return None
    bound = result.theorem.guarantees[0]
    return plots.simulation(found, result.reports[bound.report], bound.norm)
