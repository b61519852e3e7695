"""What ``lmic solve`` does: with a theorem and a plant, or with a file that is a whole problem."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

import click

from lmic import reporting
from lmic.certify.certificate_file import write_certificate
from lmic.certify.certify import certify as prove
from lmic.certify.certify import without_unproven_claim
from lmic.certify.refine import certify_domain
from lmic.commands.echo import echo_json
from lmic.commands.options import Choices, interval, numbers
from lmic.commands.output import check_output, write_output
from lmic.errors import LmicError
from lmic.interchange.formats import read_problem
from lmic.interchange.reporting import file_record, print_file
from lmic.pipeline import run
from lmic.solve.cone import ConeSolver, Status
from lmic.solve.solve import solve
from lmic.sweeps.search import search_scalar


def solve_theorem(
    name: str,
    plant: Path,
    chosen: Choices,
    solver: Sequence[ConeSolver],
    search: str | None,
    certify: Path | None,
    refine: int | None,
    output: Path | None,
    as_json: bool,
) -> bool:
    """Solve a theorem, print what it reports and recovers, and say whether the number is to be trusted."""
    found, refined, certificate, unproven = None, None, None, False
    if output:
        check_output(output)
    if refine and (search or not certify):
        raise LmicError("--refine goes with --certify and without --search; add or remove one")
    given = numbers(chosen.given, "--set")
    if search:
        scalar, low, high = interval(search, "--search")
        binding = chosen.prepare_files(name, plant)
        found = search_scalar(binding, scalar, low, high, given, chosen.relaxation(binding.plant), solver)
        given[scalar] = found.value
    if refine:
        binding = chosen.prepare_files(name, plant)
        relaxation = chosen.relaxation(binding.plant)
        refined = certify_domain(binding, relaxation, given, chosen.dimensions(), solver, rounds=refine)
        certificate, result = refined.certificate, refined.result
    else:
        result = found.result if found else run(chosen.compile_files(name, plant), solver)
        # that there is no solution is said only where it is proven
        if certify or result.solution.status is Status.INFEASIBLE:
            relaxation = chosen.relaxation(result.problem.binding.plant)
            try:
                certificate = prove(result, relaxation, given, chosen.dimensions())
            except KeyboardInterrupt:
                unproven = True
            result = without_unproven_claim(result, certificate)
    if certificate and certify and certify != Path("-"):
        write_certificate(certificate, certify)
    if output:
        write_output(result, output, certificate, name)
    if as_json:
        record = reporting.result_record(result, certificate)
        record |= {"search": reporting.search_record(found)} if found else {}
        record |= {"minimised_on_each_grid": list(refined.values)} if refined else {}
        record |= {"certificate": str(certify)} if certificate and certify != Path("-") else {}
        echo_json(record)
    else:
        if found:
            click.echo(f"best {found.scalar} = {found.value:.8g} after {found.solves} solves")
        if refined:
            values = ", ".join(f"{value:.8g}" for value in refined.values)
            click.echo(
                f"minimised on {len(refined.values)} grids, each with the point where the last one failed: {values}"
            )
        reporting.print_result(result, certificate)
    if unproven:
        raise KeyboardInterrupt(
            "the proof was not finished, so what is printed is numerical; the same command proves it"
        )
    return result.solution.trusted


def solve_file(name: str, solver: Sequence[ConeSolver], as_json: bool) -> bool:
    """Solve the semidefinite program of a file, print it, and say whether the number is to be trusted."""
    sdp = read_problem(name)
    start = perf_counter()
    solution = solve(sdp, solver)
    seconds = perf_counter() - start
    if as_json:
        echo_json(file_record(name, sdp, solution, seconds))
    else:
        print_file(name, sdp, solution, seconds)
    return solution.trusted
