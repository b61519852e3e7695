"""How long a proof takes beside the solution that it is about.

    python benchmarks/certify.py [--output reports]

Times solving, certifying and verifying for cases of the papers, prints the ratio, and writes benchmarks-certify.json.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

from lmic.analysis.sampling import cover
from lmic.certify.certify import certify
from lmic.certify.verify import verify
from lmic.files import write_whole
from lmic.library import theorem
from lmic.papers.cases import select
from lmic.pipeline import compile, run
from lmic.plants.files import read_plant

CASES = {
    "S2 Table 1, parameter-dependent": "peixoto2025.table1.parameter_dependent",
    "S2 Table 1, robust": "peixoto2025.table1.robust",
    "S1 H∞, r = (1, 0)": "wu2007.table1.hinf.point",
    "S1 H∞, whole box": "wu2007.table1.hinf.box",
    "S3, no delay": "chen2006.no_delay",
    "S3 H∞, NFT model": "chen2006.nft.hinf",
    "S3 H∞, LFT model": "chen2006.lft.hinf",
    "S4 example 1, published grid": "mustafa.example1.published",
    "S4 example 2, published grid": "mustafa.example2.published",
}


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    began = process_time()
    result = work()
    return process_time() - began, result


def measured(what: str, identifier: str) -> list[dict[str, Any]]:
    """One row for the case, or for each of the cases that the identifier is a group of."""
    rows = []
    for case in [case for table in select((identifier,)) for case in table.cases]:
        plant, statement = read_plant(case.plant), theorem(case.theorem)
        covered = {name: cover(plant, gain, name).grid for name, gain in case.cover.items()}
        relaxation = replace(case.relaxation, grid={**case.relaxation.grid, **covered})
        problem = compile(statement, plant, case.given, relaxation=relaxation)
        solving, result = timed(lambda p=problem: run(p))
        proving, certificate = timed(lambda r=result, x=relaxation, c=case: certify(r, x, c.given))
        checking, verdict = timed(lambda c=certificate: verify(c))
        name = what if case.id == identifier else f"{what}, {case.id[len(identifier) :].strip('._')}"
        rows.append(
            {
                "what": name,
                "solve": solving,
                "certify": proving,
                "verify": checking,
                "ratio": proving / solving,
                "standing": verdict.standing.value,
                "notes": list(certificate.notes),
            }
        )
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--output", type=Path, default=Path("reports"))
    chosen = parser.parse_args()
    rows = []
    for what, identifier in CASES.items():
        for row in measured(what, identifier):
            rows.append(row)
            print(
                f"{row['what']:<42}solve {row['solve']:7.2f} s   certify {row['certify']:7.2f} s   "
                f"verify {row['verify']:7.2f} s   certify/solve {row['ratio']:5.1f}   {row['standing']}",
                flush=True,
            )
    chosen.output.mkdir(parents=True, exist_ok=True)
    write_whole(chosen.output / "benchmarks-certify.json", json.dumps(rows, indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
