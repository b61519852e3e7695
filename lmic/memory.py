"""Keep what was derived from an object for as long as the object lives.

Theorems hold mappings and so have no hash; they are told apart by identity.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, Generic, TypeVar
from weakref import finalize

T = TypeVar("T")

#: derived records kept for one object, the oldest leave first
LIMIT = 32


class Kept(Generic[T]):
    """Records derived from an object and a key."""

    def __init__(self) -> None:
        self._found: dict[int, dict[Hashable, T]] = {}

    def get(self, owner: Any, key: Hashable, make: Callable[[], T]) -> T:
        """The record of ``owner`` under ``key``, made where there is none."""
        identity = id(owner)
        if identity not in self._found:
            self._found[identity] = {}
            finalize(owner, self._found.pop, identity, None)
        records = self._found[identity]
        if key not in records:
            made = make()
            if len(records) >= LIMIT:
                records.pop(next(iter(records)))
            records[key] = made
        return records[key]
