"""What the command line prints of theorems and results, as tables and as records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lmic.certify.certificate import Certificate, with_advice
from lmic.certify.document import decimal, decimal_above, decimal_below, float_above, float_below
from lmic.certify.verify import Verdict
from lmic.commands.terminal import console, marked, table, warning
from lmic.compiler.assemble import ConicProblem
from lmic.index import group, plants
from lmic.language.parameters import Parameter
from lmic.language.theorem import Theorem
from lmic.pipeline import Result
from lmic.plants.domains import vertex_points
from lmic.relax.family import LMIFamily
from lmic.relax.space import space
from lmic.solve.solution import Solution
from lmic.sweeps.search import Found

#: digits of a proven end on the screen, rounded outwards
SHOWN = 12

# A theorem and its compiled size ------------------------------------------------------------------


def family_record(family: LMIFamily) -> dict[str, Any]:
    """What became of one LMI."""
    return {
        "lmi": family.lmi.place.lmi,
        "order": family.lmi.order,
        "relaxation": list(family.methods) or ["constant"],
        "count": len(family),
        "soundness": family.soundness.value,
    }


def description(theorem: Theorem, problem: ConicProblem) -> dict[str, Any]:
    """A theorem's names and its compiled size as plain data."""
    layout = problem.layout.unknowns
    return {
        "name": theorem.name,
        "title": theorem.title,
        "source": str(theorem.source),
        "description": theorem.description,
        "data": {name: _size(leaf.shape) for name, leaf in theorem.data.items()},
        "given": [symbol.name for symbol in theorem.givens],
        "plants": [name for name in plants() if group(name) and group(name) == group(theorem.name)],
        "parameters": {name: [str(p) for p in found] for name, found in theorem.parameters.items()},
        "unknowns": {
            name: {
                "size": _size(theorem.unknowns[name].shape) if name in theorem.unknowns else "scalar",
                "basis": [str(function) for function in unknown.functions],
                "scalars": unknown.size,
            }
            for name, unknown in layout.items()
        },
        "minimise": None if theorem.minimise is None else str(theorem.minimise),
        "reports": {name: str(expression) for name, expression in theorem.reports.items()},
        "compiled": {
            "plant": problem.binding.plant.name,
            "dimensions": {symbol.name: value for symbol, value in problem.binding.sizes.items()},
            "scalar_unknowns": problem.size,
            "lmis": [family_record(family) for family in problem.families],
            "soundness": problem.soundness.value,
        },
    }


def print_description(theorem: Theorem, problem: ConicProblem) -> None:
    """A theorem for people."""
    out = console()
    record = description(theorem, problem)
    out.print(marked(theorem.name, f"  {theorem.title}"))
    out.print(str(theorem.source), style="dim")
    out.print(f"\n{theorem.description}\n")
    out.print(f"data      {', '.join(f'{name} ({size})' for name, size in record['data'].items())}")
    if record["given"]:
        out.print(f"given     {', '.join(record['given'])}")
    if record["plants"]:
        out.print(f"plants    {', '.join(record['plants'])}")
    out.print(f"minimise  {record['minimise'] or 'nothing (feasibility)'}")
    for name, expression in record["reports"].items():
        out.print(f"reports   {name} = {expression}")
    for name, node in theorem.recover.items():
        out.print(f"recovers  {name} = {node}")
    unknowns = table("unknown", "size", "basis", "scalars")
    for name, unknown in record["unknowns"].items():
        unknowns.add_row(name, unknown["size"], ", ".join(unknown["basis"]), str(unknown["scalars"]))
    out.print(unknowns)
    print_families(problem)


def print_families(problem: ConicProblem) -> None:
    """Which relaxation each LMI got, how many LMIs it made, and their soundness."""
    out = console()
    sizes = ", ".join(f"{symbol.name} = {value}" for symbol, value in problem.binding.sizes.items())
    out.print(f"compiled for {problem.binding.plant.name} ({sizes})", style="bold")
    relaxed = table("LMI", "order", "relaxation", "LMIs", "soundness")
    for record in map(family_record, problem.families):
        relaxed.add_row(
            record["lmi"],
            str(record["order"]),
            " x ".join(record["relaxation"]),
            str(record["count"]),
            record["soundness"],
        )
    out.print(relaxed)
    out.print(f"{problem.size} scalar unknowns, {len(problem.orders)} LMIs, soundness: {problem.soundness.value}")
    for line in (*_independent(problem), *tied(problem.relaxation.ties)):
        out.print(line)


def tied(ties: Mapping[str, str]) -> list[str]:
    """Which instances were made equal, so that what holds for them is no more than that; no line where none were."""
    if not ties:
        return []
    pairs = ", ".join(f"[{one or 'now'}] = [{other or 'now'}]" for one, other in ties.items())
    return [f"tied: {pairs}; the LMIs are imposed only where these are equal"]


def _independent(problem: ConicProblem) -> list[str]:
    """Which instances of a parameter vary by themselves in an LMI: a bounded step, a tie or a constant joins them."""
    axes = space(problem.binding, problem.relaxation.ties).axes
    found: dict[str, dict[str, None]] = {}
    for family in problem.families:
        occurring = {symbol for atom in family.lmi.monomials.atoms for symbol in atom.free_symbols}
        for name in problem.binding.instances:
            mine = [a.instance for a in axes if a.parameter == name and occurring & set(a.symbols)]
            if len(set(mine)) > 1:
                found.setdefault(name, {}).update(dict.fromkeys(mine))
    lines = []
    for name, several in found.items():
        names = ", ".join(str(Parameter(name, instance=instance)) for instance in several if instance)
        of = "the parameter now (no rate bound)" if "" in several else "one another"
        lines.append(f"{names}: independent of {of}")
    return lines


def _size(shape: Sequence[Any]) -> str:
    return f"{shape[0]} x {shape[1]}"


# A result -------------------------------------------------------------------------------------------


def result_record(result: Result, certificate: Certificate | None = None) -> dict[str, Any]:
    """A result as plain data; matrices of the design as their coefficients over the basis.

    With a certificate ``soundness`` says what is proven, and ``lower`` and ``upper`` enclose the reports.
    """
    solution = result.solution
    record = {
        "theorem": result.theorem.name,
        "plant": result.problem.binding.plant.name,
        "given": {symbol.name: value for symbol, value in result.problem.binding.values.items()},
        "reports": dict(result.reports),
        **solution_record(solution),
        "soundness": result.problem.soundness.value,
        "ties": dict(result.problem.relaxation.ties),
        "lmis": [family_record(family) for family in result.problem.families],
        "unknowns": _unknowns(result),
        "design": _vertex_design(result),
        "seconds": round(result.seconds, 3),
    }
    return record | (certificate_record(certificate, result.theorem) if certificate else {})


def certificate_record(certificate: Certificate, theorem: Theorem) -> dict[str, Any]:
    """What a certificate proves as plain data; its exact numbers are in its file."""
    ends = {name: certificate.ends(name, theorem) for name in theorem.reports}
    bound = certificate.lower
    return {
        "lower": {name: float_below(lower) for name, (lower, _) in ends.items() if lower is not None},
        "upper": {name: float_above(upper) for name, (_, upper) in ends.items() if upper is not None},
        "bound_for_unknowns_up_to": float(bound.radius) if bound and bound.radius else None,
        "soundness": certificate.standing.value,
        "infeasible": infeasibility(certificate),
        "proven_from": certificate.solver,
        "notes": list(certificate.notes),
    }


def infeasibility(certificate: Certificate) -> str:
    """What is proven of there being no solution; an empty text where nothing is."""
    claim = certificate.infeasible
    if claim is None:
        return ""
    if claim.radius is None:
        return f"no unknowns satisfy the LMIs, proven by {len(claim.functionals)} exact dual matrices"
    return (
        f"no unknowns of size {float(claim.radius):g} or less give every LMI a least eigenvalue above "
        f"{float(decimal_above(claim.margin, 2)):.1e}, proven by {len(claim.functionals)} dual matrices"
        f"{', and of smaller margins nothing is proven' if claim.margin else ''}"
    )


def search_record(found: Found) -> dict[str, Any]:
    """The outcome of a search over a scalar as plain data."""
    return {"scalar": found.scalar, "value": found.value, "other": found.other, "solves": found.solves}


def _unknowns(result: Result) -> dict[str, Any]:
    if not result.solution.status.usable:
        return {}
    return {
        name: {
            str(f): matrix.tolist()
            for f, matrix in zip(unknown.functions, unknown.matrices(result.solution.x), strict=True)
        }
        for name, unknown in result.problem.layout.unknowns.items()
    }


def _vertex_design(result: Result) -> dict[str, Any]:
    """The recovered matrices at the domain's vertices."""
    if not result.solution.status.usable or not result.theorem.recover:
        return {}
    points = vertex_points(result.problem.binding.domains)
    matrices = result.design(**points)
    count = max((len(values) for values in points.values()), default=1)
    return {
        "at": {name: values.tolist() for name, values in points.items()},
        **{name: np.broadcast_to(m, (count, *m.shape[-2:])).tolist() for name, m in matrices.items()},
    }


def print_result(result: Result, certificate: Certificate | None = None) -> None:
    """A result for people, with what is proven of it."""
    out, solution = console(), result.solution
    out.print(marked(result.theorem.name, f"  {result.theorem.title}"))
    print_families(result.problem)
    notes = list(certificate.notes) if certificate else []
    proof = infeasibility(certificate) if certificate else ""
    if not print_solution(solution, result.seconds, proof, notes):
        return
    for name, value in result.reports.items():
        known = enclosure(certificate, result.theorem, name) if certificate else unproven(result.theorem, name)
        out.print(marked(f"{name:<11} {value:.8g}", f"   {known}; relaxation {result.problem.soundness.value}"))
    if certificate and (certificate.upper or certificate.lower):
        out.print(f"proven from {certificate.solver}")
    for note in notes:
        out.print(f"            {note}")
    for text in solution.warnings:
        out.print(warning(text))
    if result.theorem.recover:
        print_design(result)


def print_solution(solution: Solution, seconds: float, proof: str = "", notes: Sequence[str] = ()) -> bool:
    """Solver, status and what was measured, for people; whether there is an answer to look at.

    Where there is none, ``proof`` is what is proven of that.
    """
    out = console()
    for reason in solution.handovers:
        out.print(f"handed over {reason}")
    words = ", ".join(f"{step.word} ({step.iterations})" for step in solution.passes)
    out.print(f"\nsolver      {solution.solver}: {words}; {solution.iterations} iterations in {seconds:.2f} s")
    out.print(f"status      {solution.status.value}")
    if not solution.status.usable:
        if proof:
            out.print(f"proof       {proof}")
        for line in (*notes, solution.status.advice):
            out.print(f"            {line}")
        return False
    relative = f"relative to diag S: {abs(solution.relative_violation):.1e}"
    where = f", largest at {solution.worst}" if solution.violation < 0 else ""
    out.print(f"violation   {abs(solution.violation):.1e} ({relative}){where}")
    out.print(f"uncertainty {solution.uncertainty:.1e} (gap, and what mending the violation costs; relative)")
    if solution.on_face and solution.attained is None:
        out.print("attained    not known: no dual matrix is positive definite, so unknowns may grow toward the infimum")
    out.print(f"lineality   {solution.lineality} direction(s) that no LMI sees")
    return True


def solution_record(solution: Solution) -> dict[str, Any]:
    """What was measured of an answer as plain data."""
    return {
        "status": solution.status.value,
        "advice": solution.status.advice,
        "solver": solution.solver,
        "handed_over": list(solution.handovers),
        "passes": [{"word": step.word, "iterations": step.iterations} for step in solution.passes],
        "iterations": solution.iterations,
        "objective": solution.value,
        "dual_objective": solution.bound,
        "uncertainty": solution.uncertainty,
        "violation": solution.violation,
        "relative_violation": solution.relative_violation,
        "worst_lmi": solution.worst,
        "attained": solution.attained,
        "lineality": solution.lineality,
        "warnings": list(solution.warnings),
    }


def unproven(theorem: Theorem, name: str) -> str:
    """What a report stands on without a certificate."""
    if theorem.reports[name].free_symbols <= set(theorem.givens):
        return "given, and the LMIs hold"
    return "numerical" if theorem.minimise is not None else "at one feasible point, not optimised"


def enclosure(certificate: Certificate, theorem: Theorem, name: str) -> str:
    """The proven interval of a report and what it stands on: ∈ [1.2137692, 1.2137693] certified."""
    lower, upper = certificate.ends(name, theorem)
    bound = certificate.lower if certificate.lower and name in certificate.lower.reports else None
    ends = [
        "−∞" if lower is None else decimal(decimal_below(lower, SHOWN)),
        "∞" if upper is None else decimal(decimal_above(upper, SHOWN)),
    ]
    width = f", {float((upper - lower) / abs(upper)):.0e} wide" if lower is not None and upper else ""
    radius = bound.radius if bound else None
    within = f", {_sides(theorem, name)[1]} end for unknowns up to {float(radius):.0e}" if radius else ""
    return f"∈ [{ends[0]}, {ends[1]}] {certificate.standing.value}{width}{within}"


def _sides(theorem: Theorem, report: str) -> tuple[str, str]:
    """Which end of a report a point proves, and which the dual matrices."""
    return ("lower", "upper") if theorem.maximised(report) else ("upper", "lower")


def verdict_record(certificate: Certificate, verdict: Verdict) -> dict[str, Any]:
    """The outcome of proving a certificate anew as plain data."""
    return {
        "theorem": certificate.theorem,
        "plant": certificate.plant.name,
        "holds": verdict.holds,
        "reason": verdict.reason,
        "cells": verdict.cells,
        "ties": dict(certificate.ties),
        "bound_of": "theorem" if verdict.about_theorem else "relaxation",
    } | (certificate_record(certificate, verdict.theorem) if verdict.theorem else {"soundness": verdict.standing.value})


def print_verdict(certificate: Certificate, verdict: Verdict) -> None:
    """The outcome of proving a certificate anew for people."""
    out = console()
    scalars = ", ".join(f"{name} = {value}" for name, value in certificate.scalars.items())
    out.print(marked(certificate.theorem, f" for {certificate.plant.name}{f', {scalars}' if scalars else ''}"))
    for line in tied(certificate.ties):
        out.print(line)
    if certificate.library_plant:
        out.print(f"data        those of the library's {certificate.library_plant}")
    theorem = verdict.theorem
    if not theorem:
        out.print(marked("failed", f"      {with_advice(verdict.reason)}", "bold red"))
        return
    names = dict.fromkeys(n for bound in (certificate.upper, certificate.lower) if bound for n in bound.reports)
    for name in names:
        out.print(f"{name:<11} {enclosure(certificate, theorem, name)}")
    reached, bounded = _sides(theorem, next(iter(names))) if names else ("upper", "lower")
    where = "on the whole domain" if certificate.upper and not certificate.upper.functionals else "at the listed points"
    if certificate.upper:
        out.print(f"{reached} end   every LMI is positive definite {where} ({verdict.cells} cells)")
    about = "every solution of the theorem with these bases" if verdict.about_theorem else "its relaxation"
    if certificate.lower:
        out.print(f"{bounded} end   proven by {len(certificate.lower.functionals)} dual matrices, for {about}")
    if certificate.infeasible:
        out.print(f"infeasible  {infeasibility(certificate)}, for {about}")
    out.print(f"made by     {certificate.solver}")


def print_design(result: Result) -> None:
    """The recovered matrices at the vertices."""
    points = vertex_points(result.problem.binding.domains)
    matrices = result.design(**points)
    count = max((len(values) for values in points.values()), default=1)
    for k in range(count):
        where = ", ".join(f"{name} = {np.array2string(values[k], precision=4)}" for name, values in points.items())
        shown = table("matrix", "value", title=f"design at {where}" if where else "design")
        for name, matrix in matrices.items():
            shown.add_row(name, np.array2string(matrix[min(k, len(matrix) - 1)], precision=6, suppress_small=True))
        console().print(shown)
