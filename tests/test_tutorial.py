"""The tutorial, run exactly as it is written."""

from __future__ import annotations

from pathlib import Path

import pytest
from documents import Document, agrees


def test_the_tutorial_does_what_it_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    followed = list(Document("docs/tutorial.md").follow(tmp_path))
    for what, printed, expected in followed:
        assert agrees(printed, expected), f"{what}\nprints\n{printed}\nand not\n{expected}"
    commands = " ".join(what for what, _, _ in followed)
    for word in ("check", "solve", "sweep", "--over polya", "--grid", "--certify", "verify", "Relaxation("):
        assert word in commands


def test_a_document_that_says_something_else_is_found_out() -> None:
    printed = "a  1.0000001\n\nsolver clarabel: 3\nb\nc\n"
    assert agrees(printed, "a 1.0\nsolver clarabel: 4\nb\nc")
    assert agrees(printed, "...\nc")
    assert agrees(printed, "a 1.0\n...")
    for wrong in ("a 1.001\n...", "b\nc", "a 1.0\n...\nd", "...\nb"):
        assert not agrees(printed, wrong)
