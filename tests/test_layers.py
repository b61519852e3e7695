"""Who may import whom: the stages, up to the certificate, know nothing of what prints, draws or looks at results."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from documents import ROOT

#: rooms and files that look at what the stages made
OUTSIDE = {"analysis", "authoring", "cli", "commands", "diagnosis", "pages", "papers", "reporting", "sweeps", "typeset"}
#: what the stages are made of, from the words of a theorem to the certificate
STAGES = ("language", "plants", "algebra", "compiler", "relax", "solve", "certify", "recover")
#: each is made of what stands before it; compiling and relaxing take turns
ORDER = [("algebra", "language"), ("plants",), ("compiler", "relax"), ("solve", "recover"), ("pipeline",), ("certify",)]
MODULES = [
    *(path for room in STAGES for path in sorted((ROOT / "lmic" / room).glob("*.py"))),
    ROOT / "lmic" / "pipeline.py",
]


def imported(path: Path) -> Iterator[str]:
    """What a module imports from lmic as it is loaded, by the first name behind ``lmic``."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom) and node.module == "lmic":
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("lmic."):
            yield node.module.split(".")[1]


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_stage_imports_nothing_that_looks_at_it(path: Path) -> None:
    assert not OUTSIDE & set(imported(path))


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_stage_imports_no_later_one(path: Path) -> None:
    own = path.relative_to(ROOT / "lmic").with_suffix("").parts[0]
    place = next(place for place, rooms in enumerate(ORDER) if own in rooms)
    assert not {room for rooms in ORDER[place + 1 :] for room in rooms} & set(imported(path))


def test_verifying_a_certificate_loads_no_solver_and_nothing_that_compiles() -> None:
    code = "import sys, lmic.certify.verify, lmic.certify.certificate_file; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    rooms = ("lmic.compiler", "lmic.relax", "lmic.solve", "lmic.recover", "lmic.pipeline")
    assert not [module for module in loaded if module.startswith(rooms)]
    assert not {"clarabel", "scs", "cvxpy", "sdpap"} & set(loaded)
