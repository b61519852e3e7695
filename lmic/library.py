"""The theorem library: finding theorems by name or path, and loading them.

A theorem's name is its path in the library with dots, ``peixoto2025.theorem1``; a variant stands
beside its theorem, ``peixoto2025.corollary1``. A user's own file is loaded by path in exactly the
same way; its variants are ``./my_theorem.py:robust``.
"""

from __future__ import annotations

import importlib.util
import sys
import traceback
from dataclasses import replace
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from lmic.errors import DefinitionError, LibraryError, LmicError
from lmic.index import entries, files, group
from lmic.index import root as root  # noqa: PLC0414
from lmic.language.theorem import Theorem
from lmic.plants.expressions import quoted

#: characters of a foreign error that are shown
LONGEST = 300


def names() -> list[str]:
    """Names of all theorems and variants, in order."""
    return [entry.name for entry in entries()]


def theorem(name: str | Path) -> Theorem:
    """A theorem by library name, ``"peixoto2025.theorem1"``, or by path, ``"./my_theorem.py"``.

    A variant goes by its own name in the library, and by ``"./my_theorem.py:robust"`` in a file. Raises LibraryError
    with the nearest names where there is none, and DefinitionError with the line for a file that fails.
    """
    place = locate(name)
    loaded = load_file(place.path)
    if not place.variant:
        return replace(loaded, name=place.name)
    if place.variant not in loaded.variants:
        has = ", ".join(loaded.variants) or "none"
        raise LibraryError(f"{place.path.stem} has no variant '{place.variant}'; it has {has}")
    return loaded.variant(place.variant, name=place.name)


def shipped(name: Any) -> Theorem:
    """The theorem of the library that a document names; a file is Python, and not run on the word of a document.

    Raises LibraryError for anything that is no name of a theorem of the library.
    """
    if not isinstance(name, str) or _is_path(name):
        raise LibraryError(f"its theorem, {quoted(name)}, is not one of the library; name its file with --theorem")
    try:
        locate(name)
    except LibraryError as error:
        raise LibraryError(
            f"there is no theorem {quoted(name)} in the library; name the file of one of your own with --theorem"
        ) from error
    return theorem(name)


class Located(NamedTuple):
    """Where a theorem is: its file, the variant in it (or an empty text), and the name that it goes by."""

    path: Path
    variant: str
    name: str


def locate(name: str | Path) -> Located:
    """Where the theorem of a name or path is; raises LibraryError where the library has none of that name."""
    text = str(name)
    if _is_path(text):
        file, _, variant = text.rpartition(":") if ".py:" in text else (text, "", "")
        stem = Path(file).stem
        return Located(Path(file), variant, f"{stem}:{variant}" if variant else stem)
    if text in files():
        return Located(files()[text], "", text)
    for file_name, path in files().items():
        variant = text.removeprefix(group(file_name))
        if text.startswith(group(file_name)) and variant in load_file(path).variants:
            return Located(path, variant, text)
    near = get_close_matches(text, files(), n=3)
    hint = f"did you mean {' or '.join(near)}?" if near else "'lmic list' shows all names"
    if Path(f"{text}.py").is_file():
        hint = f"for the file here write ./{text}.py"
    raise LibraryError(f"there is no theorem '{text}' in the library; {hint}")


def _is_path(text: str) -> bool:
    """Whether a text names a file, or a variant in one, and no theorem of the library."""
    return text.endswith(".py") or ".py:" in text or "/" in text


def load_file(path: Path) -> Theorem:
    """Run a theorem file and return its ``theorem``; errors name the file and line.

    A user's file is run anew each time, so that an edit counts; the library's are run once.
    """
    path = path.resolve()
    return _load_once(path) if path.is_relative_to(root().resolve()) else _load(path)


@cache
def _load_once(path: Path) -> Theorem:
    return _load(path)


def _load(path: Path) -> Theorem:
    if not path.is_file():
        raise LibraryError(f"there is no file {path}; give the path of a theorem file or a name that 'lmic list' shows")
    module = _run(path)
    found = getattr(module, "theorem", None)
    if not isinstance(found, Theorem):
        raise DefinitionError(f"{path} defines no theorem; end it with theorem = Theorem(...)")
    return replace(found, name=path.stem, description=(module.__doc__ or "").strip())


def _run(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"lmic_theorem_{path.stem}", path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    wrote_bytecode, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    try:
        spec.loader.exec_module(module)
    except SyntaxError as error:
        raise DefinitionError(f"{path}, line {error.lineno}: {error.msg}; correct the Python there") from error
    except LmicError as error:
        raise type(error)(f"{_place(path, error)}: {error}") from error
    except (Exception, SystemExit) as error:  # the user's file may raise anything
        said = ": ".join(filter(None, (type(error).__name__, " ".join(str(error).split())[:LONGEST])))
        raise DefinitionError(f"{_place(path, error)}: {said}; correct the line") from error
    finally:
        sys.dont_write_bytecode = wrote_bytecode
    return module


def _place(path: Path, error: BaseException) -> str:
    line = line_of(path, error)
    return f"{path}, line {line}" if line else str(path)


def line_of(path: Path, error: BaseException) -> int | None:
    """The line of a file in which an error arose, None where it passed none."""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if Path(frame.filename) == path]
    return lines[-1] if lines else None
