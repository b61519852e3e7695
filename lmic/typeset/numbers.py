r"""LaTeX of numbers: a recovered filter as papers print it, and a table of results (needs amsmath and booktabs)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.certify.document import decimal, decimal_above, decimal_below
from lmic.plants.domains import vertex_points

if TYPE_CHECKING:
    from lmic.certify.certificate import Certificate
    from lmic.language.theorem import Theorem
    from lmic.pipeline import Result

Array: TypeAlias = NDArray[Any]

_SPECIAL = str.maketrans(
    {c: f"\\{c}" for c in "&%$#_{}"}
    | {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
)


def number(value: float, digits: int = 5) -> str:
    r"""A number with so many significant digits, as ``1.25`` or ``1.25 \times 10^{-7}``."""
    if not np.isfinite(value):
        return r"\mathrm{NaN}" if np.isnan(value) else (r"\infty" if value > 0 else r"-\infty")
    mantissa, _, exponent = f"{value + 0.0:.{digits}g}".partition("e")
    return rf"{mantissa} \times 10^{{{int(exponent)}}}" if exponent else mantissa


def matrix(values: Array, digits: int = 5) -> str:
    """A matrix of numbers; entries below the last digit of the largest one are zero."""
    values = np.atleast_2d(values)
    small = np.abs(values) < 10.0 ** (-digits) * np.abs(values).max(initial=0.0)
    shown = np.where(small, 0.0, values)
    rows = " \\\\\n".join("  " + " & ".join(number(float(value), digits) for value in row) for row in shown)
    return f"\\left[\\begin{{array}}{{{'r' * values.shape[1]}}}\n{rows}\n\\end{{array}}\\right]"


def design(result: Result, digits: int = 5) -> str:
    """The recovered matrices as an ``align*``: at the vertices of the parameters' domains, or once where constant."""
    lines = [f"{left} &= {right}" for left, right in equations(result, digits)]
    return "\\begin{align*}\n" + " \\\\\n".join(lines) + "\n\\end{align*}"


def equations(result: Result, digits: int = 5) -> list[tuple[str, str]]:
    """Both sides of an equation for each recovered matrix: at every vertex, or once where it is constant."""
    points = vertex_points(result.problem.binding.domains)
    found = []
    for name, matrices in result.design(**points).items():
        stack = matrices if matrices.ndim == 3 else matrices[None]
        symbol = sp.latex(sp.Symbol(name))
        if (stack == stack[0]).all():
            found.append((symbol, matrix(stack[0], digits)))
            continue
        for k, values in enumerate(stack):
            where = ", ".join(
                f"{sp.latex(sp.Symbol(parameter))} = ({', '.join(number(v, digits) for v in vertices[k])})"
                for parameter, vertices in points.items()
            )
            found.append((f"{symbol} \\big|_{{{where}}}", matrix(values, digits)))
    return found


def table(results: Mapping[str, Result], certificates: Mapping[str, Certificate] | None = None, digits: int = 6) -> str:
    """A ``tabular`` of results by their labels: what each reports, what is proven of it, and its soundness.

    ``certificates`` go by the same labels; a proven interval is rounded outwards.
    """
    certificates = certificates or {}
    reports = list(dict.fromkeys(name for result in results.values() for name in result.reports))
    head = ["", *(f"${sp.latex(sp.Symbol(name))}$" for name in reports), "proven", "soundness", "status"]
    rows = []
    for label, result in results.items():
        values = [f"${number(result.reports[name], digits)}$" if name in result.reports else "--" for name in reports]
        certificate = certificates.get(label)
        soundness = certificate.standing.value if certificate else f"numerical, {result.problem.soundness.value}"
        proven = _interval(certificate, result.theorem, digits) if certificate else "--"
        rows.append([text(label), *values, proven, text(soundness), text(result.solution.status.value)])
    body = " \\\\\n".join(" & ".join(row) for row in rows)
    columns = "l" + "r" * len(reports) + "lll"
    return (
        f"\\begin{{tabular}}{{{columns}}}\n\\toprule\n{' & '.join(head)} \\\\\n\\midrule\n{body} \\\\\n"
        "\\bottomrule\n\\end{tabular}"
    )


def text(plain: str) -> str:
    """A plain text with LaTeX's special characters escaped."""
    return plain.translate(_SPECIAL)


def _interval(certificate: Certificate, theorem: Theorem, digits: int) -> str:
    """The first report's enclosure."""
    lower, upper = next((certificate.ends(name, theorem) for name in theorem.reports), (None, None))
    ends = [
        r"-\infty" if lower is None else decimal(decimal_below(lower, digits)),
        r"\infty" if upper is None else decimal(decimal_above(upper, digits)),
    ]
    return f"$[{ends[0]},\\, {ends[1]}]$"
