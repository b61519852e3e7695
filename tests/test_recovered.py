"""What is recovered leaves lmic: as systems of python-control, as arrays, as LaTeX; and statements as MathML."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import scipy.io
from click.testing import CliRunner

from lmic import library
from lmic.analysis.norms import h_infinity
from lmic.cli import main
from lmic.errors import FormatError, RecoveryError
from lmic.interchange.design import write_design
from lmic.pipeline import Result, compile, run
from lmic.plants.domains import vertex_points
from lmic.plants.plant import Plant
from lmic.plants.random import random_plant
from lmic.recover.recover import recover
from lmic.typeset import latex, mathml, numbers


@pytest.fixture(scope="module")
def filtered() -> Result:
    """The filter of Peixoto et al. for a plant of one state, in milliseconds."""
    plant = Plant.polytopic(A=[[[0.5]], [[0.3]]], B_w=[[1]], C_y=[[1]], D_y=[[1]], C_z=[[1]], D_z=[[0]])
    return run(compile(library.theorem("peixoto2025.theorem1"), plant, {"eps": 10}))


@pytest.fixture(scope="module")
def fed_back() -> Result:
    """A robust state feedback: one gain for both vertices."""
    plant = Plant.polytopic("rho", A=[[[1.2]], [[0.9]]], B=[[1]])
    return run(compile(library.theorem("standard.state_feedback_discrete_robust"), plant))


def test_state_space_at_each_frozen_parameter(filtered: Result) -> None:
    points = [[1, 0], [0.25, 0.75], [0, 1]]
    systems = filtered.design.state_spaces(alpha=points)
    assert [system.dt for system in systems] == [True] * 3
    for system, point in zip(systems, points, strict=True):
        arrays = filtered.design(alpha=point)
        for letter in "ABCD":
            assert np.allclose(getattr(system, letter), arrays[f"{letter}_F"], rtol=1e-12, atol=0)


def test_the_error_of_the_state_space_filter_keeps_the_bound(filtered: Result) -> None:
    """Plant and filter joined here, as x⁺ = A x + w, y = x + w, e = x − C_F x_F − D_F y: gain at most γ."""
    for a, (system,) in (
        (0.5, filtered.design.state_spaces(alpha=[1, 0])),
        (0.3, filtered.design.state_spaces(alpha=[0, 1])),
    ):
        A = np.block([[np.array([[a]]), np.zeros((1, 1))], [system.B, system.A]])
        B = np.vstack([[[1.0]], system.B])
        C, D = np.hstack([1 - system.D, -system.C]), -system.D
        assert h_infinity(A, B, C, D, discrete=True) <= filtered.reports["gamma"] * (1 + 1e-6)


def test_a_gain_is_a_static_system(fed_back: Result) -> None:
    (system,) = fed_back.design.state_spaces(rho=[0.5, 0.5])
    assert system.nstates == 0
    assert (fed_back.design(rho=[0.5, 0.5])["K"] == system.D).all()


def test_a_two_dimensional_filter_is_no_state_space() -> None:
    theorem = library.theorem("wu2007.theorem3")
    problem = compile(theorem, random_plant(theorem, {}, 2), {symbol.name: 1 for symbol in theorem.givens})
    design = recover(problem, np.random.default_rng(0).standard_normal(problem.size))
    names = ", ".join(theorem.recover)
    with pytest.raises(RecoveryError, match=f"recovers {names}, which is no system"):
        design.state_spaces(**vertex_points(problem.binding.domains))


# LaTeX --------------------------------------------------------------------------------------------------


def test_numbers() -> None:
    assert numbers.number(-0.0) == "0"
    assert numbers.number(1.23456789) == "1.2346"
    assert numbers.number(-3.1e-7, 2) == r"-3.1 \times 10^{-7}"
    assert numbers.number(float("inf")) == r"\infty"
    small = numbers.matrix(np.array([[1.0, 1e-9], [0.25, -2.0]]), digits=4)
    assert small == "\\left[\\begin{array}{rr}\n  1 & 0 \\\\\n  0.25 & -2\n\\end{array}\\right]"


def test_the_design_holds_its_numbers(filtered: Result) -> None:
    text = numbers.design(filtered)
    (value,) = filtered.design(alpha=[1, 0])["D_F"].ravel()
    assert r"D_{F} \big|_{\alpha = (1, 0)} &= \left[\begin{array}{r}" + f"\n  {numbers.number(value)}\n" in text
    assert text.count(r"\big|") == 8


def test_a_constant_gain_stands_once(fed_back: Result) -> None:
    text = numbers.design(fed_back)
    assert text.count("K &=") == 1
    assert r"\big|" not in text


def test_a_table_says_what_is_known(filtered: Result) -> None:
    text = numbers.table({"Theorem 1 & more": filtered})
    assert r" & $\gamma$ & proven & soundness & status \\" in text
    assert f"Theorem 1 \\& more & ${filtered.reports['gamma']:.6g}$ & -- & numerical, sufficient & solved" in text


def test_the_statement_is_one_align_with_labels() -> None:
    text = latex.theorem(library.theorem("peixoto2025.theorem1"))
    assert text.startswith("\\begin{align}\n&\\left[")
    assert re.findall(r"\\label\{([^}]*)\}", text) == [
        f"eq:peixoto2025.theorem1:{name}" for name in library.theorem("peixoto2025.theorem1").lmis
    ]


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
def test_pdflatex_compiles_statement_design_and_table(filtered: Result, tmp_path: Path) -> None:
    body = "\n\n".join(
        [
            latex.theorem(filtered.theorem),
            numbers.design(filtered),
            numbers.table({"100 % of a_b": filtered}),
            r"\eqref{eq:peixoto2025.theorem1:performance}",
        ]
    )
    # rules as plain lines where booktabs is not installed
    rules = r"\providecommand{\toprule}{\hline}\providecommand{\midrule}{\hline}\providecommand{\bottomrule}{\hline}"
    (tmp_path / "F.tex").write_text(
        "\\documentclass{article}\n\\usepackage{amsmath,amssymb}\n\\IfFileExists{booktabs.sty}{\\usepackage{booktabs}}{}\n"
        f"{rules}\n\\usepackage[paperwidth=60cm,paperheight=40cm,margin=1cm]{{geometry}}\n"
        f"\\begin{{document}}\n{body}\n\\end{{document}}\n",
        encoding="utf-8",
    )
    for _ in range(2):
        command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "F.tex"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout[-2000:]
    assert "undefined" not in done.stdout


@pytest.mark.parametrize("name", ["peixoto2025.theorem1", "wu2007.theorem1", "standard.h2_discrete"])
def test_mathml_is_well_formed_and_has_the_blocks(name: str) -> None:
    theorem = library.theorem(name)
    elements = [ElementTree.fromstring(text) for text in mathml.theorem(theorem).split("\n")]
    assert len(elements) == len(theorem.lmis)
    for element, lmi in zip(elements, theorem.lmis.values(), strict=True):
        space = "{http://www.w3.org/1998/Math/MathML}"
        table = element.find(f".//{space}mtable")
        cells = [] if table is None else table.findall(f"{space}mtr/{space}mtd")
        assert len(cells) == (len(lmi.rows) ** 2 if len(lmi.rows) > 1 else 0)


# Files --------------------------------------------------------------------------------------------------


def test_design_as_arrays(filtered: Result, tmp_path: Path) -> None:
    vertices = np.eye(2)
    expected = filtered.design(alpha=vertices)
    write_design(filtered, tmp_path / "F.npz")
    with np.load(tmp_path / "F.npz", allow_pickle=False) as arrays:
        assert all((arrays[name] == matrix).all() for name, matrix in expected.items())
        assert (arrays["at_alpha"] == vertices).all()
        assert arrays["report_gamma"] == filtered.reports["gamma"]
        assert arrays["soundness"] == "sufficient"
    write_design(filtered, tmp_path / "F.mat")
    arrays = scipy.io.loadmat(tmp_path / "F.mat")
    assert (np.moveaxis(arrays["A_F"].reshape(1, 1, 2), -1, 0) == expected["A_F"]).all()
    assert arrays["soundness"] == ["sufficient"]
    write_design(filtered, tmp_path / "F.tex")
    text = (tmp_path / "F.tex").read_text(encoding="utf-8")
    assert "% soundness: sufficient" in text
    assert numbers.design(filtered) in text
    with pytest.raises(FormatError, match=r"end the name in \.npz, \.mat, \.tex"):
        write_design(filtered, tmp_path / "F.docx")


def test_no_design_no_file(tmp_path: Path) -> None:
    lag = Plant.polytopic("rho", A=[[[0.5]], [[-0.5]]], B=[[1]], C=[[1]], D=[[0]])
    result = run(compile(library.theorem("standard.bounded_real_discrete"), lag))
    with pytest.raises(RecoveryError, match="recovers nothing"):
        write_design(result, tmp_path / "F.npz")
    with pytest.raises(RecoveryError, match="recovers nothing, which is no system"):
        result.design.state_spaces(rho=[1, 0])
    assert list(tmp_path.iterdir()) == []


def test_command_line(tmp_path: Path) -> None:
    (tmp_path / "plant.toml").write_text(
        "[parameters.rho]\nsimplex = 2\n[matrices]\nA = { vertices = [[[1.2]], [[0.9]]] }\nB = [[1]]\n"
    )
    command = ["solve", "standard.state_feedback_discrete", "--plant", str(tmp_path / "plant.toml"), "-o"]
    done = CliRunner().invoke(main, [*command, str(tmp_path / "K.mat")])
    assert done.exit_code == 0, done.output
    assert scipy.io.loadmat(tmp_path / "K.mat")["K"].size == 2
    done = CliRunner().invoke(main, [*command, str(tmp_path / "K.foo")])
    assert done.exit_code == 1
    assert done.output.startswith("FormatError: the format of")
    done = CliRunner().invoke(main, ["latex", "standard.h2_discrete", "--mathml"])
    assert done.output.startswith("<math")
