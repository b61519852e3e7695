"""Documents run as their readers would: files come from code blocks, commands are run, what they print is compared.

A block whose first line is ``# name.py`` or ``# name.toml`` is a file. Commands in ``sh`` and any other Python
are run, and a ``text`` block that follows must be what they print; ``...`` stands for lines left out.
``# ends with 1`` behind a command is its exit code.
"""

from __future__ import annotations

import contextlib
import io
import math
import re
import shlex
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

from click.testing import CliRunner

from lmic.cli import main

ROOT = Path(__file__).parent.parent
#: relative difference up to which two printed numbers are the same
TOLERANCE = 1e-6


class Document:
    """The code blocks of a Markdown file."""

    def __init__(self, path: str) -> None:
        self.text = (ROOT / path).read_text(encoding="utf-8")
        found = re.findall(r"^```(\w+)\n(.*?)^```$", self.text, flags=re.MULTILINE | re.DOTALL)
        self.blocks: list[tuple[str, str]] = [(language, text) for language, text in found]

    def block(self, language: str, containing: str = "") -> str:
        """The one code block in that language that contains a text."""
        (found,) = [text for kind, text in self.blocks if kind == language and containing in text]
        return found

    def follow(self, folder: Path) -> Iterator[tuple[str, str, str]]:
        """Do what the document says in a folder, which is the current one; what was run, printed and expected."""
        names: dict[str, Any] = {}
        for (language, text), (following, expected) in pairwise([*self.blocks, ("", "")]):
            file = re.match(r"# (\w+\.\w+)\n", text)
            if file:
                (folder / file[1]).write_text(text, encoding="utf-8")
            elif language in ("sh", "python"):
                printed = _commands(text) if language == "sh" else _python(text, names)
                yield text, printed, expected if following == "text" else "..."


def _commands(text: str) -> str:
    printed = ""
    for line in text.splitlines():
        command, _, code = line.partition("# ends with ")
        program, *words = shlex.split(command)
        assert program == "lmic"
        result = CliRunner().invoke(main, words)
        assert result.exit_code == int(code or 0), result.output
        printed += result.stdout
    return printed


def _python(text: str, names: dict[str, Any]) -> str:
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(text, names)
    return printed.getvalue()


def comparable(printed: str) -> list[list[str]]:
    """Words line by line, without what differs between machines: seconds, iterations, rounding errors, rules."""
    printed = re.sub(r"(solver +\w+):.*", r"\1", printed)
    printed = re.sub(r"(violation ).*", r"\1", printed)
    printed = re.sub(r"(uncertainty ).*", r"\1", printed)
    return [line.split() for line in printed.splitlines() if line.strip(" ─")]


def agrees(printed: str, expected: str) -> bool:
    """Whether the lines printed are the lines expected, with anything in place of ``...``."""
    lines, wanted = comparable(printed), comparable(expected)
    return _matches(lines, wanted)


def _matches(lines: list[list[str]], wanted: list[list[str]]) -> bool:
    if not wanted:
        return not lines
    if wanted[0] == ["..."]:
        return any(_matches(lines[k:], wanted[1:]) for k in range(len(lines) + 1))
    return bool(lines) and _same(lines[0], wanted[0]) and _matches(lines[1:], wanted[1:])


def _same(words: list[str], wanted: list[str]) -> bool:
    return len(words) == len(wanted) and all(map(_same_word, words, wanted))


def _same_word(word: str, wanted: str) -> bool:
    if word == wanted:
        return True
    numbers = [re.fullmatch(r"\W*(-?[\d.]+(?:e[+-]?\d+)?)\W*", one) for one in (word, wanted)]
    if not all(numbers):
        return False
    one, other = (float(number[1]) for number in numbers if number)
    return math.isclose(one, other, rel_tol=TOLERANCE)
