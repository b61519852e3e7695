"""Regenerate the papers' tables: solve every case, compare with the printed value, check the design."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from decimal import Decimal
from enum import StrEnum
from typing import Any

import numpy as np
import sympy as sp

from lmic.library import theorem
from lmic.norms import h_infinity
from lmic.papers.cases import Case, CaseTable, Simulation
from lmic.pipeline import Result, compile, run
from lmic.plants.expressions import parse
from lmic.plants.files import read_plant
from lmic.polynomials import atom_values
from lmic.simulate import Trajectory, simulate


class Verdict(StrEnum):
    """How our number stands beside the paper's."""

    REPRODUCED = "reproduced"
    BETTER = "lmic better"
    WORSE = "not reached"
    UNTRUSTED = "not to be trusted"


@dataclass(frozen=True)
class Outcome:
    """A case with its result; ``frozen_norm`` is the largest over the vertices, None if not defined."""

    case: Case
    result: Result
    value: float
    verdict: Verdict
    frozen_norm: float | None

    def record(self) -> dict[str, Any]:
        """The outcome as plain data."""
        solution = self.result.solution
        return {
            "id": self.case.id,
            "paper": float(self.case.paper),
            "value": self.value,
            "violation": solution.violation,
            "relative_violation": solution.relative_violation,
            "status": solution.status.value,
            "soundness": self.result.problem.soundness.value,
            "verdict": self.verdict.value,
            "frozen_norm": self.frozen_norm,
            "warnings": list(solution.warnings),
            "seconds": round(self.result.seconds, 3),
        }


@dataclass(frozen=True)
class Simulated:
    """The trajectories of a simulation by case id."""

    simulation: Simulation
    trajectories: dict[str, Trajectory] = field(default_factory=dict)


def reproduce(table: CaseTable) -> Iterator[Outcome]:
    """Solve the cases of a table one after another."""
    for case in table.cases:
        problem = compile(theorem(case.theorem), read_plant(case.plant), case.given)
        result = run(problem)
        value = result.reports.get(case.report, float("nan"))
        yield Outcome(case, result, value, verdict(value, case.paper, result.solution.trusted), _frozen_norm(result))


def verdict(value: float, paper: Decimal, trusted: bool) -> Verdict:
    """Reproduced means: equal to the paper's value in the digits that it prints."""
    if not trusted:
        return Verdict.UNTRUSTED
    unit = Decimal(1).scaleb(int(paper.as_tuple().exponent))
    difference = Decimal(value) - paper
    if abs(difference) <= unit / 2:
        return Verdict.REPRODUCED
    return Verdict.BETTER if difference < 0 else Verdict.WORSE


def _frozen_norm(result: Result) -> float | None:
    """Largest frozen H∞ norm over the vertices of the domain."""
    bounds = result.theorem.guarantees
    if not bounds or not result.solution.status.usable:
        return None
    points = {name: domain.vertices for name, domain in result.problem.binding.domains.items()}
    return float(h_infinity(result.design.closed_loop(bounds[0], points)).max())


def run_simulation(simulation: Simulation, outcomes: dict[str, Outcome]) -> Simulated:
    """Drive the closed loop of every case with the same signals."""
    w = signal(simulation.w, simulation.steps)
    parameters = {name: signal(texts, simulation.steps) for name, texts in simulation.parameters.items()}
    trajectories = {}
    for case in simulation.cases:
        result = outcomes[case].result
        trajectories[case] = simulate(result.design, result.theorem.guarantees[0], w, parameters)
    return Simulated(simulation, trajectories)


def signal(texts: tuple[str, ...], steps: int) -> Any:
    """Values of expressions in the step k at k = 0 … steps - 1, shape (steps, components)."""
    k = sp.Symbol("k")
    values = {k: np.arange(steps, dtype=float)}
    return np.column_stack([np.broadcast_to(atom_values(parse(text, {"k": k}), values), (steps,)) for text in texts])
