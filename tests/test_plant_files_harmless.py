"""A plant file runs no code, opens no other file, and exhausts neither memory nor patience."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from plant_file_tools import TOML, write, write_mat, write_npz

from lmic.errors import PlantError
from lmic.plants.expressions import MAX_TOTAL_TERMS
from lmic.plants.files import read_plant

SIMPLEX = "[parameters.a]\nsimplex = 3\n[matrices]\n"


def row(*entries: str) -> str:
    return f"{SIMPLEX}A = [[{', '.join(map(json.dumps, entries))}]]"


def test_a_few_kilobytes_of_powers_are_refused_at_once(tmp_path: Path) -> None:
    """Each entry is within its own limits; it is their sum that would take half a minute."""
    file = write(tmp_path / "plant.toml", row(*(f"(a1 + a2 + {n}*a3)**29" for n in range(1, 140))))
    started = time.process_time()
    with pytest.raises(PlantError) as caught:
        read_plant(file)
    assert time.process_time() - started < 15
    assert f"{file}: matrix A: entry (1,44): with '(a1 + a2 + 44*a3)**29'" in str(caught.value)
    assert f"more than {MAX_TOTAL_TERMS} terms" in str(caught.value)


def test_the_budget_is_that_of_all_matrices_together(tmp_path: Path) -> None:
    half = ", ".join(['"(a1 + a2 + a3)**29"'] * 25)
    file = write(tmp_path / "plant.toml", f"{SIMPLEX}A = [[{half}]]\nB = [[{half}]]")
    with pytest.raises(PlantError, match=r"matrix B: entry \(1,19\)"):
        read_plant(file)


def test_numbers_cost_nothing_of_it(tmp_path: Path) -> None:
    file = write(tmp_path / "plant.json", json.dumps({"matrices": {"A": [["1/3", "-2/7", 0.5]] * 10_000}}))
    assert read_plant(file).matrices["A"].shape == (10_000, 3)


#: what the interpreter is told of while the file named first is read
WATCH = """
import os, sys
from lmic.plants.files import read_plant
read_plant(sys.argv[2])  # whatever is imported or compiled once
seen = []
def watch(event, arguments):
    if event in ("open", "exec", "import") or event.split(".")[0] in ("os", "subprocess", "socket", "ctypes", "shutil"):
        seen.append((event, str(arguments[0])))
sys.addaudithook(watch)
read_plant(sys.argv[1])
print(seen)
"""


@pytest.mark.parametrize("suffix", [".toml", ".json", ".npz", ".mat"])
def test_reading_opens_one_file_and_runs_nothing(suffix: str, tmp_path: Path) -> None:
    secret = tmp_path / "secret.toml"
    secret.write_text("C = [[1]]")
    for name in ("plant", "first"):
        file = tmp_path / f"{name}{suffix}"
        match suffix:
            case ".toml":
                write(file, TOML.replace("made up", str(secret)))
            case ".json":
                write(file, json.dumps({"source": str(secret), "matrices": {"C": [[f"{len(name)} + 1/2"]]}}))
            case ".npz":
                write_npz(file, C=np.ones((1, 1)), source=str(secret))
            case ".mat":
                write_mat(file, C=np.ones((1, 1)), source=str(secret))
    words = [sys.executable, "-c", WATCH, str(tmp_path / f"plant{suffix}"), str(tmp_path / f"first{suffix}")]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == str([("open", str(tmp_path / f"plant{suffix}"))])


#: reads every file named, in an address space of a fixed size
SMALL = """
import resource, sys, time
from lmic.errors import PlantError
from lmic.plants.files import read_plant
resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
for name in sys.argv[1:]:
    start = time.process_time()
    try:
        read_plant(name)
        word = "read"
    except PlantError as error:
        word = "refused"
    print(word, round(time.process_time() - start, 2), name)
"""

GREEDY = {
    "functions": row(*("+".join(f"sin({n}*a1 + {k}*a2)" for k in range(40)) for n in range(30))),
    "reciprocals": row(*("+".join(f"1/(a1 + {n}*a2 + {k})" for k in range(40)) for n in range(30))),
    "powers of reciprocals": row(*(f"(1/(a1 + {n}) + 1/(a2 + {n}))**40" for n in range(200))),
    "powers": row(*(f"(a1 + {n}*a2)**50*(1 + a3)**9" for n in range(200))),
    "numbers": row(*(f"({n}.123456789*a1 + 1)**50" for n in range(300))),
    "nesting": f"C = {'[' * 50_000}",
    "tables": "".join(f"[a{'.b' * 20}{n}]\n" for n in range(5000)),
    "vertices": '[parameters.a]\nsimplex = 1000\n[matrices]\nA = { vertices = ['
    + ",".join(f"[[{','.join(str(n + k) for k in range(300))}]]" for n in range(1000))
    + "]}",
    "exponentials": f'[parameters.h]\nbox = {{ h = [0, 1] }}\n[matrices]\nF = {np.ones((30, 30)).tolist()}\n'
    'Phi = { exponential = "F", time = "h" }',
    "model": '[parameters.a]\nsimplex = 9\n[matrices]\nA = [["'
    + "*".join(["(a1+a2+a3)"] * 5)
    + '"]]\nB = [[1]]\nC = [[1]]\nD = [[0]]\n[fractional]\nmodel = "lft"\ndelta = "Delta"\n'
    'system = [["A", "B", "B_D"], ["C", "D", "D_D"], ["C_D", "D_z", "D_Dz"]]',
}  # fmt: skip


def test_greedy_files_get_by_with_two_gigabytes(tmp_path: Path) -> None:
    """Address space, libraries included, is bounded by the system; each file is read or refused, and soon."""
    for name, text in GREEDY.items():
        write(tmp_path / f"{name}.toml", text)
    files = [str(tmp_path / f"{name}.toml") for name in GREEDY]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}  # each of its threads takes some, on many cores all
    command = [sys.executable, "-c", SMALL, *files]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stderr
    for line in done.stdout.splitlines():
        assert float(line.split()[1]) < 15, line
    assert len(done.stdout.splitlines()) == len(GREEDY)
