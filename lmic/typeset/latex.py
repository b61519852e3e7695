r"""LaTeX of a theorem's block matrices, as the paper prints them: ``\star`` for mirrored blocks."""

from __future__ import annotations

from typing import Any

import sympy as sp

from lmic.language.lmi import LMI
from lmic.language.nodes import Node
from lmic.language.star import Star
from lmic.language.theorem import Theorem


def matrix(lmi: LMI) -> str:
    """The block matrix of one LMI with its sign, for a display environment (needs amsmath)."""
    sign = r"\succ 0" if lmi.sense > 0 else r"\prec 0"
    if len(lmi.rows) == 1:
        return f"{entry(lmi.rows[0][0])} {sign}"
    rows = " \\\\\n".join("  " + " & ".join(entry(block) for block in row) for row in lmi.rows)
    columns = "c" * len(lmi.rows)
    return f"\\left[\\begin{{array}}{{{columns}}}\n{rows}\n\\end{{array}}\\right] {sign}"


def entry(block: Any) -> str:
    """One block."""
    if isinstance(block, Star):
        return r"\star"
    text: str = sp.latex(block)
    return text


def statement_lmis(statement: Theorem) -> dict[str, LMI]:
    """The LMIs with constant unknowns written without their argument."""

    def written(block: Any) -> Any:
        if not isinstance(block, Node):
            return block
        constant = {leaf: leaf.declaration for leaf in block.leaves() if leaf.name in statement.constant}
        return block.replaced(constant)

    return {
        name: LMI(lmi.sense, tuple(tuple(map(written, row)) for row in lmi.rows))
        for name, lmi in statement.lmis.items()
    }


def notation(statement: Theorem) -> dict[str, str]:
    """How the paper writes each unknown, by its name."""
    scalars = {symbol.name: sp.latex(symbol) for symbol in statement.scalar_unknowns}
    return scalars | {name: sp.latex(leaf) for name, leaf in statement.unknowns.items()}


def theorem(statement: Theorem) -> str:
    """All LMIs of a theorem as one ``align``, each with its number and its label eq:THEOREM:LMI (needs amsmath)."""
    lines = [f"&{matrix(lmi)} \\label{{eq:{statement.name}:{name}}}" for name, lmi in statement_lmis(statement).items()]
    return "\\begin{align}\n" + " \\\\\n".join(lines) + "\n\\end{align}"


def document(statement: Theorem) -> str:
    """A complete document that pdflatex compiles, its page as large as its matrices."""
    bodies = "\n\n".join(f"$\\displaystyle {matrix(lmi)}$" for lmi in statement_lmis(statement).values())
    return (
        "\\documentclass{article}\n\\usepackage{amsmath,amssymb}\n"
        "\\usepackage[paperwidth=90cm,paperheight=25cm,margin=1cm]{geometry}\n"
        f"\\pagestyle{{empty}}\n\\begin{{document}}\n\\noindent\n{bodies}\n\\end{{document}}\n"
    )
