"""Measure lmic, CVXPY and PICOS on the same problems in one run, and write figures, plots and a page.

    python benchmarks/run.py [--quick] [--output reports]

Every time is the least of several runs. Compiling is measured in processor time with one BLAS thread, which a
machine that does other work at the same time changes little; solving in both processor and wall time.
"""

from __future__ import annotations

import os

# before numpy is loaded: with several threads processor time counts those that wait
for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import argparse
import json
import tracemalloc
import warnings
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from comparators import Cvxpy, Picos, Tool, written
from page import write_page
from problems import Problem, filter_2d, gridded, multi_simplex, polytopic_filter

from lmic.files import write_whole
from lmic.pages.report import machine
from lmic.pipeline import finish, prepare
from lmic.solve.solve import solve

#: relative difference up to which two optima are the same
SAME = 1e-5


def least(work: Callable[[], Any], runs: int) -> tuple[dict[str, float], Any]:
    """Least processor and wall time of several runs, and what the last one returned."""
    cpu, wall, result = [], [], None
    for _ in range(runs):
        began, started = process_time(), perf_counter()
        result = work()
        cpu.append(process_time() - began)
        wall.append(perf_counter() - started)
    return {"cpu": min(cpu), "wall": min(wall)}, result


def fresh(problem: Problem) -> Problem:
    """The same problem with a theorem object of which nothing is known yet."""
    return replace(problem, theorem=replace(problem.theorem))


def compile_lmic(problem: Problem, runs: int = 5) -> dict[str, Any]:
    """First compile, stage by stage, and its arrays; peak memory; the time of copying the arrays."""
    first, compiled = least(lambda: fresh(problem).compiled(), runs)
    binding = prepare(problem.theorem, problem.plant, problem.dependence)

    def again() -> Any:
        made = finish(binding, problem.given, problem.relaxation)
        return made.columns

    grid, columns = least(again, runs)
    arrays = (columns.data, columns.indices, columns.indptr)
    copy = least(lambda: [np.copy(array) for array in arrays], max(runs, 5))[0]
    tracemalloc.start()
    again()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    size = sum(array.nbytes for array in arrays)
    return {
        "lmis": len(compiled.orders),
        "unknowns": compiled.size,
        "entries": int(columns.nnz),
        "bytes": size,
        "peak": peak,
        "first": first,
        "new grid": grid,
        "copy": copy,
    }


def rebind(sizes: list[tuple[int, int]], runs: int = 5) -> list[dict[str, Any]]:
    """A first compile, and the same again with another scalar and with another plant."""
    rows = []
    for nx, vertices in sizes:
        problem = polytopic_filter(nx, vertices)
        first = compile_lmic(problem, runs)["first"]
        others = iter([polytopic_filter(nx, vertices, seed) for seed in range(1, runs + 2)])
        binding = prepare(problem.theorem, problem.plant)
        next(others)
        scalar = least(lambda b=binding, p=problem: finish(b, {"eps": 2}, p.relaxation).columns, runs)[0]
        plant = least(lambda o=others, p=problem: replace(next(o), theorem=p.theorem).compiled(), runs)[0]
        rows.append({"size": problem.size, "first": first, "scalar": scalar, "plant": plant})
    return rows


def compare(problem: Problem, tools: list[Tool], solved: bool, runs: int) -> dict[str, Any]:
    """lmic and the tools on one problem: time to the solver's arrays, and the optimum of each."""
    row: dict[str, Any] = {"series": problem.series, "size": problem.size, "lmic": compile_lmic(problem)}
    compiled = problem.compiled()
    row["lmis"] = len(compiled.orders)
    row["optimum"] = {}
    if solved:
        seconds, answer = least(lambda: solve(compiled), 1)
        row["lmic"] |= {"solve": seconds}
        row["optimum"]["lmic"] = answer.value
    for tool in tools:

        def work(tool: Tool = tool) -> Any:
            model = written(problem, compiled, tool)
            tool.compile(model)
            return model

        seconds, model = least(work, runs)
        row[tool.name] = {"first": seconds}
        if solved:
            row["optimum"][tool.name] = tool.solve(model)
    values = list(row["optimum"].values())
    row["same"] = bool(np.ptp(values) <= SAME * max(1.0, np.abs(values).max())) if values else None
    for name in ("CVXPY", "PICOS"):
        if name in row:
            row[name]["ratio"] = row[name]["first"]["cpu"] / row["lmic"]["first"]["cpu"]
    return row


def measure(quick: bool, say: Callable[[str], None]) -> dict[str, Any]:
    """Everything, as plain data."""
    tools: list[Tool] = [Cvxpy(), Picos()]
    found: dict[str, Any] = {
        "mode": "quick" if quick else "full",
        "made": datetime.now(UTC).isoformat(timespec="seconds"),
        "machine": machine(),
        "load": os.getloadavg(),
    }
    say("S1, growth with the number of points")
    growth = [25, 625, 15_625] if quick else [25, 625, 15_625, 250_047]
    found["growth"] = [{"points": n, **compile_lmic(filter_2d(n), 5 if n < 1e5 else 3)} for n in growth]
    say("S2, growth with the size of the plant")
    sizes = [(2, 2), (4, 3), (6, 4), (10, 5)]
    found["plants"] = [{"size": f"nx = {a}, N = {b}", **compile_lmic(polytopic_filter(a, b))} for a, b in sizes]
    say("bounded-real lemma on three simplexes")
    found["degrees"] = [{"degree": d, **compile_lmic(multi_simplex(d))} for d in range(6)]
    say("bounded-real lemma on 200 points")
    found["gridded"] = compile_lmic(gridded(200))
    say("binding again")
    found["rebind"] = rebind(sizes)
    say("CVXPY and PICOS")
    compared = [(polytopic_filter(2, 2), True), (gridded(10), True), (filter_2d(25), True), (filter_2d(64), not quick)]
    if not quick:
        compared += [(polytopic_filter(4, 3), True), (gridded(200), False), (filter_2d(625), False)]
    found["compared"] = []
    for problem, solved in compared:
        say(f"  {problem.series}, {problem.size}")
        found["compared"].append(compare(problem, tools, solved, 1 if len(found["compared"]) > 2 else 2))
    say("S1 solved")
    found["solved"] = []
    for n in [25, 625, 15_625]:
        compiled = filter_2d(n).compiled()
        seconds, answer = least(lambda c=compiled: solve(c), 1)
        found["solved"].append(
            {
                "points": n,
                "lmis": len(compiled.orders),
                **seconds,
                "gamma": float(np.sqrt(answer.value)),
                "status": answer.status.value,
                "violation": answer.relative_violation,
                "uncertainty": answer.uncertainty,
            }
        )
    return found


def ratios(found: dict[str, Any]) -> list[tuple[str, str, str]]:
    """What was asked for, and what was measured: (what, measured, target)."""
    big = next(row for row in found["growth"] if row["points"] == 15_625)
    last = found["growth"][-1]
    slope = np.log(last["new grid"]["cpu"] / found["growth"][1]["new grid"]["cpu"]) / np.log(last["points"] / 625)
    rows = [
        ("S1 Theorem 3, 15,625 points: compile", f"{big['first']['cpu']:.2f} s", "≤ 1 s"),
        ("… over copying its arrays", f"{big['first']['cpu'] / big['copy']['cpu']:.1f} x", "≤ 20 x"),
        ("… peak memory over its arrays", f"{big['peak'] / big['bytes']:.2f} x", "≤ 4 x"),
        (f"growth from 625 to {last['points']:,} points: exponent", f"{slope:.2f}", "1 or less"),
    ]
    for name in ("CVXPY", "PICOS"):
        largest = [row for row in found["compared"] if row["series"].startswith("S1") and name in row][-1]
        each = largest[name]["first"]["cpu"] / largest["lmis"] / (big["first"]["cpu"] / big["lmis"])
        target = "≥ 1,000 x" if name == "CVXPY" else ""
        rows.append((f"{name}, per LMI ({largest['size']} points), over lmic (15,625)", f"{each:,.0f} x", target))
    degree = found["degrees"][-1]
    rows.append((f"three simplexes, degree 5, {degree['lmis']} LMIs", f"{degree['first']['cpu']:.3f} s", "≤ 0.2 s"))
    for row in found["rebind"]:
        shares = [f"{100 * row[kind]['cpu'] / row['first']['cpu']:.0f} %" for kind in ("scalar", "plant")]
        rows.append((f"binding again, S2 {row['size']}: scalar, plant", ", ".join(shares), "≤ 10 %"))
    solved = found["solved"][-1]
    seconds = f"{solved['wall']:.1f} s ({solved['cpu']:.1f} s of processor time)"
    rows.append((f"S1 solved, 15,625 points, γ = {solved['gamma']:.6f}", seconds, "≤ 15 s"))
    same = [row["same"] for row in found["compared"] if row["same"] is not None]
    rows.append(("problems whose optimum is the same in all tools", f"{sum(same)} of {len(same)}", "all"))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="leave out what takes CVXPY and PICOS minutes")
    parser.add_argument("--output", type=Path, default=Path("reports"))
    chosen = parser.parse_args()
    warnings.filterwarnings("ignore", message="Solution may be inaccurate")
    found = measure(chosen.quick, lambda text: print(text, flush=True))
    found["ratios"] = ratios(found)
    chosen.output.mkdir(parents=True, exist_ok=True)
    write_whole(chosen.output / "benchmarks.json", json.dumps(found, indent=1, ensure_ascii=False) + "\n")
    for what, measured, target in found["ratios"]:
        print(f"{what:<72}{measured:>34}   {target}")
    print(write_page(chosen.output))


if __name__ == "__main__":
    main()
