"""Files: written completely or not at all, and read up to a size."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any

from lmic.errors import LmicError


def read_at_most(path: Path, most: int) -> bytes:
    """The content of a file of ``most`` bytes or less, however large it is and whatever it says of its size.

    Raises LmicError, whose sentence begins after the path, for what is no file, cannot be read or holds more.
    """
    try:
        if path.exists() and not path.is_file():
            raise LmicError("is not a file; give the path of one")
        with path.open("rb") as stream:
            content = stream.read(most + 1)
    except (OSError, ValueError) as error:  # a name with a null character is a ValueError
        raise LmicError(f"cannot be read ({reason(error)}); check the path and its permissions") from error
    if len(content) > most:
        raise LmicError(f"holds more than {most >> 20} MiB, more than lmic takes; give a smaller file")
    return content


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a text (as UTF-8) or bytes to a temporary file beside ``path`` and move it there.

    What is no file, such as /dev/stdout, is written to as it is; a link is followed. Raises LmicError where that is
    impossible; nothing half written is left.
    """
    data = content.encode() if isinstance(content, str) else content
    draft = None
    try:
        if path.is_dir():
            raise LmicError(f"{path} cannot be written: it is a folder; name a file in it")
        if path.exists() and not path.is_file():
            with path.open("wb", buffering=0) as stream:
                stream.write(data)
            return
        target = path.resolve() if path.is_symlink() else path
        draft = target.with_name(f".{target.name}.{os.getpid()}")
        draft.write_bytes(data)
        draft.replace(target)
    except (OSError, ValueError) as error:  # a name with a null character is a ValueError
        raise LmicError(f"{path} cannot be written: {reason(error)}; choose another place") from error
    finally:
        if draft is not None:
            with suppress(OSError, ValueError):
                draft.unlink(missing_ok=True)


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


def write_figure(path: Path, figure: Any) -> None:
    """Write a matplotlib figure in the format that the suffix names; raises ValueError for an unknown one."""
    image, kind = BytesIO(), path.suffix.removeprefix(".").lower()
    figure.savefig(image, format=kind, dpi=130, metadata={"Date": None} if kind == "svg" else None)
    write_whole(path, image.getvalue())


def make_folder(path: Path) -> None:
    """Make a folder, and those above it; raises LmicError where that is impossible."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        if not os.access(path, os.W_OK | os.X_OK):
            raise PermissionError(0, "permission denied")
    except (OSError, ValueError) as error:
        raise LmicError(f"the folder {path} cannot be written: {reason(error)}; choose another") from error


def reason(error: OSError | ValueError) -> str:
    """Why the system refused, in its own words and without the path."""
    return (getattr(error, "strerror", None) or str(error)).lower()
