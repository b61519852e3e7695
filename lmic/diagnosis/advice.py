"""One to three sentences that follow from what was measured."""

from __future__ import annotations

from collections.abc import Sequence

from lmic.diagnosis.distance import Distance
from lmic.diagnosis.growth import Bounds
from lmic.diagnosis.neighbours import Trial
from lmic.diagnosis.shares import Shares
from lmic.diagnosis.unseen import Direction
from lmic.solve.cone import Status
from lmic.solve.solution import Solution
from lmic.solve.whole import NO_MARGIN

#: relative difference from which one value is better than another
BETTER = 1e-4
#: share of the unknowns or LMIs below which a problem is a smaller one
SMALLER = 0.8
#: diverging unknowns that are named
NAMED = 3


def advice(
    solution: Solution,
    binding: Shares,
    margin: Distance | None,
    bounds: Bounds,
    unseen: Sequence[Direction],
    trials: Sequence[Trial],
) -> tuple[str, ...]:
    """What the outcome is due to and what to do, the most telling first."""
    base, *others = trials
    if solution.status is Status.UNBOUNDED:
        return (_unbounded(unseen),)
    if not solution.status.usable:
        return _without_answer(binding, margin, others)
    return tuple(filter(None, (_not_attained(bounds), _better(base, others, binding), _smaller(base, others))))


def _unbounded(unseen: Sequence[Direction]) -> str:
    if unseen:
        return (
            f"No LMI sees the direction {unseen[0].text}, along which the objective may fall; add an LMI that holds it."
        )
    return "The objective falls along a direction in which every LMI grows; add an LMI that bounds it from below."


def _without_answer(binding: Shares, margin: Distance | None, others: Sequence[Trial]) -> tuple[str, ...]:
    first = binding.shares[0]
    sentences = []
    if margin and margin.bound <= NO_MARGIN:
        far = f"by {-margin.margin:.2g} of their data" if margin.margin < -NO_MARGIN else "by their strictness alone"
        sentences.append(
            f"The LMIs miss having a solution {far}, and {first.label} holds {first.share:.0%} of what stands "
            "against it."
        )
    elif margin:
        sentences.append(
            f"The LMIs have a solution with the margin {margin.margin:.1e} of their data, so it is the solver that "
            "fails: try another with --solver."
        )
    helps = [one for one in others if one.feasible]
    if helps:
        best = min(helps, key=lambda one: (one.value is None, one.value or 0.0, one.seconds))
        value = f" with {best.value:.6g}" if best.value is not None else ""
        sentences.append(f"{best.option} has a solution{value} ({best.soundness}): take it.")
    elif others and not (margin and margin.bound > NO_MARGIN):
        sentences.append(
            f"None of the {len(others)} neighbours has one either: look at the data and the given scalars there before "
            "the relaxation."
        )
    return tuple(sentences)


def _not_attained(bounds: Bounds) -> str:
    if not bounds.diverging:
        return ""
    worst = bounds.diverging[0]
    sizes = (
        f"{worst.within[-2]:.1e} within {bounds.bounds[-2]:.0e}, {worst.within[-1]:.1e} within {bounds.bounds[-1]:.0e}"
    )
    names = ", ".join(one.unknown for one in bounds.diverging[:NAMED])
    if bounds.falls:
        return (
            f"{names} grow with every bound ({worst.unknown} {sizes}) and the objective still falls, to "
            f"{bounds.objectives[-1]:.9g}: the infimum is not attained, so quote it within a bound."
        )
    return (
        f"{names} grow with every bound ({worst.unknown} {sizes}) while the objective stays: their size means nothing, "
        "and bounding them costs nothing."
    )


def _better(base: Trial, others: Sequence[Trial], binding: Shares) -> str:
    """The neighbour of the best value, or what it means that there is none."""
    compared = [one for one in others if one.trusted and one.value is not None]
    if base.value is None or not compared:
        return (
            f"{binding.shares[0].label} binds with {binding.shares[0].share:.0%} of the dual." if binding.shares else ""
        )
    # on a grid fewer points promise more and hold less
    sound = [one for one in compared if one.soundness != "sampled" or not one.option.startswith("--grid")]
    best = min(sound, key=lambda one: one.value or 0.0, default=None)
    if best and best.value is not None and best.value < base.value - BETTER * abs(base.value):
        gain = (base.value - best.value) / abs(base.value)
        return (
            f"{best.option} lowers {base.value:.6g} to {best.value:.6g} (by {gain:.2%}) with {best.unknowns} unknowns "
            f"and {best.lmis} LMIs instead of {base.unknowns} and {base.lmis} ({best.soundness})."
        )
    finer = [one for one in compared if one.soundness == "sampled" and (one.value or 0) > base.value * (1 + BETTER)]
    if base.soundness == "sampled" and finer:
        worst = max(finer, key=lambda one: one.value or 0.0)
        return (
            f"{worst.option} raises {base.value:.6g} to {worst.value:.6g}: the grid is too coarse to trust the number."
        )
    first = binding.shares[0]
    return (
        f"No neighbour lowers {base.value:.6g} by more than {BETTER:.0e}, so neither bases nor relaxation limit it; "
        f"{first.label} binds with {first.share:.0%} of the dual."
    )


def _smaller(base: Trial, others: Sequence[Trial]) -> str:
    """A smaller problem of the same value and soundness."""
    if base.value is None:
        return ""
    same = [
        one
        for one in others
        if one.trusted
        and one.value is not None
        and one.soundness == base.soundness != "sampled"
        and abs(one.value - base.value) <= BETTER * abs(base.value)
        and one.unknowns * one.lmis <= SMALLER * base.unknowns * base.lmis
    ]
    if not same:
        return ""
    best = min(same, key=lambda one: one.unknowns * one.lmis)
    return (
        f"{best.option} gives the same with {best.unknowns} unknowns and {best.lmis} LMIs instead of {base.unknowns} "
        f"and {base.lmis}."
    )
