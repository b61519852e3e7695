"""A theorem file and a plant file to begin with."""

from __future__ import annotations

import keyword
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path
from string import Template

from lmic.errors import LmicError
from lmic.files import write_new


def write_starter(name: str, folder: Path = Path()) -> tuple[Path, Path]:
    """Write ``name.py``, a commented theorem, and ``name.toml``, a plant for it, into a folder made if need be.

    Raises LmicError, and writes neither, where the name is none or one of the files exists.
    """
    if not name.isidentifier() or keyword.iskeyword(name):
        raise LmicError(f"'{name}' is no name for a theorem; use letters, digits and underscores, as in my_theorem")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise LmicError(f"the folder {folder} cannot be made: {error.strerror}; choose another with -o") from error
    theorem, plant = folder / f"{name}.py", folder / f"{name}.toml"
    write_new({theorem: _filled("theorem.txt", name), plant: _filled("plant.txt", name)})
    return theorem, plant


def _filled(template: str, name: str) -> str:
    text = files("lmic.authoring").joinpath("templates", template).read_text(encoding="utf-8")
    return Template(text).substitute(name=name, year=datetime.now(UTC).year)
