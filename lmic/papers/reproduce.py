"""Regenerate the papers' tables: solve every case, compare with the printed value, check the design."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from decimal import Decimal
from enum import StrEnum
from typing import Any

import numpy as np

from lmic.analysis.norms import frozen_gain, frozen_peak
from lmic.analysis.sampling import cover
from lmic.certify.certificate import Certificate, Standing
from lmic.certify.certify import certify
from lmic.certify.document import float_above, float_below
from lmic.certify.refine import certify_domain
from lmic.language.systems import DelaySystem, DiscreteSystem, FornasiniMarchesini
from lmic.library import theorem
from lmic.papers.cases import Case, CaseTable, Curve, Simulation
from lmic.papers.enclosures import Enclosure, proven, stored
from lmic.papers.signals import signal, trajectory_of
from lmic.pipeline import Result, compile, prepare, run
from lmic.plants.domains import vertex_points
from lmic.plants.files import read_plant
from lmic.relax.grid import Grid
from lmic.relax.relax import Relaxation
from lmic.simulate.discrete import simulate_discrete
from lmic.simulate.plane import simulate_plane
from lmic.simulate.trajectory import Trajectory
from lmic.solve.passes import TRUSTED_VIOLATION
from lmic.solve.solution import Solution
from lmic.sweeps.sweep import sweep
from lmic.sweeps.swept import Swept


class Verdict(StrEnum):
    """How our number stands beside the paper's."""

    REPRODUCED = "reproduced"
    BETTER = "lmic better"
    WORSE = "not reached"
    REFUTED = "refuted for the printed data"
    STAND_IN = "data lost, stand-in"
    ADDED = "not in the paper"
    UNTRUSTED = "not to be trusted"


@dataclass(frozen=True)
class Frozen:
    """Largest norm of the error system at frozen parameters, and what the theorem bounds it by."""

    norm: float
    bound: float


@dataclass(frozen=True)
class Outcome:
    """A case with its result; ``frozen`` is None where no norm is bounded or defined.

    ``relaxation`` is the case's with the grids that it asked to find; ``enclosure`` is what is proven,
    and ``certificate`` the proof where it was made together with the solution.
    """

    case: Case
    relaxation: Relaxation
    result: Result
    value: float
    verdict: Verdict
    frozen: Frozen | None
    enclosure: Enclosure | None
    certificate: Certificate | None = None

    def record(self) -> dict[str, Any]:
        """The outcome as plain data."""
        solution = self.result.solution
        lower, upper = (self.enclosure.lower, self.enclosure.upper) if self.enclosure else (None, None)
        radius = self.enclosure.radius if self.enclosure else None
        return {
            "id": self.case.id,
            "paper": None if self.case.paper is None else float(self.case.paper),
            "value": self.value,
            "violation": solution.violation,
            "relative_violation": solution.relative_violation,
            "status": solution.status.value,
            "attained": solution.attained,
            "soundness": self.result.problem.soundness.value,
            "verdict": self.verdict.value,
            "frozen_norm": self.frozen.norm if self.frozen else None,
            "frozen_bound": self.frozen.bound if self.frozen else None,
            "lower": float_below(lower) if lower is not None else None,
            "upper": float_above(upper) if upper is not None else None,
            "bound_for_unknowns_up_to": float(radius) if radius else None,
            "standing": (self.enclosure.standing if self.enclosure else Standing.NUMERICAL).value,
            "warnings": list(solution.warnings),
            "seconds": round(self.result.seconds, 3),
        }


def reproduce(table: CaseTable, fresh: bool = False) -> Iterator[Outcome]:
    """Solve the cases of a table one after another; a lower bound stands before what it bounds.

    Enclosures come from the library's certificates, or are proven ``fresh``. Raises CertificateError
    where a certificate does not hold.
    """
    bounds: dict[str, float] = {}
    for case in table.cases:
        result, relaxation, certificate = _solved(case)
        if fresh and not certificate:
            certificate = certify(result, relaxation, case.given)
        if certificate:
            enclosure = proven(certificate, case) if certificate.upper or certificate.lower else None
        else:
            enclosure = stored(case)
        value = result.reports.get(case.report, float("nan"))
        if enclosure and enclosure.lower is not None and enclosure.about_theorem and enclosure.radius is None:
            bounds[case.id] = float(enclosure.lower)
        found = verdict(case, value, _doubt(case, result.solution, value), bounds)
        frozen = _frozen(relaxation, case, result)
        yield Outcome(case, relaxation, result, value, found, frozen, enclosure, certificate)


def _solved(case: Case) -> tuple[Result, Relaxation, Certificate | None]:
    """The result, the relaxation with the grids that were found, and the proof where it was asked for."""
    plant, statement = read_plant(case.plant), theorem(case.theorem)
    covered = {name: cover(plant, gain, name).grid for name, gain in case.cover.items()}
    relaxation = replace(case.relaxation, grid={**case.relaxation.grid, **covered})
    if case.refine:
        refined = certify_domain(prepare(statement, plant), relaxation, case.given)
        return refined.result, refined.relaxation, refined.certificate
    return run(compile(statement, plant, case.given, relaxation=relaxation)), relaxation, None


def _doubt(case: Case, solution: Solution, value: float) -> float:
    """How far the value may be from the optimum; infinite where it is no number to compare.

    Where the paper found no solution any point inside the cones will do, however far from the optimum.
    """
    if case.paper is not None and case.paper.is_infinite():
        inside = solution.status.usable and solution.relative_violation >= -TRUSTED_VIOLATION
        return 0.0 if inside else float("inf")
    return solution.uncertainty * abs(value) if solution.trusted else float("inf")


def verdict(case: Case, value: float, doubt: float, bounds: Mapping[str, float]) -> Verdict:
    """Reproduced means: equal to the paper's value in the digits that it prints.

    A verdict holds for every value within ``doubt`` of ``value``, or there is none. A paper that found
    no solution prints infinity. Only a proven lower bound on the optimum refutes: ``bounds`` holds
    those that are known, by case.
    """
    if not np.isfinite(doubt):
        return Verdict.UNTRUSTED
    if case.stand_in:
        return Verdict.STAND_IN
    if case.paper is None:
        return Verdict.ADDED
    if case.paper.is_infinite():
        return Verdict.BETTER
    half_unit = Decimal(1).scaleb(int(case.paper.as_tuple().exponent)) / 2
    least, most = (Decimal(value) + sign * Decimal(doubt) - case.paper for sign in (-1, 1))
    if -half_unit <= least and most <= half_unit:
        return Verdict.REPRODUCED
    if most < -half_unit:
        return Verdict.BETTER
    below = bounds.get(case.below, float("-inf")) if case.below else float("-inf")
    if below > case.paper + half_unit:
        return Verdict.REFUTED
    return Verdict.WORSE if least > half_unit else Verdict.UNTRUSTED


def _frozen(relaxation: Relaxation, case: Case, result: Result) -> Frozen | None:
    """Largest norm of the frozen error system and its bound: over the case's own points, else the vertices.

    Of several bounds, that of the case's report, else the first.
    """
    bounds = sorted(result.theorem.guarantees, key=lambda bound: bound.report != case.report)
    if not bounds or not result.solution.status.usable:
        return None
    points = vertex_points(result.problem.binding.domains)
    points |= {n: np.array(g.points) for n, g in relaxation.grid.items() if isinstance(g, Grid) and g.points}
    norm = frozen_peak if bounds[0].norm == "energy to peak" else frozen_gain
    found = norm(result.design, bounds[0].system, points)
    return None if found is None else Frozen(float(found.max()), result.reports[bounds[0].report])


def run_curve(curve: Curve) -> dict[str, Swept]:
    """The sweep of every theorem of a curve, on all cores; by theorem."""
    plant = read_plant(curve.plant)
    return {name: sweep(theorem(name), plant, curve.over, curve.given, search=curve.search) for name in curve.theorems}


def run_simulation(simulation: Simulation, outcomes: Mapping[str, Outcome]) -> dict[str, Trajectory]:
    """The closed loops of the simulation's cases, all driven by the same signals; by case id."""
    w = signal(simulation.w, simulation.size)
    parameters = {name: trajectory_of(texts, simulation.size) for name, texts in simulation.parameters.items()}
    return {case: _trajectory(simulation, case, outcomes[case].result, w, parameters) for case in simulation.cases}


def _trajectory(simulation: Simulation, case: str, result: Result, w: Any, parameters: Mapping[str, Any]) -> Trajectory:
    system = result.theorem.guarantees[0].system
    others = {}
    if isinstance(system, FornasiniMarchesini):
        edge = signal(simulation.boundary, simulation.size[:1]) if simulation.boundary else None
        state, e = simulate_plane(result.design, system, w, parameters, edge)
    elif isinstance(system, (DiscreteSystem, DelaySystem)):
        delay = signal([simulation.delay[case]], simulation.size)[:, 0] if case in simulation.delay else None
        delay = None if delay is None else np.round(delay)
        state, e = simulate_discrete(result.design, system, w, parameters, delay)
        others = {
            name: simulate_discrete(result.design, other, w, parameters, delay)[1]
            for name, other in result.theorem.signals.items()
            if isinstance(other, (DiscreteSystem, DelaySystem))
        }
    else:
        raise NotImplementedError(f"no simulation of a {type(system).__name__}")
    return Trajectory(w, e, state, parameters, others)


def achieved(trajectory: Trajectory, result: Result) -> float:
    """What the trajectory shows of the bounded norm: its gain, or its peak for an energy-to-peak norm."""
    return trajectory.peak if result.theorem.guarantees[0].norm == "energy to peak" else trajectory.gain
