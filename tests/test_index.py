"""The library's table of contents agrees with the theorems themselves, and costs none of the mathematics."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from lmic import index, library
from lmic.errors import LibraryError
from lmic.language.source import Source

COMPUTED = """from lmic.dsl import *

n = dims("n")[0]
P = Symmetric("P", n)
theorem = Theorem(
    {arguments}
    lmis={{"P": PD(P)}},
)
"""
WRITTEN = 'title="Stability", source=Source("A", "T", "V", 1996, "Theorem 1"), variants={"robust": Variant("Robust")},'


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "mine.py"


def test_entries_agree_with_the_loaded_theorems() -> None:
    entries = index.entries()
    assert [entry.name for entry in entries] == library.names()
    assert len({entry.name for entry in entries}) == len(entries) > len(index.files())
    for entry in entries:
        theorem = library.theorem(entry.name)
        assert (theorem.name, theorem.title, theorem.source) == (entry.name, entry.title, entry.source)


def test_every_file_of_the_library_is_read_without_running_it() -> None:
    for name, path in index.files().items():
        read = list(index._written(name, ast.parse(path.read_text(encoding="utf-8"))))
        assert [entry.name.rpartition(".")[2] for entry in read] == [path.stem, *library.load_file(path).variants]


@pytest.mark.parametrize(
    "arguments",
    [
        WRITTEN,
        WRITTEN.replace('"Stability"', '"Sta" + "bility".lower()'),
        WRITTEN.replace('"Robust"', 'title="Robust"'),
        'variants={"robust": Variant("Robust")}, **dict(title="Stability", source=Source("A", "T", "V", 1996, '
        '"Theorem 1")),',
        WRITTEN.replace('{"robust": Variant("Robust")}', 'dict(robust=Variant(**{"title": "Robust"}))'),
    ],
)
def test_what_is_not_written_down_is_loaded(file: Path, arguments: str) -> None:
    file.write_text(COMPUTED.format(arguments=arguments), encoding="utf-8")
    source = Source("A", "T", "V", 1996, "Theorem 1")
    assert index.read_entries("group.mine", file) == [
        index.Entry("group.mine", "Stability", source),
        index.Entry("group.robust", "Robust", source),
    ]


def test_two_theorems_of_one_name_are_refused(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file.write_text(COMPUTED.format(arguments=WRITTEN), encoding="utf-8")
    monkeypatch.setattr(index, "files", lambda: {"group.one": file, "group.two": file})
    with pytest.raises(LibraryError, match=r"two theorems .* group\.robust; rename the variant"):
        index.entries()


@pytest.mark.parametrize("words", [["--help"], ["list"], ["list", "--json"], ["solve", "--help"], ["sweep", "--help"]])
def test_what_needs_no_mathematics_imports_none(words: list[str]) -> None:
    code = (
        "import sys\nfrom lmic.cli import main\ntry:\n    main(sys.argv[1:])\nexcept SystemExit as end:\n"
        "    assert not end.code\nfinally:\n    heavy = {'sympy', 'numpy', 'scipy', 'matplotlib', 'clarabel', "
        "'joblib', 'distributed', 'pyarrow'}\n    print(sorted(heavy & set(sys.modules)), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=True)
    assert done.stdout
    assert done.stderr.strip() == "[]"
