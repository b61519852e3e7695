"""What ``lmic solve -o FILE`` writes, by the suffix: the whole result, a page of it, or the design alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from lmic.errors import FormatError
from lmic.interchange import design

if TYPE_CHECKING:
    from lmic.certify.certificate import Certificate
    from lmic.pipeline import Result

#: suffixes of a whole result and of its page
RESULT, PAGE = ".json", ".html"
SUFFIXES = (RESULT, PAGE, *design.SUFFIXES)


def check_output(path: Path) -> None:
    """Refuse, before anything is solved, a file that could not be written."""
    if path.suffix.lower() not in SUFFIXES:
        raise FormatError(f"the format of {path} is unknown; end the name in {', '.join(SUFFIXES)}")


def write_output(result: Result, path: Path, certificate: Certificate | None, theorem: str) -> None:
    """Write the result, or what of it the suffix asks for; ``theorem`` is where its statement is found again."""
    match path.suffix.lower():
        case ".json":
            from lmic.result_file import write_result

            write_result(result, path, certificate, theorem)
        case ".html":
            from lmic.pages.result import report

            report(result, certificate, path)
        case _:
            design.write_design(result, path)
