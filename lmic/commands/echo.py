"""What commands print beside tables: plain data as JSON, for ``--json``, and errors as one sentence."""

from __future__ import annotations

import os
import sys
from typing import Any

import click


def echo_json(data: Any) -> None:
    """Print plain data as JSON; infinities and NaN as null."""
    import json

    click.echo(json.dumps(_finite(data), indent=2, ensure_ascii=False))


def _finite(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _finite(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_finite(value) for value in data]
    if isinstance(data, float) and not (abs(data) < float("inf")):
        return None
    return data


def sentence(error: Exception) -> str:
    """An error as one line: lmic's own with its class, the system's with what could not be read or written."""
    if isinstance(error, MemoryError):
        return "MemoryError: the memory does not suffice; take fewer grid points, a lower degree or a smaller plant"
    if isinstance(error, OSError):
        what = error.filename or "the output"
        return f"{type(error).__name__}: {what} cannot be read or written: {error.strerror or error}; use another place"
    return f"{type(error).__name__}: {error}"


def silence_output() -> None:
    """Send what is still to be printed nowhere, since Python would try again at its end and complain."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (OSError, ValueError, AttributeError):  # standard output is no file, as in a notebook
        return
