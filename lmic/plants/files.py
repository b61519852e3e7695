"""Plant files: TOML, JSON, NumPy .npz and MATLAB .mat. They are data and never run anything.

In text files a decimal is the rational it is written as (0.1 is 1/10); in .npz and .mat a float is
its exact dyadic value.
"""

from __future__ import annotations

import json
import tomllib
import zipfile
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

from lmic.domains import BoxDomain, Domain, Motion, SimplexDomain
from lmic.errors import DomainError, ExpressionError, PlantError
from lmic.plants.expressions import parse
from lmic.plants.plant import Plant, exact_number, vertex_polynomial
from lmic.polynomials import MatrixPolynomial

#: bytes that a plant file may have, unpacked
SIZE_LIMIT = 16 * 2**20

_TOP = {"name", "source", "parameters", "scalars", "matrices"}
_PARAMETER = {"simplex", "box", "step", "rate"}


def read_plant(path: Path | str) -> Plant:
    """The plant of a .toml, .json, .npz or .mat file; raises PlantError naming file, matrix and entry."""
    path = Path(path)
    readers = {".toml": _toml, ".json": _json, ".npz": _npz, ".mat": _mat}
    if path.suffix not in readers:
        raise PlantError(f"{path} is no plant file; its name must end in {', '.join(readers)}")
    try:
        if path.stat().st_size > SIZE_LIMIT:
            raise PlantError(f"{path} has more than {SIZE_LIMIT >> 20} MiB; a plant file holds a few matrices")
        return readers[path.suffix](path)
    except OSError as error:
        raise PlantError(f"{path} cannot be read: {error.strerror or error}; check the path") from error


# Text files ------------------------------------------------------------------------------------------


def _toml(path: Path) -> Plant:
    try:
        return plant_from_tables(tomllib.loads(_text(path), parse_float=Fraction), path)
    except (tomllib.TOMLDecodeError, ValueError, RecursionError) as error:
        raise PlantError(f"{path} is not valid TOML: {error}; correct it there") from error


def _json(path: Path) -> Plant:
    def refuse(word: str) -> None:
        raise ValueError(f"{word} is not a finite number")

    try:
        tables = json.loads(_text(path), parse_float=Fraction, parse_constant=refuse)
    except (json.JSONDecodeError, ValueError, RecursionError) as error:
        raise PlantError(f"{path} is not valid JSON: {error}; correct it there") from error
    if not isinstance(tables, dict):
        raise PlantError(f"{path} does not hold a JSON object; write {{'matrices': {{...}}}}")
    return plant_from_tables(tables, path)


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise PlantError(f"{path} is not a UTF-8 text file; save it as UTF-8") from error


def plant_from_tables(tables: Mapping[str, Any], path: Path) -> Plant:
    """A plant from the tables of a text file."""
    _only(tables, _TOP, f"{path}", "the file")
    matrices = _table(tables, "matrices", path)
    if not matrices:
        raise PlantError(f"{path} gives no matrix; add a table [matrices]")
    scalars = {
        name: _number(value, f"{path}: scalar {name}") for name, value in _table(tables, "scalars", path).items()
    }
    domains: dict[str, Domain] = {}
    motions: dict[str, Motion] = {}
    for name, entry in _table(tables, "parameters", path).items():
        where = f"{path}: parameter {name}"
        try:
            domains[name] = _domain(name, entry, where)
            motions[name] = _motion(entry, domains[name], where)
        except DomainError as error:
            raise DomainError(f"{where}: {error}") from error
    names = [c for domain in domains.values() for c in domain.components]
    twice = sorted({name for name in [*names, *scalars] if [*names, *scalars].count(name) > 1})
    if twice:
        raise PlantError(f"{path}: {twice[0]} names two things among components and scalars; rename one")
    symbols = {name: sp.Symbol(name) for name in [*names, *scalars]}
    read = {name: _matrix(value, symbols, domains, f"{path}: matrix {name}") for name, value in matrices.items()}
    return Plant(read, domains, motions, scalars, str(tables.get("name", path.stem)), str(tables.get("source", "")))


def _only(table: Mapping[str, Any], known: set[str], where: str, what: str) -> None:
    for key in table:
        if key not in known:
            raise PlantError(f"{where}: '{key}' means nothing in {what}; the keys are {', '.join(sorted(known))}")


def _table(tables: Mapping[str, Any], key: str, path: Path) -> Mapping[str, Any]:
    found = tables.get(key, {})
    if not isinstance(found, dict):
        raise PlantError(f"{path}: '{key}' is not a table; write [{key}]")
    return found


def _domain(name: str, entry: Any, where: str) -> Domain:
    if not isinstance(entry, dict) or ("simplex" in entry) == ("box" in entry):
        raise PlantError(f"{where} needs either simplex = N or box = {{...}}")
    _only(entry, _PARAMETER, where, "a parameter")
    if "simplex" in entry:
        count = entry["simplex"]
        if not isinstance(count, int) or isinstance(count, bool) or not 1 <= count <= 1000:
            raise DomainError(f"a simplex has a whole number of vertices from 1, not {count!r}")
        return SimplexDomain.named(name, count)
    box = entry["box"]
    if not isinstance(box, dict) or not all(isinstance(side, list) and len(side) == 2 for side in box.values()):
        raise DomainError("a box is written {rho1 = [-1, 1], rho2 = [0, 2]}")
    ends = {c: [_number(end, f"{where}, component {c}") for end in side] for c, side in box.items()}
    return BoxDomain(tuple(ends), tuple(e[0] for e in ends.values()), tuple(e[1] for e in ends.values()))


def _motion(entry: Mapping[str, Any], domain: Domain, where: str) -> Motion:
    step, rate = entry.get("step"), entry.get("rate")
    if isinstance(step, str) and step not in ("free", "constant"):
        raise DomainError(f"step = '{step}' is unknown; write 'free', 'constant' or bounds for each component")
    return Motion(
        step if step is None or isinstance(step, str) else _bounds(step, domain, f"{where}, step"),
        None if rate is None else _bounds(rate, domain, f"{where}, rate"),
    )


def _bounds(bounds: Any, domain: Domain, where: str) -> dict[str, Any]:
    """Bounds for each component: a number for all, or {rho1 = 0.1, rho2 = [-0.1, 0.3]}."""
    table = bounds if isinstance(bounds, dict) else dict.fromkeys(domain.components, bounds)
    unknown = sorted(set(table) - set(domain.components))
    if unknown:
        raise PlantError(f"{where}: {unknown[0]} is no component; they are {', '.join(domain.components)}")
    return {c: [_number(v, where) for v in b] if isinstance(b, list) else _number(b, where) for c, b in table.items()}


def _number(value: Any, where: str) -> Fraction:
    try:
        return exact_number(value)
    except PlantError as error:
        raise PlantError(f"{where}: {error}") from error


def _matrix(
    value: Any, symbols: Mapping[str, sp.Symbol], domains: Mapping[str, Domain], where: str
) -> MatrixPolynomial:
    """A constant matrix, a matrix of expressions, or {vertices = [...]}."""
    if not isinstance(value, dict):
        return MatrixPolynomial.from_sympy(_entries(value, symbols, where))
    _only(value, {"vertices", "parameter"}, where, "a matrix")
    simplexes = {name: domain for name, domain in domains.items() if domain.kind == "simplex"}
    name = value.get("parameter", next(iter(simplexes), None) if len(simplexes) == 1 else None)
    if name not in simplexes:
        known = ", ".join(simplexes) or "none; add [parameters.alpha] with simplex = N"
        raise PlantError(f"{where} has vertices of which simplex? Give parameter = one of: {known}")
    vertices = value.get("vertices")
    components = simplexes[name].components
    if not isinstance(vertices, list) or len(vertices) != len(components):
        count = len(vertices) if isinstance(vertices, list) else "no list of"
        raise PlantError(f"{where} has {count} vertices but {name} has {len(components)}; give one matrix for each")
    read = [_entries(v, symbols, f"{where}, vertex {k + 1}") for k, v in enumerate(vertices)]
    if len({matrix.shape for matrix in read}) > 1:
        raise PlantError(f"{where}: its vertices have different sizes; give them all the same")
    if all(matrix == read[0] for matrix in read):
        return MatrixPolynomial.from_sympy(read[0])
    return MatrixPolynomial.from_sympy(
        sum((sp.Symbol(c) * matrix for c, matrix in zip(components, read, strict=True)), sp.zeros(*read[0].shape))
    )


def _entries(rows: Any, symbols: Mapping[str, sp.Symbol], where: str) -> sp.Matrix:
    """A matrix of numbers and expressions."""
    if not isinstance(rows, list) or not rows or not all(isinstance(row, list) and row for row in rows):
        raise PlantError(f"{where} is not a list of rows; write [[1, 0], [0, 1]]")
    lengths = [len(row) for row in rows]
    if len(set(lengths)) > 1:
        odd = next(k for k, length in enumerate(lengths) if length != lengths[0])
        raise PlantError(f"{where}: row {odd + 1} has {lengths[odd]} entries but row 1 has {lengths[0]}; complete it")
    return sp.Matrix(
        [
            [_entry(e, symbols, f"{where}, entry ({i + 1},{j + 1})") for j, e in enumerate(row)]
            for i, row in enumerate(rows)
        ]
    )


def _entry(entry: Any, symbols: Mapping[str, sp.Symbol], where: str) -> sp.Expr:
    if isinstance(entry, str):
        try:
            return parse(entry, symbols)
        except ExpressionError as error:
            raise ExpressionError(f"{where}: {error}") from error
    value = _number(entry, where)
    return sp.Rational(value.numerator, value.denominator)


# Array files -----------------------------------------------------------------------------------------


def _npz(path: Path) -> Plant:
    """Arrays (r, c) are constant, (N, r, c) are the vertices of one simplex."""
    try:
        with zipfile.ZipFile(path) as archive:
            if sum(member.file_size for member in archive.infolist()) > SIZE_LIMIT:
                raise PlantError(
                    f"{path} unpacks to more than {SIZE_LIMIT >> 20} MiB; a plant file holds a few matrices"
                )
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except (zipfile.BadZipFile, ValueError, EOFError, KeyError, NotImplementedError, RuntimeError) as error:
        raise PlantError(f"{path} is not a readable .npz file of plain arrays: {error}") from error
    return _from_arrays(arrays, path, vertex_axis=0)


def _mat(path: Path) -> Plant:
    """Arrays (r, c) are constant, (r, c, N) as in MATLAB's A(:,:,i) are the vertices of one simplex."""
    import scipy.io

    try:
        arrays = scipy.io.loadmat(str(path))
    except NotImplementedError as error:
        raise PlantError(f"{path} is a version 7.3 file; save it in MATLAB with '-v7'") from error
    except Exception as error:  # a corrupt file raises almost anything in there
        raise PlantError(f"{path} is not a readable .mat file: {error}") from error
    return _from_arrays({k: v for k, v in arrays.items() if not k.startswith("__")}, path, vertex_axis=2)


def _from_arrays(arrays: Mapping[str, Any], path: Path, vertex_axis: int) -> Plant:
    """A plant from arrays; a text ``parameter`` names the simplex, "alpha" without it."""
    arrays = dict(arrays)
    parameter = str(np.asarray(arrays.pop("parameter", "alpha")).ravel()[0])
    if not parameter.isidentifier():
        raise PlantError(f"{path}: the parameter's name '{parameter}' is no name; use letters and digits")
    stacks = {name: _stack(array, vertex_axis, f"{path}: matrix {name}") for name, array in arrays.items()}
    if not stacks:
        raise PlantError(f"{path} holds no array; save the plant's matrices in it")
    counts = {name: len(stack) for name, stack in stacks.items() if np.ndim(arrays[name]) == 3}
    if len(set(counts.values())) > 1:
        raise PlantError(f"{path}: the numbers of vertices differ: {counts}; give every matrix the same number")
    domain = SimplexDomain.named(parameter, next(iter(counts.values()), 1))
    matrices = {
        name: vertex_polynomial(stack, domain) if name in counts else MatrixPolynomial.constant(stack[0])
        for name, stack in stacks.items()
    }
    return Plant(matrices, {parameter: domain}, name=path.stem)


def _stack(array: Any, vertex_axis: int, where: str) -> Any:
    """Exact fractions, shape (vertices or 1, rows, cols)."""
    array = np.asarray(array)
    if array.dtype.kind not in "iufb":
        raise PlantError(f"{where} holds {array.dtype} and not real numbers; save plain numeric arrays")
    if array.ndim not in (2, 3) or array.size == 0:
        raise PlantError(f"{where} has shape {array.shape}; give a matrix, or matrices stacked along one more axis")
    if not np.isfinite(array).all():
        raise PlantError(f"{where} has an entry that is NaN or infinite; replace it by a number")
    stack = array[None] if array.ndim == 2 else np.moveaxis(array, vertex_axis, 0)
    flat = [Fraction(entry) for entry in _python_numbers(stack)]
    return np.array(flat, dtype=object).reshape(stack.shape)


def _python_numbers(stack: Any) -> Sequence[Any]:
    return (stack.astype(float) if stack.dtype.kind == "f" else stack.astype(int)).ravel().tolist()
