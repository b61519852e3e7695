"""The README's first look, run exactly as it is written."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from documents import ROOT, Document, agrees

import lmic
from lmic.cli import main
from lmic.plants.plant import Plant
from lmic.solve.registry import SOLVERS

README = Document("README.md")
block = README.block


def test_first_look(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "my_theorem.py").write_text(block("python", "theorem = Theorem"), encoding="utf-8")
    (tmp_path / "plant.toml").write_text(block("toml"), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    program, *words = block("sh", "lmic solve").split()
    assert program == "lmic"
    result = CliRunner().invoke(main, words)
    assert result.exit_code == 0, result.output
    assert agrees(result.stdout, block("text"))
    violations = re.search(r"violation +(\S+) \(relative to diag S: (\S+)\)", result.stdout)
    assert violations
    assert all(float(value) < 1e-9 for value in violations.groups())


def test_files_and_solvers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plant = Plant.polytopic(A=[[[0.5]], [[0.3]]], B_w=[[1]], C_y=[[1]], D_y=[[1]], C_z=[[1]], D_z=[[0]])
    problem = lmic.compile(lmic.theorem("peixoto2025.theorem1"), plant, {"eps": 10})
    monkeypatch.chdir(tmp_path)
    lmic.write_problem(problem, "F.dat-s")
    names = {"problem": problem}
    exec(block("python", "read_problem"), names)
    assert names["result"].solution.solver == "cvxopt"
    assert (tmp_path / "F.cbf").exists()


def test_every_solver_is_in_the_readme() -> None:
    assert all(f"`{name}`" in README.text for name in SOLVERS)


def test_the_definition_has_fifteen_lines() -> None:
    assert len([line for line in block("python", "theorem = Theorem").splitlines() if line.strip()]) == 15


def test_every_command_is_in_the_readme() -> None:
    for command in main.commands:
        assert f"`lmic {command}" in README.text


def test_the_makefile_has_the_two_commands() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for line in block("sh", "make").splitlines():
        assert f"\n{line.split()[1]}:" in makefile
