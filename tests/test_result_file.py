"""The file of a result: what is read is what was written, without solving, or there is an error that says why."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import lmic
from lmic import library
from lmic.certify.certificate_file import text
from lmic.certify.certify import certify
from lmic.cli import main
from lmic.commands.output import check_output
from lmic.dsl import PD, Data, I, Source, Symmetric, Theorem, dims
from lmic.errors import FormatError, LmicError, ResultError
from lmic.fingerprint import digest
from lmic.pipeline import Result
from lmic.plants.domains import vertex_points
from lmic.plants.plant import Plant
from lmic.recover.recover import recover
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation
from lmic.solve.cone import Status
from lmic.solve.solution import Solution

MODES = {
    "A": [[[0.5, 0.2], [0, 0.4]], [[0.1, "1/2"], [-0.3, 0.6]]],
    "B": [[1], [0.5]],
    "C": [[1, 0]],
    "D": [[0]],
}
PLANT = """name = "two modes"
[parameters.rho]
simplex = 2
[matrices]
A = { vertices = [[[0.5, 0.2], [0, 0.4]], [[0.1, "1/2"], [-0.3, 0.6]]] }
B = [[1], [0.5]]
C = [[1, 0]]
D = [[0]]
"""
THEOREM = (library.root() / "standard" / "bounded_real_discrete.py").read_text("utf-8")


@pytest.fixture(scope="module")
def lemma() -> Result:
    """The bounded-real lemma on two modes."""
    plant = Plant.polytopic("rho", "two modes", **MODES)
    return lmic.run(lmic.compile(library.theorem("standard.bounded_real_discrete"), plant))


@pytest.fixture
def file(lemma: Result, tmp_path: Path) -> Path:
    lmic.write_result(lemma, tmp_path / "result.json")
    return tmp_path / "result.json"


@pytest.fixture
def unsolved(lemma: Result, chosen: Result, monkeypatch: pytest.MonkeyPatch) -> None:
    """From here on nothing may be solved."""
    monkeypatch.setattr("lmic.pipeline.solve", lambda *args, **kwargs: pytest.fail("something was solved"))


def same(read: Result, written: Result) -> None:
    assert read.solution.x.tobytes() == written.solution.x.tobytes()
    assert read.reports == written.reports
    left, right = (replace(one.solution, x=np.zeros(0), dual=np.zeros(0)) for one in (read, written))
    assert repr(left) == repr(right)
    assert (read.problem.columns != written.problem.columns).nnz == 0
    assert [f.label(k) for f, k in read.problem.blocks()] == [f.label(k) for f, k in written.problem.blocks()]
    points = vertex_points(written.problem.binding.domains)
    for name, matrix in written.design(**points).items():
        assert read.design(**points)[name].tobytes() == matrix.tobytes()


@pytest.mark.usefixtures("unsolved")
def test_what_is_read_is_what_was_written(lemma: Result, file: Path) -> None:
    read, certificate = lmic.read_result(file)
    same(read, lemma)
    assert certificate is None


@pytest.fixture(scope="module")
def chosen() -> Result:
    """A filter with every kind of choice: a scalar, bases, Pólya degrees, a grid."""
    plant = lmic.read_plant(library.root() / "peixoto2025" / "example1.toml")
    relaxation = Relaxation({"alpha": "grid"}, {"alpha+": 0}, {"alpha": Grid.at([[1, 0], [0.3, 0.7], [0, 1]])}, {})
    basis = {"P1": "constant", "H": ["1"], "X1": ["alpha1", "alpha2"]}
    return lmic.run(lmic.compile(library.theorem("peixoto2025.theorem1"), plant, {"eps": "1/3"}, basis, relaxation))


@pytest.mark.usefixtures("unsolved")
def test_every_choice_is_kept(chosen: Result, tmp_path: Path) -> None:
    lmic.write_result(chosen, tmp_path / "chosen.json")
    read, _ = lmic.read_result(tmp_path / "chosen.json")
    same(read, chosen)
    assert read.problem.relaxation == chosen.problem.relaxation


@pytest.mark.parametrize(
    ("name", "plant", "grid"),
    [("mustafa.theorem3", "mustafa/example1.toml", {"h": 4}), ("chen2006.theorem4", "chen2006/example1_lft.toml", {})],
)
def test_exponentials_and_fractions_of_a_plant_are_kept(
    name: str, plant: str, grid: dict[str, int], tmp_path: Path
) -> None:
    theorem = library.theorem(name)
    given = {symbol.name: 1 for symbol in theorem.givens}
    problem = lmic.compile(theorem, lmic.read_plant(library.root() / plant), given, relaxation=Relaxation(grid=grid))
    solution = replace(blank(), x=np.random.default_rng(1).standard_normal(problem.size))
    value = float(problem.cost @ solution.x) + problem.constant
    result = Result(problem, replace(solution, value=value), recover(problem, solution.x), {}, 0.0)
    lmic.write_result(result, tmp_path / "plant.json")
    read, _ = lmic.read_result(tmp_path / "plant.json")
    assert read.solution.x.tobytes() == solution.x.tobytes()
    assert (read.problem.columns != problem.columns).nnz == 0


def blank() -> Solution:
    """An answer of which nothing is said."""
    zero = np.zeros(0)
    return Solution(Status.SOLVED, zero, 0.0, 0.0, 0.0, 0.0, 0.0, "", zero, 0, "none", (), ())


def test_a_dimension_that_no_matrix_fixes_is_kept(tmp_path: Path) -> None:
    n, m = dims("n m")
    A, P, X = Data("A", n, n), Symmetric("P", n), Symmetric("X", m)
    statement = Theorem({"P": PD(P - A.T * P * A - I(n)), "X": PD(X - I(m))}, Source("A", "T", "V", 1996), name="sized")
    result = lmic.run(lmic.compile(statement, Plant.polytopic(A=[[0.5]]), sizes={"m": 3}))
    lmic.write_result(result, tmp_path / "sized.json")
    read, _ = lmic.read_result(tmp_path / "sized.json", statement)
    same(read, result)


def test_the_certificate_comes_along(lemma: Result, tmp_path: Path) -> None:
    certificate = certify(lemma)
    lmic.write_result(lemma, tmp_path / "certified.json", certificate)
    _, read = lmic.read_result(tmp_path / "certified.json")
    assert read is not None
    assert text(read) == text(certificate)
    page = lmic.report(*lmic.read_result(tmp_path / "certified.json"))
    assert "certified" in page
    assert "∈ [2.33333" in page


# What is refused ------------------------------------------------------------------------------------


def changed(file: Path, change: Callable[[dict[str, Any]], None]) -> None:
    """The file changed by someone who knows how to mend its checksum."""
    tables = json.loads(file.read_text("utf-8"))
    del tables["sha256"]
    change(tables)
    file.write_text(json.dumps(tables | {"sha256": digest(tables)}), "utf-8")


def test_a_file_that_was_changed_is_refused(file: Path) -> None:
    text = file.read_text("utf-8")
    for damaged, said in (
        (text.replace("0.5", "0.6", 1), "checksum"),
        (text[:-40], "not valid JSON"),
        ("[1, 2]", "not of the format"),
        ('{"format": "lmic certificate 2"}', "is a certificate, which lmic verify proves"),
        ("[" * 100_000, "not valid JSON"),
    ):
        file.write_text(damaged, "utf-8")
        with pytest.raises(ResultError, match=said) as refused:
            lmic.read_result(file)
        assert str(refused.value).startswith(str(file))
    file.write_bytes(b"\xff\xfe")
    with pytest.raises(ResultError, match="not valid JSON"):
        lmic.read_result(file)
    with pytest.raises(ResultError, match="cannot be read"):
        lmic.read_result(file.with_name("absent.json"))


def _unsymmetric(tables: dict[str, Any]) -> None:
    tables["unknowns"]["P"][0][0][1] += 1.0


def _other_plant(tables: dict[str, Any]) -> None:
    tables["plant"]["matrices"]["B"] = [["1"]]


def _worse(tables: dict[str, Any]) -> None:
    tables["unknowns"]["gamma"][0][0][0] += 1e-3


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (_unsymmetric, "structure"),
        (_other_plant, "does not compile any more"),
        (_worse, "the objective is"),
        (lambda t: t["unknowns"]["P"].pop(), "size"),
        (lambda t: t["unknowns"].pop("P"), "lacks what a result holds"),
        (lambda t: t.pop("relaxation"), "lacks what a result holds"),
        (lambda t: t.update(solution=[]), "lacks what a result holds"),
        (lambda t: t["solution"].update(status="splendid"), "lacks what a result holds"),
        (lambda t: t.update(statement="0"), "has been changed since"),
        (lambda t: t.update(theorem="standard.absent"), "there is no theorem 'standard.absent'"),
        (lambda t: t.update(theorem="/tmp/mine.py"), "is not one of the library; name its file with --theorem"),
        (lambda t: t.update(theorem="mine.py:robust"), "is not one of the library"),
        (lambda t: t.update(certificate="{}"), "format"),
    ],
)
def test_what_does_not_fit_is_refused(change: Callable[[dict[str, Any]], None], said: str, file: Path) -> None:
    changed(file, change)
    with pytest.raises(ResultError, match=said):
        lmic.read_result(file)


@pytest.mark.parametrize("key", ["lmic", "theorem", "plant", "scalars", "basis", "solution", "unknowns", "seconds"])
@pytest.mark.parametrize("value", [None, 3, "x", [], {}, [[]], {"x": None}])
def test_wrong_types_never_end_in_a_traceback(key: str, value: Any, file: Path) -> None:
    changed(file, lambda tables: tables.update({key: value}))
    try:
        lmic.read_result(file)
    except LmicError as error:
        assert isinstance(error, ResultError)


# The command line -----------------------------------------------------------------------------------


def command(*words: str) -> Any:
    return CliRunner().invoke(main, list(words))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder with a theorem and a plant of one's own."""
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(THEOREM, "utf-8")
    Path("plant.toml").write_text(PLANT, "utf-8")
    return tmp_path


def test_solve_stores_and_report_makes_a_page(folder: Path) -> None:
    answer = command("solve", "./mine.py", "--plant", "plant.toml", "-o", "result.json")
    assert answer.exit_code == 0, answer.output
    answer = command("report", "result.json", "--theorem", "./mine.py")
    assert (answer.exit_code, answer.output) == (0, "result.html\n")
    answer = command("report", "result.json", "--theorem", "./mine.py", "-o", "page.html", "--json")
    record = json.loads(answer.output)
    assert record["reports"]["gamma"] == pytest.approx(7 / 3, rel=1e-6)  # C (I − A)⁻¹ B at the first vertex
    assert "2.3333333" in (folder / "page.html").read_text("utf-8")
    answer = command("solve", "./mine.py", "--plant", "plant.toml", "-o", "direct.html")
    assert answer.exit_code == 0, answer.output
    assert "2.3333333" in (folder / "direct.html").read_text("utf-8")


def test_a_theorem_of_ones_own_is_named_and_must_be_the_same(folder: Path) -> None:
    command("solve", "./mine.py", "--plant", "plant.toml", "-o", "result.json")
    Path("mine.py").rename("moved.py")
    answer = command("report", "result.json")
    assert answer.exit_code == 1
    assert "its theorem, './mine.py', is not one of the library; name its file with --theorem" in answer.output
    assert command("report", "result.json", "--theorem", "./moved.py").exit_code == 0
    Path("moved.py").write_text(THEOREM.replace("gamma*I(nz)", "2*gamma*I(nz)"), "utf-8")
    Path("result.html").unlink()
    answer = command("report", "result.json", "--theorem", "./moved.py")
    assert answer.exit_code == 1
    assert "has been changed since this was solved; solve again" in answer.output
    assert not Path("result.html").exists()


def test_a_name_without_a_known_suffix_is_refused_before_solving(folder: Path) -> None:
    answer = command("solve", "./mine.py", "--plant", "plant.toml", "-o", "result.txt")
    assert answer.exit_code == 1
    assert "end the name in .json, .html, .npz, .mat, .tex" in answer.output
    with pytest.raises(FormatError):
        check_output(Path("result"))
    answer = command("report", "result.json", "-o", "result.json")
    assert answer.exit_code == 1
    assert "end the name in .html" in answer.output


def test_that_there_is_no_solution_is_stored_and_shown(tmp_path: Path) -> None:
    statement = replace(library.theorem("standard.stability_discrete"), assumes=())
    result = lmic.run(lmic.compile(statement, Plant.polytopic("rho", A=[[1.5]])))
    assert not result.solution.status.usable
    lmic.write_result(result, tmp_path / "none.json")
    read, _ = lmic.read_result(tmp_path / "none.json", statement)
    assert read.solution.status is result.solution.status
    assert read.solution.value == result.solution.value
    assert f"<strong>{read.solution.status.value}</strong>" in lmic.report(read)
