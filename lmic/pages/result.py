"""The page of a result: one file with the statement, the numbers, the design, and how far the LMIs hold."""

from __future__ import annotations

import os
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from markupsafe import Markup

from lmic.analysis.margins import Margin, imposed, margins, over
from lmic.analysis.walk import chart, walk
from lmic.certify.certificate import Certificate
from lmic.files import write_whole
from lmic.pages import behaviour, plots
from lmic.pages.figures import Figure
from lmic.pages.report import machine
from lmic.pages.site import render
from lmic.pages.statement import mathml, statement
from lmic.pipeline import Result
from lmic.relax.family import Soundness
from lmic.reporting import enclosure, family_record, infeasibility, unproven
from lmic.typeset import latex, numbers

#: matrices of a design that a page shows, and rows up to which it shows an unknown's
SHOWN, ROWS = 24, 12

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
    design = equations(result)
    found, charted = _charted(result, margins(problem, solution.x, line) if usable else [])
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
        "map": charted,
        "equations": design[:SHOWN],
        "left_out": max(0, len(design) - SHOWN),
        "behaviour": behaviour.figures(result, path) if usable else [],
        "remarks": behaviour.remarks(result, path) if usable else [],
        "unknowns": unknowns(result) if usable else [],
        "machine": machine(),
        "made": datetime.now(UTC),
    }


def _charted(result: Result, found: list[Margin]) -> tuple[list[Margin], Figure | None]:
    """The margins, and over a domain of two free components a map of the least of them, with what it finds."""
    place = chart(result.problem.binding.domains)
    if place is None or not found:
        return found, None
    worst = min(found, key=lambda margin: margin.found)
    margin, held = over(result.problem, result.solution.x, place, worst.lmi)
    return [one.joined(margin) if one is worst else one for one in found], plots.over(place, margin, held)


def reported(result: Result, certificate: Certificate | None = None) -> list[Reported]:
    """What the theorem reports, and how well each number is known."""
    import sympy as sp

    return [
        Reported(
            mathml(" = ".join(dict.fromkeys([sp.latex(sp.Symbol(name)), sp.latex(result.theorem.reports[name])]))),
            f"{value:.8g}",
            enclosure(certificate, result.theorem, name) if certificate else unproven(result.theorem, name),
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
    return [mathml(f"{left} = {right}") for left, right in numbers.equations(result)]


def unknowns(result: Result) -> list[tuple[str, Markup]]:
    """The unknowns at the solution as sums over their basis functions; large ones are left out."""
    import sympy as sp

    found, written = [], latex.notation(result.theorem)
    for name, unknown in result.problem.layout.unknowns.items():
        if max(unknown.coordinate.shape) > ROWS or len(unknown.functions) > ROWS:
            continue
        terms = [
            ("" if function == 1 else sp.latex(function) + r"\,") + numbers.matrix(matrix)
            if matrix.size > 1
            else numbers.number(float(matrix[0, 0]), 8) + ("" if function == 1 else r"\," + sp.latex(function))
            for function, matrix in zip(unknown.functions, unknown.matrices(result.solution.x), strict=True)
        ]
        found.append((name, mathml(f"{written[name]} = {' + '.join(terms)}")))
    return found
