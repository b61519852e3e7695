"""Fuzzing: inputs made from a seed, and the three things asked of every one of them.

An input is read, or refused in one sentence of an lmic error; it ends soon; and it leaves no half-written file.
The seed of a case is its kind and number, so the same cases run everywhere; one that fails prints its input, which
belongs into ``fuzz_corpus`` once the defect is mended.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from random import Random
from typing import Any

import pytest

from lmic.errors import LmicError

CORPUS = Path(__file__).with_name("fuzz_corpus")
#: seconds for one case, many times what the slowest takes, for a machine that has other work
LIMIT = 20.0
#: characters of a message
LONGEST = 1200


class SlowError(BaseException):
    """A case took too long; not an Exception, so that nothing catches it."""


@contextmanager
def limited(seconds: float = LIMIT) -> Iterator[None]:
    """Raise SlowError inside after a time."""

    def ring(number: int, frame: Any) -> None:
        raise SlowError

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def check(what: str, content: Any, action: Callable[[], Any], allowed: type[LmicError] = LmicError) -> bool:
    """Do it, and fail with the input where it ends in anything but success or one sentence; whether it was success."""
    try:
        with limited():
            action()
    except allowed as error:
        message = str(error)
        if "\n" in message or not message or len(message) > LONGEST:
            pytest.fail(f"{what}: no sentence: {message!r}\n{content!r}")
        return False
    except SlowError:
        pytest.fail(f"{what}: took more than {LIMIT} s\n{content!r}")
    except BaseException as error:
        raise AssertionError(f"{what}: {type(error).__name__}: {error}\n{content!r}") from error
    return True


def seeds(kind: str, count: int) -> Iterator[tuple[str, Random]]:
    """The cases of a kind, each with its own generator."""
    for number in range(count):
        yield f"{kind} {number}", Random(f"{kind} {number}")


def corpus(kind: str) -> list[Path]:
    """The inputs that once failed."""
    return sorted((CORPUS / kind).iterdir()) if (CORPUS / kind).is_dir() else []


def mutated(random: Random, content: bytes, words: Sequence[bytes]) -> bytes:
    """A few changes anywhere: a word put in, bytes lost, doubled, moved or changed, the end missing."""
    for _ in range(random.randint(1, 4)):
        place, length = random.randint(0, len(content)), random.choice([1, 1, 2, 5, 20])
        middle = content[place : place + length]
        match random.randrange(6):
            case 0:
                content = content[:place] + random.choice(words) + content[place:]
            case 1:
                content = content[:place] + content[place + length :]
            case 2:
                content = content[:place] + middle + content[place:]
            case 3:
                content = content[:place] + random.choice(words) + content[place + length :]
            case 4:
                content = content[:place] + bytes(random.randrange(256) for _ in middle) + content[place + length :]
            case _:
                other = random.randint(0, len(content))
                content = content[:other] + middle + content[other:]
    return content[: random.randint(0, len(content))] if random.random() < 0.1 else content


# Theorem files --------------------------------------------------------------------------------------

HEAD = """from lmic.dsl import *
n, m, k = dims("n m k")
alpha, beta = Simplex("alpha", step="free"), Box("beta", "r1 r2")
A, B, C, D = Data("A", n, n)(alpha), Data("B", n, m)(alpha), Data("C", m, n), Data("D", n, n)(beta)
P, G, X, S = Symmetric("P", n), Matrix("G", n, n)(alpha), Matrix("X", n, m), Symmetric("S", m)
mu, nu, eps = Scalar("mu"), Scalar("nu"), given("eps")
"""
LEAVES = (
    *(
        "A",
        "B",
        "C",
        "D",
        "A.T",
        "B.T",
        "C.T",
        "P",
        "P(alpha)",
        "P(alpha.next)",
        "P(beta)",
        "G",
        "G.T",
        "X",
        "X.T",
        "S",
    ),
    *("I(n)", "I(m)", "I(2)", "zeros(n, m)", "mu*I(n)", "eps*I(m)", "0", "1", "mu", "nu", "eps", "star", "alpha"),
    *("P(A)", "'P'", "None", "dot(P(beta))", "[[A]]", "I(0)", "I(-1)", "1.5", "Rational(1, 3)", "sqrt(mu)", "n"),
)


def expression(random: Random, depth: int) -> str:
    """An expression of the definition language, mostly ill-formed."""
    if depth == 0 or random.random() < 0.25:
        return random.choice(LEAVES)

    def inner() -> str:
        return expression(random, depth - 1)

    match random.randrange(11):
        case 0 | 1:
            return f"({inner()} {random.choice('+-')} {inner()})"
        case 2 | 3:
            return f"{inner()}*{inner()}"
        case 4:
            return f"He({inner()})"
        case 5:
            return f"{random.choice(['inv', 'trace', 'dot', 'I', 'diag'])}({inner()})"
        case 6:
            return f"kron({inner()}, {inner()})"
        case 7:
            return f"block([[{inner()}, {inner()}], [{inner()}, {inner()}]])"
        case 8:
            return f"-{inner()}" if random.random() < 0.5 else f"{inner()}**2"
        case 9:
            return f"{inner()}/{inner()}"
        case _:
            return f"({inner()}){random.choice(['.T', '(alpha)', '[0]', '.shape', '.next'])}"


def sound_block(random: Random, row: int, column: int, sizes: Sequence[str]) -> str:
    """A block that fits a row and a column, affine in the unknowns."""
    if row > column:
        return "star"
    square = {
        "n": ["P(alpha)", "He(A*G)", "I(n)", "mu*I(n)", "He(A.T*P(alpha))", "D + D.T", "He(D.T*G)", "P(alpha.next)"],
        "m": ["S", "He(C*X)", "mu*I(m)", "eps*I(m)", "S - nu*I(m)", "He(B.T*X)"],
    }
    rectangular = {
        "nn": ["A*P(alpha)", "G", "0", "G.T*A", "D*G", "eps*A"],
        "nm": ["B", "X", "0", "P(alpha)*B", "A*X", "X*S*0"],
        "mn": ["C", "X.T", "0", "C*G", "B.T*P(alpha)"],
        "mm": ["S", "C*X", "0", "C*B"],
    }
    return random.choice(square[sizes[row]] if row == column else rectangular[sizes[row] + sizes[column]])


def definition(random: Random) -> str:
    """A theorem file: blocks that fit, with now and then one that does not, or blocks of any kind."""
    size = random.choice([1, 2, 2, 3])
    sizes = [random.choice("nm") for _ in range(size)]
    wild = random.random() < 0.4
    rows = [[sound_block(random, i, j, sizes) for j in range(size)] for i in range(size)]
    for _ in range(random.choice([0, 0, 1, 2])):
        rows[random.randrange(size)][random.randrange(size)] = expression(random, 2)
    if wild:
        rows = [
            [expression(random, random.randint(0, 3)) for _ in range(size)]
            for _ in range(size if random.random() < 0.9 else size + 1)
        ]
    text = ", ".join(f"[{', '.join(row)}]" for row in rows)
    minimise, reports = "None", "{}"
    if random.random() < 0.3:
        minimise = random.choice(["mu", "mu", "mu + nu", "mu**2", "P", "eps", "trace(P)", "-mu", "0*mu"])
        reports = random.choice(["{}", "{'gamma': sqrt(mu)}", "{'v': 1/mu}", "{'v': P}"])
    sense = random.choice(["PD", "PD", "ND"])
    return (
        f"{HEAD}theorem = Theorem(lmis={{'a': {sense}([{text}])}}, minimise={minimise}, reports={reports},\n"
        "    source=Source('N. N.', 'Notes', 'unpublished', 2026))\n"
    )


# Plant files ----------------------------------------------------------------------------------------

NUMBERS = (
    *("0", "1", "-1", "0.5", "1e-3", "1e300", "-1e-300", "1e999", "nan", "inf", "1/3", "1/0", "2**50", "9" * 40),
    *("'1/3'", "'a1'", "'a1*a2'", "'(a1 + a2)**20'", "'sin(r1)'", "'exp(r1*r2)'", "'c'", "'z'", "''", "'1 +'", "true"),
    *("[1]", "{}", "1979-05-27", "0x10", "'a1**-1'", "'where(r1 > 0, 1, 0)'", "'1/(a1 - a1)'", "'((((a1'", "'log(r1)'"),
)
SOUND = ("0", "1", "-1", "0.5", "1e-3", "'1/3'", "'a1'", "'a1*a2 + 1'", "'c/2'", "'-r1**2'", "'sin(r1)'")
TOML_WORDS = tuple(
    word.encode()
    for word in (
        *NUMBERS,
        *("[", "]", "{", "}", "=", ",", '"', "\n", ".", "[parameters.b]\n", "simplex = 3\n", "box = { r1 = [0, 1] }\n"),
        *("step = 0.1\n", "rate = [-1, 1]\n", "step = 'free'\n", "parameter = 'b'", "vertices = ", "exponential = 'A'"),
        *("time = 'r1'", "[fractional]\nmodel = 'nft'\n", "delta = 'Delta'\n", "\x00", "é", "\\u0000", "name = 1\n"),
    )
)


def matrix(random: Random, depth: int = 2) -> str:
    rows, columns = random.randint(1, 3), random.randint(1, 3)
    body = [[random.choice(NUMBERS if random.random() < 0.05 else SOUND) for _ in range(columns)] for _ in range(rows)]
    if random.random() < 0.03:
        body[0] = body[0][1:]
    shown = "[" + ", ".join(f"[{', '.join(row)}]" for row in body) + "]"
    match random.randrange(8) if depth else 7:
        case 0 | 1:
            vertices = ", ".join(matrix(random, 0) for _ in range(random.randint(1, 3)))
            owner = random.choice(["", "", ", parameter = 'a'", ", parameter = 'b'"])
            return f"{{ vertices = [{vertices}]{owner} }}"
        case 2:
            name = random.choice(["A", "B", "F", "M0"])
            return f"{{ exponential = '{name}', time = '{random.choice(['r1', 'r1*r2', 'a1', '1', 'z'])}' }}"
    return shown


def plant_toml(random: Random) -> str:
    """A plant file with the right keys, and anything as their values."""
    parts = [f"name = {random.choice(['made', '1', chr(34) * 2])!r}"]
    parts += [f"[parameters.a]\nsimplex = {random.choice([2, 3, 2, 2, 2, 2, 2, 0, 10**6])}"]
    if random.random() < 0.9:
        ends = random.choice(["[0, 1]", "[0, 1]", "[0, 1]", "[-1, '1/3']", "[1, 0]", "[0, 0]", "0", "['r1', 2]"])
        parts.append(f"[parameters.r]\nbox = {{ r1 = {ends}, r2 = [0, 1] }}")
        parts += random.choice([[], [], [], ["step = 0.1"], ["rate = [-1, 1]"], ["rate = { r1 = 1 }"], ["step = [1]"]])
    if random.random() < 0.9:
        parts.append(f"[scalars]\nc = {random.choice(NUMBERS if random.random() < 0.2 else SOUND[:6])}")
    parts.append("[matrices]")
    names = random.sample([*"ABCDEFGH", "M0", "pi"], random.randint(0, 4))
    parts += [f"{name} = {matrix(random)}" for name in names]
    if random.random() < 0.15:
        model = random.choice(["nft", "lft", "x"])
        parts.append(f"[fractional]\nmodel = '{model}'\nsystem = [['A', 'B', 'E'], ['C', 'D', 'H']]\ndelta = 'Delta'")
    return "\n".join(parts) + "\n"


# Command lines --------------------------------------------------------------------------------------

VALUES = (
    *(
        "",
        "0",
        "1",
        "-1",
        "2",
        "nan",
        "1e999",
        "1/3",
        "eps=1",
        "eps=",
        "=1",
        "eps",
        "eps=1:6",
        "eps=6:1",
        "rho=5",
        "rho=(0)",
    ),
    *("P=constant", "P=2", "P=-1", "P=1; rho1", "P=99", "Q=1", "rho=polya", "rho=vertices", "rho=magic", "alpha=1"),
    *(
        "rho=chebyshev:3",
        "rho=random:2",
        "rho=0",
        "rho=(1, 0); (0, 1)",
        "rho=()",
        "h=rigorous",
        "h=x",
        "b=a",
        "rho+=rho",
    ),
    *("polya=0,1", "eps=0.1:6:3", "log:1:2:3", "grid:rho=2", "dependence:P=1", "n=2", "n=0", "n=99999999", "nw=x"),
    *("clarabel", "nobody", "scs", "-", "--", "é", " ", "a" * 300, "51", "1000000", "--help", "-o", "a=b=c"),
)
COMMANDS: Mapping[str, tuple[str, ...]] = {
    "list": ("--json",),
    "show": (
        "--plant",
        "--vertices",
        "--set",
        "--dependence",
        "--size",
        "--polya",
        "--grid",
        "--relax",
        "--tie",
        "--json",
    ),
    "latex": ("--document", "--mathml", "-o", "--json"),
    "solve": (
        "--plant",
        "--set",
        "--dependence",
        "--polya",
        "--grid",
        "--cover",
        "--solver",
        "--search",
        "-o",
        "--refine",
    ),
    "verify": ("--theorem", "--json"),
    "refute": ("--plant", "--set", "--below", "--above", "--polya", "-o", "--json"),
    "export": ("--plant", "--set", "--dependence", "--relax", "--polya", "-o", "--json"),
    "diagnose": ("--plant", "--set", "--polya", "--grid", "--solver", "--patience", "--json"),
    "sweep": (
        "--plant",
        "--over",
        "--set",
        "--search",
        "-o",
        "--jobs",
        "--table",
        "--plot",
        "--report",
        "--least-over",
    ),
    "check": ("--plant", "--set", "--json"),
    "new": ("-o",),
    "report": ("-o", "--plant"),
    "reproduce": ("-o", "--certify"),
    "gallery": ("--nothing",),
}
FLAGS = frozenset({"--json", "--document", "--mathml"})


def command_line(random: Random, names: Sequence[str], files: Sequence[str]) -> list[str]:
    """A command with its options in any number and order, and values of the right or of any kind."""
    command = random.choice([*COMMANDS, "nothing"])
    words = [command]
    if random.random() < 0.92 and command != "list":
        words.append(random.choice([*names, *files, *VALUES]))
    options = COMMANDS.get(command, ("--json",))
    for _ in range(random.randint(0, 4)):
        option = random.choice(options)
        words.append(option)
        if option not in FLAGS or random.random() < 0.05:
            words.append(random.choice(files if option in ("--plant", "-o", "--table", "--plot") else VALUES))
    if command == "sweep":
        words += ["--jobs", "1"]
    return words
