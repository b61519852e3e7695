"""The library's table of contents: names, titles and sources of all theorems, without running their files.

What a theorem is called and where it was published stands in its file as plain text, so reading the syntax
tree is enough, and ``lmic list`` needs none of the mathematics. A file that computes its title is loaded.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from lmic.errors import LibraryError
from lmic.language.source import Source


@dataclass(frozen=True)
class Entry:
    """One line of the table of contents."""

    name: str
    title: str
    source: Source


@cache
def root() -> Path:
    """Folder of the library: inside the installed package, or beside it in a checkout."""
    package = Path(__file__).parent
    for folder in (package / "theorems", package.parent / "theorems"):
        if folder.is_dir():
            return folder
    raise LibraryError(f"the theorem library is missing beside {package}; install lmic again")


@cache
def files() -> dict[str, Path]:
    """Every theorem file of the library by its name."""
    return {
        ".".join(path.relative_to(root()).with_suffix("").parts): path
        for path in sorted(root().rglob("*.py"))
        if not path.name.startswith("_")
    }


@cache
def plants() -> dict[str, Path]:
    """Every plant file of the library by its name: ``peixoto2025.example1``."""
    return {
        ".".join(path.relative_to(root()).with_suffix("").parts): path
        for path in sorted(root().rglob("*.toml"))
        if path.name != "cases.toml"
    }


def group(name: str) -> str:
    """``peixoto2025.`` of ``peixoto2025.theorem1``."""
    return name.rpartition(".")[0] + "." if "." in name else ""


def entries() -> list[Entry]:
    """Every theorem and variant of the library, in order; raises LibraryError where two share a name."""
    found: dict[str, Entry] = {}
    for name, path in files().items():
        for entry in read_entries(name, path):
            if entry.name in found:
                raise LibraryError(f"two theorems of the library are called {entry.name}; rename the variant in {path}")
            found[entry.name] = entry
    return list(found.values())


def read_entries(name: str, path: Path) -> list[Entry]:
    """The theorem of a file, then its variants."""
    try:
        return list(_written(name, ast.parse(path.read_text(encoding="utf-8"))))
    except (_ComputedError, SyntaxError):
        return _loaded(name, path)


class _ComputedError(Exception):
    """What is looked for is not written down in the file as a literal."""


def _written(name: str, module: ast.Module) -> Iterator[Entry]:
    statement = _call(_assigned(module, "theorem"), "Theorem")
    keywords = {keyword.arg: keyword.value for keyword in statement.keywords}
    if statement.args or None in keywords or "source" not in keywords:
        raise _ComputedError
    try:
        source = Source(**_literals(_call(keywords["source"], "Source"), tuple(Source.__dataclass_fields__)))
    except TypeError as error:  # an argument is missing: loading the file says which
        raise _ComputedError from error
    yield Entry(name, _literal(keywords["title"]) if "title" in keywords else "", source)
    variants = keywords.get("variants", ast.Dict([], []))
    if not isinstance(variants, ast.Dict):
        raise _ComputedError
    for key, value in zip(variants.keys, variants.values, strict=True):
        said = {"title": ""} | _literals(_call(value, "Variant"), ("title", "statement"))
        statement_name = said.get("statement") or source.statement
        yield Entry(group(name) + _literal(key), said["title"], replace(source, statement=statement_name))


def _assigned(module: ast.Module, name: str) -> ast.expr:
    """The only value that is assigned to a name."""
    values = [
        node.value
        for node in ast.walk(module)
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == name for t in node.targets)
    ]
    if len(values) != 1:
        raise _ComputedError
    return values[0]


def _call(node: ast.expr | None, function: str) -> ast.Call:
    if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Name) or node.func.id != function:
        raise _ComputedError
    return node


def _literals(call: ast.Call, names: tuple[str, ...]) -> dict[str, Any]:
    """The arguments of a call that have one of the names, in whose order the positional ones stand."""
    given = dict(zip(names, call.args, strict=False)) | {
        keyword.arg: keyword.value for keyword in call.keywords if keyword.arg in names
    }
    if any(isinstance(argument, ast.Starred) for argument in call.args) or None in {k.arg for k in call.keywords}:
        raise _ComputedError
    return {name: _literal(value) for name, value in given.items()}


def _literal(node: ast.expr | None) -> Any:
    try:
        return ast.literal_eval(node) if node is not None else None
    except ValueError as error:
        raise _ComputedError from error


def _loaded(name: str, path: Path) -> list[Entry]:
    """The same from the theorem itself."""
    from lmic.library import load_file

    theorem = load_file(path)
    variants = [(group(name) + key, theorem.variant(key)) for key in theorem.variants]
    return [Entry(called, one.title, one.source) for called, one in [(name, theorem), *variants]]
