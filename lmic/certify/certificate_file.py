"""The file of a certificate: data only, exact, and read strictly."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from fractions import Fraction
from hashlib import sha256
from pathlib import Path
from typing import Any

import sympy as sp

from lmic.certify import document
from lmic.certify.certificate import Certificate, Lower, Unknown, Upper, with_advice
from lmic.certify.finite import Coefficient, Functional
from lmic.certify.infeasible import Infeasible
from lmic.certify.lower import Dual, Pivot
from lmic.errors import CertificateError, LmicError, PlantError
from lmic.files import read_at_most, write_whole
from lmic.plants.expressions import parse, quoted

FORMAT = "lmic certificate 2"
MAX_BYTES = 32 * 2**20
#: total degree of a functional on one axis that is still read
MAX_POWER = 200
#: the keys of dual matrices
_DUAL = ("dual", "faces", "pivots")


def write_certificate(certificate: Certificate, path: str | os.PathLike[str]) -> None:
    """Write the file."""
    write_whole(Path(path), text(certificate))


def read_certificate(path: str | os.PathLike[str]) -> Certificate:
    """The certificate in a file; raises CertificateError, naming the file, for anything else."""
    file = Path(path)
    try:
        content = read_at_most(file, MAX_BYTES)
    except LmicError as error:
        raise CertificateError(f"{file} {error}") from error
    try:
        return parsed(content)
    except CertificateError as error:
        raise CertificateError(f"{file}: {with_advice(str(error))}") from error


# Writing --------------------------------------------------------------------------------------------


def text(certificate: Certificate) -> str:
    """The file's text, with the sum that protects it against accidental changes."""
    tables = _tables(certificate)
    lines = [f"{json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}" for key, value in tables.items()]
    lines.append(f'"sha256": "{checksum(tables)}"')
    return "{\n" + ",\n".join(lines) + "\n}\n"


def checksum(tables: Mapping[str, Any]) -> str:
    """SHA-256 of the tables in canonical JSON."""
    canonical = json.dumps(tables, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return sha256(canonical.encode()).hexdigest()


def _tables(certificate: Certificate) -> dict[str, Any]:
    upper, lower, infeasible = certificate.upper, certificate.lower, certificate.infeasible
    return {
        "format": FORMAT,
        "theorem": certificate.theorem,
        "library_plant": certificate.library_plant,
        "standing": certificate.standing.value,
        "scalars": {name: str(value) for name, value in certificate.scalars.items()},
        "dimensions": dict(certificate.dimensions),
        "ties": dict(certificate.ties),
        "plant": document.plant_tables(certificate.plant),
        "solver": certificate.solver,
        "versions": dict(certificate.versions),
        "notes": list(certificate.notes),
        "upper": None if upper is None else {"reports": _reports(upper), "functionals": _functionals(upper)},
        "unknowns": [
            {
                "name": name,
                "basis": [str(function) for function in unknown.functions],
                "matrices": [document.matrix_text(matrix) for matrix in unknown.matrices],
            }
            for name, unknown in certificate.unknowns.items()
        ],
        "lower": None
        if lower is None
        else {
            "reports": _reports(lower),
            "radius": _radius(lower),
            "functionals": _functionals(lower),
            **_dual_tables(lower.dual),
        },
        "infeasible": None
        if infeasible is None
        else {
            "radius": _radius(infeasible),
            "margin": document.decimal(infeasible.margin),
            "functionals": _functionals(infeasible),
            **_dual_tables(infeasible.dual),
        },
    }


def _radius(bound: Lower | Infeasible) -> str | None:
    return None if bound.radius is None else document.decimal(bound.radius)


def _dual_tables(dual: Dual) -> dict[str, Any]:
    return {
        "dual": [document.upper_text(matrix) for matrix in dual.matrices],
        "faces": [None if face is None else document.integers_text(face) for face in dual.faces],
        "pivots": [[p.column, p.lmi, p.row, p.col] for p in dual.pivots],
    }


def _reports(bound: Upper | Lower) -> dict[str, str]:
    return {name: document.decimal(value) for name, value in bound.reports.items()}


def _functionals(bound: Upper | Lower | Infeasible) -> list[dict[str, Any]]:
    return [
        {
            "lmi": functional.lmi,
            "axes": [
                {
                    "symbols": [str(symbol) for symbol in axis.symbols],
                    "corners": [[document.number_text(value) for value in corner] for corner in axis.corners],
                    "powers": list(axis.powers),
                }
                for axis in functional.axes
            ],
        }
        for functional in bound.functionals
    ]


# Reading --------------------------------------------------------------------------------------------


def parsed(content: bytes) -> Certificate:
    """The certificate that the content of a file states; the cheapest checks come first."""
    if len(content) > MAX_BYTES:
        raise CertificateError(f"holds more than {MAX_BYTES >> 20} MiB, which no certificate does")
    try:
        tables = json.loads(
            content.decode("utf-8"),
            parse_float=_refused,
            parse_constant=_refused,
            object_pairs_hook=_without_repetition,
        )
    except (ValueError, RecursionError) as error:
        raise CertificateError(f"is not valid JSON ({error}); it was changed, or is no certificate") from error
    if not isinstance(tables, dict) or tables.get("format") != FORMAT:
        raise CertificateError(f"is not of the format '{FORMAT}'; write it anew with --certify")
    body = {key: value for key, value in tables.items() if key != "sha256"}
    if tables.get("sha256") != checksum(body):
        raise CertificateError("does not have the checksum that it states; it was changed after it was written")
    return certificate_of(body)


def certificate_of(tables: Mapping[str, Any]) -> Certificate:
    """The certificate of plain tables, each of the type it must have."""
    keys = {"format", "theorem", "library_plant", "standing", "scalars", "dimensions", "ties", "plant", "versions"}
    _keys(tables, keys | {"upper", "unknowns", "lower", "infeasible", "notes", "solver"})
    plant = document.read_plant_tables(tables["plant"])
    symbols = {name: sp.Symbol(name) for domain in plant.domains.values() for name in domain.components}
    upper, lower, infeasible = tables["upper"], tables["lower"], tables["infeasible"]
    unknowns = {}
    for entry in _list(tables["unknowns"]):
        _keys(entry, {"name", "basis", "matrices"})
        unknowns[_text(entry["name"])] = Unknown(
            tuple(_function(function, symbols) for function in _list(entry["basis"])),
            tuple(document.matrix(rows) for rows in _list(entry["matrices"])),
        )
    found = Certificate(
        theorem=_text(tables["theorem"]),
        plant=plant,
        library_plant=_text(tables["library_plant"]),
        scalars={name: document.number(value) for name, value in _table(tables["scalars"]).items()},
        dimensions={name: _integer(value) for name, value in _table(tables["dimensions"]).items()},
        ties={name: _text(value) for name, value in _table(tables["ties"]).items()},
        unknowns=unknowns,
        upper=None if upper is None else _upper(upper),
        lower=None if lower is None else _lower(lower),
        infeasible=None if infeasible is None else _infeasible(infeasible),
        notes=tuple(_text(note) for note in _list(tables["notes"])),
        solver=_text(tables["solver"]),
        versions={name: _text(value) for name, value in _table(tables["versions"]).items()},
    )
    if tables["standing"] != found.standing.value:
        raise CertificateError(f"calls itself {quoted(tables['standing'])} but states what is {found.standing.value}")
    return found


def _upper(entry: Any) -> Upper:
    _keys(entry, {"reports", "functionals"})
    return Upper(_read_reports(entry), _read_functionals(entry))


def _lower(entry: Any) -> Lower:
    _keys(entry, {"reports", "radius", "functionals", *_DUAL})
    return Lower(_read_reports(entry), _read_functionals(entry), _read_dual(entry), _read_radius(entry))


def _infeasible(entry: Any) -> Infeasible:
    _keys(entry, {"radius", "margin", "functionals", *_DUAL})
    margin = document.number(entry["margin"])
    return Infeasible(_read_functionals(entry), _read_dual(entry), _read_radius(entry), margin)


def _read_radius(entry: Mapping[str, Any]) -> Fraction | None:
    radius = None if entry["radius"] is None else document.number(entry["radius"])
    if radius is not None and radius <= 0:
        raise CertificateError(f"{quoted(entry['radius'])} is not a bound on the size of unknowns")
    return radius


def _read_dual(entry: Mapping[str, Any]) -> Dual:
    pivots = []
    for pivot in _list(entry["pivots"]):
        numbers = [_integer(value) for value in _list(pivot)]
        if len(numbers) != 4:
            raise CertificateError(f"{quoted(pivot)} is not a pivot, which has four numbers")
        pivots.append(Pivot(*numbers))
    matrices = tuple(document.symmetric(rows) for rows in _list(entry["dual"]))
    faces = tuple(None if rows is None else document.integers(rows) for rows in _list(entry["faces"]))
    fits = len(faces) == len(matrices) and all(
        face is None or face.shape[1] == len(matrix) for face, matrix in zip(faces, matrices, strict=False)
    )
    if not fits:
        raise CertificateError("the faces of the dual matrices do not fit them")
    return Dual(matrices, faces, tuple(pivots))


def _read_reports(entry: Mapping[str, Any]) -> dict[str, Fraction]:
    return {name: document.number(value) for name, value in _table(entry["reports"]).items()}


def _read_functionals(entry: Mapping[str, Any]) -> tuple[Functional, ...]:
    found = []
    for functional in _list(entry["functionals"]):
        _keys(functional, {"lmi", "axes"})
        found.append(Functional(_text(functional["lmi"]), tuple(map(_axis, _list(functional["axes"])))))
    return tuple(found)


def _axis(entry: Any) -> Coefficient:
    _keys(entry, {"symbols", "corners", "powers"})
    symbols = tuple(sp.Symbol(_text(name)) for name in _list(entry["symbols"]))
    corners = tuple(tuple(document.number(value) for value in _list(corner)) for corner in _list(entry["corners"]))
    powers = tuple(_integer(power) for power in _list(entry["powers"]))
    fits = symbols and corners and len(powers) == len(corners) and all(len(c) == len(symbols) for c in corners)
    if not fits or len(set(symbols)) < len(symbols) or sum(powers) > MAX_POWER:
        raise CertificateError("an axis has corners, powers and symbols that do not fit together")
    return Coefficient(symbols, corners, powers)


def _function(entry: Any, symbols: Mapping[str, sp.Symbol]) -> sp.Expr:
    try:
        return parse(_text(entry), symbols)
    except PlantError as error:
        raise CertificateError(f"a basis function is damaged: {error}") from error


def _keys(entry: Any, keys: set[str]) -> None:
    if set(_table(entry)) != keys:
        wrong = min(set(entry) ^ keys)
        raise CertificateError(f"the key {quoted(wrong)} is missing or does not belong there")


def _table(entry: Any) -> Mapping[str, Any]:
    if not isinstance(entry, dict):
        raise CertificateError(f"{quoted(entry)} stands where a table is needed")
    return entry


def _list(entry: Any) -> Sequence[Any]:
    if not isinstance(entry, list):
        raise CertificateError(f"{quoted(entry)} stands where a list is needed")
    return entry


def _text(entry: Any) -> str:
    if not isinstance(entry, str):
        raise CertificateError(f"{quoted(entry)} stands where a text is needed")
    return entry


def _integer(entry: Any) -> int:
    if type(entry) is not int or not 0 <= entry < 10**6:
        raise CertificateError(f"{quoted(entry)} stands where a number of things is needed")
    return entry


def _refused(literal: str) -> Any:
    raise ValueError(f"{literal} is not exact")


def _without_repetition(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        repeated, _ = Counter(key for key, _ in pairs).most_common(1)[0]
        raise ValueError(f"the key {quoted(repeated)} occurs twice in one object")
    return table
