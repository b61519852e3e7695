"""Who does the work of a sweep: this process, all cores of this machine, or a Dask cluster."""

from __future__ import annotations

import gc
import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any, TypeAlias

from lmic import __version__
from lmic.errors import SweepError
from lmic.sweeps.plan import Line
from lmic.sweeps.work import Done, solve_line

#: solves lines in any order, each result as it comes
Workers: TypeAlias = Callable[[Iterable[Line]], Iterator[Done]]

#: seconds to wait for a scheduler, and for its first worker
TIMEOUT = 30

#: name of the thread in which a process watches the one that it works for
WATCH = "lmic-watch"


def here(lines: Iterable[Line]) -> Iterator[Done]:
    """One after another in this process."""
    return map(solve_line, lines)


@contextmanager
def cores(jobs: int) -> Iterator[Workers]:
    """As many processes of this machine, each with one thread for its linear algebra."""
    from joblib import Parallel, delayed, parallel_config
    from joblib.externals.loky.process_executor import BrokenProcessPool

    def solve(lines: Iterable[Line]) -> Iterator[Done]:
        work = (delayed(_served)(line, os.getpid()) for line in lines)
        try:
            with _deaf():  # the processes are started by the call
                found = Parallel(return_as="generator_unordered", batch_size=1)(work)
            yield from found
        except BrokenProcessPool as error:
            raise SweepError(
                "a worker process ended by itself (out of memory?); resume with the same command, or with fewer --jobs"
            ) from error

    with parallel_config("loky", n_jobs=jobs, inner_max_num_threads=1), warnings.catch_warnings():
        # Ctrl-C cancels what is under way, on purpose
        warnings.filterwarnings("ignore", message=".*tasks which were still being processed", category=UserWarning)
        yield solve


@contextmanager
def _deaf() -> Iterator[None]:
    """Ctrl-C is ignored for the moment in which processes are started, and by these for good.

    They inherit that it is ignored and nothing else: a mask is taken away by what multiprocessing starts beside them.
    """
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or before is None:
        yield
        return
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _served(line: Line, master: int) -> Done:
    """The work of a process that belongs to another: it leaves Ctrl-C to that one, and ends when that one is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if not any(thread.name == WATCH for thread in threading.enumerate()):
        threading.Thread(target=_watch, args=(master,), name=WATCH, daemon=True).start()
    return solve_line(line)


def _watch(master: int) -> None:
    while os.getppid() == master:
        time.sleep(1)
    os._exit(1)


@contextmanager
def _no_collection() -> Iterator[None]:
    """A client that found no scheduler closes itself when collected: never while another holds Dask's lock."""
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


@contextmanager
def cluster(address: str) -> Iterator[Workers]:
    """The workers of the Dask scheduler at an address such as tcp://host:8786."""
    try:
        from distributed import Client, as_completed
    except ImportError as error:
        raise SweepError("a cluster needs Dask: pip install 'lmic[cluster]', here and on every worker") from error
    try:
        with _no_collection():
            client = Client(address, timeout=TIMEOUT)
    except (OSError, ValueError) as error:
        raise SweepError(
            f"no scheduler answers at {address}; start one with 'dask scheduler' and give its address"
        ) from error

    def solve(lines: Iterable[Line]) -> Iterator[Done]:
        futures = client.map(solve_line, list(lines), pure=False)
        try:
            for future in as_completed(futures):
                if future.status != "finished":
                    raise SweepError(f"the cluster lost a part of the sweep ({future.exception()!r}); resume it")
                yield future.result()
                future.release()
        finally:
            client.cancel([future for future in futures if not future.done()])

    with client:
        _check_workers(client, address)
        yield solve


def _check_workers(client: Any, address: str) -> None:
    """Some worker must be there, and all must run this version of lmic."""
    try:
        client.wait_for_workers(1, timeout=TIMEOUT)
    except TimeoutError as error:
        raise SweepError(
            f"the scheduler at {address} has no worker; start some with 'dask worker {address} --nthreads 1'"
        ) from error
    versions = client.run(_version, on_error="return")
    for worker, version in versions.items():
        if version != __version__:
            said = f"has lmic {version}" if isinstance(version, str) else f"has no lmic ({version!r})"
            raise SweepError(f"the worker {worker} {said}; install lmic {__version__} there")


def _version() -> str:
    return __version__


def workers(jobs: int | None, scheduler: str | None) -> AbstractContextManager[Workers]:
    """Those that are asked for; all cores where nothing is."""
    if scheduler:
        return cluster(scheduler)
    from joblib import cpu_count

    count = cpu_count() if jobs is None else jobs
    return _alone() if count == 1 else cores(count)


@contextmanager
def _alone() -> Iterator[Workers]:
    yield here
