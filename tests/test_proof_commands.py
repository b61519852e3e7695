"""Certificates on the command line: solve --certify, verify and refute."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from click.testing import CliRunner

from lmic import library
from lmic.certify.certificate import Certificate
from lmic.cli import main

ROOT = library.root()
EXAMPLE_1 = ROOT / "peixoto2025" / "example1.toml"
SECTION_5 = ROOT / "wu2007" / "example.toml"


def test_solve_certify_verify_refute(tmp_path: Path) -> None:
    runner, path = CliRunner(), tmp_path / "table1.json"
    command = ["solve", "peixoto2025.theorem1", "--plant", str(EXAMPLE_1), "--set", "eps=150"]
    record = json.loads(runner.invoke(main, [*command, "--certify", str(path), "--json"]).output)
    assert record["soundness"] == "certified"
    assert record["lower"]["gamma"] <= record["reports"]["gamma"] <= record["upper"]["gamma"]
    assert record["certificate"] == str(path)
    shown = runner.invoke(main, ["verify", str(path)])
    assert shown.exit_code == 0
    assert "certified" in shown.output
    path.write_text(path.read_text().replace("150", "151"))
    damaged = runner.invoke(main, ["verify", str(path)])
    assert damaged.exit_code == 1
    assert "checksum" in damaged.stderr
    printed = ["refute", "wu2007.theorem3", "--plant", str(SECTION_5), "--grid", "r=2", "--below"]
    foreign = runner.invoke(main, [*printed, "1.8469", "--set", "x=1"])
    assert foreign.exit_code == 1
    assert "x is no scalar of the theorem" in foreign.stderr


def test_what_is_reached_is_not_refuted(first_order: Certificate, tmp_path: Path) -> None:
    plant = tmp_path / "first_order.toml"
    plant.write_text("[matrices]\nA = [[0.5]]\nB = [[1]]\nC = [[1]]\nD = [[0]]\n")
    command = ["refute", "standard.bounded_real_discrete", "--plant", str(plant), "--below"]
    runner = CliRunner()
    assert runner.invoke(main, [*command, "1.9999"]).exit_code == 0
    assert runner.invoke(main, [*command, "2.0001"]).exit_code == 1


def test_what_is_maximised_is_refuted_above(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(
        "from lmic.dsl import *\n(n,) = dims('n')\n"
        "A, x = Data('A', n, n, symmetric=True), Scalar('x')\n"
        "theorem = Theorem(lmis={'size': PD(A - x*I(n))}, minimise=-x, reports={'least': x},\n"
        "    source=Source('N. N.', 'A test', 'unpublished', 2026))\n"
    )
    (tmp_path / "plant.toml").write_text("[matrices]\nA = [[2, 1], [1, 2]]\n")
    command = ["refute", str(tmp_path / "mine.py"), "--plant", str(tmp_path / "plant.toml")]
    reached = CliRunner().invoke(main, [*command, "--above", "1.01"])
    assert reached.exit_code == 0, reached.output
    assert "least is at most 1" in reached.output
    assert CliRunner().invoke(main, [*command, "--above", "0.99"]).exit_code == 1
    for option, words in (
        (["--below", "1"], "give that"),
        ([], "give one"),
        (["--below", "1", "--above", "1"], "give one"),
    ):
        refused = CliRunner().invoke(main, [*command, *option])
        assert refused.exit_code == 1
        assert words in refused.output


def test_a_bound_on_less_than_the_theorem_refutes_nothing(
    first_order: Certificate, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a relaxation's coefficients, or for unknowns up to a size, a bound is told and no more."""
    words = ["--plant", str(EXAMPLE_1), "--set", "eps=150", "--below", "1.2"]
    answer = CliRunner().invoke(main, ["refute", "peixoto2025.theorem1", *words])
    assert answer.exit_code == 1
    assert "(proven of the relaxation), which does not refute it" in answer.output
    assert first_order.lower
    bounded = replace(first_order, lower=replace(first_order.lower, radius=Fraction(10**6)))
    lower = first_order.lower.reports["gamma"]
    monkeypatch.setattr("lmic.certify.certify.refutation", lambda *_: (bounded, "gamma", lower))
    plant = tmp_path / "first_order.toml"
    plant.write_text("[matrices]\nA = [[0.5]]\nB = [[1]]\nC = [[1]]\nD = [[0]]\n")
    command = ["refute", "standard.bounded_real_discrete", "--plant", str(plant), "--below", "1.9"]
    answer = CliRunner().invoke(main, command)
    assert answer.exit_code == 1
    assert "(proven for unknowns up to 1e+06), which does not refute it" in answer.output
    record = json.loads(CliRunner().invoke(main, [*command, "--json"]).output)
    assert (record["refuted"], record["bound_of"]) == (False, "theorem")
    assert Fraction(record["lower"]) <= lower
