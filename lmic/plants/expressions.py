"""Scalar expressions of plant files and signals: a small language that is parsed, never run as code.

    numbers      12, 0.45 (exactly 9/20), 1e-3 (exactly 1/1000)
    names        the given symbols, and pi; Euler's number is exp(1), so that ``e`` stays free
    operators    + - * / and ** with an integer exponent, parentheses
    functions    sin cos tan exp log sqrt sinh cosh tanh abs
    cases        where(k >= 10, a, b) is a if the comparison (< <= > >=) holds, b otherwise

The limits below keep every text cheap: to parse, and to multiply out afterwards.
"""

from __future__ import annotations

import ast
import math
import re
import unicodedata
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import sympy as sp

from lmic.errors import ExpressionError

MAX_TEXT = 2000  # characters
MAX_NODES = 500  # operators, names, numbers and calls
MAX_DEPTH = 50  # operations inside one another, sums and products apart
MAX_CALLS = 3  # functions inside one another: sympy's time is exponential in this
MAX_DEGREE, MAX_TERMS = 50, 500  # of the expression multiplied out
MAX_ARGUMENT_DEGREE, MAX_ARGUMENT_TERMS = 5, 20  # of a function's argument multiplied out
MAX_DIGITS = 100  # characters of a literal
MAX_EXPONENT = 200  # of a literal, in powers of ten
MAX_BITS = 1024  # of a numerator or denominator, so that every number has a finite float
MAX_TOTAL_TERMS = 20_000  # multiplied out, of all expressions of one file together

FUNCTIONS: Mapping[str, Any] = {
    "sin": sp.sin,
    "cos": sp.cos,
    "tan": sp.tan,
    "exp": sp.exp,
    "log": sp.log,
    "sqrt": sp.sqrt,
    "sinh": sp.sinh,
    "cosh": sp.cosh,
    "tanh": sp.tanh,
    "abs": sp.Abs,
}
CONSTANTS: Mapping[str, sp.Expr] = {"pi": sp.pi}
#: what may not stand inside a function: sympy's rules for these pairs take any amount of time and memory
_BANNED_INSIDE: Mapping[Any, tuple[Any, str]] = {
    sp.exp: (sp.log, "a logarithm"),
    sp.sinh: (sp.Function, "a function"),
    sp.cosh: (sp.Function, "a function"),
    sp.tanh: (sp.Function, "a function"),
}
WHERE = "where"
RESERVED = frozenset({*FUNCTIONS, *CONSTANTS, WHERE})

#: for each comparison, the order of (left, right) and of (then, otherwise) in Where
_COMPARISONS: Mapping[type[ast.cmpop], tuple[int, int]] = {
    ast.GtE: (1, 1),
    ast.LtE: (-1, 1),
    ast.Lt: (1, -1),
    ast.Gt: (-1, -1),
}
_LITERAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e(?P<exponent>[+-]?\d+))?", re.ASCII | re.IGNORECASE)
_QUOTIENT = re.compile(rf"[+-]?\d{{1,{MAX_DIGITS}}}/0*[1-9]\d{{0,{MAX_DIGITS - 1}}}", re.ASCII)
_FOREIGN = re.compile(r"[^\w\s+\-*/().,<>=]")


class Budget:
    """What the expressions of one file may still cost: each pays for the terms that it is multiplied out to."""

    def __init__(self, terms: int = MAX_TOTAL_TERMS) -> None:
        self._total = self._left = terms

    def spend(self, terms: int, text: str) -> None:
        """Pay for the terms; raises ExpressionError, naming the text, where no more are left."""
        self._left -= terms
        if self._left < 0:
            raise ExpressionError(
                f"with {quoted(text)} the expressions of this file have more than {self._total} terms, all multiplied "
                "out together; lower their powers, or give fewer of them"
            )


class Where(sp.Function):
    """``Where(a, b, x, y)`` is x where a >= b, and y elsewhere.

    Unlike sympy's Piecewise it is not simplified, which can take sympy any amount of time.
    """

    nargs = 4

    @classmethod
    def eval(cls, left: sp.Expr, right: sp.Expr, then: sp.Expr, otherwise: sp.Expr) -> sp.Expr | None:
        """The value where the comparison is between constants that differ or agree for certain; else None."""
        difference = left - right
        if difference.is_number and difference.is_comparable:
            return then if difference >= 0 else otherwise
        return None

    def _sympystr(self, printer: Any) -> str:
        left, right, then, otherwise = map(printer.doprint, self.args)
        return f"{WHERE}({left} >= {right}, {then}, {otherwise})"

    def _numpycode(self, printer: Any) -> str:
        left, right, then, otherwise = map(printer.doprint, self.args)
        return f"{printer._module_format('numpy.where')}({left} >= {right}, {then}, {otherwise})"

    def _eval_derivative(self, symbol: sp.Symbol) -> sp.Expr:
        left, right, then, otherwise = self.args
        return Where(left, right, then.diff(symbol), otherwise.diff(symbol))

    def _eval_rewrite_as_Piecewise(
        self, left: sp.Expr, right: sp.Expr, then: sp.Expr, otherwise: sp.Expr, **_: Any
    ) -> sp.Expr:
        return sp.Piecewise((then, left >= right), (otherwise, True))


def parse(text: str, symbols: Mapping[str, sp.Symbol], budget: Budget | None = None) -> sp.Expr:
    """The expression that ``text`` states in the given symbols, with exact numbers.

    Raises ExpressionError, quoting the text and the offending part, if it is not one of the
    expressions above, passes a limit, leaves nothing of the ``budget`` that it shares with others, or
    holds a constant that is infinite, complex or undefined. Functions of symbols stay as written, and
    ``where`` becomes Where.
    """
    try:
        text = " ".join(text.split())
        tree = _syntax_tree(text)
        # Python normalises the names of a syntax tree in this way.
        known = {unicodedata.normalize("NFKC", name): symbol for name, symbol in symbols.items()}
        reader = _Reader(text, {**CONSTANTS, **known}, budget or Budget())
        expression = reader.read(tree)
        reader.expanded(expression, tree)
    except RecursionError:
        raise ExpressionError(f"{quoted(text)} nests its operations too deeply; write it flatter") from None
    return expression


def rational(text: str) -> Fraction:
    """The exact value of a text such as ``"0.45"``, ``"-1/3"`` or ``"2*(1 + 1/3)"``; else ExpressionError."""
    if (value := quotient(text)) is not None:
        return value
    expression = parse(text, {})
    if not expression.is_Rational:
        raise ExpressionError(f"{quoted(text)} is not a rational number; give one such as 0.5 or 1/3")
    return Fraction(int(expression.p), int(expression.q))


def quotient(text: str) -> Fraction | None:
    """The value of a text such as ``"-1/3"``, which needs no parser; None for any other text."""
    return Fraction(text.strip()) if _QUOTIENT.fullmatch(text.strip()) else None


def whole_number(text: str) -> int | None:
    """The value of a text such as ``"12"``, a count or a degree of at most nine digits; None for any other text."""
    return int(text) if text.strip().isdecimal() and len(text.strip()) < 10 else None


def decimal(text: str) -> Fraction:
    """The exact value of a literal: ``"-0.45"`` is -9/20, ``"1e-3"`` is 1/1000; else ExpressionError."""
    literal = _LITERAL.fullmatch(text) if len(text) <= MAX_DIGITS else None
    if literal is None or abs(int(literal["exponent"] or 0)) > MAX_EXPONENT:
        raise ExpressionError(
            f"{quoted(text)} is not a decimal number of at most {MAX_DIGITS} characters with an exponent within "
            f"{MAX_EXPONENT}; give a finite one such as 0.5 or 1e-3"
        )
    return Fraction(text)


def quoted(value: Any) -> str:
    """A short form of what the user wrote, for messages."""
    try:
        text = repr(value)
    except ValueError:  # Python prints no integer of more than 4300 digits
        text = "a number of thousands of digits"
    return text if len(text) <= 80 else f"{text[:50]}...{text[-20:]}"


def size(expression: sp.Expr) -> tuple[int, int]:
    """Bounds on the number of terms and on the degree once multiplied out; a function is one factor."""
    match expression:
        case sp.Add(args=parts) | sp.Mul(args=parts):
            terms, degrees = zip(*map(size, parts), strict=True)
            return (sum(terms), max(degrees)) if expression.is_Add else (math.prod(terms), sum(degrees))
        case sp.Pow(base=base, exp=exponent) if exponent.is_Rational:
            count, degree = size(base)
            times = math.ceil(abs(exponent))
            return math.comb(count + times - 1, times), degree * times
        case _:
            return 1, int(not expression.is_Rational)


def _syntax_tree(text: str) -> ast.expr:
    """Python's own syntax tree of the text, of limited size."""
    if len(text) > MAX_TEXT:
        raise ExpressionError(f"{quoted(text)} has {len(text)} characters; use at most {MAX_TEXT}")
    if foreign := _FOREIGN.search(text):
        advice = "write ** for a power" if foreign[0] == "^" else "use numbers, names, + - * / **, (), and functions"
        raise ExpressionError(f"{quoted(text)} has {foreign[0]!r} in it; {advice}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError, MemoryError) as error:
        reason = error.msg if isinstance(error, SyntaxError) else "it cannot be parsed"
        raise ExpressionError(f"{quoted(text)} is not an expression ({reason}); correct its syntax") from None
    for found, limit, what in (
        (sum(1 for node in ast.walk(tree) if isinstance(node, ast.expr)), MAX_NODES, "parts"),
        (_height(tree, _is_nesting), MAX_DEPTH, "operations inside one another"),
        (_height(tree, _is_function_call), MAX_CALLS, "functions inside one another"),
    ):
        if found > limit:
            raise ExpressionError(f"{quoted(text)} has {found} {what}; use at most {limit}")
    return tree


def _height(node: ast.AST, counts: Callable[[ast.AST], bool]) -> int:
    """The most nodes that count on any path down from this one."""
    below = 0
    for child in ast.iter_child_nodes(node):
        below = max(below, _height(child, counts))
    return below + counts(node)


def _is_nesting(node: ast.AST) -> bool:
    """Whether a node is more than a link of a long sum or product."""
    if isinstance(node, ast.BinOp):
        return not isinstance(node.op, (ast.Add, ast.Sub, ast.Mult))
    return isinstance(node, ast.expr)


def _is_function_call(node: ast.AST) -> bool:
    return isinstance(node, ast.Call) and not (isinstance(node.func, ast.Name) and node.func.id == WHERE)


@dataclass(frozen=True)
class _Reader:
    """Turns syntax into sympy, each node by its own rule; what has no rule is an error."""

    text: str
    known: Mapping[str, sp.Expr]
    budget: Budget

    def read(self, node: ast.expr) -> sp.Expr:
        match node:
            case ast.Constant(value=value) if type(value) in (int, float):
                # From the source, since the value is rounded.
                return sp.Rational(decimal(self._source(node)))
            case ast.Name(id=name) if name in self.known:
                return self.known[name]
            case ast.Name(id=name):
                raise self._error(node, f"is unknown here; use one of {quoted(', '.join(sorted(self.known)))}")
            case ast.UnaryOp(op=ast.UAdd(), operand=operand):
                return self.read(operand)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return -self.read(operand)
            case ast.BinOp(left=left, op=ast.Add(), right=right):
                return self.read(left) + self.read(right)
            case ast.BinOp(left=left, op=ast.Sub(), right=right):
                return self.read(left) - self.read(right)
            case ast.BinOp(left=left, op=ast.Mult(), right=right):
                return self._product(self.read(left), self.read(right))
            case ast.BinOp(left=left, op=ast.Div(), right=right):
                return self._product(self.read(left), self._reciprocal(self.read(right), right))
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                return self._power(left, right, node)
            case ast.Call(func=ast.Name(id="where"), args=[condition, then, otherwise], keywords=[]):
                return self._where(condition, then, otherwise)
            case ast.Call(func=ast.Name(id="where")):
                raise self._error(node, "needs a comparison and two values, as where(k >= 10, 1, 0)")
            case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in FUNCTIONS:
                return self._apply(FUNCTIONS[name], argument, node)
            case ast.Call(func=ast.Name(id=name)) if name in FUNCTIONS:
                raise self._error(node, f"does not have one argument; write {name}(...)")
            case ast.Call(func=function):
                raise self._error(function, f"is not a function here; use one of {', '.join(FUNCTIONS)}, {WHERE}")
            case ast.Compare():
                raise self._error(node, "is a comparison; write it as the condition of where(condition, a, b)")
        raise self._error(node, "is not permitted; use numbers, names, + - * / **, parentheses and functions")

    def bound(self, expression: sp.Expr, node: ast.expr, limits: tuple[int, int] = (MAX_TERMS, MAX_DEGREE)) -> None:
        """Refuse what would grow out of hand when multiplied out, and numbers without a finite float."""
        terms, degree = size(expression)
        if terms > limits[0] or degree > limits[1]:
            raise self._error(node, f"is too large multiplied out; keep to {limits[0]} terms and degree {limits[1]}")
        numbers = expression.atoms(sp.Rational)
        if any(max(abs(int(n.p)), int(n.q)).bit_length() > MAX_BITS for n in numbers):
            raise self._error(node, f"has a numerator or denominator of more than {MAX_BITS} bits; use shorter numbers")

    def expanded(self, expression: sp.Expr, node: ast.expr) -> sp.Expr:
        """The expression multiplied out, which shows constants in disguise such as (x + 1)**2 - x*(x + 2)."""
        self.bound(expression, node)
        self.budget.spend(size(expression)[0], self.text)
        expanded = sp.expand(expression)
        self.bound(expanded, node)
        if expanded.is_number and not _is_finite(expanded):
            raise self._error(node, "is not a finite real number; correct it")
        return expanded

    def _product(self, left: sp.Expr, right: sp.Expr) -> sp.Expr:
        # sympy would ask first whether the other factor is finite, which can take it any amount of time
        return sp.S.Zero if left == 0 or right == 0 else left * right

    def _reciprocal(self, divisor: sp.Expr, node: ast.expr) -> sp.Expr:
        expanded = self.expanded(divisor, node)
        # A number of which not one digit can be trusted, such as sin(1)**2 + cos(1)**2 - 1, is as bad as zero.
        if expanded == 0 or (expanded.is_number and not expanded.is_comparable):
            raise self._error(node, "is zero and divides; correct the divisor")
        return 1 / divisor

    def _power(self, base_node: ast.expr, exponent_node: ast.expr, node: ast.expr) -> sp.Expr:
        base, exponent = self.read(base_node), self.read(exponent_node)
        if not exponent.is_Integer or abs(exponent) > MAX_DEGREE:
            raise self._error(exponent_node, f"is not an integer of size at most {MAX_DEGREE}, as an exponent must be")
        power = base ** abs(exponent)
        self.bound(power, node)
        return power if exponent >= 0 else self._reciprocal(power, base_node)

    def _apply(self, function: Any, argument_node: ast.expr, node: ast.expr) -> sp.Expr:
        argument = self.expanded(self.read(argument_node), argument_node)
        self.bound(argument, argument_node, (MAX_ARGUMENT_TERMS, MAX_ARGUMENT_DEGREE))
        banned, what = _BANNED_INSIDE.get(function, (None, ""))
        if banned and argument.has(banned):
            raise self._error(node, f"has {what} inside {function.__name__}, which is not permitted; rewrite it")
        if not argument.is_number:
            # unevaluated, because sympy's rules for symbolic arguments can take it any amount of time;
            # expanded, because the logarithm of a product becomes a sum
            return sp.expand(function(argument, evaluate=False))
        value = function(argument)
        if not _is_finite(value):
            raise self._error(node, "is not a finite real number; correct the argument")
        return value

    def _where(self, condition: ast.expr, then: ast.expr, otherwise: ast.expr) -> sp.Expr:
        match condition:
            case ast.Compare(left=left, ops=[comparison], comparators=[right]) if type(comparison) in _COMPARISONS:
                sides, values = _COMPARISONS[type(comparison)]
            case _:
                raise self._error(condition, "is not one comparison by < <= > or >=; write one such as k >= 10")
        chosen = Where(
            *[self.expanded(self.read(node), node) for node in (left, right)[::sides]],
            *[self.expanded(self.read(node), node) for node in (then, otherwise)[::values]],
        )
        if chosen.func is Where and (chosen.args[0] - chosen.args[1]).is_number:
            raise self._error(condition, "compares two constants too close to tell apart; replace it by its outcome")
        return chosen

    def _error(self, node: ast.expr, cause: str) -> ExpressionError:
        part = self._source(node)
        place = "" if part == self.text else f"in {quoted(self.text)}, "
        return ExpressionError(f"{place}{quoted(part)} {cause}")

    def _source(self, node: ast.expr) -> str:
        return ast.get_source_segment(self.text, node) or self.text


def _is_finite(number: sp.Expr) -> bool:
    """Whether a constant is a real number of a float's range."""
    value = complex(number)
    return math.isfinite(value.real) and value.imag == 0
