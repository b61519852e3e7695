"""The benchmarks: they load, and what they measure in CVXPY and PICOS is lmic's own problem."""

from __future__ import annotations

import subprocess
import sys

from documents import ROOT

CODE = """
from comparators import Cvxpy, Picos
from problems import polytopic_filter
import certify, page
from run import compare
row = compare(polytopic_filter(2, 2), [Cvxpy(), Picos()], True, 1)
assert set(row["optimum"]) == {"lmic", "CVXPY", "PICOS"}, row
assert row["same"], row
"""


def test_all_tools_are_given_the_same_problem() -> None:
    command = [sys.executable, "-c", CODE]
    found = subprocess.run(command, cwd=ROOT / "benchmarks", capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr
