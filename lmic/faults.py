"""Checks that go on after a fault: they yield what is wrong and return what is right.

Compiling stops at the first fault, :func:`demand`; ``lmic check`` tells all of them, :func:`collect`.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import TypeAlias, TypeVar

from lmic.errors import LmicError

T = TypeVar("T")

#: a check: yields faults, and returns its value, which leaves out what a fault concerns
Checked: TypeAlias = Generator[LmicError, None, T]


def demand(check: Checked[T]) -> T:
    """The value of a check; raises its first fault."""
    try:
        fault = next(check)
    except StopIteration as done:
        value: T = done.value
        return value
    raise fault


def collect(check: Checked[T]) -> tuple[list[LmicError], T]:
    """All faults of a check, and its value."""
    faults: list[LmicError] = []
    while True:
        try:
            faults.append(next(check))
        except StopIteration as done:
            return faults, done.value
