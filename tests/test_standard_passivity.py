"""The positive-real lemmas, against passivity indices in closed form or from a fine grid of frequencies."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from standard_cases import DELTA, ENDS, UNIT, Matrices, cases, feasible, plant, scalars, theorem

from lmic.dsl import PD, I
from lmic.pipeline import compile, run
from lmic.plants.plant import Plant
from lmic.relax.relax import Relaxation
from lmic.solve.cone import Status


@dataclass(frozen=True)
class Index:
    """``nu`` is the optimum of the theorems that match the pattern."""

    pattern: str
    what: str
    plant: Plant
    nu: float
    relaxation: Relaxation | None = None


def random_system(discrete: bool) -> dict[str, np.ndarray]:
    """Three states, two inputs and outputs; the spectral radius is 0.8, the spectral abscissa -1/2."""
    generator = np.random.default_rng(8)
    A, B, C, D = (generator.standard_normal(shape) for shape in ((3, 3), (3, 2), (2, 3), (2, 2)))
    poles = np.linalg.eigvals(A)
    A = 0.8 * A / np.abs(poles).max() if discrete else A - (poles.real.max() + 0.5) * np.eye(3)
    return {"A": A, "B": B, "C": C, "D": D}


def index(system: dict[str, np.ndarray], discrete: bool) -> float:
    """Least eigenvalue of the transfer function's Hermitian part, at infinity and on a fine grid (never below it)."""
    A, B, C, D = system.values()
    points = np.exp(1j * np.linspace(-np.pi, np.pi, 200_001)) if discrete else 1j * np.linspace(-50, 50, 200_001)
    G = C @ np.linalg.solve(points[:, None, None] * np.eye(len(A)) - A, B + 0j) + D
    part = np.linalg.eigvalsh((G + G.conj().swapaxes(1, 2)) / 2).min()
    return float(part if discrete else min(part, np.linalg.eigvalsh((D + D.T) / 2).min()))


CROSSED: Matrices = scalars(A=-1, B="1+3*r", C="4-3*r", D=3)
CONTINUOUS, DISCRETE = random_system(False), random_system(True)

INDICES = [
    # Re G falls from 2 + 1 at ω = 0 to 2
    Index("passivity_continuous*", "lag", plant(scalars(A=-1, B=1, C=1, D=2)), 2),
    # Re G = 2 - 1/(1 + ω²)
    Index("passivity_continuous*", "lead", plant(scalars(A=-1, B=1, C=-1, D=2)), 1),
    Index("passivity_continuous*", "Hermitian part", plant(CONTINUOUS), index(CONTINUOUS, False)),
    # the slowest pole alone gives 1, and so does P = 1 for all of them, whatever the rate
    Index("passivity_continuous*", "pole", plant(scalars(A="r", B=1, C=-1, D=2), (-3, -1), rate=100), 1, ENDS),
    # (bp - c)² < 4p(3 - ν) at the ends, (b, c) = (1, 4), (4, 1): p = 1 costs 9/4; for a constant r p = c/b costs none
    Index("passivity_continuous_quadratic", "b and c", plant(CROSSED, UNIT), 0.75),
    Index("passivity_continuous", "b and c constant", plant(CROSSED, UNIT, rate=0), 3, ENDS),
    # 1/(z - 1/2) moves on the circle through 2 and -2/3
    Index("passivity_discrete*", "lag", plant(scalars(A="1/2", B=1, C=1, D=2)), 4 / 3),
    Index("passivity_discrete*", "Hermitian part", plant(DISCRETE), index(DISCRETE, True)),
    # the end at -1/2 alone gives 3 - 2, and so does P = 1 for a free r
    Index("passivity_discrete*", "switched pole", plant(scalars(A="r", B=1, C=1, D=3), ("-1/2", "1/2")), 1),
]


@pytest.mark.parametrize(("name", "case"), cases(INDICES))
def test_largest_index(name: str, case: Index) -> None:
    result = run(compile(theorem(name), case.plant, relaxation=case.relaxation))
    assert result.solution.status is Status.SOLVED, result.solution.warnings
    assert result.reports["nu"] == pytest.approx(case.nu, rel=1e-6)


@pytest.mark.parametrize("side", [1, -1], ids=["below", "above"])
@pytest.mark.parametrize(("name", "case"), cases(INDICES))
def test_largest_index_is_the_border_of_feasibility(name: str, case: Index, side: int) -> None:
    posed = theorem(name)
    level = case.nu * (1 - side * np.sign(case.nu) * DELTA)
    bounded = {**posed.lmis, "level": PD((posed.reports["nu"] - level) * I(1))}
    assert (feasible(replace(posed, lmis=bounded, minimise=None), case.plant, case.relaxation) is not None) == (
        side > 0
    )
