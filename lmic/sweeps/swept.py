"""What came out of a sweep: as columns, as arrays over the axes, as a file for other programs."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lmic.errors import SweepError
from lmic.files import write_whole
from lmic.solve.cone import Status
from lmic.sweeps.plan import Key, Plan

Array: TypeAlias = NDArray[Any]

#: what is known of a point, beside its reports
FACTS = (
    "status", "objective", "bound", "uncertainty", "violation", "soundness", "trusted", "solves", "iterations",
    "seconds", "error",
)  # fmt: skip


#: formats of a table
TABLES = (".csv", ".parquet")


def check_table(path: Path) -> None:
    """Raise SweepError for a path whose suffix names no table."""
    if path.suffix not in TABLES:
        raise SweepError(f"the format of {path} is unknown; end the name in {' or '.join(TABLES)}")


@dataclass(frozen=True)
class Swept:
    """All records of a finished sweep, in the order of the plan: the last axis runs fastest."""

    plan: Plan
    records: Mapping[Key, Mapping[str, Any]]

    @property
    def failed(self) -> dict[str, int]:
        """How many points failed, by reason."""
        return dict(Counter(record["error"] for record in self.records.values() if "error" in record))

    @property
    def statuses(self) -> dict[str, int]:
        """How many points ended how."""
        return dict(Counter(record.get("status", "error") for record in self.records.values()))

    @property
    def doubtful(self) -> int:
        """How many points have a number that is not to be trusted; an infeasible point has none."""
        return sum(
            record.get("status") in (Status.SOLVED, Status.ALMOST, Status.FAILED) and not record["trusted"]
            for record in self.records.values()
        )

    @property
    def solves(self) -> int:
        """How many problems were solved in all."""
        return sum(record.get("solves", 0) for record in self.records.values())

    @property
    def reports(self) -> tuple[str, ...]:
        """What the theorem reports, or its objective where it reports nothing."""
        return tuple(self.plan.theorem.reports) or ("objective",)

    def columns(self) -> dict[str, list[Any]]:
        """The table, one list for each column: ``pandas.DataFrame(swept.columns())`` reads it."""
        shown = [dict(zip(axis.labels, axis.shown, strict=True)) for axis in self.plan.axes]
        found: dict[str, list[Any]] = {
            axis.column: [shown[k][key[k]] for key in self.records] for k, axis in enumerate(self.plan.axes)
        }
        records = list(self.records.values())
        if self.plan.search:
            name = self.plan.search[0]
            found[name] = [record.get("found", {}).get(name) for record in records]
        for name in self.plan.theorem.reports:
            found[name] = [record.get("reports", {}).get(name) for record in records]
        return found | {fact: [record.get(fact) for record in records] for fact in FACTS}

    def values(self, name: str) -> Array:
        """A column of numbers over the axes, shape ``plan.shape``; NaN where a point has none."""
        found = self.columns()
        if name not in found:
            raise SweepError(f"the sweep has no column '{name}'; it has {', '.join(found)}")
        return np.array([np.nan if value is None else value for value in found[name]], dtype=float).reshape(
            self.plan.shape
        )

    def least(self, name: str, over: str) -> tuple[Array, Array]:
        """The least of a column along one axis, and where on it: two arrays over the other axes.

        Where no value is known both are NaN, and the place on an axis of labels is None. Values are compared at the
        upper end of their doubt, so that a doubtful one does not win by being wrong.
        """
        values = self.values(name)
        place = self.axis(over)
        axis = self.plan.axes[place]
        nowhere, kind = (np.nan, float) if axis.numeric else (None, object)
        position = np.array([*axis.shown, nowhere], dtype=kind)
        upper = values + self.values("uncertainty") * np.abs(values)
        upper = np.where(np.isnan(upper), np.inf, upper)
        chosen = np.expand_dims(upper.argmin(axis=place), place)
        missing = np.isinf(upper.min(axis=place))
        least = np.take_along_axis(values, chosen, place).squeeze(place)
        where = position[np.where(missing, len(axis.shown), chosen.squeeze(place))]
        return np.where(missing, np.nan, least), np.array(where, dtype=kind)

    def axis(self, column: str) -> int:
        """Which axis has a column."""
        if column not in self.plan.columns:
            raise SweepError(f"'{column}' is not swept over; the axes are {', '.join(self.plan.columns)}")
        return self.plan.columns.index(column)

    def write_table(self, path: Path) -> None:
        """The table as .csv, or as .parquet with the extra ``table``."""
        check_table(path)
        (self._write_csv if path.suffix == ".csv" else self._write_parquet)(path)

    def _write_csv(self, path: Path) -> None:
        columns = self.columns()
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
        write_whole(path, text.getvalue())

    def _write_parquet(self, path: Path) -> None:
        try:
            import pyarrow
            from pyarrow import parquet
        except ImportError as error:
            raise SweepError("a .parquet table needs Arrow: pip install 'lmic[table]', or write a .csv one") from error
        content = io.BytesIO()
        parquet.write_table(pyarrow.table(self.columns()), content)
        write_whole(path, content.getvalue())
