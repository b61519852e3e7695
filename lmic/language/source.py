"""Where a statement was published."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Source:
    """Where a statement was published; ``statement`` is its name there, e.g. "Theorem 1"."""

    authors: str
    title: str
    venue: str
    year: int | None
    statement: str = ""
    derived: str = ""

    @property
    def short(self) -> str:
        """Authors, year and the statement's name."""
        statement = f", {self.statement}" if self.statement else ""
        return f"{self.authors}{f' ({self.year})' if self.year else ''}{statement}"

    def __str__(self) -> str:
        place = f", {self.statement}" if self.statement else ""
        year = f" ({self.year})" if self.year else ""
        return f"{self.authors}{year}. {self.title}. {self.venue}{place}."
