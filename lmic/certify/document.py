"""Plants and numbers as the plain data of a certificate file, and back, without losing a digit."""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction
from math import floor, inf, isqrt, log10, nextafter
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from sympy.printing.str import StrPrinter

from lmic.algebra.polynomials import MatrixPolynomial
from lmic.errors import CertificateError, PlantError
from lmic.plants.domains import BoxDomain, Domain, Motion, SimplexDomain
from lmic.plants.expressions import quoted
from lmic.plants.files import plant_of_tables
from lmic.plants.plant import Plant

Array: TypeAlias = NDArray[Any]

#: m, m/n, a decimal, or m·2^k written mpk
_NUMBER = re.compile(
    r"(?P<head>-?\d{1,600})(?:/(?P<below>\d{1,600})|p(?P<power>-?\d{1,4})|\.(?P<after>\d{1,60}))?", re.A
)
_INTEGERS = re.compile(r"(-?\d{1,9}( -?\d{1,9})*)?", re.A)


class _Printer(StrPrinter):
    """Expressions as the plant language spells them."""

    def _print_Abs(self, expression: sp.Expr) -> str:
        return f"abs({self._print(expression.args[0])})"


def number_text(value: Fraction) -> str:
    """A dyadic fraction as m or mp-k (m·2⁻ᵏ), any other as m/n."""
    value = Fraction(value)
    below = value.denominator
    if below & (below - 1) == 0 and below > 2**10:
        return f"{value.numerator}p-{below.bit_length() - 1}"
    return str(value)


def number(text: Any) -> Fraction:
    """The fraction that a text states; raises CertificateError for any other text."""
    found = _NUMBER.fullmatch(text) if isinstance(text, str) else None
    if found is None or (found["below"] and int(found["below"]) == 0):
        raise CertificateError(f"{quoted(text)} is not an exact number; it was changed, or the file is no certificate")
    if found["power"]:
        return int(found["head"]) * Fraction(2) ** int(found["power"])
    return Fraction(text)


def decimal_above(value: Fraction, digits: int = 15) -> Fraction:
    """The least decimal with ``digits`` significant digits that is not below the value."""
    unit = _unit(value, digits)
    return -floor(-value / unit) * unit


def decimal_below(value: Fraction, digits: int = 15) -> Fraction:
    """The greatest decimal with ``digits`` significant digits that is not above the value."""
    unit = _unit(value, digits)
    return floor(value / unit) * unit


def root_above(value: Fraction, digits: int = 15) -> Fraction:
    """A decimal with about ``digits`` significant digits that is not below the root of the value."""
    unit = _unit(value, digits, 2)
    return (isqrt(floor(value / unit**2)) + 1) * unit


def root_below(value: Fraction, digits: int = 15) -> Fraction:
    """A decimal with about ``digits`` significant digits that is not above the root of the value."""
    unit = _unit(value, digits, 2)
    return isqrt(floor(value / unit**2)) * unit


def float_below(value: Fraction) -> float:
    """The greatest float that is not above the value."""
    nearest = float(value)
    return nearest if Fraction(nearest) <= value else nextafter(nearest, -inf)


def float_above(value: Fraction) -> float:
    """The least float that is not below the value."""
    return -float_below(-value)


def _unit(value: Fraction, digits: int, root: int = 1) -> Fraction:
    """One in the last of the significant digits of the value's root."""
    # of numerator and denominator by themselves, since a fraction may be beyond all floats
    size = floor((log10(abs(value.numerator)) - log10(value.denominator)) / root) if value else 0
    return Fraction(10) ** (size - digits + 1)


def decimal(value: Fraction) -> str:
    """The digits of a fraction that has finitely many."""
    places = 0
    while (value * 10**places).denominator != 1:
        places += 1
    digits = str(abs(int(value * 10**places))).rjust(places + 1, "0")
    sign = "-" if value < 0 else ""
    return sign + (f"{digits[:-places]}.{digits[-places:]}" if places else digits)


def matrix_text(matrix: Array) -> list[list[str]]:
    """Rows of number texts."""
    return [[number_text(entry) for entry in row] for row in matrix.tolist()]


def matrix(rows: Any) -> Array:
    """A matrix of fractions from rows of number texts."""
    if not (isinstance(rows, list) and rows and all(isinstance(row, list) and row for row in rows)):
        raise CertificateError(f"{quoted(rows)} is not a matrix")
    if len({len(row) for row in rows}) > 1:
        raise CertificateError("a matrix has rows of different lengths")
    values = np.array([number(entry) for row in rows for entry in row], dtype=object)
    return values.reshape(len(rows), len(rows[0]))


def upper_text(matrix: Array) -> list[list[str]]:
    """Rows of a symmetric matrix from the diagonal on."""
    return [[number_text(entry) for entry in row[i:]] for i, row in enumerate(matrix.tolist())]


def symmetric(rows: Any) -> Array:
    """A symmetric matrix of fractions from its rows from the diagonal on."""
    if not isinstance(rows, list) or any(
        not isinstance(row, list) or len(row) != len(rows) - i for i, row in enumerate(rows)
    ):
        raise CertificateError(f"{quoted(rows)} is not the upper half of a matrix")
    result = np.full((len(rows), len(rows)), Fraction(0), dtype=object)
    for i, row in enumerate(rows):
        for j, entry in enumerate(row, i):
            result[i, j] = result[j, i] = number(entry)
    return result


def integers_text(matrix: Array) -> list[str]:
    """Rows of integers, with blanks between them."""
    return [" ".join(map(str, row)) for row in matrix.tolist()]


def integers(rows: Any) -> Array:
    """A matrix of integers from such rows."""
    if not isinstance(rows, list) or not all(isinstance(row, str) and _INTEGERS.fullmatch(row) for row in rows):
        raise CertificateError(f"{quoted(rows)} is not a matrix of integers")
    found = [list(map(int, row.split())) for row in rows]
    if len(set(map(len, found))) != 1:
        raise CertificateError("a matrix has rows of different lengths")
    return np.array(found, dtype=object)


# Plants ---------------------------------------------------------------------------------------------


def plant_tables(plant: Plant) -> dict[str, Any]:
    """The plant as the tables of a plant file; raises where a plant file cannot state it."""
    tables = {
        "name": plant.name,
        "source": plant.source,
        "parameters": {name: _parameter(plant, name) for name in plant.domains},
        "scalars": {name: str(value) for name, value in plant.scalars.items()},
        "matrices": {
            name: dict(plant.exponentials[name]) if name in plant.exponentials else _matrix_texts(matrix)
            for name, matrix in plant.matrices.items()
        },
    }
    if not same_plant(read_plant_tables(tables), plant):
        raise CertificateError(f"{plant.name} cannot be written as a plant file; simplify its expressions")
    return tables


def read_plant_tables(tables: Any) -> Plant:
    """The plant of such tables."""
    try:
        return plant_of_tables(tables, "plant")
    except PlantError as error:
        raise CertificateError(f"the plant's data are damaged: {error}") from error


def same_plant(first: Plant, second: Plant) -> bool:
    """Whether two plants have equal data, whatever their names."""
    return (
        first.domains == second.domains
        and _motions(first) == _motions(second)
        and first.scalars == second.scalars
        and first.matrices.keys() == second.matrices.keys()
        and all(_same_matrix(first.matrices[name], second.matrices[name]) for name in first.matrices)
    )


def _same_matrix(first: MatrixPolynomial, second: MatrixPolynomial) -> bool:
    if first.shape != second.shape:
        return False
    difference = first + MatrixPolynomial(second.monomials, -second.coefficients)
    return not (difference.coefficients != 0).any()


def _motions(plant: Plant) -> Mapping[str, tuple[Any, Any]]:
    return {
        name: (_bounds(motion.step), _bounds(motion.rate))
        for name, motion in plant.motions.items()
        if motion != Motion()
    }


def _bounds(bounds: Any) -> Any:
    """Bounds with exact ends."""
    if not isinstance(bounds, Mapping):
        return bounds
    return {name: _ends(bound) for name, bound in bounds.items()}


def _ends(bound: Any) -> Any:
    return str(_exact(bound)) if np.ndim(bound) == 0 else [str(_exact(end)) for end in bound]


def _exact(value: Any) -> Fraction:
    return Fraction(repr(value)) if isinstance(value, float) else Fraction(value)


def _parameter(plant: Plant, name: str) -> dict[str, Any]:
    found = _domain(plant.domains[name])
    step, rate = _motions(plant).get(name, (None, None))
    return found | ({} if step is None else {"step": step}) | ({} if rate is None else {"rate": rate})


def _domain(domain: Domain) -> dict[str, Any]:
    match domain:
        case SimplexDomain():
            return {"simplex": len(domain.components)}
        case BoxDomain():
            sides = zip(domain.components, domain.lower, domain.upper, strict=True)
            return {"box": {name: [str(low), str(high)] for name, low, high in sides}}
    raise CertificateError(f"a plant file has no {domain.kind}; state the domain as a simplex or a box")


def _matrix_texts(matrix: MatrixPolynomial) -> list[list[str]]:
    printer = _Printer()
    return [[printer.doprint(entry) for entry in row] for row in matrix.to_sympy().tolist()]
