"""A diagnosis for people, and as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lmic.commands.terminal import console, marked, table
from lmic.diagnosis.diagnose import Diagnosis
from lmic.diagnosis.neighbours import Trial
from lmic.diagnosis.ranges import Range
from lmic.diagnosis.shares import Shares
from lmic.reporting import print_families, solution_record

#: rows of a table, and the share from which an LMI is one
ROWS, SHOWN = 8, 1e-3
#: directions that are written out
DIRECTIONS = 5


def diagnosis_record(found: Diagnosis) -> dict[str, Any]:
    """Everything that was measured."""
    result, margin = found.result, found.distance
    return {
        "theorem": result.theorem.name,
        "plant": result.problem.binding.plant.name,
        "given": {symbol.name: value for symbol, value in result.problem.binding.values.items()},
        "reports": dict(result.reports),
        **solution_record(result.solution),
        "binding": [
            {"lmi": one.lmi, "at": list(one.points), "share": one.share}
            for one in found.binding.shares
            if one.share > 0
        ],
        "margin": None
        if margin is None
        else {"largest": margin.margin, "bound": margin.bound, "held_by": margin.shares.shares[0].label},
        "unknowns": [
            {
                "name": one.unknown,
                "largest": one.largest,
                "within": dict(zip(map(str, found.growth.bounds), one.within, strict=True)),
                "power": one.power,
                "diverges": one.diverges,
            }
            for one in found.growth.growths
        ],
        "objective_within": dict(zip(map(str, found.growth.bounds), found.growth.objectives, strict=True)),
        "ranges": {
            "data": [_range_record(one) for one in found.data],
            "lmis": [_range_record(one) for one in found.lmis],
        },
        "unseen": [{"unknowns": list(one.unknowns), "direction": one.text} for one in found.unseen],
        "choices": [_trial_record(one) for one in found.trials],
        "not_tried": list(found.untried),
        "conclusions": list(found.advice),
    }


def _range_record(one: Range) -> dict[str, Any]:
    return {"of": one.what, "smallest": one.smallest, "largest": one.largest}


def _trial_record(one: Trial) -> dict[str, Any]:
    return {
        "option": one.option,
        "value": one.value,
        "status": one.status,
        "trusted": one.trusted,
        "unknowns": one.unknowns,
        "lmis": one.lmis,
        "seconds": round(one.seconds, 3),
        "soundness": one.soundness,
        "failure": one.failure,
    }


def print_diagnosis(found: Diagnosis) -> None:
    """The tables, and the advice at the end."""
    out, result = console(), found.result
    out.print(marked(result.theorem.name, f"  {result.theorem.title}"))
    print_families(result.problem)
    values = ", ".join(f"{name} = {value:.8g}" for name, value in result.reports.items())
    out.print(f"status: {result.solution.status.value}{f', {values}' if values else ''}")
    if found.distance:
        bound = f"no margin is above {found.distance.bound:.2g}"
        out.print(f"largest margin: {found.distance.margin:.3g} of scaled data ({bound})")
    _print_binding(found.binding)
    _print_growth(found)
    _print_ranges(found)
    _print_unseen(found)
    _print_trials(found)
    for sentence in found.advice:
        out.print(sentence, style="bold")


def _print_binding(shares: Shares) -> None:
    shown = table("binding LMI", "at", "share of the dual")
    rows = [one for one in shares.shares if one.share >= SHOWN]
    for one in rows[:ROWS]:
        shown.add_row(one.lmi, ", ".join(one.points) or "everywhere", f"{one.share:.1%}")
    if len(rows) > ROWS:
        shown.add_row(f"{len(rows) - ROWS} more", "", f"{sum(one.share for one in rows[ROWS:]):.1%}")
    console().print(shown)
    for what, parts in (("LMI", shares.by_lmi), ("point", shares.by_point)):
        if len(parts) > 1 and len(rows) > 1:
            console().print(f"by {what}: {_largest(parts)}")


def _largest(parts: Mapping[str, float]) -> str:
    found = [f"{name} {share:.1%}" for name, share in parts.items() if share >= SHOWN]
    return ", ".join(found[:ROWS]) + (f" and {len(found) - ROWS} more" if len(found) > ROWS else "")


def _print_growth(found: Diagnosis) -> None:
    bounds = found.growth
    if not bounds.growths:
        return
    shown = table("unknown", "largest entry", *(f"within {bound:.0e}" for bound in bounds.bounds), "growth")
    for one in bounds.growths:
        word = f"~ bound^{one.power:.2f}: diverges" if one.diverges else "stays" if bounds.bounds else "not tried"
        shown.add_row(one.unknown, f"{one.largest:.3g}", *(f"{size:.3g}" for size in one.within), word)
    if bounds.bounds:
        shown.add_row(
            "objective", "", *(f"{value:.9g}" for value in bounds.objectives), "falls" if bounds.falls else "stays"
        )
    console().print(shown)


def _print_ranges(found: Diagnosis) -> None:
    shown = table("coefficients", "smallest", "largest", "spread")
    for where, ranges in (("data ", found.data), ("LMIs ", found.lmis)):
        for one in ranges:
            shown.add_row(f"{where}{one.what}", f"{one.smallest:.2g}", f"{one.largest:.2g}", f"{one.spread:.0e}")
    console().print(shown)


def _print_unseen(found: Diagnosis) -> None:
    count = len(found.unseen)
    console().print(f"lineality: {count or 'no'} direction{'' if count == 1 else 's'} that no LMI sees")
    for one in found.unseen[:DIRECTIONS]:
        console().print(f"  {one.text}")
    if count > DIRECTIONS:
        names = dict.fromkeys(name for one in found.unseen for name in one.unknowns)
        console().print(f"  and {count - DIRECTIONS} more, in {', '.join(names)}")


def _short(option: str) -> str:
    """The option as typed; of a basis for many unknowns the first, and how many there are."""
    first, *others = option.split(" --dependence ")
    return f"{first} and so for {len(others)} more" if len(others) > 1 else option


def _print_trials(found: Diagnosis) -> None:
    name = next(iter(found.result.reports), next(iter(found.result.theorem.reports), "objective"))
    shown = table("choice", name, "status", "unknowns", "LMIs", "seconds", "soundness")
    for one in found.trials:
        option = _short(one.option) or "as given"
        if one.failure:
            shown.add_row(option, "", one.failure, "", "", "", "")
            continue
        value = "" if one.value is None else f"{one.value:.8g}{'' if one.trusted else ' (not to be trusted)'}"
        shown.add_row(option, value, one.status, str(one.unknowns), str(one.lmis), f"{one.seconds:.2f}", one.soundness)
    console().print(shown)
    if found.untried:
        console().print(f"not tried for lack of time: {', '.join(found.untried)}")
