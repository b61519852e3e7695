"""``lmic verify`` and ``lmic refute``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from lmic.commands.echo import echo_json
from lmic.commands.options import JSON, PLANT, Choices, compiling, numbers


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--theorem", metavar="PATH", help="The theorem file, where the theorem is not one of the library.")
@JSON
def verify(file: Path, theorem: str | None, as_json: bool) -> None:
    """Prove a certificate anew from its theorem and its file alone, without any solver."""
    from lmic import library, reporting
    from lmic.certify.certificate_file import read_certificate
    from lmic.certify.verify import verify as prove

    certificate = read_certificate(file)
    verdict = prove(certificate, library.theorem(theorem) if theorem else None)
    if as_json:
        echo_json(reporting.verdict_record(certificate, verdict))
    else:
        reporting.print_verdict(certificate, verdict)
    if not verdict.holds:
        sys.exit(1)


@click.command()
@click.argument("name")
@PLANT
@compiling
@click.option("--below", metavar="VALUE", required=True, help="The value that the theorem is said to reach.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Write the certificate to a file.")
@JSON
def refute(name: str, plant: Path, below: str, output: Path | None, as_json: bool, **choices: Any) -> None:
    """Prove that no solution of a theorem reports so small a value; ends with 1 where that is not proven.

    A bound on the relaxation alone, or for unknowns up to a size, is told, and refutes nothing.
    """
    from lmic.certify.certificate_file import write_certificate
    from lmic.certify.certify import refutation
    from lmic.certify.document import decimal, decimal_below, float_below
    from lmic.pipeline import run
    from lmic.reporting import SHOWN

    chosen = Choices(**choices)
    value = numbers([f"value={below}"], "--below")["value"]
    result = run(chosen.compile_files(name, plant))
    certificate, report, lower = refutation(
        result, chosen.relaxation(result.problem.binding.plant), numbers(chosen.given, "--set"), chosen.dimensions()
    )
    if output:
        write_certificate(certificate, output)
    assert certificate.lower is not None
    radius = certificate.lower.radius
    about_theorem = all(functional.at_point for functional in certificate.lower.functionals)
    refuted = lower > value and radius is None and about_theorem
    if as_json:
        record = {"report": report, "below": float(value), "lower": float_below(lower), "refuted": refuted}
        record |= {"lower_bound_of": "theorem" if about_theorem else "relaxation"}
        echo_json(record | {"lower_for_unknowns_up_to": None if radius is None else float_below(radius)})
    else:
        proven = "proven" if about_theorem else "proven of the relaxation"
        proven += "" if radius is None else f" for unknowns up to {float_below(radius):g}"
        verdict = "so it cannot be reached with these bases" if refuted else "which does not refute it"
        click.echo(
            f"{report} = {below}: {report} is at least {decimal(decimal_below(lower, SHOWN))} ({proven}), {verdict}"
        )
    if not refuted:
        sys.exit(1)
