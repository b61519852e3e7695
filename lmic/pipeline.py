"""From a theorem and a plant to a design, in nine stages.

| # | record         | made by            | content                                                        |
|---|----------------|--------------------|----------------------------------------------------------------|
| 0 | Theorem        | a theorem file     | block matrices over symbolic dimensions                        |
| 1 | SymbolicLMI    | lower              | stars filled, F ≻ 0, shapes and symmetry checked               |
| 2 | TermList       | terms              | every block as Σ coefficient · L · X · R                       |
| 3 | ParametricLMI  | bind               | plant and bases in: Σ_m g_m(θ) F_m(x)                          |
| 4 | LMIFamily      | relax              | finitely many LMIs, labelled, with their soundness             |
| 5 | ConicProblem   | assemble           | minimise c·x, F_k(x) ⪰ 0, one sparse array                     |
| 6 | Solution       | solve              | lineality, congruence rescaling, solver, measured violation    |
| 7 | Certificate    | certify            | what is proven of the number: an enclosure, and where it holds |
| 8 | Design         | recover            | the filter's matrices as functions of the parameter            |
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import sympy as sp

from lmic.assumptions import check_assumptions
from lmic.compiler.assemble import ConicProblem, assemble
from lmic.compiler.bases import Choice
from lmic.compiler.bind import Binding, bind
from lmic.compiler.lower import lower
from lmic.compiler.terms import TermList, term_lists
from lmic.errors import Place, RecoveryError
from lmic.language.theorem import Theorem
from lmic.memory import Kept
from lmic.plants.plant import Plant
from lmic.recover.recover import Design, recover
from lmic.relax.relax import Relaxation, relax
from lmic.solve.cone import ConeSolver
from lmic.solve.solution import Solution
from lmic.solve.solve import solve

#: size up to which an imaginary part is the root of a rounding error
ROUNDED_ROOT = 1e-4

_symbolic: Kept[Mapping[str, TermList]] = Kept()


@dataclass(frozen=True)
class Result:
    """A solved theorem: ``reports`` hold what it reports (γ), computed from the solution.

    ``reports`` is empty where there is no point to look at; ``seconds`` is the wall time of solving and recovering.
    """

    problem: ConicProblem
    solution: Solution
    design: Design
    reports: Mapping[str, float]
    seconds: float

    @property
    def theorem(self) -> Theorem:
        """The theorem that was solved."""
        return self.problem.binding.theorem

    @property
    def slack(self) -> Any:
        """svec of all LMIs at the solution."""
        return self.problem.matrix @ self.solution.x + self.problem.offset

    def _repr_html_(self) -> str:
        """What is reported, what was measured and the design, for notebooks."""
        from lmic.pages.notebook import result_html

        return result_html(self)


def prepare(
    theorem: Theorem,
    plant: Plant,
    dependence: Mapping[str, Choice] | None = None,
    sizes: Mapping[str, int] | None = None,
) -> Binding:
    """Stages 1 to 3, with the given scalars still open: the part that a sweep does once.

    Arguments and errors are those of :func:`lmic.compile`.
    """
    return bind(theorem, symbolic(theorem), plant, dependence, sizes)


def symbolic(theorem: Theorem) -> Mapping[str, TermList]:
    """Stages 1 and 2, which no plant changes: done once for a theorem object and kept as long as it lives."""
    return _symbolic.get(theorem, "terms", lambda: term_lists(lower(theorem)))


def finish(
    binding: Binding, given: Mapping[str, Any] | None = None, relaxation: Relaxation | None = None
) -> ConicProblem:
    """Stages 3 to 5: the given scalars set, relaxed, assembled.

    ``given`` are values by name, numbers or texts such as ``"1/3"``. Raises PlantError for a scalar that is missing or
    unknown, RelaxationError for a relaxation that does not fit the dependence on a parameter.
    """
    fixed = binding.fixed(given or {})
    chosen = relaxation or Relaxation()
    return assemble(fixed, relax(fixed, chosen), chosen)


def compile(
    theorem: Theorem,
    plant: Plant,
    given: Mapping[str, Any] | None = None,
    dependence: Mapping[str, Choice] | None = None,
    relaxation: Relaxation | None = None,
    sizes: Mapping[str, int] | None = None,
) -> ConicProblem:
    """Stages 1 to 5: a theorem with a plant as one conic problem, minimise c·x with every F_k(x) ⪰ 0.

    ``given`` are the values of the theorem's and the plant's scalars; ``dependence`` the degree or
    basis of each unknown (degree 1 where nothing is said); ``relaxation`` how the parameters
    are made finite; ``sizes`` the dimensions that no matrix of the plant determines.

    Raises DefinitionError, ShapeError, AsymmetryError or NotAffineError for what the theorem states, PlantError,
    ShapeError or DomainError for a plant that does not fit it, BasisError and RelaxationError for choices that do not
    apply. Each names the theorem, and the LMI and block where there is one.
    """
    return finish(prepare(theorem, plant, dependence, sizes), given, relaxation)


def run(
    problem: ConicProblem, solver: ConeSolver | Sequence[ConeSolver] | None = None, near: Result | None = None
) -> Result:
    """Stages 6 and 8: solve, with one solver after another until one has an answer, and recover.

    ``solver`` is one of :func:`lmic.solvers`, or several of them. ``near`` is a result at neighbouring data: its
    coordinates may save work, and change no digit that is known.

    Whether the answer can be relied on is in ``result.solution``: its status, violation and uncertainty. Raises
    PlantError where the data already rule out a solution, SolverError where no solver could run, RecoveryError where
    a report is not real.
    """
    start = perf_counter()
    check_assumptions(problem.binding)
    solution = solve(problem, solver, near=near.slack if near and near.solution.trusted else None)
    design = recover(problem, solution.x)
    return Result(problem, solution, design, reports(design) if solution.status.usable else {}, perf_counter() - start)


def reports(design: Design) -> dict[str, float]:
    """The reported scalars at the solution; raises RecoveryError where one is not a real number."""
    expressions = design.binding.theorem.reports
    return {name: _report(design, name, expression, design.scalars) for name, expression in expressions.items()}


def _report(design: Design, name: str, expression: sp.Expr, scalars: Mapping[str, float]) -> float:
    value = complex(expression.xreplace({s: sp.Float(scalars[s.name], 17) for s in expression.free_symbols}))
    # the root of an optimum of zero, which rounding makes slightly negative, is zero
    if not abs(value.imag) <= ROUNDED_ROOT * max(1.0, abs(value.real)):
        raise RecoveryError(
            f"the report {name} = {expression} is {value:.3g} at the solution, which is not real; correct the formula",
            Place(design.binding.theorem.name),
        )
    return value.real
