"""``lmic new``: what it writes is checked, solved and never over something else."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import lmic
from lmic.analysis.norms import frozen_gain
from lmic.cli import main


def run(*words: str) -> Result:
    return CliRunner().invoke(main, list(words))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_it_runs_at_once(folder: Path) -> None:
    written = run("new", "mine")
    assert written.exit_code == 0, written.output
    commands = [line.split()[1:] for line in written.stdout.splitlines() if line.startswith("  lmic")]
    assert [command[0] for command in commands] == ["check", "solve"]
    for command in commands:
        result = run(*command, "--json")
        assert result.exit_code == 0, result.output
    assert json.loads(run(*commands[0], "--json").stdout)["findings"] == []


def test_its_controller_keeps_the_promise(folder: Path) -> None:
    """The closed loop at frozen α is stable and its H∞ norm is below γ; the plant alone is unstable."""
    run("new", "mine")
    plant = lmic.read_plant("mine.toml")
    result = lmic.run(lmic.compile(lmic.theorem("./mine.py"), plant))
    (promise,) = result.theorem.guarantees
    alphas = [[1, 0], [0.5, 0.5], [0, 1]]
    gains = frozen_gain(result.design, promise.system, {"alpha": alphas})
    assert all(0 < gain < result.reports["gamma"] for gain in gains)
    loops = result.design.frozen(promise.system, {"alpha": alphas})["A"]
    assert max(abs(np.linalg.eigvals(loops)).ravel()) < 1
    assert max(abs(np.linalg.eigvals(np.array([[1, 0.2], [0.3, 0.9]])))) > 1


def test_the_comments_teach_every_part(folder: Path) -> None:
    run("new", "mine")
    text = (folder / "mine.py").read_text(encoding="utf-8")
    comments = " ".join(line.partition("#")[2] for line in text.splitlines())
    for word in ("Data", "Symmetric", "star", "He(X)", "--dependence", "given", "affinely", "--search", "alpha.next"):
        assert word in comments
    assert max(map(len, text.splitlines())) <= 120


def test_nothing_is_overwritten(folder: Path) -> None:
    for existing in ("mine.py", "mine.toml"):
        (folder / existing).write_text("kept", encoding="utf-8")
        result = run("new", "mine")
        assert result.exit_code == 1
        assert f"{existing} exists and is not overwritten" in result.stderr
        assert [path.name for path in folder.iterdir()] == [existing]
        assert (folder / existing).read_text(encoding="utf-8") == "kept"
        (folder / existing).unlink()


def test_a_folder_is_made(folder: Path) -> None:
    result = run("new", "mine", "-o", "a/b", "--json")
    assert json.loads(result.stdout) == {"theorem": "a/b/mine.py", "plant": "a/b/mine.toml"}
    assert (folder / "a" / "b" / "mine.py").is_file()


@pytest.mark.parametrize("name", ["a.b", "../x", "1st", "", "class", "a b"])
def test_names_that_are_none(name: str, folder: Path) -> None:
    result = run("new", "--", name)
    assert result.exit_code == 1
    assert "is no name for a theorem" in result.stderr
    assert not list(folder.iterdir())


def test_a_folder_that_cannot_be_made(folder: Path) -> None:
    (folder / "file").write_text("", encoding="utf-8")
    result = run("new", "mine", "-o", "file")
    assert result.exit_code == 1
    assert "cannot be made" in result.stderr
