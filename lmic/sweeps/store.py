"""A sweep's file: JSON lines, one header and then one record for each point, in the order in which they were done.

Lines are only ever appended, each batch in one write that is flushed to the disk, so that a sweep which is killed
leaves whole lines and at most one torn one at the end. That one is cut off when the sweep resumes.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from lmic import __version__
from lmic.errors import SweepError
from lmic.files import write_whole
from lmic.interrupts import NOTHING
from lmic.sweeps.plan import Key, Plan

FORMAT = 1


class Store:
    """The records of a sweep, on disk where it has a file; a context that holds the file's lock."""

    def __init__(self, plan: Plan, path: Path | None) -> None:
        self.plan, self.path = plan, path
        self.records: dict[Key, Mapping[str, Any]] = {}
        self._stream: Any = None

    def __enter__(self) -> Self:
        if self.path is None:
            return self
        if self.path.exists() and not self.path.is_file():
            raise SweepError(f"{self.path} cannot be written: it is no file; name one")
        if not self.path.exists() or (self.path.is_file() and not self.path.stat().st_size):
            header = {"lmic sweep": FORMAT, "version": __version__, **self.plan.header}
            write_whole(self.path, json.dumps(header, ensure_ascii=False) + "\n")
        try:
            self._stream = self.path.open("r+b")
            _lock(self._stream, self.path)
            content = self._stream.read()
            whole = content.rfind(b"\n") + 1
            self.records = self._read(content[:whole])
            self._stream.truncate(whole)
            self._stream.seek(whole)
        except BaseException as error:
            # the file's lock must not outlive a file that is refused: a notebook keeps the last error, and this with it
            self._close()
            if isinstance(error, OSError):
                raise SweepError(f"{self.path} cannot be written: {error.strerror}; choose another file") from error
            raise
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._close()

    def _close(self) -> None:
        if self._stream:
            self._stream.close()

    def append(self, records: Iterable[tuple[Key, Mapping[str, Any]]]) -> None:
        """Keep the records of some points."""
        records = list(records)
        self.records |= dict(records)
        if self._stream is None:
            return
        columns = self.plan.columns
        lines = [{"at": dict(zip(columns, key, strict=True)), **record} for key, record in records]
        text = "".join(json.dumps(line, ensure_ascii=False, allow_nan=False) + "\n" for line in lines)
        try:
            self._stream.write(text.encode())
            self._stream.flush()
            os.fsync(self._stream.fileno())
        except OSError as error:
            raise SweepError(f"{self.path} cannot be written: {error.strerror}; make room and resume") from error

    def kept(self) -> str:
        """What an interrupted sweep leaves, by the file itself: an append may have been broken off."""
        if self.path is None or not self.path.exists():
            return NOTHING
        held = max(0, self.path.read_bytes().count(b"\n") - 1)
        return f"{held} of {len(self.plan)} points are in {self.path}, and the same sweep does the others"

    def _read(self, content: bytes) -> dict[Key, Mapping[str, Any]]:
        """The records of a file whose header is of this problem."""
        lines = content.splitlines()
        header = _object(lines[0]) if lines else None
        if header is None or header.get("lmic sweep") != FORMAT:
            raise SweepError(f"{self.path} is no file of a sweep; choose another name")
        if header.get("fingerprint") != self.plan.fingerprint:
            said = {key: header.get(key) for key in self.plan.header if key != "fingerprint"}
            differs = [key for key, value in said.items() if value != self.plan.header[key]]
            what = ", ".join(f"{key} {said[key]}" for key in differs) or "other data or choices under the same names"
            raise SweepError(f"{self.path} holds a sweep of another problem ({what}); choose another file")
        columns = self.plan.columns
        found: dict[Key, Mapping[str, Any]] = {}
        for number, line in enumerate(lines[1:], 2):
            record = _object(line)
            at = record.pop("at", None) if record else None
            if record is None or not isinstance(at, dict) or set(at) != set(columns) or not _is_record(record):
                raise SweepError(f"{self.path}, line {number} is no point of this sweep; remove the line")
            found[tuple(str(at[column]) for column in columns)] = record
        return found


def _is_record(record: Mapping[str, Any]) -> bool:
    """Whether it holds what a worker writes of a point: a reason, or everything that is known of a result."""
    if "error" in record:
        return isinstance(record["error"], str)
    kinds = {"status": str, "soundness": str, "trusted": bool, "iterations": int, "solves": int, "reports": dict}
    if not all(type(record.get(name)) is kind for name, kind in kinds.items()):
        return False
    numbers = [record.get(name) for name in ("objective", "bound", "uncertainty", "violation", "seconds")]
    numbers += [*record["reports"].values(), *(record.get("found") or {}).values()]
    return all(value is None or isinstance(value, (int, float)) for value in numbers)


def _object(line: bytes) -> dict[str, Any] | None:
    try:
        found = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None


def _lock(stream: Any, path: Path) -> None:
    """Two sweeps that append to one file would do everything twice."""
    try:
        import fcntl
    except ImportError:  # Windows has no such locks
        return
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise SweepError(f"{path} is being written by another sweep; wait for it, or choose another file") from error
