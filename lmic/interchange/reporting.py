"""What the command line prints of a solved file."""

from __future__ import annotations

from collections import Counter
from typing import Any

from lmic.commands.terminal import console, marked, warning
from lmic.interchange.sdp import SDP
from lmic.reporting import print_solution, solution_record
from lmic.solve.solution import Solution


def file_record(name: str, sdp: SDP, solution: Solution, seconds: float) -> dict[str, Any]:
    """A solved file as plain data: ``objective`` and its bound in the file's own sense, unknowns by name."""
    sign = -1.0 if sdp.maximised else 1.0
    usable = solution.status.usable
    return {
        "file": name,
        "title": sdp.notes.title,
        "sense": "maximise" if sdp.maximised else "minimise",
        "unknowns": sdp.size,
        "orders": sdp.orders.tolist(),
        **solution_record(solution),
        "objective": sign * solution.value,
        "dual_objective": sign * solution.bound,
        "soundness": sdp.notes.soundness,
        "x": {sdp.name(k): float(value) for k, value in enumerate(solution.x)} if usable else {},
        "seconds": round(seconds, 3),
    }


def print_file(name: str, sdp: SDP, solution: Solution, seconds: float) -> None:
    """A solved file for people."""
    out = console()
    out.print(marked(name, f"  {sdp.notes.title}"))
    counts = Counter(sdp.orders.tolist())
    orders = ", ".join(f"{count} of order {order}" for order, count in sorted(counts.items()))
    out.print(f"{sdp.size} scalar unknowns, {len(sdp.orders)} LMIs ({orders}), soundness: {sdp.notes.soundness}")
    if not print_solution(solution, seconds):
        return
    sign, what = (-1.0, "maximum") if sdp.maximised else (1.0, "minimum")
    what = what if sdp.cost.any() else "feasible"
    known = f"   numerical; dual bound {sign * solution.bound:.9g}"
    out.print(marked(f"{what:<11} {sign * solution.value:.9g}", known))
    for text in solution.warnings:
        out.print(warning(text))
