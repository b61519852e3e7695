"""Certificate files are read as they were written, and nothing false is accepted, whatever is changed in them."""

from __future__ import annotations

import json
import random
import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from lmic import library
from lmic.certify import document
from lmic.certify.certificate import Certificate, Unknown
from lmic.certify.certificate_file import checksum, parsed, read_certificate, text, write_certificate
from lmic.certify.verify import verify
from lmic.errors import CertificateError
from lmic.plants.files import read_plant

# Files -------------------------------------------------------------------------------------------------


def test_a_certificate_is_read_as_it_was_written(table_1: Certificate, tmp_path: Path) -> None:
    path = tmp_path / "table1.json"
    write_certificate(table_1, path)
    again = read_certificate(path)
    assert text(again) == text(table_1)
    verdict = verify(again)
    assert verdict.holds
    assert again.library_plant == "peixoto2025/example1.toml"


def test_a_thousand_corrupted_files_are_rejected(first_order: Certificate) -> None:
    """A digit, letter or sign changed, a byte lost or doubled, anywhere in the file."""
    content = text(first_order).encode()
    generator = random.Random(5)
    for number in range(1100):
        place = generator.randrange(len(content))
        if number % 2 == 0:
            place = generator.choice([m.start() for m in re.finditer(rb"\d", content)])
            other = generator.choice([d for d in b"0123456789" if d != content[place]])
            changed = content[:place] + bytes([other]) + content[place + 1 :]
        elif number % 4 == 1:
            changed = content[:place] + content[place + 1 :]
        else:
            changed = content[:place] + content[place : place + 1] + content[place:]
        if _same_json(changed, content):
            continue  # white space between the tokens, which states nothing
        with pytest.raises(CertificateError):
            verdict = verify(parsed(changed))
            raise CertificateError(verdict.reason) if not verdict.holds else AssertionError(changed)


def _same_json(first: bytes, second: bytes) -> bool:
    try:
        return bool(json.loads(first) == json.loads(second))
    except ValueError:
        return False


def _tables(certificate: Certificate) -> dict[str, Any]:
    tables = json.loads(text(certificate))
    del tables["sha256"]
    return tables


def test_without_the_checksum_what_is_accepted_is_true(first_order: Certificate) -> None:
    """A digit changed and the checksum made to fit: whatever still is proven holds by hand.

    The norm of d + cb/(z − a) is that at z = 1 or at z = −1.
    """
    body = json.dumps(_tables(first_order))
    digits = [m.start() for m in re.finditer(r"\d", body)]
    generator = random.Random(11)
    accepted = 0
    for _ in range(300):
        place = generator.choice(digits)
        changed = json.loads(body[:place] + generator.choice("0123456789") + body[place + 1 :])
        try:
            found = parsed(json.dumps(changed | {"sha256": checksum(changed)}).encode())
        except CertificateError:
            continue
        if not verify(found).holds:
            continue
        accepted += 1
        a, b, c, d = (found.plant.matrices[name].coefficients[0, 0, 0] for name in "ABCD")
        assert found.lower
        assert _holds_by_hand(found)
        assert found.lower.reports["gamma"] <= max(abs(d + c * b / (1 - a)), abs(d - c * b / (1 + a)))
    assert 20 < accepted < 280


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"theorem": "standard.stability_discrete"}, "report|unknowns|matrix"),
        ({"library_plant": "wu2007/example.toml"}, "are not those of the library"),
        ({"library_plant": "../pyproject.toml"}, "the library has no plant"),
        ({"scalars": {"eps": "1"}}, "the scalars are eps"),
        ({"unknowns": []}, "the unknowns are none"),
        ({"upper": None, "lower": None, "standing": "numerical"}, "states nothing"),
        ({"upper": None}, "calls itself"),
        ({"extra": 1}, "'extra'"),
        ({"scalars": {"eps": 1.5}}, "not exact"),
    ],
)
def test_damage_that_keeps_the_checksum_is_named(first_order: Certificate, change: dict[str, Any], reason: str) -> None:
    tables = _tables(first_order) | change
    content = json.dumps(tables | {"sha256": checksum(tables)}).encode()
    with pytest.raises(CertificateError, match=reason):
        verdict = verify(parsed(content))
        assert not verdict.holds
        raise CertificateError(verdict.reason)


@pytest.mark.parametrize("content", [b"", b"[]", b"{}", b"\xff", b"[" * 10_000, b'{"format": 1, "format": 2}', b"null"])
def test_what_is_no_certificate_is_refused(content: bytes) -> None:
    with pytest.raises(CertificateError):
        parsed(content)


def test_a_certificate_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    for name in ("absent.json", ".", "a\0b"):
        with pytest.raises(CertificateError, match=r"; (check|give) the path"):
            read_certificate(tmp_path / name)


def test_plants_survive_their_text() -> None:
    for file in sorted(library.root().glob("*/*.toml")):
        if file.name != "cases.toml":
            plant = read_plant(file)
            assert document.same_plant(document.read_plant_tables(document.plant_tables(plant)), plant)


def test_numbers_survive_their_text() -> None:
    generator = random.Random(1)
    for _ in range(300):
        value = Fraction(generator.randint(-(10**9), 10**9), generator.choice([1, 3, 7, 2**5, 2**70, 10**6]))
        assert document.number(document.number_text(value)) == value
        assert document.decimal_below(value) <= value <= document.decimal_above(value)
        root = document.root_below(abs(value)), document.root_above(abs(value))
        assert root[0] ** 2 <= abs(value) <= root[1] ** 2
        assert root[1] - root[0] <= Fraction(1, 10**13) * root[1]


# Nothing false is proven -----------------------------------------------------------------------------


def test_mutated_problems_are_judged_as_exact_arithmetic_judges_them(first_order: Certificate) -> None:
    """1,000 certificates with an entry nudged, by a little or by much, against the LMI worked out by hand.

    The bounded-real lemma of x⁺ = ax + bw, z = cx + dw is
    [[P, 0, aP, c], [0, γ, bP, d], [aP, bP, P, 0], [c, d, 0, γ]] ≻ 0.
    """
    generator = random.Random(7)
    verdicts = []
    for _ in range(1000):
        nudge = Fraction(generator.choice([-1, 1]), 10 ** generator.randint(1, 12))
        changed = _nudged(first_order, generator.choice([*first_order.unknowns, "A", "B", "C", "D", "gamma"]), nudge)
        verdict = verify(replace(changed, lower=None))
        assert verdict.holds == _holds_by_hand(changed), verdict.reason
        verdicts.append(verdict.holds)
    assert 200 < sum(verdicts) < 800


def _nudged(certificate: Certificate, what: str, nudge: Fraction) -> Certificate:
    assert certificate.upper
    if what == "gamma":
        reports = {name: value + nudge for name, value in certificate.upper.reports.items()}
        return replace(certificate, upper=replace(certificate.upper, reports=reports))
    if what in certificate.unknowns:
        unknown = certificate.unknowns[what]
        moved = Unknown(unknown.functions, tuple(m + nudge for m in unknown.matrices))
        return replace(certificate, unknowns={**certificate.unknowns, what: moved})
    matrices = dict(certificate.plant.matrices)
    matrices[what] = replace(matrices[what], coefficients=matrices[what].coefficients + nudge)
    return replace(certificate, plant=replace(certificate.plant, matrices=matrices))


def _holds_by_hand(certificate: Certificate) -> bool:
    """By the leading minors of the 4 x 4 matrix, and the claim by comparison."""
    assert certificate.upper
    a, b, c, d = (certificate.plant.matrices[name].coefficients[0, 0, 0] for name in "ABCD")
    P, gamma = (certificate.unknowns[name].matrices[0][0, 0] for name in ("P", "gamma"))
    F = [[P, 0, a * P, c], [0, gamma, b * P, d], [a * P, b * P, P, 0], [c, d, 0, gamma]]
    minors = [_determinant([row[:k] for row in F[:k]]) for k in range(1, 5)]
    return min(minors) > 0 and certificate.upper.reports["gamma"] >= gamma


def _determinant(rows: list[list[Fraction]]) -> Fraction:
    if not rows:
        return Fraction(1)
    head, *tail = rows
    return sum(
        ((-1) ** j * entry * _determinant([row[:j] + row[j + 1 :] for row in tail]) for j, entry in enumerate(head)),
        Fraction(0),
    )
