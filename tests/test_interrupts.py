"""Ctrl-C in every long command, in a process of its own: what was done is kept and said, and nothing else is left."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from lmic.certify.certificate_file import read_certificate
from lmic.library import root

EXAMPLE = root() / "peixoto2025" / "example1.toml"
CERTIFICATE = root().parent / "certificates" / "peixoto2025.theorem1.eps10.json"
LAG = """
[parameters.rho]
box = { rho1 = [0, 1] }
rate = 0
[matrices]
A = [[-1, "rho1"], [0, -2]]
"""

#: 1/(1 − a) is the gain
GAIN = """
[parameters.rho]
simplex = 1
[scalars]
a = 0
[matrices]
A = [["a"]]
B = [[1]]
C = [[1]]
D = [[0]]
"""

#: lmic as a program that is sent Ctrl-C when it calls a certain function for a certain time
PROGRAM = """
import os, signal, sys
from importlib import import_module
module, name, left = sys.argv[1], sys.argv[2], int(sys.argv[3])
home = import_module(module)
wanted = getattr(home, name)
def called(*arguments, **options):
    global left
    left -= 1
    if left == 0:
        os.kill(os.getpid(), signal.SIGINT)
    return wanted(*arguments, **options)
setattr(home, name, called)
from lmic.cli import main
main(sys.argv[4:])
"""


def interrupted(folder: Path, place: str, *words: str, at: int = 1) -> tuple[str, str]:
    """What a command printed that was interrupted at a call of module:function, and its one line about that."""
    module, _, name = place.partition(":")
    line = [sys.executable, "-c", PROGRAM, module, name, str(at), *words]
    environment = {**os.environ, "PYTHONIOENCODING": "utf-8"}
    done = subprocess.run(
        line, capture_output=True, text=True, encoding="utf-8", cwd=folder, check=False, timeout=300, env=environment
    )
    assert done.returncode == 130, (done.stdout, done.stderr)
    (said,) = done.stderr.splitlines()
    assert said.startswith("interrupted; ")
    assert not [path for path in folder.rglob("*") if path.name.startswith(".")]
    return done.stdout, said.removeprefix("interrupted; ")


@pytest.mark.parametrize(
    ("words", "place"),
    [
        (("solve", "peixoto2025.theorem1", "--set", "eps=10", "-o", "F.npz"), "lmic.solve.scaling:rescaled"),
        (("refute", "peixoto2025.theorem1", "--set", "eps=10", "--below", "1", "-o", "C.json"), "lmic.pipeline:run"),
        (("export", "peixoto2025.theorem1", "--set", "eps=10", "-o", "F.cbf"), "lmic.pipeline:assemble"),
    ],
)
def test_before_anything_is_known(words: tuple[str, ...], place: str, tmp_path: Path) -> None:
    out, said = interrupted(tmp_path, place, *words, "--plant", str(EXAMPLE))
    assert out == ""
    assert said == "nothing was written, and the same command begins anew"
    assert not list(tmp_path.iterdir())


def test_verify(tmp_path: Path) -> None:
    out, said = interrupted(tmp_path, "lmic.certify.verify:_finite", "verify", str(CERTIFICATE))
    assert (out, said) == ("", "nothing was written, and the same command begins anew")


def test_a_proof_that_is_not_finished_leaves_the_number(tmp_path: Path) -> None:
    words = (
        "solve",
        "peixoto2025.theorem1",
        "--set",
        "eps=10",
        "--plant",
        str(EXAMPLE),
        "--certify",
        "C.json",
        "--json",
    )
    out, said = interrupted(tmp_path, "lmic.certify.certify:blank", *words)
    record = json.loads(out)
    assert record["reports"]["gamma"] == pytest.approx(float(read_certificate(CERTIFICATE).upper.reports["gamma"]))
    assert "upper" not in record
    assert "numerical" in said
    assert not list(tmp_path.iterdir())


def test_a_line_search_says_its_best_and_where_to_go_on(tmp_path: Path) -> None:
    (tmp_path / "plant.toml").write_text(GAIN)
    words = ("solve", "standard.bounded_real_discrete", "--plant", "plant.toml", "--search", "a=0:0.8")
    _, said = interrupted(tmp_path, "lmic.sweeps.search:finish", *words, at=4)
    assert said.startswith("after 3 solves a = 0 is the best, with the objective 1")
    assert said.endswith("go on with --search a=0:0.1")


def test_a_bisection_says_its_bracket(tmp_path: Path) -> None:
    (tmp_path / "plant.toml").write_text(LAG)
    words = (
        "solve",
        "standard.decay_rate_continuous",
        "--plant",
        "plant.toml",
        "--search",
        "beta=0:4",
        "--dependence",
        "P=constant",
    )
    _, said = interrupted(tmp_path, "lmic.sweeps.search:finish", *words, at=4)
    assert said == "after 3 solves beta = 0 is the best; go on with --search beta=0:2"


def test_reproduce_keeps_the_numbers_that_are_known_and_their_certificates(tmp_path: Path) -> None:
    words = ("reproduce", "peixoto2025.table1", "mustafa", "-o", "out", "--certify", "proofs")
    _, said = interrupted(tmp_path, "lmic.papers.reproduce:_solved", *words, at=3)
    assert "2 numbers are in out/index.html; go on with: lmic reproduce " in said
    page = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert "mustafa" in page.lower()
    assert len(list((tmp_path / "proofs").iterdir())) == 2
    left = said.partition("lmic reproduce ")[2]
    assert left.startswith("mustafa.")
    assert "peixoto2025.table1." in left
    assert "figure3" not in left
    assert left.endswith(" -o out/rest")


def test_a_diagnosis_says_how_far_it_came(tmp_path: Path) -> None:
    (tmp_path / "plant.toml").write_text(LAG)
    words = ("diagnose", "standard.stability_continuous", "--plant", "plant.toml", "--polya", "rho=0")
    _, said = interrupted(tmp_path, "lmic.diagnosis.neighbours:compile", *words, at=3)
    assert said.startswith("1 of ")
    assert said.endswith("--patience makes it shorter")


def test_the_gallery_keeps_its_pages(tmp_path: Path) -> None:
    _, said = interrupted(tmp_path, "lmic.pages.gallery:statement", "gallery", "-o", "site", at=4)
    assert len(list((tmp_path / "site").iterdir())) == 3
    assert said.startswith("3 of ")
    assert "pages are in site" in said


#: one solver, interrupted while it computes: Clarabel after its first iteration, SCS, which would take hours, at once
SOLVING = """
import os, signal, sys, threading, time
import numpy as np, scipy.sparse as sps
from lmic.solve.cone import ConeData
from lmic.solve.registry import SOLVERS
from importlib import import_module
entry = SOLVERS[sys.argv[1]]
settings = {"eps_abs": 1e-15, "eps_rel": 1e-15, "max_iters": 10**8} if sys.argv[1] == "scs" else {}
generator, order, size = np.random.default_rng(0), 50, 300
identity = np.zeros(order * (order + 1) // 2)
identity[np.arange(order) * (np.arange(order) + 3) // 2] = 1
matrix = generator.standard_normal((len(identity), size))
data = ConeData(matrix.T @ identity, sps.csc_array(matrix), 50 * identity, np.array([order]))
solver = getattr(import_module(entry.module), entry.attribute)(**settings)
begun, pressed = threading.Event(), threading.Event()
def press():  # until it is noticed: before SCS listens, it is Python that hears it
    begun.wait()
    while running:
        os.kill(os.getpid(), signal.SIGINT)
        pressed.set()
        time.sleep(1)
running = True
threading.Thread(target=press, daemon=True).start()
if sys.argv[1] == "scs":
    begun.set()
else:
    import contextlib, lmic.solve.clarabel
    noticed = lmic.solve.clarabel.noticed
    @contextlib.contextmanager
    def watched():
        with noticed() as stop:
            def asked():  # after each iteration
                if begun.is_set():
                    pressed.wait()
                begun.set()
                return stop()
            yield asked
    lmic.solve.clarabel.noticed = watched
try:
    answer = solver(data)
    print("solved", answer.word)
except KeyboardInterrupt:
    running = False
    print("stopped" if begun.is_set() else "too soon")
assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
"""


@pytest.mark.parametrize("name", ["clarabel", "scs"])
def test_compiled_solvers_stop(name: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", SOLVING, name], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.stdout.strip().endswith("stopped"), done
