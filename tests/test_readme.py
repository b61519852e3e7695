"""The README's commands, run exactly as they are written."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from documents import ROOT, Document, agrees

import lmic
from lmic.cli import main
from lmic.plants.plant import Plant
from lmic.solve.registry import SOLVERS

README, PROGRAMS, SWEEPS = Document("README.md"), Document("docs/programs.md"), Document("docs/sweeps.md")
block = README.block


def test_first_look(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "my_theorem.py").write_text(block("python", "theorem = Theorem"), encoding="utf-8")
    (tmp_path / "plant.toml").write_text(block("toml"), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    program, *words = block("sh", "lmic solve ./my_theorem.py").split()
    assert program == "lmic"
    result = CliRunner().invoke(main, words)
    assert result.exit_code == 0, result.output
    assert agrees(result.stdout, block("text"))
    violations = re.search(r"violation +(\S+) \(relative to diag S: (\S+)\)", result.stdout)
    assert violations
    assert all(float(value) < 1e-9 for value in violations.groups())
    _, *words = Document("docs/diagnosis.md").block("sh").split()
    result = CliRunner().invoke(main, words)
    assert result.exit_code == 0, result.output
    assert "dissipation" in result.stdout


def test_first_result() -> None:
    program, *words = block("sh", "pip install").splitlines()[-1].split()
    assert program == "lmic"
    result = CliRunner().invoke(main, [*words, "--json"])
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["reports"]["gamma"] == pytest.approx(1.2137692, abs=5e-8)
    assert "γ = 1.2137692" in README.text


def test_the_first_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The command is the makefile's, and its numbers are known where P is constant or the stiffness is."""
    words = _words(block("sh", "oscillator.svg"))
    makefile = _words((ROOT / "Makefile").read_text(encoding="utf-8"))
    assert " ".join(words[1 : words.index("-o")]) in " ".join(makefile)
    assert f"](docs/{words[-1]})" in README.text
    assert (ROOT / "docs" / words[-1]).is_file()
    norm = 1 / (0.2 * math.sqrt(0.99))  # H∞ norm of 1/(s² + 0.2 s + 1)
    words[words.index("s=0:0.6:31")] = f"s=0,{0.9 / norm},{1.01 / norm}"
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(main, [*words[1:], "--jobs", "1", "--json"])
    assert result.exit_code == 0, result.output
    (constant, *_), (middle, affine, quadratic), (none, *wider) = np.array(
        json.loads(result.stdout)["table"]["gamma"], dtype=float
    ).reshape(3, 3)
    assert [constant, middle] == pytest.approx([norm, norm / (1 - 0.9)], rel=1e-6)  # the circle criterion
    assert quadratic < affine < middle / 5
    assert np.isnan(none)
    assert all(np.isfinite(wider))
    assert (tmp_path / words[-1]).read_text(encoding="utf-8").startswith("<?xml")


def test_the_sweep(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The command as it is written, at few of its points."""
    words = _words(SWEEPS.block("sh"))
    thinned = {"rho=1:21:21": "rho=1,21", "eps=0.1:6:296": "eps=1,2"}
    assert thinned.keys() <= set(words)
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(main, [*(thinned.get(word, word) for word in words[1:]), "--jobs", "1"])
    assert result.exit_code == 0, result.output
    assert "4 points (4 solved)" in result.output
    assert (tmp_path / words[-1]).is_file()


def _words(text: str) -> list[str]:
    """Words of a shell's commands, whose lines may go on."""
    return text.replace("\\\n", " ").split()


def test_files_and_solvers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plant = Plant.polytopic(A=[[[0.5]], [[0.3]]], B_w=[[1]], C_y=[[1]], D_y=[[1]], C_z=[[1]], D_z=[[0]])
    problem = lmic.compile(lmic.theorem("peixoto2025.theorem1"), plant, {"eps": 10})
    monkeypatch.chdir(tmp_path)
    lmic.write_problem(problem, "F.dat-s")
    names = {"problem": problem}
    exec(PROGRAMS.block("python", "read_problem"), names)
    assert names["result"].solution.solver == "cvxopt"
    assert (tmp_path / "F.cbf").exists()


def test_every_solver_is_documented() -> None:
    assert all(f"| `{name}`" in PROGRAMS.text or f"`{name}` |" in PROGRAMS.text for name in SOLVERS)


def test_the_definition_has_fifteen_lines() -> None:
    assert len([line for line in block("python", "theorem = Theorem").splitlines() if line.strip()]) == 15


def test_every_command_is_in_the_readme() -> None:
    for command in main.commands:
        assert f"`lmic {command}" in README.text


def test_the_makefile_has_the_two_commands() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for line in block("sh", "make reproduce").splitlines():
        assert f"\n{line.split()[1]}:" in makefile
