"""The certificates of the repository, proven anew."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import pytest
from click.testing import CliRunner

from lmic.certify.certificate import Standing, read_certificate
from lmic.certify.verify import verify
from lmic.cli import main

FOLDER = Path(__file__).parent.parent / "certificates"
FILES = sorted(FOLDER.glob("*.json"))

#: γ of Example 1 of Peixoto et al. (2025) by theorem and ε, from an independent SDPA solution in 200-bit arithmetic
REFERENCE = {
    "peixoto2025.theorem1": {
        1: "12.56046971834415863",
        10: "1.719904163691479878",
        50: "1.215248599689679686",
        150: "1.213769249285198035",
        1000: "1.213638820286880660",
    },
    "peixoto2025.corollary1": {
        1: "14.91287332096275712",
        10: "8.318716925531442742",
        50: "8.183950239239421206",
        150: "8.171543751332294879",
        1000: "8.167089700085760642",
    },
}


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_certificate_is_proven_anew(path: Path) -> None:
    certificate = read_certificate(path)
    verdict = verify(certificate)
    assert verdict.holds, verdict.reason
    assert certificate.library_plant


def test_table_1_is_enclosed_for_every_epsilon() -> None:
    found = set()
    for path in FILES:
        certificate = read_certificate(path)
        if certificate.theorem not in REFERENCE:
            continue
        eps = certificate.scalars["eps"]
        assert certificate.standing is Standing.CERTIFIED
        assert certificate.lower and certificate.upper
        lower, upper = certificate.lower.reports["gamma"], certificate.upper.reports["gamma"]
        assert lower <= Fraction(REFERENCE[certificate.theorem][int(eps)]) <= upper
        assert (upper - lower) / upper <= 1e-6
        found.add((certificate.theorem, int(eps)))
    assert found == {(theorem, eps) for theorem, values in REFERENCE.items() for eps in values}


def test_the_printed_values_of_s1_are_refuted() -> None:
    """1.8469 and 1.3632 of Wu et al. (2007) lie below what r = (1, 0) alone allows."""
    for case, printed in (("hinf", "1.8469"), ("l2linf", "1.3632")):
        certificate = read_certificate(FOLDER / f"wu2007.table1.{case}.point.json")
        assert certificate.lower
        assert certificate.lower.reports["gamma"] > Fraction(printed)


def test_fresh_enclosures_need_no_stored_certificate(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("lmic.papers.enclosures.folder", lambda: tmp_path / "none")
    command = ["reproduce", "peixoto2025.table1.robust", "-o", str(tmp_path / "reports"), "--json"]
    (numerical,) = json.loads(CliRunner().invoke(main, command).output)
    assert (numerical["standing"], numerical["lower"], numerical["upper"]) == ("numerical", None, None)
    (fresh,) = json.loads(CliRunner().invoke(main, [*command, "--fresh"]).output)
    assert fresh["standing"] == "certified"
    assert (
        fresh["lower"]
        <= float(REFERENCE["peixoto2025.corollary1"][150])
        <= fresh["upper"]
        <= fresh["lower"] * (1 + 1e-6)
    )
    written = tmp_path / "written"
    (certified,) = json.loads(CliRunner().invoke(main, [*command, "--certify", str(written)]).output)
    assert certified["standing"] == "certified"
    assert [path.name for path in written.iterdir()] == ["peixoto2025.table1.robust.json"]
