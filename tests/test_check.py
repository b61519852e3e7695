"""``lmic check``: every fault of a file at its line, nothing that is none, and the matrix with its shapes."""

from __future__ import annotations

import json
import re
from pathlib import Path
from random import Random
from typing import Any

import pytest
from click.testing import CliRunner

from lmic import library
from lmic.authoring import display
from lmic.authoring.checkup import check
from lmic.authoring.execution import execute
from lmic.cli import main
from lmic.compiler.lower import lower
from lmic.compiler.terms import objective, term_lists
from lmic.errors import LmicError
from lmic.faults import demand

HEAD = """from lmic.dsl import *
n, m = dims("n m")
alpha = Simplex("alpha", step="free")
A, B = Data("A", n, n)(alpha), Data("B", n, m)(alpha)
P, G = Symmetric("P", n), Matrix("G", n, n)(alpha)
mu = Scalar("mu")
"""
TAIL = 'source=Source("nobody", "Notes", "unpublished", 2026))\n'
SOUND = HEAD + 'theorem = Theorem(lmis={"a": PD([[P(alpha), (A + G)*B], [star, mu*I(m)]])}, ' + TAIL


def findings(text: str, folder: Path) -> list[dict[str, Any]]:
    """What is found in a file, as the JSON says it, line by line."""
    (folder / "mine.py").write_text(text, encoding="utf-8")
    result = CliRunner().invoke(main, ["check", str(folder / "mine.py"), "--json"])
    assert result.exception is None or isinstance(result.exception, SystemExit)
    found = json.loads(result.stdout)["findings"]
    assert result.exit_code == int(any(one["fault"] for one in found))
    return found


def stated(rows: str, *arguments: str) -> str:
    """A file whose only LMI begins in line 7."""
    return f'{HEAD}theorem = Theorem(lmis={{"a": PD({rows})}}, {"".join(f"{one}, " for one in arguments)}{TAIL}'


def test_a_sound_file_has_no_findings(tmp_path: Path) -> None:
    assert findings(SOUND, tmp_path) == []


@pytest.mark.parametrize("name", library.names())
def test_the_library_is_sound(name: str) -> None:
    checkup = check(library.locate(name))
    assert checkup.findings == []
    assert checkup.lmis


def test_every_lmi_of_the_library_is_traced_to_its_line() -> None:
    for path in library.files().values():
        execution = execute(path)
        for lmi in execution.namespace["theorem"].lmis.values():
            call = execution.call_of(lmi)
            assert call is not None
            assert path.read_text("utf-8").splitlines()[call.lineno - 1][call.col_offset :].startswith(("PD", "ND"))


#: rows from line 7 on, the kind of their only fault, its line and block, and words of its message
FAULTS: list[tuple[str, str, int, list[int] | None, str]] = [
    ("[[P(alpha),\n B], [star, P(alpha)]]", "ShapeError", 8, [1, 2], "n x m"),
    ("[[P(alpha), A],\n [A, P(alpha)]]", "AsymmetryError", 7, [1, 2], "not the transpose"),
    ("[[P(alpha), 0],\n [star,\n G]]", "AsymmetryError", 9, [2, 2], "is not symmetric"),
    ("[[P(alpha), A],\n [star, He(P(alpha)*G)]]", "NotAffineError", 8, [2, 2], "new unknown"),
    ("[[P(alpha), A],\n [star, mu**2*I(n)]]", "NotAffineError", 8, [2, 2], "not affine"),
    ("[[P(alpha), A],\n [star, star]]", "DefinitionError", 8, [2, 2], "diagonal"),
    ("[[P(alpha), star],\n [star, P(alpha)]]", "DefinitionError", 7, [1, 2], "both star"),
    ("[[P(alpha), A],\n [2*star, P(alpha)]]", "DefinitionError", 8, [2, 1], "stands for a whole block"),
    ("[[P(alpha), A],\n [star, P(alpha) + 3]]", "DefinitionError", 8, [2, 2], "3*I(n)"),
    ("[[P(alpha), A],\n [star, Q]]", "DefinitionError", 8, [2, 2], "NameError: name 'Q' is not defined"),
    ("[[P(alpha), A],\n [star, alpha + 1]]", "DefinitionError", 8, [2, 2], "TypeError"),
    ("[[P(alpha), A],\n [star]]", "DefinitionError", 7, None, "row 2 has 1 blocks"),
    ("P(alpha)\n + B", "ShapeError", 7, [1, 1], "do not add"),
    ("[[P(alpha), B + B.T],\n [star, P(alpha)]]", "ShapeError", 7, [1, 2], "n against m"),
    ("P(alpha) + Q", "DefinitionError", 7, [1, 1], "'Q' is not defined"),
]  # fmt: skip


@pytest.mark.parametrize(("rows", "kind", "line", "block", "words"), FAULTS)
def test_a_fault_is_told_once_at_its_line(
    rows: str, kind: str, line: int, block: list[int] | None, words: str, tmp_path: Path
) -> None:
    (found,) = [one for one in findings(stated(rows), tmp_path) if one["fault"]]
    assert (found["kind"], found["line"], found["block"]) == (kind, line, block)
    assert words in found["message"]
    assert "\n" not in found["message"]


def test_all_faults_are_told(tmp_path: Path) -> None:
    text = HEAD + "\n".join(
        [
            "E = A + 1",
            "lemma = PD([",
            "    [P(alpha), 0, A*G*B],",
            "    [star, E, Gg],",
            "    [star, A.T*B*A, He(G*P(alpha)) - P(alpha.next)],",
            "])",
            "theorem = Theorem(",
            "    minimise=mu,",
            '    lmis={"lemma": lemma, "P": PD(P(alpha) + mu*P(alpha)), "mu": PD([[mu*I(m), 0]])},',
            '    reports={"gamma": sqrt(mu), "delta": Scalar("delta")},',
            '    recover={"K": Matrix("K", n, n)},',
            '    guarantees=[Bound("l2 gain", DiscreteSystem(A, B, A, 0), "peak")],',
            "    " + TAIL,
        ]
    )
    told = {(one["line"], one["kind"], one["lmi"] or "/".join(one["part"])) for one in findings(text, tmp_path)}
    assert told == {
        (7, "DefinitionError", ""),
        (9, "ShapeError", "lemma"),
        (10, "DefinitionError", "lemma"),
        (11, "ShapeError", "lemma"),
        (11, "NotAffineError", "lemma"),
        (15, "NotAffineError", "P"),
        (15, "DefinitionError", "mu"),
        (16, "DefinitionError", "reports/delta"),
        (17, "DefinitionError", "recover/K"),
        (18, "DefinitionError", "guarantees/peak/D"),
        (18, "DefinitionError", "guarantees/peak"),
    }


@pytest.mark.parametrize(
    ("argument", "kind", "words"),
    [
        ("minimise=mu**2", "NotAffineError", "mu**2 is not affine in mu"),
        ('minimise="mu"', "DefinitionError", "'mu'"),
        ('recover={"K": A*B*A}', "ShapeError", "do not multiply"),
        ("assumes=[Schur(B, because='')]", "ShapeError", "B(alpha) is n x m; only a square matrix is stable"),
        ("bisect='eps'", "DefinitionError", "'eps' is no bisection; write Bisection(eps, 'maximise')"),
        ("bisect=Bisection(mu, 'maximise')", "DefinitionError", "mu is no given scalar of the LMIs"),
        ("bisect=Bisection(mu, 'max')", "DefinitionError", "is no bisection"),
        (
            'reports={"g": mu}, guarantees=[Bound("L2 gain", DiscreteSystem(A, B, A, B), "g")]',
            "DefinitionError",
            "'L2 gain' is no norm that is known here; promise a bound of 'l2 gain' or 'energy to peak'",
        ),
        ("minimize=mu", "DefinitionError", "unexpected keyword argument 'minimize'"),
        ('variants={"v": Variant("v", constant=["P"])}', "DefinitionError", "the unknowns themselves"),
    ],
)
def test_faults_outside_the_lmis(argument: str, kind: str, words: str, tmp_path: Path) -> None:
    rows = "[[P(alpha), (A + G)*B], [star, mu*I(m)]]"
    (found,) = [one for one in findings(stated(rows, "\n" + argument), tmp_path) if one["fault"]]
    assert (found["kind"], found["line"]) == (kind, 8 if "minimize" not in argument else 7)
    assert words in found["message"]


def test_what_follows_from_a_failure_is_not_told(tmp_path: Path) -> None:
    text = SOUND.replace('Symmetric("P", n)', 'Symetric("P", n)')
    (found,) = findings(text, tmp_path)
    assert (found["line"], "did you mean Symmetric?" in found["message"]) == (5, True)


@pytest.mark.parametrize(
    ("declaration", "words"),
    [
        ('E = Data("E", n, m)', "the data E"),
        ('H = Matrix("H", n, n)', "the unknown H"),
        ('nu = Scalar("nu")', "the scalar unknown nu"),
        ('eps = given("eps")', "the given scalar eps"),
        ('beta = Box("beta")', "the parameter beta"),
        ('q, = dims("q")', "the dimension q"),
    ],
)
def test_unused_declarations_are_no_faults(declaration: str, words: str, tmp_path: Path) -> None:
    (found,) = findings(SOUND.replace("theorem =", f"{declaration}\ntheorem ="), tmp_path)
    assert (found["fault"], found["kind"], found["line"]) == (False, "unused", 7)
    assert words in found["message"]


def test_an_lmi_that_is_not_stated_is_told(tmp_path: Path) -> None:
    """Of two entries of one name Python keeps the last, and the first would be lost without a word."""
    text = SOUND.replace(
        "theorem = Theorem(lmis={", 'theorem = Theorem(lmis={"b": PD(P(alpha)),\n    "b": PD(mu*I(m)), '
    )
    (found,) = findings(text, tmp_path)
    assert (found["fault"], found["kind"], found["line"]) == (False, "unused", 7)
    assert "an LMI is written and not stated" in found["message"]


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("x = (1\n", 1, "was never closed"),
        ("x = 1\nimport nothing_of_that_name\n", 2, "ModuleNotFoundError"),
        ("raise SystemExit(3)\n", 1, "SystemExit"),
        ("x = 1\n", None, "there is no theorem in the file"),
        ("\n\ndef f():\n    return 1/0\n\nf()\n", 4, "division by zero"),
        ("\udcff", 1, "utf-8"),
    ],
)
def test_python_that_fails(text: str, line: int | None, words: str, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_bytes(text.encode(errors="surrogateescape"))
    result = CliRunner().invoke(main, ["check", str(tmp_path / "mine.py"), "--json"])
    assert result.exit_code == 1
    (found,) = json.loads(result.stdout)["findings"]
    assert found["line"] == line
    assert words in found["message"]


def test_the_matrix_is_shown_with_its_shapes(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(stated("[[P(alpha), G], [star, mu*I(m)]]"), encoding="utf-8")
    result = CliRunner().invoke(main, ["check", str(tmp_path / "mine.py")])
    lines = [line.split() for line in result.stdout.splitlines()]
    assert ["a", "≻", "0"] in lines
    assert ["n", "m"] in lines
    assert ["n", "P(alpha)", "✗", "G(alpha)"] in lines
    assert ["m", "⋆", "mu*I(m)"] in lines
    assert f"ShapeError: {tmp_path / 'mine.py'}:7: mine / a / block (1,2)" in result.stdout
    assert lines[-1] == ["1", "fault,", "2", "unused", "declarations"]


def test_a_matrix_wider_than_the_terminal_is_listed() -> None:
    result = CliRunner().invoke(main, ["check", "chen2006.theorem6"])
    assert result.exit_code == 0
    assert "  (5,2)   2*nx x 4*nx" in result.stdout
    assert all(len(line) <= 140 for line in result.stdout.splitlines())


def test_a_plant_is_checked_beside_the_theorem(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(SOUND, encoding="utf-8")
    plant = tmp_path / "plant.toml"
    plant.write_text("[parameters]\nbeta = { simplex = 2 }\n[matrices]\nA = [[1, 2]]\nC = [[1]]\n", encoding="utf-8")
    words = ["check", str(tmp_path / "mine.py"), "--plant", str(plant), "--json"]
    result = CliRunner().invoke(main, words)
    assert result.exit_code == 1
    messages = [one["message"] for one in json.loads(result.stdout)["findings"]]
    for wanted in ("alpha has no domain", "B (n x m) is missing", "gives the matrix C", "A of plant is 1 x 2"):
        assert len([message for message in messages if wanted in message]) == 1
    plant.write_text("[parameters]\nalpha = { simplex = 2 }\n[matrices]\nA = [[1]]\nB = [[1]]\n", encoding="utf-8")
    assert CliRunner().invoke(main, words).exit_code == 0


@pytest.mark.parametrize(("name", "words"), [("nothing", "'lmic list'"), ("./nothing.py", "cannot be read")])
def test_no_such_theorem(name: str, words: str) -> None:
    result = CliRunner().invoke(main, ["check", name])
    assert result.exit_code == 1
    assert words in result.stderr
    assert result.stdout == ""


def test_files_that_are_more_than_a_list_of_statements(tmp_path: Path) -> None:
    """Functions, loops, classes and names of one's own are run as they are written."""
    text = HEAD + "\n".join(
        [
            "from lmic import dsl",
            "def lmi(matrix):",
            "    gain = 2*matrix",
            "    return dsl.PD([[matrix, (sum := gain + matrix)], [star, sum]])",
            "class Kept:",
            "    Q = dsl.Symmetric('Q', n)",
            "    stated = PD([[Q, 0], [star, Q]])",
            "unknowns = [Symmetric(f'R{k}', n) for k in range(2)]",
            "lmis = {f'R{k}': lmi(R) for k, R in enumerate(unknowns)} | {'Q': Kept.stated}",
            "lmis['a'] = PD([*[[P(alpha), (A + G)*B]], [star, mu*I(m)]])",
            "theorem = Theorem(lmis=lmis, " + TAIL,
        ]
    )
    assert findings(text, tmp_path) == []
    wrong = findings(text.replace("return dsl.PD([[matrix", "return dsl.PD([[G"), tmp_path)
    assert [(one["line"], one["lmi"], one["block"]) for one in wrong] == [(10, "R0", [1, 1]), (10, "R1", [1, 1])]


def test_a_plant_waits_for_a_sound_theorem(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(stated("[[G]]"), encoding="utf-8")
    result = CliRunner().invoke(main, ["check", str(tmp_path / "mine.py"), "--plant", "plant.toml"])
    assert result.exit_code == 1
    assert "plant.toml is checked once the theorem has no fault" in result.stdout


PIECES = ["star", "A", "P", "0", "mu", ".T", "*", "+", "-", "[", "]", "(", ")", ",", "He(", "alpha", "None", "'x'", "n"]


def mutated(text: str, random: Random) -> str:
    """A file with one to three of its words removed, replaced by another, or joined by one."""
    words = re.findall(r"\w+|\s+|[^\w\s]", text)
    for _ in range(random.choice([1, 1, 2, 3])):
        place = random.randrange(len(words))
        words[place] = random.choice(["", random.choice(words), words[place] + random.choice(PIECES)])
    return "".join(words)


@pytest.mark.filterwarnings("ignore::SyntaxWarning")
@pytest.mark.parametrize("seed", range(5))
def test_what_is_sound_is_what_compiles(seed: int, tmp_path: Path) -> None:
    """A file has no fault exactly where its LMIs can be lowered and split into terms."""
    random, path = Random(seed), tmp_path / "mine.py"
    texts = [file.read_text("utf-8") for name, file in library.files().items() if name.startswith("standard.")]
    for _ in range(30):
        path.write_text(mutated(random.choice(texts), random), encoding="utf-8")
        checkup = check(library.locate(path))
        assert not any("\n" in finding.reason for finding in checkup.findings)
        display.record(checkup)
        try:
            theorem = library.load_file(path)
            term_lists(lower(theorem))
            demand(objective(theorem))
        except LmicError:
            assert not checkup.sound
        else:
            assert checkup.sound, checkup.findings
