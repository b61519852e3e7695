"""LaTeX: as the paper prints it, and it compiles."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from lmic import library
from lmic.dsl import PD, I, Scalar, dims, given
from lmic.typeset import latex


def test_prints_as_the_paper_does() -> None:
    text = latex.matrix(library.theorem("peixoto2025.theorem1").lmis["performance"])
    assert r"P_{1}(\alpha_{k+1}) - \operatorname{He}\{X_{1}(\alpha_k)\} & \star" in text
    assert r"-X_{2}(\alpha_k) - \epsilon H^{\top}(\alpha_k) + P_{3}^{\top}(\alpha_{k+1})" in text
    assert r"- \delta I_{n_{w}}" in text
    assert text.count(r"\star") == 15
    assert text.endswith(r"\prec 0")


def test_a_product_of_scalars_stands_without_parentheses() -> None:
    (n,), k, nu = dims("n"), given("k"), Scalar("nu", latex=r"\nu")
    shown = {
        2 * nu * I(n): r"2 \nu I_{n}",
        -k * nu * I(n): r"-k \nu I_{n}",
        (1 - k) * I(n): r"\left(1 - k\right) I_{n}",
    }
    for expression, text in shown.items():
        assert latex.matrix(PD(expression)) == rf"{text} \succ 0"


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
@pytest.mark.parametrize("name", library.names())
def test_every_theorem_compiles_with_pdflatex(name: str, tmp_path: Path) -> None:
    (tmp_path / "theorem.tex").write_text(latex.document(library.theorem(name)), encoding="utf-8")
    done = subprocess.run(
        ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "theorem.tex"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-2000:]
    assert (tmp_path / "theorem.pdf").stat().st_size > 1000
