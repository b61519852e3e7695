"""Functions of the parameters enclosed on a cell: a Taylor polynomial about its centre and a ball.

A function is carried through flint's power series with ball coefficients, at the centre for the
polynomial and over the whole cell for the remainder, so that the enclosure holds for certain.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import flint
import sympy as sp

from lmic.algebra.functions import ExponentialEntry
from lmic.errors import CertificateError
from lmic.plants.expressions import Where

#: a polynomial with ball coefficients, by exponents
Polynomial: TypeAlias = dict[tuple[int, ...], flint.arb]
Series: TypeAlias = flint.arb_series
Translation: TypeAlias = Callable[[sp.Expr, list[Series], int], Series]

#: degree of the Taylor polynomial of a function of one symbol; of several symbols it is linear
DEGREE = 4


@dataclass(frozen=True)
class Range:
    """Where each symbol lies: |symbol − centre| ≤ radius."""

    centres: Mapping[sp.Symbol, flint.fmpq]
    radii: Mapping[sp.Symbol, flint.fmpq]

    def ball(self, symbol: sp.Symbol) -> flint.arb:
        """A ball that holds the symbol's values."""
        return flint.arb(self.centres[symbol]) + self.offset(symbol)

    def offset(self, symbol: sp.Symbol) -> flint.arb:
        """A ball that holds symbol − centre."""
        return flint.arb(0, flint.arb(self.radii[symbol]).upper())


def enclosure(atom: sp.Expr, symbols: tuple[sp.Symbol, ...], where: Range) -> Polynomial:
    """A polynomial in the offsets of ``symbols`` from their centres, with ``atom`` inside everywhere on the cell.

    Its constant coefficient is not finite where nothing is known of the atom (a division by zero).
    """
    zero = (0,) * len(symbols)
    if atom in where.centres:
        return {zero: flint.arb(where.centres[atom]), _power(symbols, atom, 1): flint.arb(1)}
    inner = sorted(atom.free_symbols, key=str)
    if not inner:
        return {zero: _coefficients(atom, {}, 1)[0]}
    directions = {s: flint.arb_series([where.ball(s), where.offset(s)], DEGREE + 2) for s in inner}
    for terms in range(DEGREE + 1 if len(inner) == 1 else 2, -1, -1):
        *lower, remainder = _coefficients(atom, directions, terms + 1)
        # Taylor's theorem asks for a function that is smooth on the whole cell
        if not all(coefficient.is_finite() for coefficient in (*lower, remainder)):
            continue
        if terms == 0:
            return {zero: remainder}
        return _taylor(atom, symbols, inner, where, terms) | {zero: _value(atom, inner, where) + remainder}
    return {zero: flint.arb.nan()}


def value(atom: sp.Expr, point: Mapping[sp.Symbol, flint.fmpq]) -> flint.arb:
    """A ball that holds the atom's value at a point; not finite where it has none."""
    return _value(atom, sorted(atom.free_symbols, key=str), Range(point, {}))


def product(first: Polynomial, second: Polynomial) -> Polynomial:
    """The product of two polynomials."""
    result: Polynomial = {}
    for left, a in first.items():
        for right, b in second.items():
            powers = tuple(i + j for i, j in zip(left, right, strict=True))
            result[powers] = result[powers] + a * b if powers in result else a * b
    return result


def _taylor(
    atom: sp.Expr, symbols: tuple[sp.Symbol, ...], inner: list[sp.Symbol], where: Range, terms: int
) -> Polynomial:
    """The Taylor coefficients of degree 1 to ``terms`` - 1; for several symbols the gradient."""
    found: Polynomial = {}
    for symbol in inner:
        centres = {s: flint.arb_series([flint.arb(where.centres[s]), int(s == symbol)], terms) for s in inner}
        for degree, coefficient in enumerate(_coefficients(atom, centres, terms)[1:], 1):
            found[_power(symbols, symbol, degree)] = coefficient
    return found


def _value(atom: sp.Expr, inner: list[sp.Symbol], where: Range) -> flint.arb:
    return _coefficients(atom, {s: flint.arb_series([flint.arb(where.centres[s])], 1) for s in inner}, 1)[0]


def _power(symbols: tuple[sp.Symbol, ...], symbol: sp.Symbol, degree: int) -> tuple[int, ...]:
    return tuple(degree if s == symbol else 0 for s in symbols)


def _coefficients(atom: sp.Expr, values: Mapping[sp.Symbol, Series], length: int) -> list[flint.arb]:
    """The first coefficients of the atom's series; not finite where flint finds none."""
    try:
        series = _series(atom, values, length)
    except (ValueError, ZeroDivisionError):  # flint refuses to divide by a series that may begin with zero
        return [flint.arb.nan()] * length
    return [series[k] if k < series.prec else flint.arb.nan() for k in range(length)]


# From sympy to series -------------------------------------------------------------------------------


def _series(expression: sp.Expr, values: Mapping[sp.Symbol, Series], length: int) -> Series:
    """The series of an expression, its symbols replaced by theirs."""
    if expression in values:
        return flint.arb_series(values[expression], length)
    if expression.is_Rational:
        return _constant(flint.fmpq(int(expression.p), int(expression.q)), length)
    if expression.is_Float:  # the decimal that it is written as
        return _series(sp.Rational(repr(float(expression))), values, length)
    if isinstance(expression, ExponentialEntry):
        return _exponential(expression, _series(expression.time, values, length), length)
    translation = TRANSLATIONS.get(expression.func)
    if translation is None:
        raise CertificateError(
            f"{expression} has no ball arithmetic; state it with exp, log, sqrt, trigonometric or hyperbolic functions"
        )
    return translation(expression, [_series(argument, values, length) for argument in expression.args], length)


def _exponential(entry: ExponentialEntry, time: Series, length: int) -> Series:
    """An entry of exp(tM) = exp(t_0 M) Σ_k ((t − t_0) M)^k / k!, a sum that ends where the series does."""
    row, column = entry.place
    exponent = flint.arb_mat([[flint.arb(flint.fmpq(int(v.p), int(v.q))) for v in r] for r in entry.exponent.tolist()])
    power, matrix = _constant(1, length), (exponent * time[0]).exp()
    step = flint.arb_series([flint.arb(0), *(time[k] for k in range(1, length))], length)
    result = _constant(matrix[row, column], length)
    for k in range(1, length):
        power, matrix = power * step / k, matrix * exponent
        result += power * matrix[row, column]
    return result


def _constant(value: Any, length: int) -> Series:
    return flint.arb_series([flint.arb(value)], length)


def _unknown(length: int) -> Series:
    return flint.arb_series([flint.arb.nan()] * length, length)


def _sum(expression: sp.Expr, arguments: list[Series], length: int) -> Series:
    return sum(arguments[1:], arguments[0])


def _product(expression: sp.Expr, arguments: list[Series], length: int) -> Series:
    result = arguments[0]
    for argument in arguments[1:]:
        result = result * argument
    return result


def _raised(expression: sp.Expr, arguments: list[Series], length: int) -> Series:
    base, exponent = arguments[0], expression.exp
    if exponent.is_Integer:
        power = _constant(1, length)
        for _ in range(abs(int(exponent))):
            power = power * base
        return power if exponent >= 0 else _constant(1, length) / power
    if exponent == sp.S.Half:
        return base.sqrt()
    return (arguments[1] * base.log()).exp()


def _hyperbolic(expression: sp.Expr, arguments: list[Series], length: int) -> Series:
    grows, decays = arguments[0].exp(), (-arguments[0]).exp()
    if isinstance(expression, sp.sinh):
        return (grows - decays) / 2
    if isinstance(expression, sp.cosh):
        return (grows + decays) / 2
    return (grows - decays) / (grows + decays)


def _absolute(expression: sp.Expr, arguments: list[Series], length: int) -> Series:
    value = arguments[0][0]
    if value >= 0 or value <= 0:
        return arguments[0] if value >= 0 else -arguments[0]
    return _constant(abs(value), 1) if length == 1 else _unknown(length)


def _where(expression: sp.Expr, arguments: list[Series], length: int) -> Series:
    """The branch that holds on the whole cell; both together where the comparison changes on it."""
    left, right, then, otherwise = arguments
    difference = left[0] - right[0]
    if difference >= 0 or difference < 0:
        return then if difference >= 0 else otherwise
    return _constant(then[0].union(otherwise[0]), 1) if length == 1 else _unknown(length)


def _named(method: str) -> Translation:
    return lambda expression, arguments, length: getattr(arguments[0], method)()


#: how the series of an expression follows from its arguments', by the expression's class; a handler
#: gets the expression, the arguments' series and the number of coefficients wanted
TRANSLATIONS: dict[type, Translation] = {
    sp.Add: _sum,
    sp.Mul: _product,
    sp.Pow: _raised,
    sp.exp: _named("exp"),
    sp.log: _named("log"),
    sp.sin: _named("sin"),
    sp.cos: _named("cos"),
    sp.tan: _named("tan"),
    sp.sinh: _hyperbolic,
    sp.cosh: _hyperbolic,
    sp.tanh: _hyperbolic,
    sp.Abs: _absolute,
    Where: _where,
    sp.pi.func: lambda expression, arguments, length: _constant(flint.arb.pi(), length),
    sp.E.func: lambda expression, arguments, length: _constant(flint.arb.const_e(), length),
}
