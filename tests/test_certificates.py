"""The certificates of the repository, proven anew."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import pytest
from click.testing import CliRunner

from lmic.certify.certificate import Standing
from lmic.certify.certificate_file import read_certificate
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


#: optima as Chen and Fong (2006) print their conditions, from independent prototypes; the last digit is rounded.
#: Those with eight digits or more from 200 or 300 bits
CHEN = {
    "chen2006.nft.hinf": "3.92817",
    "chen2006.nft.h2": "7.18448",
    "chen2006.nft.mixed1": "8.3525",
    "chen2006.nft.mixed5": "10.7701",
    "chen2006.nft.mixed9": "10.8054",
    "chen2006.no_delay.hinf": "2.5834",
    "chen2006.no_delay.h2": "5.0832",
    "chen2006.example2": "0.018720",
}


#: the same with E and F full, with V and K full too, and for the LFT model: from double precision, to about 1e-5
CHEN_ROUGH = {
    "chen2006.nft.hinf_full_EF": "3.9048",
    "chen2006.nft.hinf_full": "3.8686",
    "chen2006.nft.h2_full_EF": "7.1420",
    "chen2006.nft.h2_full": "7.0883",
    "chen2006.nft.mixed1_full_EF": "8.2946",
    "chen2006.nft.mixed1_full": "8.2134",
    "chen2006.nft.mixed5_full_EF": "10.6615",
    "chen2006.nft.mixed5_full": "10.4898",
    "chen2006.nft.mixed9_full_EF": "10.669",
    "chen2006.nft.mixed9_full": "10.4677",
    "chen2006.lft.hinf": "6.2856",
    "chen2006.lft.h2": "9.4513",
}


def ends_of_s3(name: str) -> tuple[Fraction, Fraction]:
    certificate = read_certificate(FOLDER / f"{name}.json")
    assert certificate.standing is Standing.CERTIFIED
    assert certificate.lower and certificate.upper
    assert certificate.lower.radius is None
    report = next(iter(certificate.lower.reports))
    lower, upper = certificate.lower.reports[report], certificate.upper.reports[report]
    assert lower <= upper
    assert (upper - lower) / upper <= Fraction(1, 10**6)
    return lower, upper


@pytest.mark.parametrize("name", CHEN_ROUGH)
def test_the_other_conditions_of_s3_are_enclosed_near_their_references(name: str) -> None:
    lower, upper = ends_of_s3(name)
    reference = Fraction(CHEN_ROUGH[name])
    assert lower * (1 - Fraction(3, 10**5)) <= reference <= upper * (1 + Fraction(3, 10**5))


@pytest.mark.parametrize("name", CHEN)
def test_the_conditions_of_s3_are_enclosed(name: str) -> None:
    lower, upper = ends_of_s3(name)
    half_unit = Fraction(1, 2 * 10 ** len(CHEN[name].partition(".")[2]))
    assert lower - half_unit <= Fraction(CHEN[name]) <= upper + half_unit


def test_the_mixed_filters_that_the_paper_did_not_find_are_enclosed() -> None:
    """No reference is known. ρ γ + (1 − ρ) μ is no less than of both optima apart, and its optimum concave in ρ."""
    gamma, mu = (ends_of_s3(f"chen2006.lft.{norm}")[0] for norm in ("hinf", "h2"))
    ends = {rho: ends_of_s3(f"chen2006.lft.mixed{rho}") for rho in (1, 5, 9)}
    for tenths, (_, upper) in ends.items():
        rho = Fraction(tenths, 10)
        assert upper >= rho * gamma + (1 - rho) * mu
    assert ends[5][1] >= (ends[1][0] + ends[9][0]) / 2


def test_the_grids_of_s4_are_enclosed() -> None:
    """References in 200 bits: 0.10173990; the infimum 0.0951207 of Example 2 is not attained."""
    first = read_certificate(FOLDER / "mustafa.example1.published.json")
    assert first.lower and first.upper
    ends = first.lower.reports["gamma"], first.upper.reports["gamma"]
    assert first.lower.radius is None
    assert ends[0] - Fraction(5, 10**9) <= Fraction("0.10173990") <= ends[1] + Fraction(5, 10**9)
    assert ends[1] / ends[0] - 1 <= Fraction(1, 10**6)
    second = read_certificate(FOLDER / "mustafa.example2.published.json")
    assert second.lower and second.upper
    assert second.lower.reports["gamma"] <= Fraction("0.0951208")
    assert second.lower.radius
    assert second.upper.reports["gamma"] <= Fraction("0.09513")


def test_a_case_for_all_parameters_is_proven_on_the_whole_domain() -> None:
    """S1 for every a, b, c in the box, and S4 for every sampling interval."""
    names = ["wu2007.table1.hinf.box", "wu2007.table1.l2linf.box", "mustafa.example1.whole", "mustafa.example2.whole"]
    for name in names:
        certificate = read_certificate(FOLDER / f"{name}.json")
        assert certificate.standing is Standing.CERTIFIED
        assert certificate.upper
        assert not certificate.upper.functionals


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
