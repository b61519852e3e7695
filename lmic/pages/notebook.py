"""What a notebook shows of theorems, compiled problems and results: small pieces of the pages, without figures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lmic.pages.site import render

if TYPE_CHECKING:
    from lmic.compiler.assemble import ConicProblem
    from lmic.language.theorem import Theorem
    from lmic.pipeline import Result


def theorem_html(theorem: Theorem) -> str:
    """The statement: block matrices as MathML, data, unknowns, source."""
    from lmic.pages.statement import statement

    return render("notebook.html", what="theorem", theorem=statement(theorem))


def problem_html(problem: ConicProblem) -> str:
    """Sizes and relaxations: a line for each LMI."""
    from lmic.reporting import family_record

    return render("notebook.html", what="problem", problem=problem, families=list(map(family_record, problem.families)))


def result_html(result: Result) -> str:
    """What is reported and how well it is known, what was measured, and the design."""
    from lmic.pages.result import MEANING, SHOWN, equations, reported

    found = equations(result)
    return render(
        "notebook.html",
        what="result",
        result=result,
        reported=reported(result),
        meaning=MEANING[result.problem.soundness],
        equations=found[:SHOWN],
        left_out=max(0, len(found) - SHOWN),
    )
