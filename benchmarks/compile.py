"""How long the stages take: S2 over sizes, S1 over the number of grid points.

    python benchmarks/compile.py

Prints the median of several runs of each stage, and the size of what came out.
"""

from __future__ import annotations

from collections.abc import Callable
from statistics import median
from time import perf_counter
from typing import Any

from lmic import library
from lmic.pipeline import finish, prepare
from lmic.plants.files import read_plant
from lmic.plants.random import random_plant
from lmic.relax.relax import Relaxation


def timed(work: Callable[[], Any], runs: int = 5) -> tuple[float, Any]:
    seconds, result = [], None
    for _ in range(runs):
        start = perf_counter()
        result = work()
        seconds.append(perf_counter() - start)
    return median(seconds), result


def row(name: str, bind: float, problem: Any, rest: float, arrays: float) -> None:
    columns = problem.columns
    print(
        f"{name:<34}{bind * 1e3:>9.1f}{rest * 1e3:>10.1f}{arrays * 1e3:>11.1f}{len(problem.orders):>8}{columns.nnz:>12}"
    )


def main() -> None:
    print(f"{'problem':<34}{'bind/ms':>9}{'relax/ms':>10}{'arrays/ms':>11}{'LMIs':>8}{'entries':>12}")
    theorem = library.theorem("peixoto2025.theorem1")
    for nx, vertices in ((2, 2), (4, 3), (6, 4), (10, 5)):
        plant = random_plant(theorem, {"nx": nx, "nw": 2, "ny": 2, "nz": 2}, vertices)
        bind, binding = timed(lambda plant=plant: prepare(theorem, plant), 3)
        rest, problem = timed(lambda binding=binding: finish(binding, {"eps": 1}), 3)
        row(f"S2 theorem 1, nx = {nx}, N = {vertices}", bind, problem, rest, timed(lambda p=problem: p.columns, 1)[0])
    theorem = library.theorem("wu2007.theorem3")
    plant = read_plant(library.root() / "wu2007" / "example.toml")
    bind, binding = timed(lambda: prepare(theorem, plant), 3)
    for count in (2, 3, 5, 7):
        choice = Relaxation(method={"r": "grid"}, grid={"r": count})
        rest, problem = timed(lambda choice=choice: finish(binding, {}, choice), 3)
        row(f"S1 theorem 3, {count}² points, 3 copies", bind, problem, rest, timed(lambda p=problem: p.columns, 1)[0])


if __name__ == "__main__":
    main()
