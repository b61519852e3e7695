"""Sweeps: every point once, whatever happens on the way."""

from __future__ import annotations

import csv
import json
import os
import re
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import lmic
from lmic.cli import main
from lmic.errors import DomainError, LmicError, PlantError, SweepError
from lmic.library import root
from lmic.papers.cases import case_tables
from lmic.papers.figures import draw_curve
from lmic.papers.reproduce import run_curve
from lmic.pipeline import compile, run
from lmic.plants.files import read_plant
from lmic.plants.plant import Plant
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation
from lmic.solve.clarabel import Clarabel
from lmic.solve.neighbour import solve_near
from lmic.solve.solve import solve
from lmic.sweeps import work
from lmic.sweeps.axes import make_axis
from lmic.sweeps.plan import Plan
from lmic.sweeps.plot import plot
from lmic.sweeps.sweep import axes_of, sweep
from lmic.sweeps.swept import Swept

LEMMA = "standard.bounded_real_discrete"

#: A has spectral radius |a|, so γ exists for |a| < 1 only; c scales the output and with it γ
PLANT = """name = "scaled modes"

[parameters.rho]
simplex = 2

[scalars]
a = 0.5
c = 1

[matrices]
A = { vertices = [[["a", 0.2], [0, 0.4]], [[0.1, "1/2"], [-0.3, "a"]]] }
B = [[1], [0.5]]
C = [["c", 0]]
D = [[0]]
"""

EXAMPLE_2 = root() / "peixoto2025" / "example2.toml"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "plant.toml"
    path.write_text(PLANT, encoding="utf-8")
    return path


@pytest.fixture
def plant(file: Path) -> Plant:
    return read_plant(file)


def gamma(plant: Plant, given: Mapping[str, Any] | None = None, **choices: Any) -> float:
    return run(compile(lmic.theorem(LEMMA), plant, given, **choices)).reports["gamma"]


def records(path: Path) -> list[dict[str, Any]]:
    """The records of a sweep's file, all of which must be whole."""
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()[1:]]


# Axes and plans ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "values", "labels", "column"),
    [
        ("eps", "0.1:6:296", ("0.1", "0.12", "0.14"), "eps"),
        ("eps", "1, 1/3,50", ("1", "1/3", "50"), "eps"),
        ("eps", "log:1:1000:4", ("1", "10", "100", "1000"), "eps"),
        ("set:polya", "1,2", ("1", "2"), "polya"),
        ("polya", "0,2", ("0", "2"), "polya"),
        ("polya:alpha+", [0, 1], ("0", "1"), "polya alpha+"),
        ("dependence:P", "constant,1,1; rho1; rho1**2", ("constant", "1", "1; rho1; rho1**2"), "dependence P"),
        ("grid:rho", "5,chebyshev:9", ("5", "chebyshev:9"), "grid rho"),
        ("grid:r", "5, (1/4, 0); (0,-1),(1,1)", ("5", "0.25 0; 0 -1", "1 1"), "grid r"),
        ("grid:h", [Grid.at([[0.1], [0.2]]), Grid(4, "random", seed=3)], ("0.1; 0.2", "random:4 seed 3"), "grid h"),
        ("c", np.array([0.1, 2.0]), ("0.1", "2"), "c"),
    ],
)
def test_axes(key: str, values: Any, labels: tuple[str, ...], column: str) -> None:
    axis = make_axis(key, values)
    assert axis.labels[: len(labels)] == labels
    assert axis.column == column


def test_a_range_is_exact() -> None:
    axis = make_axis("eps", "0.1:6:296")
    assert len(axis.values) == 296
    assert axis.values[1] == Fraction(12, 100)
    assert axis.values[-1] == 6
    assert make_axis("c", "log:1:8:4").values[0] == 1


@pytest.mark.parametrize(
    ("key", "values", "words"),
    [
        ("eps", "", ["no value"]),
        ("eps", [], ["no value"]),
        ("eps", "1:2", ["LOW:HIGH:COUNT"]),
        ("eps", "2:1:5", ["lower to a higher"]),
        ("eps", "log:0:1:5", ["positive"]),
        ("eps", "one", ["eps=one"]),
        ("eps", "1,2,1.0", ["twice", "1"]),
        ("polya:alpha", "1.5", ["Pólya degree", "1.5"]),
        ("grid:rho", "many", ["grid", "many"]),
        ("colour:rho", "1", ["colour:rho", "dependence:P"]),
        ("dependence:", "1", ["dependence:"]),
        ("plant:x", "1", ["plant:x"]),
    ],
)
def test_axes_refused(key: str, values: Any, words: list[str]) -> None:
    with pytest.raises(SweepError) as refused:
        make_axis(key, values)
    for word in words:
        assert word in str(refused.value)


@pytest.mark.parametrize(
    ("over", "choices", "error", "words"),
    [
        ({}, {}, SweepError, ["nothing is swept over"]),
        ({"a": "0,1", "set:a": "2"}, {}, SweepError, ["a is swept twice"]),
        ({"b": "1,2"}, {}, PlantError, ["b is no scalar", "a, c"]),
        ({"dependence:Q": "1"}, {}, SweepError, ["Q is no unknown", "which has P"]),
        ({"a": "0,1"}, {"given": {"a": 0}}, SweepError, ["a is both fixed and swept over"]),
        ({"grid:rho": "2,3"}, {"relaxation": Relaxation(grid={"rho": 5})}, SweepError, ["rho is both fixed and swept"]),
        ({"polya:rho": "0,1"}, {"relaxation": Relaxation(polya=2)}, SweepError, ["degrees are fixed while polya rho"]),
        ({"polya": "0,1"}, {"relaxation": Relaxation(polya={"rho": 2})}, SweepError, ["degrees are fixed while polya"]),
        ({"a": "0,1"}, {"search": ("a", 0, 1)}, SweepError, ["a is both searched and swept over"]),
        ({"a": "0:0.9:10000", "c": "1:2:10000"}, {}, SweepError, ["100000000 points", "coarsen"]),
        ({"a": "0,1"}, {"jobs": 0}, SweepError, ["0 processes"]),
    ],
)
def test_sweeps_refused(
    plant: Plant, over: dict[str, Any], choices: dict[str, Any], error: type[LmicError], words: list[str]
) -> None:
    with pytest.raises(error) as refused:
        sweep(lmic.theorem(LEMMA), plant, over, **choices)
    for word in words:
        assert word in str(refused.value)


def test_a_missing_scalar_and_two_plants_of_one_name_are_refused(plant: Plant) -> None:
    filter_ = lmic.theorem("peixoto2025.theorem1")
    with pytest.raises(PlantError, match="eps has no value"):
        sweep(filter_, read_plant(EXAMPLE_2), {"rho": "1,2"})
    with pytest.raises(SweepError, match="two plants are called scaled modes"):
        sweep(lmic.theorem(LEMMA), [plant, plant], {"a": "0,0.1"})
    with pytest.raises(DomainError, match="rho has no domain"):
        sweep(lmic.theorem(LEMMA), read_plant(EXAMPLE_2), {"rho": "1,2"}, jobs=1)
    with pytest.raises(SweepError, match="needs a plant"):
        sweep(lmic.theorem(LEMMA), [], {"a": "0,0.1"})


@pytest.mark.parametrize("length", [1, 2, 7, 100])
def test_lines_hold_every_point_once(plant: Plant, length: int) -> None:
    """Whatever the axes' order; points of one line differ in the last scalar only, and what is done is left out."""
    over = {"c": "1,2,3", "polya": "0,1", "a": "0:0.4:5", "dependence:P": "constant,1"}
    plan = Plan(lmic.theorem(LEMMA), (plant,), axes_of(over, (plant,)))
    done = dict.fromkeys(list(plan.points())[::4])
    found = []
    for line in plan.lines(length, done):
        assert 1 <= len(line.keys) <= length
        assert len({(key[0], key[1], key[3]) for key in line.keys}) == 1
        for key, scalars in zip(line.keys, line.scalars, strict=True):
            assert (str(scalars["c"]), float(scalars["a"])) == (key[0], float(key[2]))
            assert (str(line.relaxation.polya), str(line.dependence["P"])) == (key[1], key[3])
        found += line.keys
    assert len(found) == len(set(found))
    assert set(found) | set(done) == set(plan.points())
    assert not set(found) & set(done)


# What comes out -------------------------------------------------------------------------------------


def test_values_are_those_of_the_single_problems(plant: Plant) -> None:
    """Scalars, bases and Pólya degrees, in the shape of the axes."""
    swept = lmic.sweep(
        lmic.theorem(LEMMA),
        plant,
        {"dependence:P": ["constant", 1], "a": [0.1, 0.5], "polya": [0, 1]},
        {"c": 2},
        jobs=1,
    )
    expected = [
        [[gamma(plant, {"a": a, "c": 2}, dependence={"P": p}, relaxation=Relaxation(polya=d)) for d in (0, 1)] for a in
         (0.1, 0.5)] for p in ("constant", 1)
    ]  # fmt: skip
    assert swept.values("gamma") == pytest.approx(np.array(expected), rel=1e-7)
    assert swept.statuses == {"solved": 8}
    assert not swept.doubtful
    assert swept.solves == 8


def test_plants_and_grids(plant: Plant, tmp_path: Path) -> None:
    other = read_plant(_edited(tmp_path, 'name = "scaled modes"', 'name = "other"').with_name("other.toml"))
    swept = lmic.sweep(lmic.theorem(LEMMA), [plant, other], {"grid:rho": "2,4"}, relaxation=_gridded(), jobs=1)
    assert swept.plan.columns == ("plant", "grid rho")
    assert swept.columns()["plant"] == ["scaled modes", "scaled modes", "other", "other"]
    values = swept.values("gamma")
    assert values[0] == pytest.approx(values[1], rel=1e-9)
    assert swept.columns()["soundness"] == ["sampled"] * 4
    assert values[0, 1] >= values[0, 0] - 1e-9
    assert values[0, 0] == pytest.approx(
        gamma(plant, relaxation=Relaxation({"rho": "grid", "rho+": "grid"}, grid={"rho": 2, "rho+": 2})), 1e-7
    )


def _gridded() -> Relaxation:
    return Relaxation({"rho": "grid", "rho+": "grid"}, grid={"rho+": 2})


def _edited(folder: Path, old: str, new: str) -> Path:
    path = folder / "other.toml"
    path.write_text(PLANT.replace(old, new), encoding="utf-8")
    return path


def test_a_failed_point_is_recorded_with_its_reason_and_stops_nothing(plant: Plant, tmp_path: Path) -> None:
    """At |a| > 1 the plant is unstable; at degree 60 the relaxation is refused: four points of eight remain."""
    path = tmp_path / "s.jsonl"
    swept = lmic.sweep(lmic.theorem(LEMMA), plant, {"polya": "0,60", "a": "0.1,2,0.2,0.3"}, file=path, jobs=1)
    values = swept.values("gamma")
    assert np.isfinite(values[0]).tolist() == [True, False, True, True]
    assert np.isnan(values[1]).all()
    reasons = swept.failed
    assert sum(reasons.values()) == 5
    assert any("RelaxationError" in reason and "50" in reason for reason in reasons)
    assert [record["at"]["a"] for record in records(path) if "error" in record and record["at"]["polya"] == "0"] == [
        "2"
    ]
    again = lmic.sweep(lmic.theorem(LEMMA), plant, {"polya": "0,60", "a": "0.1,2,0.2,0.3"}, file=path, jobs=1)
    assert again.records == swept.records


def test_any_exception_is_a_reason(plant: Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: Any, **__: Any) -> Any:
        raise ZeroDivisionError("nothing left")

    monkeypatch.setattr(work, "run", broken)
    swept = lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1,0.2"}, jobs=1)
    assert swept.failed == {"ZeroDivisionError: nothing left": 2}


def test_a_slow_line_is_handed_back_and_goes_on(plant: Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    """No line waits longer than its patience, and no point is lost or done twice for that."""
    monkeypatch.setattr(work.solve_line, "__defaults__", (0.0,))
    steps: list[tuple[int, int]] = []
    swept = lmic.sweep(
        lmic.theorem(LEMMA), plant, {"a": "0:0.4:5"}, jobs=1, advance=lambda more, total: steps.append((more, total))
    )
    assert steps == [(0, 5)] + [(1, 5)] * 5
    assert np.isfinite(swept.values("gamma")).all()


def test_search_at_every_point() -> None:
    """ε = 2 gives 1.5849 at ρ = 10; the best ε cannot be worse."""
    filter_, plant = lmic.theorem("peixoto2025.theorem1"), read_plant(EXAMPLE_2)
    swept = lmic.sweep(filter_, plant, {"rho": [10]}, search=("eps", 1.5, 4), jobs=1)
    (value,) = swept.values("gamma")
    (found,) = swept.columns()["eps"]
    assert value == pytest.approx(run(compile(filter_, plant, {"rho": 10, "eps": found})).reports["gamma"], rel=1e-8)
    assert value == pytest.approx(1.5848410656, rel=1e-8)
    assert swept.solves > 8


def test_least_over_an_axis(plant: Plant) -> None:
    swept = lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "2,0.1", "c": "1,3,2"}, jobs=1)
    least, where = swept.least("gamma", "c")
    assert np.isnan([least[0], where[0]]).all()
    assert least[1] == pytest.approx(gamma(plant, {"a": 0.1, "c": 1}), rel=1e-7)
    assert where[1] == 1
    with pytest.raises(SweepError, match="'eps' is not swept over; the axes are a, c"):
        swept.least("gamma", "eps")
    with pytest.raises(SweepError, match="no column 'delta'"):
        swept.values("delta")


def test_least_over_labels(plant: Plant) -> None:
    over = {"a": "2,0.1", "dependence:P": "constant,1"}
    least, where = lmic.sweep(lmic.theorem(LEMMA), plant, over, jobs=1).least("gamma", "dependence P")
    assert np.isnan(least[0])
    assert where.tolist() == [None, "1"]


@pytest.fixture
def swept(plant: Plant) -> Swept:
    return lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1,2", "c": "1,2"}, jobs=1)


def test_tables(swept: Swept, tmp_path: Path) -> None:
    from pyarrow import parquet

    swept.write_table(tmp_path / "t.csv")
    with (tmp_path / "t.csv").open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["a"], row["c"]) for row in rows] == [("0.1", "1.0"), ("0.1", "2.0"), ("2.0", "1.0"), ("2.0", "2.0")]
    assert [float(row["gamma"]) for row in rows[:2]] == swept.values("gamma")[0].tolist()
    assert rows[2]["gamma"] == ""
    assert "unstable" in rows[2]["error"] or rows[2]["error"]
    swept.write_table(tmp_path / "t.parquet")
    assert parquet.read_table(tmp_path / "t.parquet").to_pydict() == swept.columns()
    with pytest.raises(SweepError, match=r"end the name in \.csv or \.parquet"):
        swept.write_table(tmp_path / "t.xls")
    with pytest.raises(LmicError, match="cannot be written"):
        swept.write_table(tmp_path / "nowhere" / "t.parquet")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["plant.toml", "t.csv", "t.parquet"]


@pytest.mark.parametrize(
    ("over", "least"),
    [
        ({"a": "0.1:0.5:3"}, None),
        ({"a": "0.1:0.5:3", "dependence:P": "constant,1"}, None),
        ({"dependence:P": "constant,1"}, None),
        ({"a": "0.1,0.2", "c": "1,2,3"}, "a"),
        ({"a": "0:0.2:9", "c": "log:1:1e6:9"}, None),
    ],
)
def test_plots(plant: Plant, tmp_path: Path, over: dict[str, Any], least: str | None) -> None:
    plot(lmic.sweep(lmic.theorem(LEMMA), plant, over, jobs=1), tmp_path / "p.png", least_over=least)
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")


def test_plots_refused(swept: Swept, plant: Plant, tmp_path: Path) -> None:
    with pytest.raises(SweepError, match=r"cannot be drawn.*\.png"):
        plot(swept, tmp_path / "p.xyz")
    one = lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1,0.2"}, jobs=1)
    with pytest.raises(SweepError, match="a is the only axis"):
        plot(one, tmp_path / "p.png", least_over="a")


# The file -------------------------------------------------------------------------------------------


def test_a_torn_last_line_is_cut_off_and_its_point_done_again(plant: Plant, tmp_path: Path) -> None:
    path = tmp_path / "s.jsonl"
    first = lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1,0.2,0.3"}, file=path, jobs=1)
    content = path.read_bytes()
    for cut in (1, 40, len(content.splitlines()[-1])):
        path.write_bytes(content[:-cut])
        again = lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1,0.2,0.3"}, file=path, jobs=1)
        assert path.read_bytes().startswith(content[: content.rstrip(b"\n").rfind(b"\n") + 1])
        assert [record["at"]["a"] for record in records(path)] == ["0.1", "0.2", "0.3"]
        assert again.values("gamma") == pytest.approx(first.values("gamma"), rel=1e-8)


@pytest.mark.parametrize("calls", [1, 2, 3], ids=["before the first point", "after it", "after the second"])
def test_what_an_interrupted_sweep_kept_is_what_its_file_holds(plant: Plant, tmp_path: Path, calls: int) -> None:
    """Ctrl-C may come between a write and anything that counts it."""
    path = tmp_path / "s.jsonl"
    left = calls

    def stop(more: int, total: int) -> None:
        nonlocal left
        left -= 1
        if not left:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match=f"^{calls - 1} of 4 points are in {re.escape(str(path))}"):
        lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1,0.2,0.3,0.4"}, file=path, jobs=1, advance=stop)
    assert len(records(path)) == calls - 1


def test_a_sweep_may_grow(plant: Plant, tmp_path: Path) -> None:
    """More values of an axis do what is new; fewer show what is asked for and keep the rest."""
    path = tmp_path / "s.jsonl"
    lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1,0.2"}, file=path, jobs=1)
    done: list[int] = []
    lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1,0.2,0.3"}, file=path, jobs=1, advance=lambda n, _: done.append(n))
    assert done == [2, 1]
    fewer = lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.2"}, file=path, jobs=1)
    assert list(fewer.records) == [("0.2",)]
    assert len(records(path)) == 3


def test_the_file_of_another_problem_is_refused(plant: Plant, tmp_path: Path) -> None:
    path = tmp_path / "s.jsonl"
    lemma, over = lmic.theorem(LEMMA), {"a": "0.1,0.2"}
    lmic.sweep(lemma, plant, over, file=path, jobs=1)
    before = path.read_bytes()
    changed = read_plant(_edited(tmp_path, "0.4", "0.41"))
    for theorem, data, axes, choices, word in [
        (lmic.theorem(f"{LEMMA}_quadratic"), plant, over, {}, f"theorem {LEMMA}"),
        (lemma, changed, over, {}, "other data"),
        (lemma, plant, {"c": "1,2"}, {}, r"axes \['a'\]"),
        (lemma, plant, over, {"given": {"c": 2}}, r"fixed \{\}"),
        (lemma, plant, over, {"dependence": {"P": 2}}, "other data or choices"),
        (lemma, plant, over, {"relaxation": Relaxation(polya=1)}, "other data or choices"),
        (lemma, plant, over, {"search": ("c", 1, 2)}, "search None"),
    ]:
        with pytest.raises(SweepError, match=f"another problem .*{word}"):
            lmic.sweep(theorem, data, axes, file=path, jobs=1, **choices)
    assert path.read_bytes() == before


def test_a_file_that_was_refused_may_be_mended_and_taken(plant: Plant, tmp_path: Path) -> None:
    """The error is kept, as a notebook keeps the last one; the file's lock is not."""
    path = tmp_path / "s.jsonl"
    lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1"}, file=path, jobs=1)
    size = path.stat().st_size
    with path.open("ab") as stream:
        stream.write(b"{}\n")
    with pytest.raises(SweepError, match="remove the line") as kept:
        lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1"}, file=path, jobs=1)
    os.truncate(path, size)
    assert lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1"}, file=path, jobs=1).statuses == {"solved": 1}
    assert kept.value.place is not None


def test_other_files_are_refused_and_left_alone(plant: Plant, tmp_path: Path) -> None:
    path = tmp_path / "s.jsonl"
    for content, word in [(b"alpha,beta\n1,2\n", "no file of a sweep"), (b"no line", "no file of a sweep")]:
        path.write_bytes(content)
        with pytest.raises(SweepError, match=word):
            lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1"}, file=path, jobs=1)
        assert path.read_bytes() == content
    path.write_bytes(b"")
    lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1"}, file=path, jobs=1)
    content = path.read_bytes() + b'{"at": {"b": "1"}}\n'
    path.write_bytes(content)
    with pytest.raises(SweepError, match="line 3 is no point of this sweep"):
        lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1"}, file=path, jobs=1)
    for bad, word in [(tmp_path / "no" / "s.jsonl", "cannot be written"), (tmp_path, "cannot be written")]:
        with pytest.raises(LmicError, match=word):
            lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1"}, file=bad, jobs=1)


def test_two_sweeps_do_not_write_one_file(plant: Plant, tmp_path: Path) -> None:
    path = tmp_path / "s.jsonl"

    def intrude(more: int, total: int) -> None:
        with pytest.raises(SweepError, match="being written by another sweep"):
            lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1,0.2"}, file=path, jobs=1)

    lmic.sweep(lmic.theorem(LEMMA), plant, {"a": "0.1,0.2"}, file=path, jobs=1, advance=intrude)
    assert len(records(path)) == 2


# The command ----------------------------------------------------------------------------------------


def command(*words: str) -> Any:
    return CliRunner().invoke(main, ["sweep", *words])


def test_command(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    words = [LEMMA, "--plant", "plant.toml", "--over", "a=0.1,0.2", "--over", "c=1,2", "-o", "s.jsonl", "--jobs", "1"]
    shown = command(*words, "--table", "t.csv", "--plot", "p.png", "--least-over", "c")
    assert shown.exit_code == 0, shown.output
    for word in ("least gamma", "at c", "4 points (4 solved)", "written: s.jsonl", "written: t.csv", "written: p.png"):
        assert word in shown.stdout
    record = json.loads(command(*words, "--json").stdout)
    assert record["points"] == record["solves"] == 4
    assert record["table"]["a"] == [0.1, 0.1, 0.2, 0.2]
    assert record["failed"] == {}


def test_command_with_failures_ends_with_1_and_says_why(file: Path, tmp_path: Path) -> None:
    shown = command(LEMMA, "--plant", str(file), "--over", "a=0.1,2", "-o", str(tmp_path / "s.jsonl"), "--jobs", "1")
    assert shown.exit_code == 1
    assert "1 failed: " in shown.stdout
    assert "1 solved" in shown.stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--over", "a"], "no '='"),
        (["--over", "a=1", "--over", "a=2"], "twice"),
        (["--over", "a=x"], "a=x"),
        (["--over", "a=0.1,0.2", "--scheduler", "nonsense"], "nonsense"),
        (["--over", "a=0.1,0.2", "--least-over", "c"], "not swept over"),
    ],
)
def test_command_refused(file: Path, tmp_path: Path, words: list[str], said: str) -> None:
    result = command(LEMMA, "--plant", str(file), "-o", str(tmp_path / "s.jsonl"), *words)
    assert result.exit_code == 1
    assert said in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1


# Neighbours -----------------------------------------------------------------------------------------


def test_a_neighbour_changes_no_digit_and_saves_iterations() -> None:
    """γ over ε from nothing and from the last point: the same to 1e-8, also across a kink and at the domain's end."""
    filter_, plant = lmic.theorem("peixoto2025.theorem1"), read_plant(EXAMPLE_2)
    binding = lmic.prepare(filter_, plant)
    warm, cold = 0, 0
    for rho, values in ((10, (1.94, 2.0, 2.06)), (20, (0.3, 0.36, 0.42)), (21, (5.9, 5.95, 6.0))):
        near = None
        for eps in values:
            problem = lmic.finish(binding, {"rho": rho, "eps": eps})
            near, alone = run(problem, near=near), run(problem)
            assert near.reports["gamma"] == pytest.approx(alone.reports["gamma"], rel=1e-8)
            assert near.solution.uncertainty < 2e-8
            assert near.solution.relative_violation > -1e-9
            warm, cold = warm + near.solution.iterations, cold + alone.solution.iterations
    assert warm < cold


@pytest.mark.parametrize("slack", [np.zeros(3), np.full(342, np.nan), np.full(342, np.inf)])
def test_a_neighbour_that_is_none_is_left_aside(slack: np.ndarray) -> None:
    filter_, plant = lmic.theorem("peixoto2025.theorem1"), read_plant(EXAMPLE_2)
    problem = compile(filter_, plant, {"rho": 10, "eps": 2})
    assert len(problem.offset) == 342
    assert solve_near(problem, slack, Clarabel()) is None
    assert solve(problem, near=slack).value == pytest.approx(1.584912454**2, rel=1e-8)


@pytest.mark.parametrize(("rho", "gamma"), [(10, 1.5849), (20, 3.8020)])
def test_example_2_of_peixoto_et_al(rho: int, gamma: float) -> None:
    """γ at ε = 2, from an independent dense formulation."""
    result = run(compile(lmic.theorem("peixoto2025.theorem1"), read_plant(EXAMPLE_2), {"rho": rho, "eps": 2}))
    assert result.reports["gamma"] == pytest.approx(gamma, abs=5.1e-5)


def test_a_doubtful_value_is_not_the_least(swept: Swept) -> None:
    records = {key: dict(record) for key, record in swept.records.items()}
    records["0.1", "2"] |= {"reports": {"gamma": 0.0001}, "uncertainty": 1e9}
    assert Swept(swept.plan, records).least("gamma", "c")[1][0] == 1


def test_curves_of_case_tables(tmp_path: Path) -> None:
    """Figures 3 and 4 as the case table states them, at two values of ρ: pictures, tables, and γ at its best."""
    (curve,) = [curve for table in case_tables() for curve in table.curves]
    assert make_axis("rho", curve.over["rho"]).shown == tuple(range(1, 22))
    assert curve.search == ("eps", 0.1, 6.0)
    found = run_curve(replace(curve, over={"rho": "2,20"}))
    best, robust = (swept.values("gamma") for swept in found.values())
    assert best[1] < 3.8020
    assert (best < robust).all()
    for swept in found.values():
        assert swept.solves * 10 <= 2 * 296
        assert not swept.doubtful
    written = draw_curve(curve, found, tmp_path)
    assert [path.name for path in written] == ["peixoto2025.figure3.png", "peixoto2025.figure4.png"]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in written)
    assert {path.name for path in tmp_path.glob("*.csv")} == {
        "peixoto2025.figure3.theorem1.csv",
        "peixoto2025.figure3.corollary1.csv",
    }


@pytest.mark.long
def test_the_line_search_reaches_the_grid_with_a_tenth_of_the_solves() -> None:
    """Figure 3 both ways: 21 x 296 problems, and a search at each ρ, which may only be better."""
    filter_, plant = lmic.theorem("peixoto2025.theorem1"), read_plant(EXAMPLE_2)
    full = lmic.sweep(filter_, plant, {"rho": "1:21:21", "eps": "0.1:6:296"})
    sought = lmic.sweep(filter_, plant, {"rho": "1:21:21"}, search=("eps", 0.1, 6))
    assert not sought.doubtful
    assert full.solves == 21 * 296
    assert (sought.values("gamma") <= full.least("gamma", "eps")[0] * (1 + 1e-8)).all()
    assert 10 * sought.solves <= full.solves
