"""Ctrl-C: what is kept, said in one line, and solvers in compiled code that notice it."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

#: exit code of a command that was interrupted, as shells give it
EXIT = 130
#: what is said where nothing else is
NOTHING = "nothing was written, and the same command begins anew"


@contextmanager
def keeping(said: Callable[[], str]) -> Iterator[None]:
    """Give a KeyboardInterrupt from inside the words that say what is kept and how to go on; the first words stay."""
    try:
        yield
    except KeyboardInterrupt as stop:
        if stop.args:
            raise
        raise KeyboardInterrupt(said()) from stop


@contextmanager
def noticed() -> Iterator[Callable[[], bool]]:
    """Note Ctrl-C instead of raising it, for compiled code that asks by the yielded function whether to stop.

    Python cannot raise within such code. The KeyboardInterrupt comes on leaving. Only the main thread gets signals;
    in others, and where a handler is not Python's, nothing changes.
    """
    seen: list[int] = []
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or before is not signal.default_int_handler:
        yield lambda: False
        return

    def note(number: int, frame: Any) -> None:
        seen.append(number)

    signal.signal(signal.SIGINT, note)
    try:
        yield lambda: bool(seen)
    finally:
        signal.signal(signal.SIGINT, before)
    if seen:
        raise KeyboardInterrupt
