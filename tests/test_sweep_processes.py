"""Sweeps in other processes: all cores, a Dask cluster, and what is left when they are killed or interrupted."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

import lmic
from lmic.errors import SweepError
from lmic.library import root
from lmic.pipeline import compile, run
from lmic.plants.files import read_plant
from lmic.sweeps.sweep import sweep

LMIC = Path(sys.executable).with_name("lmic")
FILTER = "peixoto2025.theorem1"
EXAMPLE_2 = root() / "peixoto2025" / "example2.toml"
RHO, EPS = [str(rho) for rho in range(1, 9)], [str(eps) for eps in range(1, 25)]
POINTS = {(rho, eps) for rho in RHO for eps in EPS}
WORDS = ["--over", f"rho={','.join(RHO)}", "--over", f"eps={','.join(EPS)}", "--jobs", "2"]

#: how long to wait for what another process should do, however busy the machine is
DEADLINE = 300.0


def until(met: Callable[[], bool], process: subprocess.Popen[Any] | None = None) -> None:
    end = time.monotonic() + DEADLINE
    while not met():
        assert time.monotonic() < end, "it did not happen"
        assert process is None or process.poll() is None, "the process ended by itself"
        time.sleep(0.02)


def hearing_interrupts() -> None:
    """A shell starts what runs in its background with Ctrl-C ignored, and children inherit that."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def started(file: Path) -> subprocess.Popen[str]:
    """A sweep as a user starts it, in a process group of its own as a terminal makes one."""
    words = [str(LMIC), "sweep", FILTER, "--plant", str(EXAMPLE_2), *WORDS, "-o", str(file)]
    return subprocess.Popen(
        words,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=hearing_interrupts,  # noqa: PLW1509  (nothing but a signal, before any thread)
        encoding="utf-8",
    )


def lines(file: Path) -> int:
    return file.read_bytes().count(b"\n") if file.exists() else 0


def keys(file: Path) -> list[tuple[str, str]]:
    """The points of a file, as often as they stand in it."""
    text = file.read_text(encoding="utf-8")
    assert text.endswith("\n")
    records = [json.loads(line) for line in text.splitlines()[1:]]
    assert all("gamma" in record["reports"] for record in records)
    return [(record["at"]["rho"], record["at"]["eps"]) for record in records]


def group_is_gone(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return True
    return False


def resumed(file: Path) -> None:
    """Resume, and find every point once; what had been done stands as it was."""
    before = file.read_bytes()
    whole = before[: before.rfind(b"\n") + 1]
    swept = lmic.sweep(lmic.theorem(FILTER), read_plant(EXAMPLE_2), {"rho": RHO, "eps": EPS}, file=file)
    found = keys(file)
    assert len(found) == len(POINTS)
    assert set(found) == POINTS
    assert file.read_bytes().startswith(whole)
    assert swept.statuses == {"solved": len(POINTS)}
    alone = run(compile(swept.plan.theorem, swept.plan.plants[0], {"rho": 8, "eps": 2}))
    assert swept.values("gamma")[7, 1] == pytest.approx(alone.reports["gamma"], rel=1e-8)


def test_a_killed_sweep_resumes_with_nothing_lost_and_nothing_done_twice(tmp_path: Path) -> None:
    file = tmp_path / "s.jsonl"
    process = started(file)
    until(lambda: lines(file) > 8, process)
    process.kill()
    process.communicate()
    # its workers see that it is gone
    until(lambda: group_is_gone(process.pid))
    done = lines(file) - 1
    assert 8 <= done < len(POINTS), "killed too late to show anything"
    with file.open("ab") as stream:  # as if the last write had not come to its end
        stream.write(b'{"at": {"rho": "8", "e')
    resumed(file)


def test_an_interrupted_sweep_says_how_to_resume(tmp_path: Path) -> None:
    file = tmp_path / "s.jsonl"
    process = started(file)
    until(lambda: lines(file) > 8, process)
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=DEADLINE)
    assert process.returncode == 130, (out, err)
    assert f"interrupted; {lines(file) - 1} of {len(POINTS)} points are in {file}" in " ".join(err.split())
    assert "Traceback" not in err
    until(lambda: group_is_gone(process.pid))
    resumed(file)


def of_group(group: int) -> list[int]:
    """The processes of a group."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # it has ended
            if path.read_text(errors="replace").rpartition(")")[2].split()[2] == str(group):
                found.append(int(path.parent.name))
    return found


def listens(process: int) -> bool:
    """Whether a process does not ignore Ctrl-C."""
    (ignored,) = re.findall(r"SigIgn:\s*(\w+)", Path(f"/proc/{process}/status").read_text(encoding="utf-8"))
    return not int(ignored, 16) >> (signal.SIGINT - 1) & 1


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="counts processes as Linux shows them")
def test_workers_that_only_begin_hear_no_interrupt(tmp_path: Path) -> None:
    """Whatever a worker imports at that moment, Ctrl-C is said in one line."""
    process = started(tmp_path / "s.jsonl")
    # it, two workers, and what keeps their memory in order; while they are started it hears nothing either
    until(lambda: len(of_group(process.pid)) >= 4 and listens(process.pid), process)
    assert [one for one in of_group(process.pid) if listens(one)] == [process.pid]
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=DEADLINE)
    assert process.returncode == 130, (out, err)
    assert err.startswith("interrupted; "), err


def test_a_lost_worker_is_said_and_what_was_done_is_kept(tmp_path: Path) -> None:
    """As when the system runs out of memory: the sweep ends in one sentence, and resumes."""
    from joblib.externals.loky import reusable_executor

    file = tmp_path / "s.jsonl"
    theorem, plant = lmic.theorem(FILTER), read_plant(EXAMPLE_2)

    def kill(more: int, total: int) -> None:
        if more and lines(file) > 1:
            for process in list(reusable_executor._executor._processes.values()):
                os.kill(process.pid, signal.SIGKILL)

    with pytest.raises(SweepError, match="a worker process ended by itself"):
        sweep(theorem, plant, {"rho": RHO, "eps": EPS}, file=file, jobs=2, advance=kill)
    assert 0 < len(keys(file)) < len(POINTS)
    resumed(file)


def test_a_users_own_theorem_goes_to_the_workers(tmp_path: Path) -> None:
    """Its file is on no worker's path; neither is the plant's."""
    (tmp_path / "mine.py").write_text((root() / "peixoto2025" / "theorem1.py").read_text(encoding="utf-8"))
    theorem = lmic.theorem(tmp_path / "mine.py")
    over = {"rho": [1, 10], "eps": [2, 3]}
    swept = lmic.sweep(theorem, read_plant(EXAMPLE_2), over, jobs=2)
    assert swept.values("gamma")[1, 0] == pytest.approx(1.5849, abs=5e-5)
    alone = lmic.sweep(theorem, read_plant(EXAMPLE_2), over, jobs=1)
    assert swept.values("gamma") == pytest.approx(alone.values("gamma"), rel=1e-8)


# A cluster ------------------------------------------------------------------------------------------


@contextmanager
def running(*words: str) -> Iterator[subprocess.Popen[Any]]:
    process = subprocess.Popen([sys.executable, "-m", *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[str]:
    """The address of a Dask scheduler in a process of its own, without workers."""
    contact = tmp_path / "scheduler.json"
    words = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(contact))
    with running("distributed.cli.dask_scheduler", *words) as process:
        until(lambda: contact.exists() and contact.read_text().endswith("}"), process)
        yield json.loads(contact.read_text())["address"]


@pytest.fixture
def workers(scheduler: str, tmp_path: Path) -> Iterator[str]:
    """The same with two workers, each in a process of its own."""
    words = ("distributed.cli.dask_worker", scheduler, "--nthreads", "1", "--no-nanny", "--no-dashboard")
    with (
        running(*words, "--local-directory", str(tmp_path / "one")),
        running(*words, "--local-directory", str(tmp_path / "two")),
    ):
        yield scheduler


def test_a_cluster_does_the_same(workers: str, tmp_path: Path) -> None:
    from distributed import Client

    with Client(workers, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=DEADLINE)
    file = tmp_path / "s.jsonl"
    theorem, plant = lmic.theorem(FILTER), read_plant(EXAMPLE_2)
    over = {"rho": RHO[:4], "eps": ["1", "2", "0"]}
    swept = lmic.sweep(theorem, plant, over, file=file, scheduler=workers)
    alone = lmic.sweep(theorem, plant, over, jobs=1)
    assert swept.values("gamma") == pytest.approx(alone.values("gamma"), rel=1e-8, nan_ok=True)
    assert swept.statuses == alone.statuses
    assert len(keys(file)) == 12
    # it resumes on this machine what a cluster began, and the other way round
    lmic.sweep(theorem, plant, {**over, "rho": RHO[:5]}, file=file, jobs=1)
    lmic.sweep(theorem, plant, {**over, "rho": RHO[:6]}, file=file, scheduler=workers)
    assert len(keys(file)) == len(set(keys(file))) == 18


def test_a_scheduler_without_workers_is_said(scheduler: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lmic.sweeps.workers.TIMEOUT", 2)
    with pytest.raises(SweepError, match=r"has no worker; start some with 'dask worker tcp://"):
        sweep(lmic.theorem(FILTER), read_plant(EXAMPLE_2), {"rho": "1,2", "eps": "2"}, scheduler=scheduler)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense://x", "not an address"])
def test_a_missing_scheduler_is_said(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lmic.sweeps.workers.TIMEOUT", 2)
    with pytest.raises(SweepError, match=r"no scheduler answers at .*dask scheduler"):
        sweep(lmic.theorem(FILTER), read_plant(EXAMPLE_2), {"rho": "1,2", "eps": "2"}, scheduler=address)


def test_workers_of_another_version_are_refused(workers: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lmic.sweeps.workers.__version__", "99.0")
    with pytest.raises(SweepError, match=r"has lmic .*; install lmic 99\.0 there"):
        sweep(lmic.theorem(FILTER), read_plant(EXAMPLE_2), {"rho": "1,2", "eps": "2"}, scheduler=workers)


def test_absent_extras_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    theorem, plant = lmic.theorem(FILTER), read_plant(EXAMPLE_2)
    swept = sweep(theorem, plant, {"rho": "1", "eps": "2"}, jobs=1)
    for module in ("distributed", "pyarrow"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(SweepError, match=r"pip install 'lmic\[cluster\]'"):
        sweep(theorem, plant, {"rho": "1", "eps": "2"}, scheduler="tcp://127.0.0.1:9")
    with pytest.raises(SweepError, match=r"pip install 'lmic\[table\]'"):
        swept.write_table(tmp_path / "t.parquet")
