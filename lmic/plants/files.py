"""Plant files: TOML, JSON, NumPy .npz and MATLAB .mat. They are data: they run nothing and name no other file.

No key refers to a file (``source`` is a text that is shown), expressions are parsed by lmic's own rules, pickled
objects and MATLAB's function handles and objects are refused, and limits on bytes, depth, powers and terms keep time
and memory small whatever a file holds.

A text file (JSON has the same structure)::

    name = "Two-mass system"                        # optional, like source
    [parameters.alpha]
    simplex = 2                                     # two vertices; the components are alpha1, alpha2
    step = 0.1                                      # optional: bounds on the motion, "free" or "constant"
    [parameters.rho]
    box = { rho1 = [-1, 1], rho2 = [0, "1/3"] }
    rate = { rho1 = 2, rho2 = [-1, 0.5] }           # optional: bounds on the derivative
    [scalars]
    c = 10                                          # a default, which may be changed when solving
    [matrices]
    A = { vertices = [[[0.43, 0], [1, "c/2"]], [[0.1, 0.9], [0, 0.05]]] }
    B = [["1 + 0.5*rho1", "sin(rho2)"], [0, "c"]]   # expressions in components and scalars
    C = [[1, 0]]
    Phi = { exponential = "F", time = "h" }         # exp(h F), F constant
    Gamma = { exponential = "F", time = "h", input = "G" }     # the integral of exp(s F) G over s from 0 to h
    D = [[0, 0]]
    [fractional]                                    # optional: A, ..., D made affine in alpha by an uncertainty
    model = "nft"                                   # or "lft"
    system = [
        ["A",       "B",   "B_Delta"],
        ["C",       "D",   "D_Delta"],
        ["C_Delta", "D_z", "D_Delta_z"],
    ]
    delta = "Delta"

Vertices belong to the only simplex, or to the one that ``parameter = "alpha"`` beside them names;
their entries are numbers and expressions in the scalars. A decimal is the rational that it is
written as: 0.1 is 1/10.

``system`` names the matrices of the plant's equations (rows) and signals (columns), which are
polynomials in a simplex's components, the only simplex's or that of ``parameter``. The last row,
the last column and ``delta`` name what is made: in the example, and with x⁺ = A x + B w,

    x⁺ = A x + B w + B_Delta w_Δ,   y = C x + D w + D_Delta w_Δ,
    z_Δ = C_Delta x + D_z w + D_Delta_z w_Δ,   w_Δ = Delta z_Δ

equals the polynomial plant, and A, ..., D keep what does not pass through Delta: the part that is
constant (lft) or affine (nft). See lmic/plants/fractional.py.

An array file holds its matrices by name: two-dimensional ones are constant, three-dimensional ones
are vertices, which the first axis counts in .npz and the last, as in A(:,:,i), in .mat. The texts
``parameter`` ("alpha" if absent), ``name`` and ``source`` are optional. A float is the dyadic
rational that it stores: 0.1 is 3602879701896397/2**55.
"""

from __future__ import annotations

import json
import keyword
import os
import re
import tomllib
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from difflib import get_close_matches
from fractions import Fraction
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.algebra.functions import exponential
from lmic.algebra.polynomials import MatrixPolynomial
from lmic.errors import DomainError, LmicError, PlantError
from lmic.files import read_at_most
from lmic.index import plants
from lmic.plants.domains import BoxDomain, Domain, Motion, SimplexDomain
from lmic.plants.expressions import RESERVED, Budget, decimal, parse, quoted, quotient, size
from lmic.plants.fractional import FractionalForm, fractional_plant
from lmic.plants.matlab import read_arrays
from lmic.plants.plant import Plant, exact_number, vertex_polynomial

Array: TypeAlias = NDArray[Any]

MAX_BYTES = 4 * 2**20  # of a file, packed and unpacked
MAX_VERTICES = 1000  # of a simplex
MAX_COEFFICIENTS = 10**7  # of a matrix of expressions
ENTRY_TERMS = 5  # for which an entry of an exponential counts, a function of its own
MAX_DOTS = 32  # of a line of TOML, decimal points apart

_DECIMAL_POINT = re.compile(r"(?<![\w.])\d+\.\d")


def read_plant(path: str | os.PathLike[str]) -> Plant:
    """The plant that a .toml, .json, .npz or .mat file states, or one of the library's by its name.

    ``read_plant("peixoto2025.example1")`` needs no file of one's own. Raises PlantError, naming the file and the matrix
    and entry in it, for whatever is wrong.
    """
    file = plants().get(str(path), Path(path))
    with _at(str(path)):
        reader = _READERS.get(file.suffix.lower())
        if reader is None:
            raise PlantError(f"'{file.suffix}' is not the suffix of a plant file; {_meant(str(path))}")
        plant = reader(_content(file), file.stem)
        if not plant.matrices:
            raise PlantError("states no matrix; give at least one")
        return plant


def _meant(name: str) -> str:
    here: list[str] = []
    with suppress(OSError, ValueError):  # a name that no file can have
        here = [name + suffix for suffix in _READERS if Path(name + suffix).is_file()]
    if here:
        return f"did you mean {' or '.join(here)}?"
    near = get_close_matches(name, plants(), n=2)
    return f"did you mean the library's {' or '.join(near)}?" if near else f"use {', '.join(_READERS)}"


@contextmanager
def _at(place: str) -> Iterator[None]:
    """Names the place in every error about data that is raised inside."""
    try:
        yield
    except (PlantError, DomainError) as error:
        raise PlantError(f"{place}: {error}") from error


@contextmanager
def _readable(advice: str) -> Iterator[None]:
    """Turns whatever a library raises on damaged data, which is almost anything, into a PlantError."""
    try:
        yield
    except PlantError:
        raise
    except Exception as error:
        raise PlantError(f"cannot be read ({error}); {advice}") from error


def _content(file: Path) -> bytes:
    try:
        return read_at_most(file, MAX_BYTES)
    except LmicError as error:
        raise PlantError(str(error)) from error


def _refuse_size(size: int) -> None:
    if size > MAX_BYTES:
        raise PlantError(f"holds more than {MAX_BYTES >> 20} MiB of data; a plant file holds a few matrices")


# Text files ------------------------------------------------------------------------------------------


class Numeral(str):
    """A decimal number of a text file, as written."""

    __slots__ = ()


def _read_toml(content: bytes, stem: str) -> Plant:
    text = _text(content)
    for number, line in enumerate(text.split("\n"), 1):
        # tomllib's time and memory are quadratic in the number of parts of a dotted key
        if line.count(".") - len(_DECIMAL_POINT.findall(line)) > MAX_DOTS:
            raise PlantError(f"line {number} has more than {MAX_DOTS} dots beside decimal points; break it up")
    try:
        document = tomllib.loads(text, parse_float=Numeral)
    except (ValueError, RecursionError) as error:
        raise PlantError(f"is not valid TOML: {error}; correct it there") from error
    return plant_of_tables(document, stem)


def _read_json(content: bytes, stem: str) -> Plant:
    try:
        document = json.loads(
            _text(content), parse_float=Numeral, parse_constant=Numeral, object_pairs_hook=_object_without_repetition
        )
    except (ValueError, RecursionError) as error:
        raise PlantError(f"is not valid JSON: {error}; correct it there") from error
    return plant_of_tables(document, stem)


def _text(content: bytes) -> str:
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise PlantError(f"is not UTF-8 text (byte {error.start}); save it as UTF-8") from error


def _object_without_repetition(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        repeated, _ = Counter(key for key, _ in pairs).most_common(1)[0]
        raise ValueError(f"the key {quoted(repeated)} occurs twice in one object")
    return table


def plant_of_tables(document: Any, stem: str) -> Plant:
    """The plant that the tables of a text file state, called ``stem`` where they give no name."""
    document = _table(document, {"name", "source", "parameters", "scalars", "matrices", "fractional"})
    texts = {"name": document.get("name", stem), "source": document.get("source", "")}
    for key, text in texts.items():
        if type(text) is not str:
            raise PlantError(f"{key} is {quoted(text)}; give a text in quotation marks")
    domains: dict[str, Domain] = {}
    motions: dict[str, Motion] = {}
    for name, entry in _named(document, "parameters"):
        with _at(f"parameter {name}"):
            keys = _table(entry, {"simplex", "box", "step", "rate"})
            domains[name] = _domain(name, keys)
            motions[name] = _motion(keys, domains[name])
    scalars = {}
    for name, entry in _named(document, "scalars"):
        with _at(f"scalar {name}"):
            scalars[name] = _number(entry)
    plant = Plant({}, domains, motions, scalars, **texts)
    matrices: dict[str, MatrixPolynomial] = {}
    entries = dict(_named(document, "matrices"))
    budget = Budget()
    exponentials = {name for name, entry in entries.items() if isinstance(entry, dict) and "exponential" in entry}
    for name in sorted(entries, key=lambda name: name in exponentials):
        with _at(f"matrix {name}"):
            matrices[name] = (
                _exponential(entries[name], plant, matrices, budget)
                if name in exponentials
                else _matrix(entries[name], plant, budget)
            )
    plant = replace(plant, matrices=matrices, exponentials={name: entries[name] for name in sorted(exponentials)})
    if "fractional" not in document:
        return plant
    with _at("fractional"):
        return _fractional(document["fractional"], plant)


def _table(entry: Any, keys: set[str]) -> dict[str, Any]:
    if not isinstance(entry, dict):
        raise PlantError(f"{quoted(entry)} is not a table; give one with keys among {', '.join(sorted(keys))}")
    unknown = sorted(set(entry) - keys)
    if unknown:
        raise PlantError(f"the key {quoted(unknown[0])} means nothing here; the keys are {', '.join(sorted(keys))}")
    return entry


def _named(document: Mapping[str, Any], key: str) -> list[tuple[str, Any]]:
    """The items of a table whose keys are names."""
    table = document.get(key, {})
    if not isinstance(table, dict):
        raise PlantError(f"{key} is {quoted(table)}; give a table of names")
    return [(_name(name), entry) for name, entry in table.items()]


def _name(name: str) -> str:
    if not name.isidentifier() or keyword.iskeyword(name) or name in RESERVED:
        raise PlantError(f"{quoted(name)} cannot be a name; use letters, digits and _, and no reserved word")
    return name


def _domain(name: str, entry: Mapping[str, Any]) -> Domain:
    match entry.get("simplex"), entry.get("box"):
        case int(vertices), None if not isinstance(vertices, bool):
            return _new_simplex(name, vertices)
        case None, dict(sides):
            ends = []
            for component, side in sides.items():
                with _at(f"component {_name(component)}"):
                    ends.append(_interval(side))
            return BoxDomain(tuple(sides), tuple(low for low, _ in ends), tuple(high for _, high in ends))
    raise PlantError(f"has no domain; give either simplex = number of vertices or box = {{{name}1 = [-1, 1], ...}}")


def _new_simplex(name: str, vertices: int) -> SimplexDomain:
    if not 0 < vertices <= MAX_VERTICES:
        raise PlantError(f"has {quoted(vertices)} vertices; a simplex has from 1 to {MAX_VERTICES}")
    return SimplexDomain.named(name, vertices)


def _motion(entry: Mapping[str, Any], domain: Domain) -> Motion:
    step, rate = entry.get("step"), entry.get("rate")
    if step is not None and step not in ("free", "constant"):
        step = _bounds(step, domain, "step")
    return Motion(step, None if rate is None else _bounds(rate, domain, "rate"))


def _bounds(entry: Any, domain: Domain, what: str) -> dict[str, Any]:
    """Bounds by component: a number, or a pair (lowest, highest)."""
    bounds = entry if isinstance(entry, dict) else dict.fromkeys(domain.components, entry)
    if set(bounds) != set(domain.components):
        raise PlantError(f"{what} does not bound the components {', '.join(domain.components)}; bound these, no other")
    found: dict[str, Any] = {}
    for component, bound in bounds.items():
        with _at(f"{what} of {component}"):
            found[component] = _interval(bound) if isinstance(bound, list) else _number(bound)
    return found


def _interval(side: Any) -> tuple[Fraction, Fraction]:
    if not isinstance(side, list) or len(side) != 2:
        raise PlantError(f"{quoted(side)} is not an interval; write [lowest, highest]")
    return _number(side[0]), _number(side[1])


def _number(entry: Any) -> Fraction:
    return decimal(entry) if isinstance(entry, Numeral) else exact_number(entry)


def _matrix(entry: Any, plant: Plant, budget: Budget) -> MatrixPolynomial:
    """A matrix of numbers and expressions, or the vertices of one."""
    scalars = {name: sp.Symbol(name) for name in plant.scalars}
    if not isinstance(entry, dict):
        components = (name for domain in plant.domains.values() for name in domain.components)
        return _polynomial(_entries(entry, scalars | {name: sp.Symbol(name) for name in components}, budget))
    entry = _table(entry, {"vertices", "parameter"})
    domain = _simplex(entry.get("parameter"), plant.domains)
    given, count = entry.get("vertices"), len(domain.components)
    if not isinstance(given, list) or len(given) != count:
        number = len(given) if isinstance(given, list) else "no"
        raise PlantError(f"has {number} vertices where its parameter has {count}; give a list with a matrix for each")
    vertices = []
    for number, vertex in enumerate(given, 1):
        with _at(f"vertex {number}"):
            vertices.append(_entries(vertex, scalars, budget))
            if vertices[-1].shape != vertices[0].shape:
                sizes = f"{_shape(vertices[-1])} where vertex 1 is {_shape(vertices[0])}"
                raise PlantError(f"is {sizes}; make all vertices equally large")
    return _vertex_sum(np.array(vertices), domain)


def _exponential(entry: Any, plant: Plant, known: Mapping[str, MatrixPolynomial], budget: Budget) -> MatrixPolynomial:
    """exp(tA), or the integral of exp(sA) B over s from 0 to t: a block of exp(t [[A, B], [0, 0]])."""
    entry = _table(entry, {"exponential", "time", "input"})
    exponent = _constant(entry["exponential"], known)
    if exponent.shape[0] != exponent.shape[1]:
        raise PlantError(
            f"{quoted(entry['exponential'])} is {_shape(exponent)}; only a square matrix has an exponential"
        )
    order = exponent.shape[0]
    components = {name: sp.Symbol(name) for domain in plant.domains.values() for name in domain.components}
    if not isinstance(entry.get("time"), str):
        raise PlantError('has no time; add time = "h", the component that multiplies the exponent')
    time = parse(entry["time"], components, budget)
    if "input" not in entry:
        budget.spend(ENTRY_TERMS * order**2, "exponential")
        return _entries_of(exponential(sp.Matrix(exponent), time, order, slice(None)))
    right = _constant(entry["input"], known)
    if right.shape[0] != order:
        raise PlantError(
            f"{quoted(entry['input'])} has {right.shape[0]} rows where the exponent has {order}; correct one"
        )
    budget.spend(ENTRY_TERMS * order * right.shape[1], "exponential")
    augmented = sp.zeros(order + right.shape[1])
    augmented[:order, :order], augmented[:order, order:] = sp.Matrix(exponent), sp.Matrix(right)
    return _entries_of(exponential(augmented, time, order, slice(order, None)))


def _entries_of(matrix: sp.Matrix) -> MatrixPolynomial:
    """A matrix whose entries are all different functions, one coefficient matrix for each."""
    if len(matrix) ** 2 > MAX_COEFFICIENTS:
        raise PlantError(f"has more than {MAX_COEFFICIENTS} coefficients, entries squared; take a smaller exponent")
    return MatrixPolynomial.from_sympy(matrix)


def _constant(name: Any, known: Mapping[str, MatrixPolynomial]) -> Array:
    """A matrix of this plant that depends on nothing, by name."""
    if not isinstance(name, str) or name not in known:
        names = ", ".join(known) or "none yet"
        raise PlantError(f"{quoted(name)} is no matrix of this plant; name a constant one (there are: {names})")
    if known[name].monomials.atoms:
        raise PlantError(f"{quoted(name)} is not constant; an exponential is formed of constant matrices")
    return np.asarray(known[name].coefficients[0])


def _simplex(name: Any, domains: Mapping[str, Domain], what: str = "has vertices") -> SimplexDomain:
    """The simplex of that name, or the only one, for an entry that ``what`` describes."""
    simplexes = {key: domain for key, domain in domains.items() if isinstance(domain, SimplexDomain)}
    if name is None and len(simplexes) == 1:
        (domain,) = simplexes.values()
        return domain
    if not isinstance(name, str) or name not in simplexes:
        mend = f"add parameter = one of: {', '.join(simplexes)}" if simplexes else "state one under [parameters]"
        raise PlantError(f"{what} without a simplex; {mend}")
    return simplexes[name]


def _fractional(entry: Any, plant: Plant) -> Plant:
    """The plant's NFT or LFT model."""
    entry = _table(entry, {"model", "system", "delta", "parameter"})
    missing = sorted({"model", "system", "delta"} - set(entry))
    if missing:
        raise PlantError(f"the key {missing[0]} is missing; give model, system and delta")
    model, system, delta = entry["model"], entry["system"], entry["delta"]
    if not isinstance(system, list) or not all(isinstance(row, list) for row in system):
        raise PlantError(f"system is {quoted(system)}; give a list of rows of names of matrices")
    for name in (model, delta, *chain(*system)):
        if type(name) is not str:
            raise PlantError(f"{quoted(name)} is not a name; give texts in quotation marks")
    simplex = _simplex(entry.get("parameter"), plant.domains, "has polynomials")
    names = tuple(tuple(_name(name) for name in row) for row in system)
    return fractional_plant(plant, FractionalForm(model, names, _name(delta)), simplex)


def _entries(rows: Any, symbols: Mapping[str, sp.Symbol], budget: Budget) -> Array:
    """Fractions and expressions, shape (rows, cols)."""
    if not isinstance(rows, list) or not all(isinstance(row, list) for row in rows):
        raise PlantError(f"{quoted(rows)} is not a list of rows; write [[1, 0], [0, 1]]")
    if not rows or not rows[0]:
        raise PlantError("is empty; give at least one row with one entry")
    entries = np.empty((len(rows), len(rows[0])), dtype=object)
    for i, row in enumerate(rows):
        if len(row) != len(rows[0]):
            raise PlantError(
                f"row {i + 1} has {len(row)} entries where row 1 has {len(rows[0])}; make them equally long"
            )
        for j, entry in enumerate(row):
            with _at(f"entry ({i + 1},{j + 1})"):
                entries[i, j] = _entry(entry, symbols, budget)
    return entries


def _entry(entry: Any, symbols: Mapping[str, sp.Symbol], budget: Budget) -> Fraction | sp.Expr:
    if not isinstance(entry, str) or isinstance(entry, Numeral):
        return _number(entry)
    if (value := quotient(entry)) is not None:
        return value
    expression = parse(entry, symbols, budget)
    return Fraction(int(expression.p), int(expression.q)) if expression.is_Rational else expression


def _shape(matrix: Array) -> str:
    return " x ".join(map(str, matrix.shape))


def _polynomial(entries: Array) -> MatrixPolynomial:
    if all(isinstance(entry, Fraction) for entry in entries.flat):
        return MatrixPolynomial.constant(entries)
    matrix = sp.Matrix(entries)
    terms = sum(size(entry)[0] for entry in matrix)
    # every function and every reciprocal is an atom of its own, in which each term has a power
    atoms = len(set().union(*(entry.atoms(sp.Symbol, sp.Function, sp.Pow) for entry in matrix)))
    if terms * max(len(matrix), atoms) > MAX_COEFFICIENTS:
        raise PlantError(
            f"has more than {MAX_COEFFICIENTS} coefficients or powers, its terms times its entries or the functions in "
            "them; shorten its expressions"
        )
    return MatrixPolynomial.from_sympy(matrix)


def _vertex_sum(vertices: Array, domain: Domain) -> MatrixPolynomial:
    """Σ_i alpha_i · vertices[i], where entries may depend on scalars."""
    if all(isinstance(entry, Fraction) for entry in vertices.flat):
        return vertex_polynomial(vertices, domain)
    if (vertices == vertices[0]).all():
        return _polynomial(vertices[0])
    components = np.array([sp.Symbol(name) for name in domain.components])
    return _polynomial((components[:, None, None] * vertices).sum(axis=0))


# Array files -----------------------------------------------------------------------------------------


def _read_npz(content: bytes, stem: str) -> Plant:
    arrays = {}
    with _readable("write it by numpy.savez"), zipfile.ZipFile(BytesIO(content)) as archive:
        members = {member.filename.removesuffix(".npy"): member for member in archive.infolist()}
        _refuse_size(sum(member.file_size for member in members.values()))
        if len(members) < len(archive.infolist()):
            raise PlantError("holds two arrays of the same name; keep one")
        for name, member in members.items():
            if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
                raise PlantError(f"{quoted(name)} is packed in a foreign way; write the file by numpy.savez")
            with _at(quoted(name)), _readable("store a plain array of numbers"), archive.open(member) as stream:
                arrays[name] = np.lib.format.read_array(stream, allow_pickle=False)
    return _plant_of_arrays(arrays, stem)


def _read_mat(content: bytes, stem: str) -> Plant:
    with _readable("save it again with the option -v7"):
        arrays = read_arrays(content, MAX_BYTES)
    return _plant_of_arrays(
        {name: np.moveaxis(array, -1, 0) if array.ndim == 3 else array for name, array in arrays.items()}, stem
    )


def _plant_of_arrays(arrays: Mapping[str, Array], stem: str) -> Plant:
    """A plant from matrices and stacks of vertices, shape (vertices, rows, cols), and the optional texts."""
    texts = {"parameter": "alpha", "name": stem, "source": ""}
    stacks = {}
    for name, array in arrays.items():
        if name in texts and array.dtype.kind == "U" and array.size == 1:
            texts[name] = str(array.item())
        else:
            with _at(f"matrix {_name(name)}"):
                stacks[name] = _exact(array)
    counts = {name: len(stack) for name, stack in stacks.items() if stack.ndim == 3}
    if len(set(counts.values())) > 1:
        listed = ", ".join(f"{name} {count}" for name, count in counts.items())
        raise PlantError(f"has different numbers of vertices ({listed}); give every matrix the same number")
    parameter = texts.pop("parameter")
    domains = {}
    if counts:
        with _at(f"parameter {_name(parameter)}"):
            domains[parameter] = _new_simplex(parameter, next(iter(counts.values())))
    matrices = {
        name: vertex_polynomial(stack, domains[parameter]) if stack.ndim == 3 else MatrixPolynomial.constant(stack)
        for name, stack in stacks.items()
    }
    return Plant(matrices, domains, name=texts["name"], source=texts["source"])


def _exact(array: Array) -> Array:
    """The stored numbers as fractions."""
    if array.dtype.kind not in "iuf" or array.dtype.itemsize > np.dtype(float).itemsize:
        raise PlantError(f"has entries of type {array.dtype.name}; store real numbers in double precision")
    if array.ndim not in (2, 3) or array.size == 0:
        raise PlantError(f"has shape {array.shape}; give a matrix, or matrices stacked along a third axis")
    for place in np.argwhere(~np.isfinite(array))[:1]:
        *vertex, row, column = (int(index) + 1 for index in place)
        at_vertex = f"vertex {vertex[0]}, " if vertex else ""
        raise PlantError(f"{at_vertex}entry ({row},{column}) is not finite; replace it by a number")
    return np.array([Fraction(number) for number in array.ravel().tolist()], dtype=object).reshape(array.shape)


_READERS: Mapping[str, Callable[[bytes, str], Plant]] = {
    ".toml": _read_toml,
    ".json": _read_json,
    ".npz": _read_npz,
    ".mat": _read_mat,
}
