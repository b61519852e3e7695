"""The checklists of docs/extending.md name files, functions and tests that are there."""

from __future__ import annotations

import re

import pytest
from documents import ROOT, Document

TEXT = Document("docs/extending.md").text
PATHS = sorted(set(re.findall(r"`((?:lmic|tests|theorems|certificates|pyproject)[\w/]*(?:\.\w+|/))`", TEXT)))
NAMED = sorted(set(re.findall(r"`(\w+)`\s+in\s+`([\w/.]+)`", TEXT)))


@pytest.mark.parametrize("path", [path for path in PATHS if "NAME" not in path and "GROUP" not in path])
def test_the_file_is_there(path: str) -> None:
    assert (ROOT / path).exists()


@pytest.mark.parametrize(("name", "path"), NAMED)
def test_the_name_is_defined_in_the_file(name: str, path: str) -> None:
    text = (ROOT / path).read_text(encoding="utf-8")
    assert re.search(rf"^\s*(def {name}\(|class {name}\b|{name}\b *[:=])", text, flags=re.MULTILINE)


def test_there_is_a_checklist_for_each_kind() -> None:
    headings = re.findall(r"^## (.*)$", TEXT, flags=re.MULTILINE)
    assert headings == ["A theorem", "A relaxation", "A solver", "A file format", "A command", "A release"]
    assert len(NAMED) > 25
