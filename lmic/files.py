"""Writing files: completely, or not at all."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from lmic.errors import LmicError


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a text (as UTF-8) or bytes to a temporary file beside ``path`` and move it there.

    Raises LmicError where that is impossible; nothing half written is left.
    """
    if path.is_dir():
        raise LmicError(f"{path} cannot be written: it is a folder; name a file in it")
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        draft.write_bytes(content.encode() if isinstance(content, str) else content)
        draft.replace(path)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise LmicError(f"{path} cannot be written: {error.strerror}; choose another place") from error
    except BaseException:
        draft.unlink(missing_ok=True)
        raise


def write_new(contents: Mapping[Path, str]) -> None:
    """Write texts (as UTF-8) to files that do not exist yet: all of them, or none.

    Raises LmicError where one exists or cannot be written; nothing is overwritten.
    """
    written: list[Path] = []
    try:
        for path, content in contents.items():
            with path.open("xb") as stream:
                written.append(path)
                stream.write(content.encode())
    except FileExistsError as error:
        _remove(written)
        raise LmicError(f"{path} exists and is not overwritten; choose another name or folder") from error
    except OSError as error:
        _remove(written)
        raise LmicError(f"{path} cannot be written: {error.strerror}; choose another place") from error
    except BaseException:
        _remove(written)
        raise


def _remove(paths: Sequence[Path]) -> None:
    for path in paths:
        path.unlink(missing_ok=True)
