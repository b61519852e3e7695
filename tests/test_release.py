"""What is released: both archives are whole, and what they say of themselves agrees with the source."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from email.message import Message
from email.parser import BytesParser
from pathlib import Path
from typing import Any

import pytest
from cffconvert import Citation
from documents import ROOT
from packaging.version import Version
from ruamel.yaml import YAML

from lmic import __version__

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CITATION = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
CHANGELOG = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
#: the kinds of change that Keep a Changelog 1.1.0 knows
KINDS = {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}


@pytest.fixture(scope="module")
def dist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the source archive and the wheel that was made from it, as ``make dist`` makes them."""
    folder = tmp_path_factory.mktemp("dist")
    said = _python("-m", "build", "--no-isolation", "--outdir", folder, ROOT)
    assert said.returncode == 0, said.stdout + said.stderr
    return folder


@pytest.fixture(scope="module")
def source(dist: Path) -> set[str]:
    """Names in the source archive, its outer folder left out."""
    (archive,) = dist.glob("*.tar.gz")
    with tarfile.open(archive) as stream:
        return {name.partition("/")[2] for name in stream.getnames()}


@pytest.fixture(scope="module")
def wheel(dist: Path) -> dict[str, bytes]:
    (archive,) = dist.glob("*.whl")
    with zipfile.ZipFile(archive) as stream:
        return {name: stream.read(name) for name in stream.namelist()}


def _python(*words: str | os.PathLike[str]) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, check=False)


def _of(wheel: dict[str, bytes], ending: str) -> bytes:
    (found,) = (content for name, content in wheel.items() if name.endswith(ending))
    return found


def test_the_source_archive_is_all_that_git_keeps(source: set[str]) -> None:
    if not (ROOT / ".git").exists():
        pytest.skip("not a clone")
    words = ["git", "-C", str(ROOT), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    kept = subprocess.run(words, capture_output=True, text=True, check=True).stdout.split("\0")
    assert source == {name for name in kept if name and (ROOT / name).exists()} | {"PKG-INFO"}


def test_the_wheel_is_the_package_with_its_library(source: set[str], wheel: dict[str, bytes]) -> None:
    expected = {name for name in source if name.startswith("lmic/")}
    expected |= {f"lmic/{name}" for name in source if name.startswith(("theorems/", "certificates/"))}
    assert {name for name in wheel if ".dist-info/" not in name} == expected
    assert expected >= {
        "lmic/py.typed",
        "lmic/authoring/templates/theorem.txt",
        "lmic/pages/templates/result.html",
        "lmic/theorems/peixoto2025/theorem1.py",
        "lmic/theorems/peixoto2025/example1.toml",
        "lmic/certificates/peixoto2025.table1.robust.json",
    }


def test_the_wheel_says_what_the_project_says(wheel: dict[str, bytes]) -> None:
    said: Message = BytesParser().parsebytes(_of(wheel, ".dist-info/METADATA"))
    assert said["Version"] == __version__
    assert said["License-Expression"] == PROJECT["license"]
    assert set(said.get_all("Provides-Extra", ())) == set(PROJECT["optional-dependencies"])
    assert _of(wheel, "licenses/LICENSE") == (ROOT / "LICENSE").read_bytes()
    assert b"lmic = lmic.cli:main" in _of(wheel, "entry_points.txt")


def test_both_archives_pass_the_metadata_check(dist: Path) -> None:
    said = _python("-m", "twine", "check", "--strict", *dist.iterdir())
    assert said.returncode == 0, said.stdout + said.stderr
    assert said.stdout.count("PASSED") == 2


def test_the_citation_is_valid_and_says_what_the_project_says() -> None:
    Citation(CITATION).validate()
    said: dict[str, Any] = YAML(typ="safe", pure=True).load(CITATION)
    assert str(said["version"]) == __version__
    assert (said["title"], said["license"]) == (PROJECT["name"], PROJECT["license"])
    assert (said["abstract"], said["keywords"]) == (PROJECT["description"], PROJECT["keywords"])
    assert [author["name"] for author in said["authors"]] == [author["name"] for author in PROJECT["authors"]]


def test_every_python_that_is_named_is_tried() -> None:
    named = [line.rpartition(" ")[2] for line in PROJECT["classifiers"] if re.search(r"3\.\d+$", line)]
    assert PROJECT["requires-python"] == f">={named[0]}"
    run = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert f"for version in {' '.join(named)}; do" in run


def test_the_changelog_has_its_form() -> None:
    unreleased, *released = re.findall(r"^## (.+)$", CHANGELOG, re.MULTILINE)
    assert unreleased == "[Unreleased]"
    entries = [re.fullmatch(r"\[(\d+\.\d+\.\d+)\] - (\d{4}-\d\d-\d\d)", heading) for heading in released]
    assert all(entries), released
    versions = [Version(entry[1]) for entry in entries if entry]
    assert versions == sorted(versions, reverse=True)
    assert all(version <= Version(__version__) for version in versions)
    assert set(re.findall(r"^### (.+)$", CHANGELOG, re.MULTILINE)) <= KINDS
