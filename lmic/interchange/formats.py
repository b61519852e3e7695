"""The file formats by suffix: SDPA sparse, CBF, SeDuMi in a MATLAB file, NumPy arrays.

Every format's writer takes an :class:`~lmic.interchange.sdp.SDP` to bytes, and its reader takes bytes to one;
what is read is what was written, bit for bit. To add a format, write one file with the two functions,
name it here, and give it to the tests of all formats.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from lmic.compiler.assemble import ConicProblem
from lmic.errors import FormatError, LmicError
from lmic.files import read_at_most, write_whole
from lmic.interchange.cbf import read_cbf, write_cbf
from lmic.interchange.matlab import read_mat, write_mat
from lmic.interchange.npz import read_npz, write_npz
from lmic.interchange.sdp import SDP, sdp_of_problem
from lmic.interchange.sdpa import read_sdpa, write_sdpa

#: bytes of a file that is read
MAX_BYTES = 2**28


@dataclass(frozen=True)
class Format:
    """A format's name, writer and reader."""

    name: str
    write: Callable[[SDP], bytes]
    read: Callable[[bytes], SDP]


FORMATS: Mapping[str, Format] = {
    ".dat-s": Format("SDPA sparse", write_sdpa, read_sdpa),
    ".cbf": Format("CBF", write_cbf, read_cbf),
    ".mat": Format("SeDuMi", write_mat, read_mat),
    ".npz": Format("NumPy", write_npz, read_npz),
}


def is_problem_file(path: str | Path) -> bool:
    """Whether the suffix is that of a format."""
    return Path(path).suffix.lower() in FORMATS


def read_problem(path: str | Path) -> SDP:
    """The semidefinite program of a .dat-s, .cbf, .mat or .npz file.

    Raises FormatError, naming the file, for whatever is wrong.
    """
    file = Path(path)
    try:
        found = _format(file)
        return found.read(read_at_most(file, MAX_BYTES))
    except LmicError as error:
        raise FormatError(f"{file}: {error}") from error
    except ValueError as error:
        raise FormatError(f"{file} cannot be read ({error}); write it anew") from error


def write_problem(problem: ConicProblem | SDP, path: str | Path) -> None:
    """Write a problem in the format that the suffix names: .dat-s, .cbf, .mat or .npz.

    Raises FormatError for another suffix, and LmicError where the file cannot be written; no half of one is left.
    """
    file = Path(path)
    found = _format(file)
    sdp = sdp_of_problem(problem) if isinstance(problem, ConicProblem) else problem
    write_whole(file, found.write(sdp))


def _format(file: Path) -> Format:
    if file.suffix.lower() not in FORMATS:
        known = ", ".join(f"{suffix} ({found.name})" for suffix, found in FORMATS.items())
        raise FormatError(f"the format of {file} is unknown; end the name in one of {known}")
    return FORMATS[file.suffix.lower()]
