"""Ten thousand inputs of every kind: read, or refused in one sentence; soon; and nothing half-written left.

Others of the same kind stand with what they test: bytes and damaged plant files in test_plant_files_refused.py (300),
expressions in test_expressions.py (300), damaged problem files in test_interchange_damaged.py (2,400), damaged
certificates in test_certificate_files.py (1,400). With the cases here that makes more than ten thousand.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner
from fuzz_tools import (
    TOML_WORDS,
    check,
    command_line,
    corpus,
    definition,
    limited,
    mutated,
    plant_toml,
    seeds,
)
from interchange_tools import lag
from plant_file_tools import TOML

import lmic
from lmic.certify.certificate_file import parsed
from lmic.certify.verify import verify
from lmic.cli import main
from lmic.compiler.lower import lower
from lmic.compiler.terms import term_lists
from lmic.errors import CertificateError, PlantError
from lmic.fingerprint import digest
from lmic.interchange.formats import FORMATS
from lmic.interchange.sdp import sdp_of_problem
from lmic.language.theorem import Theorem
from lmic.library import root
from lmic.pipeline import compile, run
from lmic.plants.files import read_plant
from lmic.plants.random import random_plant
from lmic.relax.relax import Relaxation
from lmic.result_file import read_result, write_result
from lmic.sweeps.plan import Plan
from lmic.sweeps.store import Store

DEFINITIONS, PLANTS, DAMAGED_PLANTS, FILES, LINES = 3000, 3000, 2500, 3000, 1500
#: of those that are well-formed, one in so many is compiled as well
COMPILED = 3


def test_enough_cases() -> None:
    elsewhere = 300 + 300 + 2400 + 1400
    assert DEFINITIONS + PLANTS + DAMAGED_PLANTS + FILES + LINES + elsewhere >= 10_000


# Theorem files --------------------------------------------------------------------------------------


def define(path: Path, content: str) -> Theorem:
    path.write_text(content, encoding="utf-8")
    theorem = lmic.theorem(path)
    term_lists(lower(theorem))
    return theorem


def compile_anyhow(theorem: Theorem) -> None:
    given = {symbol.name: 1 for symbol in theorem.givens}
    compile(theorem, random_plant(theorem, {}, 2), given, relaxation=Relaxation(grid={"beta": 2}))


@pytest.mark.filterwarnings("ignore::SyntaxWarning")
def test_definitions(tmp_path: Path) -> None:
    sound, compiled = 0, 0
    for name, random in seeds("definition", DEFINITIONS):
        content = definition(random)
        found: list[Theorem] = []
        sound += check(name, content, lambda: found.append(define(tmp_path / "theorem.py", content)))  # noqa: B023
        if found and sound % COMPILED == 0:
            compiled += check(name, content, lambda: compile_anyhow(found[0]))  # noqa: B023
    assert sound > DEFINITIONS // 5, "too few are well-formed to test anything beyond the first error"
    assert compiled > sound // COMPILED // 10


@pytest.mark.parametrize("path", corpus("definitions"), ids=lambda path: path.stem)
def test_definitions_that_once_failed(path: Path, tmp_path: Path) -> None:
    content = path.read_text(encoding="utf-8")
    check(path.stem, content, lambda: compile_anyhow(define(tmp_path / "theorem.py", content)))


# Plant files ----------------------------------------------------------------------------------------


def test_plants(tmp_path: Path) -> None:
    path = tmp_path / "plant.toml"
    read = 0
    for name, random in seeds("plant", PLANTS):
        content = plant_toml(random)
        path.write_text(content, encoding="utf-8")
        read += check(name, content, lambda: read_plant(path), PlantError)
    assert read > PLANTS // 50


def test_damaged_plants(tmp_path: Path) -> None:
    path = tmp_path / "plant.toml"
    examples = [TOML.encode(), *(file.read_bytes() for file in sorted(root().glob("*/example*.toml")))]
    for name, random in seeds("damaged plant", DAMAGED_PLANTS):
        content = mutated(random, random.choice(examples), TOML_WORDS)
        path.write_bytes(content)
        check(name, content, lambda: read_plant(path), PlantError)


@pytest.mark.parametrize("path", corpus("plants"), ids=lambda path: path.stem)
def test_plants_that_once_failed(path: Path) -> None:
    check(path.stem, path, lambda: read_plant(path), PlantError)


# Files of other kinds -------------------------------------------------------------------------------

JSON_WORDS = tuple(
    word.encode()
    for word in (
        *("{", "}", "[", "]", ",", ":", '"', "null", "true", "-1", "0", "1e999", "NaN", "9" * 5000, '""', '"\\ud800"'),
        *('{"at": {}}', "\n", '"at"', '"reports"', '"error"', '"status"', "[" * 2000, '"solved"', '"1/0"', '"1p-9999"'),
    )
)
TEXT_WORDS = (
    *JSON_WORDS,
    b"VER\n",
    b"PSDCON\n",
    b"1 1 1 1 1e400\n",
    b"99999999999 ",
    b"-5 ",
    b"\x00",
    b"*",
    b"PK\x03\x04",
)


def sweep_plan() -> Plan:
    theorem = lmic.theorem("peixoto2025.theorem1")
    plant = read_plant(root() / "peixoto2025" / "example1.toml")
    from lmic.sweeps.axes import axes_of

    return Plan(theorem, (plant,), axes_of({"eps": "1,2,3"}, (plant,)))


def resume(plan: Plan, path: Path, content: bytes) -> None:
    path.write_bytes(content)
    with Store(plan, path) as store:
        from lmic.sweeps.swept import Swept

        swept = Swept(plan, {key: store.records.get(key, {"error": "missing"}) for key in plan.points()})
        assert swept.statuses is not None
        for name in swept.reports:
            swept.values(name)
        swept.columns()
        assert swept.doubtful >= 0


def rewritten(path: Path, body: bytes) -> Path:
    """A file of a result with the checksum made to fit, where it is JSON at all."""
    try:
        tables = json.loads(body)
        path.write_text(json.dumps(tables | {"sha256": digest(tables)}))
    except (ValueError, TypeError, RecursionError):
        path.write_bytes(body)
    return path


def test_damaged_files(tmp_path: Path) -> None:
    """Problems of all formats with words of their own put in, certificates past their checksum, sweeps' files."""
    sdp = sdp_of_problem(lag())
    contents = {suffix: found.write(sdp) for suffix, found in FORMATS.items()}
    certificate = min(
        (root().parent / "certificates").glob("*.json"), key=lambda path: path.stat().st_size
    ).read_bytes()
    plan = sweep_plan()
    record = {"status": "solved", "reports": {"gamma": 1.5}, "objective": 1.0, "bound": 1.0, "uncertainty": 0.0}
    record |= {"violation": 0.0, "soundness": "exact", "trusted": True, "iterations": 3, "solves": 1, "seconds": 0.1}
    lines = [{"lmic sweep": 1, **plan.header}, *({"at": {"eps": str(k)}, **record} for k in (1, 2, 3))]
    sweep = "".join(json.dumps(line) + "\n" for line in lines).encode()
    resume(plan, tmp_path / "s.jsonl", sweep)
    write_result(run(lag()), tmp_path / "r.json", theorem="standard.bounded_real_discrete")
    result = json.dumps({k: v for k, v in json.loads((tmp_path / "r.json").read_bytes()).items() if k != "sha256"})
    read_result(rewritten(tmp_path / "r.json", result.encode()))
    for name, random in seeds("file", FILES):
        match random.choice([*FORMATS, "certificate", "sweep", "sweep", "result"]):
            case "result":
                content = mutated(random, result.encode(), JSON_WORDS)
                check(name, content, lambda: read_result(rewritten(tmp_path / "r.json", content)))  # noqa: B023
            case "certificate":
                content = mutated(random, certificate, JSON_WORDS)
                check(name, content[:4000], lambda: verify(parsed(content)), CertificateError)  # noqa: B023
            case "sweep":
                head, rest = sweep.split(b"\n", 1)
                content = head + b"\n" + mutated(random, rest, JSON_WORDS)
                check(name, content, lambda: resume(plan, tmp_path / "s.jsonl", content))  # noqa: B023
            case suffix:
                content = mutated(random, contents[suffix], TEXT_WORDS)
                check(name, content, lambda: FORMATS[suffix].read(content))  # noqa: B023


@pytest.mark.parametrize("path", corpus("sweeps"), ids=lambda path: path.stem)
def test_sweeps_that_once_failed(path: Path, tmp_path: Path) -> None:
    plan = sweep_plan()
    header = json.dumps({"lmic sweep": 1, **plan.header}).encode()
    check(path.stem, path, lambda: resume(plan, tmp_path / "s.jsonl", header + b"\n" + path.read_bytes()))


# The command line -----------------------------------------------------------------------------------

NAMES = (
    "standard.stability_discrete",
    "standard.bounded_real_discrete",
    "standard.decay_rate_discrete",
    "./mine.py",
    "x.y",
)
MINE = '''"""Mine."""
from lmic.dsl import *
(n,) = dims("n")
A, P, eps = Data("A", n, n)(Simplex("rho", step="free")), Symmetric("P", n), given("eps")
theorem = Theorem(lmis={"a": PD([[P - eps*A.T*P*A]]), "b": PD([[P]])}, source=Source("N. N.", "Notes", "none", 2026))
'''
PLANT = """name = "lag"
[parameters.rho]
simplex = 2
[matrices]
A = { vertices = [[["1/2"]], [["-1/2"]]] }
"""
OUTPUTS = (
    "out.npz",
    "out.mat",
    "out.tex",
    "out.csv",
    "out.png",
    "out.dat-s",
    "out.jsonl",
    "folder",
    "no/where",
    "out.xyz",
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    (tmp_path / "mine.py").write_text(MINE)
    (tmp_path / "plant.toml").write_text(PLANT)
    (tmp_path / "two.toml").write_text(PLANT.replace("simplex = 2", "simplex = 3"))
    (tmp_path / "F.dat-s").write_bytes(FORMATS[".dat-s"].write(sdp_of_problem(lag())))
    (tmp_path / "C.json").write_text("{}")
    return tmp_path


def run_line(words: list[str]) -> None:
    """Fail unless the command ends by itself, with at most one line of lmic's own where it refuses."""
    with limited():
        done = CliRunner().invoke(main, words)
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code in (0, 1, 2)
    assert "Traceback" not in done.output
    if done.exit_code == 1 and done.stderr:
        assert done.stderr.count("\n") == 1, done.stderr


def test_command_lines(folder: Path) -> None:
    files = ("plant.toml", "plant.toml", "plant.toml", "two.toml", "F.dat-s", "C.json", "no.toml", *OUTPUTS)
    for name, random in seeds("command line", LINES):
        words = command_line(random, NAMES, files)
        if words[0] == "reproduce":  # without a name it takes minutes
            words.insert(1, "no case")
        check(name, words, lambda: run_line(words))  # noqa: B023
        left = [path.name for path in folder.rglob(".*")]
        assert not left, (name, words, left)


@pytest.mark.parametrize("path", corpus("command_lines"), ids=lambda path: path.stem)
def test_command_lines_that_once_failed(path: Path, folder: Path) -> None:
    words = path.read_text(encoding="utf-8").removesuffix("\n").split("\n")
    check(path.stem, words, lambda: run_line(words))
