"""Plain data as JSON, for the commands' ``--json``."""

from __future__ import annotations

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
