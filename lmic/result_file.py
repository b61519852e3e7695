"""The file of a result: everything that decides it, so that pages are made of it without solving again.

JSON with the plant's data, the choices that it was compiled with, the unknowns' matrices for each basis function, what
was measured, and the certificate where one was made. Numbers are the shortest decimals of their doubles, so that what
is read is what was written, bit for bit. Of the theorem the file holds name and digest: reading compiles the theorem
as it is now, and refuses where that is no longer the one that was solved.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic import __version__, library
from lmic.certify import certificate_file, document
from lmic.certify.certificate import Certificate
from lmic.compiler.assemble import ConicProblem
from lmic.compiler.layout import UnknownLayout
from lmic.errors import LibraryError, LmicError, Place, ResultError
from lmic.files import read_at_most, write_whole
from lmic.fingerprint import digest, promises, statement
from lmic.language.theorem import Theorem
from lmic.pipeline import Result, compile, reports
from lmic.recover.recover import recover
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation
from lmic.solve.cone import Status
from lmic.solve.solution import ABSOLUTE, Pass, Solution

Array: TypeAlias = NDArray[Any]

FORMAT = "lmic result 1"
MAX_BYTES = 256 * 2**20
#: how far the objective may be from the stored one where another version or machine rounds differently, relative
ROUNDING = 1e-9


def write_result(
    result: Result,
    path: str | os.PathLike[str],
    certificate: Certificate | None = None,
    theorem: str = "",
) -> None:
    """Write the file; ``theorem`` is what it calls the theorem: its name, or the path of a file of one's own.

    Raises CertificateError for a plant that no plant file can state.
    """
    tables = _tables(result, certificate, theorem or result.theorem.name)
    lines = [f"{json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}" for key, value in tables.items()]
    lines.append(f'"sha256": "{digest(tables)}"')
    write_whole(Path(path), "{\n" + ",\n".join(lines) + "\n}\n")


def read_result(path: str | os.PathLike[str], theorem: Theorem | None = None) -> tuple[Result, Certificate | None]:
    """The result in a file, compiled anew and not solved, and the certificate that was made of it.

    ``theorem`` is the statement where it is not one of the library. The dual matrices and their face are not kept.
    Raises ResultError, naming the file, where it is damaged or its theorem is another by now.
    """
    file = Path(path)
    tables = _parsed(file)
    try:
        return _result(tables, theorem or library.shipped(tables["theorem"]))
    except (LibraryError, ResultError) as error:
        raise ResultError(f"{file}: {error}") from error
    except LmicError as error:
        raise ResultError(f"{file} does not compile any more: {error}") from error
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        raise ResultError(f"{file} lacks what a result holds ({error}); write it anew with lmic solve -o") from error


# Writing --------------------------------------------------------------------------------------------


def _tables(result: Result, certificate: Certificate | None, theorem: str) -> dict[str, Any]:
    problem, solution = result.problem, result.solution
    binding = problem.binding
    measured = {name: value for name, value in vars(solution).items() if name not in ("x", "dual", "on_face")}
    fixed = {shape for leaf in binding.theorem.data.values() for shape in leaf.shape}
    tables = {
        "format": FORMAT,
        "lmic": __version__,
        "theorem": theorem,
        "statement": _statement(binding.theorem),
        "plant": document.plant_tables(binding.plant),
        "scalars": {symbol.name: value for symbol, value in binding.values.items()},
        "dimensions": {symbol.name: size for symbol, size in binding.sizes.items() if symbol not in fixed},
        "basis": {name: [str(f) for f in binding.layout.unknowns[name].functions] for name in binding.theorem.unknowns},
        "relaxation": asdict(replace(problem.relaxation, grid=_grids(problem.relaxation))),
        "soundness": problem.soundness.value,
        "reports": dict(result.reports),
        "solution": measured | {"passes": [asdict(step) for step in solution.passes]},
        "unknowns": {name: unknown.matrices(solution.x).tolist() for name, unknown in binding.layout.unknowns.items()}
        if solution.status.usable
        else {},
        "seconds": result.seconds,
        "certificate": None if certificate is None else certificate_file.text(certificate),
    }
    return _plain(tables)


def _statement(theorem: Theorem) -> str:
    return digest([*statement(theorem), *promises(theorem)])


def _grids(relaxation: Relaxation) -> dict[str, Grid]:
    return {name: Grid.of(g) for name, g in relaxation.grid.items()}


def _plain(data: Any) -> Any:
    """Plain data; numbers that JSON does not have as texts."""
    match data:
        case Mapping():
            return {key: _plain(value) for key, value in data.items()}
        case list() | tuple():
            return [_plain(value) for value in data]
        case float() if not np.isfinite(data):
            return str(float(data))
        case np.generic():
            return _plain(data.item())
    return data


# Reading --------------------------------------------------------------------------------------------


def _parsed(file: Path) -> dict[str, Any]:
    """The tables of a file that nobody changed."""
    try:
        content = read_at_most(file, MAX_BYTES)
    except LmicError as error:
        raise ResultError(f"{file} {error}") from error
    try:
        tables = json.loads(content.decode("utf-8"))
        stated = tables.pop("sha256", None) if isinstance(tables, dict) else None
        intact = stated == digest(tables)
    except (ValueError, RecursionError) as error:
        raise ResultError(f"{file} is not valid JSON ({error}); give a file of lmic solve -o RESULT.json") from error
    kind = tables.get("format") if isinstance(tables, dict) else None
    if kind == certificate_file.FORMAT:
        raise ResultError(
            f"{file} is a certificate, which lmic verify proves; give a file of lmic solve -o RESULT.json"
        )
    if kind != FORMAT:
        raise ResultError(f"{file} is not of the format '{FORMAT}'; write it with lmic solve -o RESULT.json")
    if not intact:
        raise ResultError(f"{file} does not have the checksum that it states: it was changed or cut; solve again")
    found: dict[str, Any] = tables
    return found


def _result(tables: Mapping[str, Any], theorem: Theorem) -> tuple[Result, Certificate | None]:
    place = Place(theorem.name)
    if tables["statement"] != _statement(theorem):
        raise ResultError("the theorem has been changed since this was solved; solve again", place)
    chosen = tables["relaxation"]
    grids = {
        name: Grid(g["count"], g["kind"], g["seed"], tuple(map(tuple, g["points"])))
        for name, g in chosen["grid"].items()
    }
    problem = compile(
        theorem,
        document.read_plant_tables(tables["plant"]),
        tables["scalars"],
        tables["basis"],
        Relaxation(chosen["method"], chosen["polya"], grids, chosen["ties"]),
        tables["dimensions"],
    )
    solution = _solution(tables, problem)
    usable = solution.status.usable
    design = recover(problem, solution.x)
    found = Result(problem, solution, design, reports(design) if usable else {}, float(tables["seconds"]))
    value = float(problem.cost @ solution.x) + problem.constant
    if usable and not abs(value - solution.value) <= ROUNDING * max(abs(value), ABSOLUTE):
        raise ResultError(
            f"the objective is {value:.9g} at the stored unknowns where {solution.value:.9g} is stored: this version "
            f"compiles another problem than lmic {tables['lmic']} did; solve again",
            place,
        )
    if tables["certificate"] is None:
        return found, None
    certificate = certificate_file.parsed(tables["certificate"].encode())
    if certificate.theorem != theorem.name or not document.same_plant(certificate.plant, problem.binding.plant):
        raise ResultError("the certificate in it is of another theorem or plant; solve again", place)
    return found, certificate


def _solution(tables: Mapping[str, Any], problem: ConicProblem) -> Solution:
    stored = dict(tables["solution"])
    status = Status(stored.pop("status"))
    x = np.full(problem.size, np.nan)
    if status.usable:
        x = np.concatenate(
            [_coordinates(u, tables["unknowns"][name]) for name, u in problem.layout.unknowns.items()] or [np.zeros(0)]
        )
    steps = tuple(
        Pass(**{**step, **_floats(step, "value", "bound", "violation", "price")}) for step in stored["passes"]
    )
    stored |= _floats(stored, "value", "bound", "price", "violation", "relative_violation")
    stored |= {name: tuple(stored[name]) for name in ("warnings", "handovers")}
    return Solution(**{**stored, "status": status, "x": x, "dual": np.zeros(0), "passes": steps})


def _floats(entry: Mapping[str, Any], *names: str) -> dict[str, float]:
    return {name: float(entry[name]) for name in names}


def _coordinates(unknown: UnknownLayout, stored: Any) -> Array:
    """The columns of an unknown from its matrices, one for each basis function; they must be of its structure."""
    matrices = np.array(stored, dtype=float)
    if matrices.shape != (len(unknown.functions), *unknown.coordinate.shape):
        raise ResultError(f"the matrices of {unknown.name} do not have its size; solve again")
    free = unknown.coordinate >= 0
    found = np.zeros((len(matrices), unknown.count))
    found[:, unknown.coordinate[free]] = matrices[:, free]
    x = found.ravel()
    if not np.array_equal(replace(unknown, offset=0).matrices(x), matrices):
        raise ResultError(f"the matrices of {unknown.name} do not have its structure; solve again")
    return x
