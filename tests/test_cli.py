"""The command line as a user meets it: every command, and every kind of bad input."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from click.testing import CliRunner, Result

from lmic.cli import main
from lmic.commands import terminal
from lmic.library import root

LMIC = Path(sys.executable).with_name("lmic")
EXAMPLE = str(root() / "peixoto2025" / "example1.toml")

THEOREM = '''"""Bounded-real lemma, discrete time."""

from lmic.dsl import *

nx, nw, nz = dims("nx nw nz")
alpha = Simplex("alpha", step="free")
A, B = Data("A", nx, nx)(alpha), Data("B", nx, nw)(alpha)
C, D = Data("C", nz, nx)(alpha), Data("D", nz, nw)(alpha)
P, G, mu = Symmetric("P", nx), Matrix("G", nx, nx)(alpha), Scalar("mu")

lemma = PD([
    [P(alpha), 0, A.T*G, C.T],
    [star, mu*I(nw), B.T*G, D.T],
    [star, star, He(G) - P(alpha.next), 0],
    [star, star, star, I(nz)],
])

theorem = Theorem(
    title="Bounded-real lemma",
    minimise=mu,
    lmis={"dissipation": lemma},
    reports={"gamma": sqrt(mu)},
    assumes=[Schur(A, because="the lemma implies stability")],
    variants={"robust": Variant("Bounded-real lemma, quadratic", constant=(P, G))},
    source=Source("nobody", "Notes", "unpublished", 2026),
)
'''

MATRICES: dict[str, Any] = {
    "A": [[[0.5, 0.2], [0, 0.4]], [[0.1, 0.5], [-0.3, 0.6]]],
    "B": [[1], [0.5]],
    "C": [[1, 0]],
    "D": [[0]],
}
#: static gain C (I - A)⁻¹ B at the first vertex, which bounds γ from below; the lemma reaches it
GAMMA = 7 / 3

PLANT = """name = "two modes"

[parameters.alpha]
simplex = 2

[matrices]
A = { vertices = [[[0.5, 0.2], [0, 0.4]], [[0.1, "1/2"], [-0.3, 0.6]]] }
B = [[1], [0.5]]
C = [[1, 0]]
D = [[0]]
"""


def lmic(*words: str) -> Result:
    return CliRunner().invoke(main, list(words))


def installed(*words: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONIOENCODING": "utf-8"}
    return subprocess.run([str(LMIC), *words], capture_output=True, text=True, check=False, env=environment)


def answer(*words: str) -> Any:
    """The JSON that a successful command prints."""
    result = lmic(*words, "--json")
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a user: a theorem and a plant of their own, and nothing else."""
    (tmp_path / "my_theorem.py").write_text(THEOREM, encoding="utf-8")
    (tmp_path / "plant.toml").write_text(PLANT, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def refused(folder: Path) -> Callable[..., None]:
    """Run a command that must fail in one line, name all of ``words``, and leave the folder as it is."""

    def run(command: Sequence[str], words: Sequence[str], code: int = 1) -> None:
        before = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
        result = lmic(*command)
        assert isinstance(result.exception, SystemExit), repr(result.exception)
        assert result.exit_code == code
        assert result.stdout == ""
        assert len(result.stderr.strip().splitlines()) == 1, result.stderr
        for word in words:
            assert word in result.stderr
        assert {path: path.stat().st_mtime_ns for path in folder.rglob("*")} == before

    return run


def edited(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new, 1)


# Commands -------------------------------------------------------------------------------------------


def test_list() -> None:
    records = answer("list")
    assert {"name", "title", "source"} <= records[0].keys()
    names = [record["name"] for record in records]
    assert {"peixoto2025.theorem1", "peixoto2025.corollary1"} <= set(names)
    shown = lmic("list")
    assert shown.exit_code == 0
    # a name broken over two lines cannot be copied
    assert [name for name in names if name not in shown.stdout] == []
    assert "None" not in shown.stdout


def test_show() -> None:
    record = answer("show", "peixoto2025.theorem1", "--plant", EXAMPLE, "--set", "eps=150")
    assert record["data"]["B_w"] == "nx x nw"
    assert record["compiled"]["dimensions"] == {"nx": 2, "nw": 1, "ny": 1, "nz": 2}
    assert record["compiled"]["scalar_unknowns"] == 97
    assert {lmi["lmi"]: lmi["count"] for lmi in record["compiled"]["lmis"]} == {"performance": 6, "P1": 2, "P2": 2}
    shown = lmic("show", "peixoto2025.theorem1", "--plant", EXAMPLE, "--set", "eps=150")
    for word in ("delta", "gamma = sqrt(delta)", "97 scalar unknowns", "10 LMIs", "sufficient"):
        assert word in shown.stdout


def test_show_for_given_sizes_without_a_plant() -> None:
    record = answer("show", "peixoto2025.theorem1", "--size", "nx=4", "--size", "nz=2", "--vertices", "3")
    assert record["compiled"]["dimensions"] == {"nx": 4, "nw": 1, "ny": 1, "nz": 2}
    assert record["unknowns"]["P1"]["scalars"] == 3 * 10


def test_latex(folder: Path) -> None:
    assert answer("latex", "peixoto2025.theorem1").keys() == {"performance", "P1", "P2"}
    shown = lmic("latex", "peixoto2025.theorem1")
    assert shown.exit_code == 0
    assert r"\star" in shown.stdout
    assert r"\begin{document}" not in shown.stdout
    assert lmic("latex", "./my_theorem.py", "--document", "-o", "page.tex").exit_code == 0
    assert r"\end{document}" in (folder / "page.tex").read_text(encoding="utf-8")


def test_a_variant_prints_its_constant_matrices_without_the_parameter() -> None:
    written = lmic("latex", "peixoto2025.corollary1").stdout
    assert r"A_{f}^{\top}(\alpha_k)" not in written
    assert r"H(\alpha_k)" not in written


def test_solve_by_name() -> None:
    command = ("solve", "peixoto2025.theorem1", "--plant", EXAMPLE, "--set", "eps=150")
    record = answer(*command)
    assert record["reports"]["gamma"] == pytest.approx(1.213769249, abs=1e-4)
    assert record["status"] == "solved"
    assert record["relative_violation"] == pytest.approx(0, abs=1e-9)
    assert np.shape(record["design"]["A_F"]) == (2, 2, 2)
    shown = lmic(*command).stdout
    for word in ("status", "violation", "gamma", "1.21376", "A_F"):
        assert word in shown


@pytest.mark.parametrize("theorem", ["./my_theorem.py", "my_theorem.py", "./my_theorem.py:robust"])
def test_solve_by_path(folder: Path, theorem: str) -> None:
    record = answer("solve", theorem, "--plant", "plant.toml")
    assert record["reports"]["gamma"] == pytest.approx(GAMMA, abs=1e-6)
    assert record["theorem"] == theorem.removeprefix("./").replace(".py", "")
    if theorem.endswith(":robust"):
        assert record["unknowns"]["P"].keys() == {"1"}


def test_solve_by_absolute_path_from_elsewhere(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir("/")
    record = answer("solve", str(folder / "my_theorem.py"), "--plant", str(folder / "plant.toml"))
    assert record["reports"]["gamma"] == pytest.approx(GAMMA, abs=1e-6)


def test_an_edited_theorem_is_read_again(folder: Path) -> None:
    command = ("latex", "my_theorem.py")
    assert lmic(*command).exit_code == 0
    (folder / "my_theorem.py").write_text(edited(THEOREM, '"dissipation": lemma', '"renamed": lemma'), encoding="utf-8")
    assert answer(*command).keys() == {"renamed"}


def test_solve_in_a_folder_whose_name_holds_py(folder: Path) -> None:
    (folder / "a.python").mkdir()
    (folder / "my_theorem.py").rename(folder / "a.python" / "my_theorem.py")
    record = answer("solve", "a.python/my_theorem.py:robust", "--plant", "plant.toml")
    assert record["reports"]["gamma"] == pytest.approx(GAMMA, abs=1e-6)


def write_json(path: Path) -> None:
    matrices = {**MATRICES, "A": {"vertices": MATRICES["A"]}}
    path.write_text(json.dumps({"parameters": {"alpha": {"simplex": 2}}, "matrices": matrices}), encoding="utf-8")


def write_npz(path: Path) -> None:
    np.savez(path, **{name: np.array(matrix, dtype=float) for name, matrix in MATRICES.items()})


def write_mat(path: Path) -> None:
    arrays = {name: np.array(matrix, dtype=float) for name, matrix in MATRICES.items()}
    scipy.io.savemat(path, {**arrays, "A": np.moveaxis(arrays["A"], 0, 2)})


@pytest.mark.parametrize(
    ("name", "write"), [("p.json", write_json), ("p.npz", write_npz), ("p.mat", write_mat)], ids=["json", "npz", "mat"]
)
def test_plant_formats(folder: Path, name: str, write: Callable[[Path], None]) -> None:
    write(folder / name)
    record = answer("solve", "my_theorem.py", "--plant", name)
    assert record["plant"] == "p"
    assert record["reports"]["gamma"] == pytest.approx(GAMMA, abs=1e-6)


@pytest.mark.parametrize(
    "options", [("--polya", "1"), ("--polya", "alpha=1"), ("--dependence", "P=2"), ("--dependence", "P=1; alpha1")]
)
def test_options_reach_the_problem(folder: Path, options: Sequence[str]) -> None:
    plain, chosen = (answer("show", "my_theorem.py", "--plant", "plant.toml", *more) for more in ((), options))
    assert plain != chosen


def test_one_vertex(folder: Path) -> None:
    one = edited(PLANT, "simplex = 2", "simplex = 1").replace(', [[0.1, "1/2"], [-0.3, 0.6]]', "")
    (folder / "plant.toml").write_text(one, encoding="utf-8")
    record = answer("solve", "my_theorem.py", "--plant", "plant.toml")
    assert record["reports"]["gamma"] == pytest.approx(GAMMA, abs=1e-6)
    assert record["soundness"] == "exact"


def test_export(folder: Path) -> None:
    command = ("export", "my_theorem.py", "--plant", "plant.toml", "-o", "out.dat-s")
    assert answer(*command) == {"file": "out.dat-s", "unknowns": 15, "lmis": 6, "soundness": "sufficient"}
    written = (folder / "out.dat-s").read_text(encoding="utf-8")
    assert [line for line in written.splitlines() if not line.startswith('"')][:2] == ["15", "6"]
    again = lmic(*command)
    assert again.stdout == "out.dat-s: 15 unknowns, 6 LMIs, soundness: sufficient\n"
    assert (folder / "out.dat-s").read_text(encoding="utf-8") == written


TABLE_1 = {
    "peixoto2025.table1.robust": (8.18, 8.171543751, "lmic better"),
    "peixoto2025.table1.parameter_dependent": (1.21, 1.213769249, "reproduced"),
}


def test_reproduce_as_json(folder: Path) -> None:
    records = {record["id"]: record for record in answer("reproduce", "peixoto2025.table1")}
    assert TABLE_1.keys() <= records.keys()
    for case, (paper, value, verdict) in TABLE_1.items():
        record = records[case]
        assert {"id", "paper", "value", "violation", "status", "verdict", "seconds"} <= record.keys()
        assert record["paper"] == paper
        assert record["value"] == pytest.approx(value, abs=1e-4)
        assert record["violation"] == pytest.approx(0, abs=1e-9)
        assert (record["status"], record["verdict"]) == ("solved", verdict)
        assert record["seconds"] > 0
        assert record["frozen_norm"] <= record["value"]
        assert record["achieved"] <= record["value"]


def test_reproduce_as_a_table(folder: Path) -> None:
    shown = lmic("reproduce", "peixoto2025.table1", "-o", "figures")
    assert shown.exit_code == 0, shown.output
    for word in ("Table 1", "1.21", "1.213769", "8.18", "8.171544", "reproduced", "lmic better"):
        assert word in shown.stdout
    assert {path.name for path in (folder / "figures").iterdir()} == {
        "index.html",
        "index.md",
        "peixoto2025.figure1.png",
        "peixoto2025.figure2.png",
    }


def test_one_case_of_a_table(folder: Path) -> None:
    assert [record["id"] for record in answer("reproduce", "peixoto2025.table1.robust")] == [
        "peixoto2025.table1.robust"
    ]


# Bad statements --------------------------------------------------------------------------------------

AT = "my_theorem / dissipation / block "
#: what is changed in the theorem file, and what the message names
STATEMENTS: dict[str, tuple[str, str, list[str]]] = {
    "product of two unknowns": ("A.T*G", "P(alpha)*G", ["NotAffineError", AT + "(1,3)", "P(alpha)*G(alpha)"]),
    "unsymmetric diagonal": ("[P(alpha), 0", "[G, 0", ["AsymmetryError", AT + "(1,1)", "G(alpha)", "He("]),
    "mirrored entries": ("star, He(G)", "G*B, He(G)", ["AsymmetryError", AT + "(2,3)", "block (3,2)", "star"]),
    "wrong block": ("C.T]", "C]", ["ShapeError", AT + "(1,4)", "nz x nx", "transpose"]),
    "wrong product": ("B.T*G", "B*G", ["ShapeError", AT + "(2,3)", "do not multiply"]),
    "inverse of an unknown": ("A.T*G", "A.T*inv(G)", ["NotAffineError", AT + "(1,3)", "inv(G(alpha))", "Schur"]),
    "nonlinear objective": ("minimise=mu", "minimise=mu**2", ["my_theorem", "mu**2", "not affine"]),
    "objective without a scalar": ("minimise=mu", 'minimise="mu"', ["my_theorem", "minimise", "mu"]),
    "matrix minimised": ("minimise=mu", "minimise=P", ["my_theorem", "minimise", "P"]),
    "list for PD": ("lemma = PD([", "lemma = ([", ["DefinitionError", "my_theorem", "dissipation", "PD"]),
    "no table of LMIs": ('{"dissipation": lemma}', "lemma", ["DefinitionError", "my_theorem", "lmis"]),
    "one name twice": ('Scalar("mu")', 'Scalar("P")', ["my_theorem", "P", "different names"]),
    "unknown without LMI": ("sqrt(mu)", 'sqrt(Scalar("nu"))', ["my_theorem", "nu"]),
    "no theorem": ("theorem = Theorem", "lemma1 = Theorem", ["DefinitionError", "my_theorem.py", "theorem = Theorem"]),
    "syntax": ("PD([", "PD(([", ["DefinitionError", "my_theorem.py, line 11"]),
    "unknown word": ("alpha = Simplex", "alpha = Simplx", ["my_theorem.py, line 6", "NameError", "Simplx"]),
    "unknown argument": ("minimise=mu", "minimize=mu", ["my_theorem.py, line 18", "minimize"]),
    "exit": ("nx, nw, nz =", "raise SystemExit\nnx, nw, nz =", ["my_theorem.py, line 5"]),
    "no step": (', step="free"', "", ["DomainError", "my_theorem", "alpha", "step"]),
}  # fmt: skip


@pytest.mark.parametrize(("old", "new", "words"), STATEMENTS.values(), ids=STATEMENTS)
def test_bad_statement(refused: Callable[..., None], folder: Path, old: str, new: str, words: list[str]) -> None:
    (folder / "my_theorem.py").write_text(edited(THEOREM, old, new), encoding="utf-8")
    refused(["solve", "./my_theorem.py", "--plant", "plant.toml"], words)


# Bad plants ------------------------------------------------------------------------------------------

#: what is changed in the plant file, and what the message names
PLANTS: dict[str, tuple[str, str, list[str]]] = {
    "wrong shape": ("D = [[0]]", "D = [[0, 0]]", ["ShapeError", "my_theorem", "D", "1 x 2", "nz x nw"]),
    "ragged": ("D = [[0]]", "D = [[0], [0, 1]]", ["PlantError", "plant.toml", "matrix D", "row 2"]),
    "missing": ("D = [[0]]", "", ["PlantError", "my_theorem", "D (nz x nw) is missing", "add it"]),
    "unknown": ("D = [[0]]", "D = [[0]]\nE = [[0]]", ["PlantError", "my_theorem", "the matrix E"]),
    "nan": ("D = [[0]]", "D = [[nan]]", ["PlantError", "plant.toml", "nan"]),
    "inf": ("D = [[0]]", "D = [[inf]]", ["PlantError", "plant.toml", "inf"]),
    "code": ("D = [[0]]", "D = [[\"__import__('os').getcwd()\"]]", ["plant.toml", "matrix D", "entry (1,1)", "import"]),
    "foreign name": ("D = [[0]]", 'D = [["beta"]]', ["plant.toml", "matrix D", "entry (1,1)", "beta"]),
    "vertices": ("simplex = 2", "simplex = 3", ["PlantError", "plant.toml", "matrix A", "2 vertices", "3"]),
    "no vertex": ("simplex = 2", "simplex = 0", ["plant.toml", "alpha", "0", "from 1"]),
    "other domain": ("simplex = 2", "box = {alpha1 = [0, 1]}", ["PlantError", "matrix A", "simplex"]),
    "other parameter": ("parameters.alpha", "parameters.beta", ["DomainError", "my_theorem", "alpha", "beta"]),
    "unstable": ("0.5, 0.2", "1.5, 0.2", ["PlantError", "my_theorem", "A(alpha)", "unstable", "1.5", "stabilise"]),
    "misspelt key": ("simplex = 2", "simplx = 2", ["PlantError", "plant.toml", "alpha"]),
    "broken TOML": ("D = [[0]]", "D = [[0]", ["PlantError", "plant.toml", "not valid TOML"]),
}


@pytest.mark.parametrize(("old", "new", "words"), PLANTS.values(), ids=PLANTS)
def test_bad_plant(refused: Callable[..., None], folder: Path, old: str, new: str, words: list[str]) -> None:
    (folder / "plant.toml").write_text(edited(PLANT, old, new), encoding="utf-8")
    refused(["solve", "my_theorem.py", "--plant", "plant.toml"], words)


@pytest.mark.parametrize("name", ["p.json", "p.npz", "p.mat", "p.toml"])
def test_file_of_another_kind(refused: Callable[..., None], folder: Path, name: str) -> None:
    (folder / name).write_bytes(b"\x00\xff garbage")
    refused(["solve", "my_theorem.py", "--plant", name], ["PlantError", name])


def test_nan_in_arrays(refused: Callable[..., None], folder: Path) -> None:
    arrays = {name: np.array(matrix, dtype=float) for name, matrix in MATRICES.items()}
    np.savez(folder / "p.npz", **{**arrays, "D": [[np.nan]]})
    refused(["solve", "my_theorem.py", "--plant", "p.npz"], ["PlantError", "p.npz", "matrix D", "finite"])


# Bad words -------------------------------------------------------------------------------------------

OWN = ("my_theorem.py", "--plant", "plant.toml")
PAPER = ("peixoto2025.theorem1", "--plant", EXAMPLE)
#: the words of the command, and what the message names
COMMANDS: dict[str, tuple[tuple[str, ...], list[str]]] = {
    "near name": (("solve", "peixoto2025.theorem", "--plant", EXAMPLE), ["LibraryError", "peixoto2025.theorem1"]),
    "no such name": (("latex", "zzz"), ["LibraryError", "zzz", "lmic list"]),
    "file without suffix": (("show", "my_theorem"), ["LibraryError", "my_theorem.py"]),
    "no such file": (("solve", "./other.py", "--plant", "plant.toml"), ["LibraryError", "other.py"]),
    "no such variant": (("show", "./my_theorem.py:tight"), ["LibraryError", "tight", "robust"]),
    "no such plant": (("solve", "my_theorem.py", "--plant", "no.toml"), ["PlantError", "no.toml"]),
    "plant of no kind": (("solve", "my_theorem.py", "--plant", "my_theorem.py"), ["PlantError", ".toml"]),
    "no such case": (("reproduce", "nobody"), ["LibraryError", "nobody", "peixoto2025"]),
    "near case": (("reproduce", "peixoto2025.tabel1"), ["LibraryError", "peixoto2025.table1 or"]),
    "near plant": (("show", "peixoto2025.theorem1", "--plant", "peixoto2025.exampel1"), ["PlantError", "library"]),
    "scalar missing": (("solve", *PAPER), ["peixoto2025.theorem1", "eps"]),
    "scalar unknown": (("solve", *OWN, "--set", "eps=1"), ["my_theorem", "eps"]),
    "scalar without value": (("solve", *PAPER, "--set", "eps"), ["--set eps", "NAME=VALUE"]),
    "scalar no number": (("solve", *PAPER, "--set", "eps=much"), ["eps", "much"]),
    "scalar nan": (("solve", *PAPER, "--set", "eps=nan"), ["eps", "nan"]),
    "scalar huge": (("solve", *PAPER, "--set", "eps=1e400"), ["eps", "1e400"]),
    "polya negative": (("solve", *OWN, "--polya", "-1"), ["--polya", "-1", "whole number"]),
    "polya no number": (("solve", *OWN, "--polya", "alpha=x"), ["--polya alpha", "'x'"]),
    "polya of nothing": (("solve", *OWN, "--polya", "beta=1"), ["beta", "alpha"]),
    "grid without name": (("solve", *OWN, "--grid", "5"), ["--grid 5", "NAME="]),
    "grid no number": (("solve", *OWN, "--grid", "alpha=x"), ["--grid", "'x'"]),
    "grid of thousands of digits": (("solve", *OWN, "--grid", f"alpha={'9' * 5000}"), ["--grid alpha", "999..."]),
    "polya of thousands of digits": (("solve", *OWN, "--polya", "9" * 5000), ["--polya", "whole number"]),
    "grid of no kind": (("solve", *OWN, "--grid", "alpha=hexagonal:3"), ["hexagonal"]),
    "grid of no point": (("solve", *OWN, "--grid", "alpha=0"), ["grid", "alpha"]),
    "size no number": (("show", *OWN, "--size", "nx=two"), ["--size nx", "two"]),
    "size of nothing": (("solve", *OWN, "--size", "ny=2"), ["ny", "nx"]),
    "size against the plant": (("solve", *OWN, "--size", "nx=3"), ["nx", "3", "2"]),
    "size zero": (("show", "my_theorem.py", "--size", "nx=0"), ["nx", "0"]),
    "relaxation of no kind": (("solve", *OWN, "--relax", "alpha=magic"), ["RelaxationError", "magic", "polya"]),
    "dependence of nothing": (("solve", *OWN, "--dependence", "Q=1"), ["BasisError", "Q", "P, G"]),
    "format": (("export", *OWN, "-o", "out.sdpa"), ["out.sdpa", ".dat-s"]),
    "output without folder": (("export", *OWN, "-o", "nowhere/out.dat-s"), ["nowhere", "cannot be written"]),
    "output is a folder": (("latex", "my_theorem.py", "-o", "."), ["cannot be written"]),
    "figures into a file": (("reproduce", "peixoto2025", "-o", "plant.toml"), ["plant.toml", "cannot be written"]),
}


@pytest.mark.parametrize(("command", "words"), COMMANDS.values(), ids=COMMANDS)
def test_bad_words(refused: Callable[..., None], command: Sequence[str], words: list[str]) -> None:
    refused(command, words)


def test_nothing_half_written(folder: Path) -> None:
    (folder / "out.dat-s").mkdir()
    assert lmic("export", *OWN, "-o", "out.dat-s").exit_code == 1
    assert {path.name for path in folder.iterdir()} == {"my_theorem.py", "plant.toml", "out.dat-s"}


def test_infeasible_is_an_answer_with_advice(folder: Path) -> None:
    unstable = edited(PLANT, "0.5, 0.2", "1.5, 0.2")
    (folder / "plant.toml").write_text(unstable, encoding="utf-8")
    (folder / "my_theorem.py").write_text(re.sub(r" *assumes=.*\n", "", THEOREM), encoding="utf-8")
    shown = lmic("solve", *OWN)
    assert isinstance(shown.exception, SystemExit)
    assert shown.exit_code == 1
    assert "infeasible" in shown.output
    assert "check the data" in shown.output
    assert "gamma" not in shown.output
    record = lmic("solve", *OWN, "--json")
    assert record.exit_code == 1
    answered = json.loads(record.stdout)
    assert answered["status"] == "infeasible"
    assert answered["reports"] == {}
    assert answered["objective"] is None


# As a process ----------------------------------------------------------------------------------------


def test_traceback_only_with_debug(folder: Path) -> None:
    command = ("solve", "./my_theorem.py", "--plant", "no.toml")
    plain, debugged = installed(*command), installed(*command, "--debug")
    assert plain.returncode == debugged.returncode == 1
    assert plain.stdout == ""
    assert len(plain.stderr.splitlines()) == 1
    assert "Traceback" in debugged.stderr
    assert "PlantError: no.toml" in debugged.stderr


def test_usage_names_what_is_missing(folder: Path) -> None:
    done = installed("solve", "./my_theorem.py")
    assert done.returncode == 2
    assert "--plant" in done.stderr
    assert "Traceback" not in done.stderr


def test_solve_as_a_process_leaves_no_trace(folder: Path) -> None:
    done = installed("solve", "./my_theorem.py", "--plant", "plant.toml", "--json")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert json.loads(done.stdout)["reports"]["gamma"] == pytest.approx(GAMMA, abs=1e-6)
    assert {path.name for path in folder.iterdir()} == {"my_theorem.py", "plant.toml"}


@pytest.mark.parametrize(
    ("step", "said"),
    [('step = "free"', ["alpha+: independent of the parameter now (no rate bound)"]), ("step = 0.1", []),
     ('step = "constant"', [])],
)  # fmt: skip
def test_only_what_nothing_bounds_is_called_independent(folder: Path, step: str, said: list[str]) -> None:
    (folder / "moving.toml").write_text(PLANT.replace("simplex = 2", f"simplex = 2\n{step}"), encoding="utf-8")
    shown = lmic("show", "./my_theorem.py", "--plant", "moving.toml")
    assert [line for line in shown.output.splitlines() if "independent of" in line] == said


@pytest.mark.parametrize(
    ("ties", "said"),
    [((), "r[a], r[b], r[c]"), (("--tie", "b=a"), "r[a], r[c]"), (("--tie", "b=a", "--tie", "c=a"), "")],
)
def test_copies_are_named_with_their_instances(ties: tuple[str, ...], said: str) -> None:
    shown = lmic("show", "wu2007.theorem3", "--plant", "wu2007.example", "--grid", "r=2", *ties)
    found = [line for line in shown.output.splitlines() if "independent of" in line]
    assert found == ([f"{said}: independent of one another"] if said else [])
    assert ("tied: [b] = [a]" in shown.output) == bool(ties)


def test_a_proof_for_tied_instances_says_so(folder: Path) -> None:
    """With α⁺ = α the claim is that of frozen parameters, however the LMIs are proven."""
    lmic("solve", "./my_theorem.py", "--plant", "plant.toml", "--tie", "+=", "--certify", "proof.json")
    proven = lmic("verify", "proof.json", "--theorem", "my_theorem.py")
    assert proven.exit_code == 0, proven.output
    assert "tied: [+] = [now]; the LMIs are imposed only where these are equal" in proven.output
    record = json.loads(lmic("verify", "proof.json", "--theorem", "my_theorem.py", "--json").output)
    assert record["ties"] == {"+": ""}


def test_what_is_printed_keeps_its_brackets(capsys: pytest.CaptureFixture[str]) -> None:
    """An instance, r[a], is no style of the terminal's."""
    shown = terminal.table("r[b]", title="at r[c]")
    shown.add_row("r[a] = 1")
    terminal.console().print(shown)
    terminal.console().print(terminal.warning("r[d] = 2"))
    printed = capsys.readouterr().out
    assert all(f"r[{instance}]" in printed for instance in "abcd")
