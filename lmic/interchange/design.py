"""A recovered design as a file: plain arrays for NumPy or MATLAB, or LaTeX as papers print it.

The arrays are the recovered matrices at the vertices of the parameters' domains, K of them: in .npz of
shape (K, rows, cols), in .mat (rows, cols, K). ``at_NAME`` are the K values of a parameter, a row each;
``report_NAME`` what the theorem reports; ``theorem``, ``plant``, ``soundness`` and ``status`` are texts.
"""

from __future__ import annotations

from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import scipy.io

from lmic.errors import FormatError, Place, RecoveryError
from lmic.files import write_whole
from lmic.plants.domains import vertex_points
from lmic.typeset import numbers

if TYPE_CHECKING:
    from lmic.pipeline import Result

SUFFIXES = (".npz", ".mat", ".tex")


def check_suffix(path: Path) -> None:
    """Refuse, before anything is solved, a file that could not be written."""
    if path.suffix.lower() not in SUFFIXES:
        raise FormatError(f"the format of {path} is unknown; end the name in {', '.join(SUFFIXES)}")


def write_design(result: Result, path: Path) -> None:
    """Write the design in the format of the suffix; raises RecoveryError where there is none to write."""
    check_suffix(path)
    if not result.theorem.recover or not result.solution.status.usable:
        reason = f"is {result.solution.status.value}" if result.theorem.recover else "recovers nothing"
        raise RecoveryError(
            f"the theorem {reason}, so that there is no design to write; leave out -o", Place(result.theorem.name)
        )
    match path.suffix.lower():
        case ".npz":
            write_whole(path, _npz(_arrays(result)))
        case ".mat":
            write_whole(path, _mat(_arrays(result)))
        case _:
            write_whole(path, _tex(result))


def _arrays(result: Result) -> dict[str, Any]:
    points = vertex_points(result.problem.binding.domains)
    count = max((len(values) for values in points.values()), default=1)
    matrices = {
        name: np.broadcast_to(matrix, (count, *matrix.shape[-2:])) for name, matrix in result.design(**points).items()
    }
    return {
        **matrices,
        **{f"at_{name}": np.asarray(values, dtype=float) for name, values in points.items()},
        **{f"report_{name}": np.array(value) for name, value in result.reports.items()},
        **_words(result),
    }


def _words(result: Result) -> dict[str, str]:
    return {
        "theorem": result.theorem.name,
        "plant": result.problem.binding.plant.name,
        "soundness": result.problem.soundness.value,
        "status": result.solution.status.value,
    }


def _npz(arrays: Mapping[str, Any]) -> bytes:
    file = BytesIO()
    np.savez_compressed(file, allow_pickle=False, **{name: np.asarray(value) for name, value in arrays.items()})
    return file.getvalue()


def _mat(arrays: Mapping[str, Any]) -> bytes:
    file = BytesIO()
    turned = {
        name: np.moveaxis(value, 0, -1) if isinstance(value, np.ndarray) and value.ndim == 3 else value
        for name, value in arrays.items()
    }
    scipy.io.savemat(cast(Any, file), turned, do_compression=True)
    return file.getvalue()


def _tex(result: Result) -> str:
    notes = [f"% {name}: {value}" for name, value in _words(result).items()]
    notes += [f"% {name} = {value:.9g} (numerical)" for name, value in result.reports.items()]
    return "\n".join([*notes, numbers.design(result)]) + "\n"
