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
@click.option("--below", metavar="VALUE", help="The value that the theorem is said to reach.")
@click.option("--above", metavar="VALUE", help="The same where the theorem maximises.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Write the certificate to a file.")
@JSON
def refute(
    name: str,
    plant: Path,
    below: str | None,
    above: str | None,
    output: Path | None,
    as_json: bool,
    **choices: Any,
) -> None:
    """Prove that no solution of a theorem reports so good a value; ends with 1 where that is not proven.

    A bound on the relaxation alone, or for unknowns up to a size, is told, and refutes nothing.
    """
    from lmic.certify.certificate_file import write_certificate
    from lmic.certify.certify import refutation
    from lmic.certify.document import decimal, decimal_above, decimal_below, float_above, float_below
    from lmic.errors import LmicError
    from lmic.pipeline import run
    from lmic.reporting import SHOWN

    side, text = ("--above", above) if below is None else ("--below", below)
    if text is None or (below is not None and above is not None):
        raise LmicError("the value to refute is given by --below, or by --above where the theorem maximises; give one")
    chosen = Choices(**choices)
    value = numbers([f"value={text}"], side)["value"]
    result = run(chosen.compile_files(name, plant))
    certificate, report, bound = refutation(
        result, chosen.relaxation(result.problem.binding.plant), numbers(chosen.given, "--set"), chosen.dimensions()
    )
    maximised = result.theorem.maximised(report)
    if maximised != (side == "--above"):
        better = ("larger", "--above") if maximised else ("smaller", "--below")
        raise LmicError(f"{name}: a {better[0]} {report} is better, so a value is refuted by {better[1]}; give that")
    if output:
        write_certificate(certificate, output)
    assert certificate.lower is not None
    radius = certificate.lower.radius
    about_theorem = all(functional.at_point for functional in certificate.lower.functionals)
    refuted = (bound < value if maximised else bound > value) and radius is None and about_theorem
    if as_json:
        said, end = ("above", "upper") if maximised else ("below", "lower")
        outward = float_above(bound) if maximised else float_below(bound)
        record = {"report": report, said: float(value), end: outward, "refuted": refuted}
        record |= {"bound_of": "theorem" if about_theorem else "relaxation"}
        echo_json(record | {"bound_for_unknowns_up_to": None if radius is None else float_below(radius)})
    else:
        far, shown = ("most", decimal_above) if maximised else ("least", decimal_below)
        proven = "proven" if about_theorem else "proven of the relaxation"
        proven += "" if radius is None else f" for unknowns up to {float_below(radius):g}"
        verdict = "so it cannot be reached with these bases" if refuted else "which does not refute it"
        click.echo(f"{report} = {text}: {report} is at {far} {decimal(shown(bound, SHOWN))} ({proven}), {verdict}")
    if not refuted:
        sys.exit(1)
