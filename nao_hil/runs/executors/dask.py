"""Carries out jobs on the workers of a dask scheduler: its own with local processes, or one elsewhere."""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import logging
import os
import queue
import signal
import threading
import time
import uuid
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import CancelledError
from itertools import islice
from typing import Any, Final

import dask
from distributed import Client, LocalCluster, Security
from distributed.client import ClosedClientError
from distributed.comm.core import CommClosedError
from distributed.scheduler import KilledWorker

from bridge.errors import ConfigurationError, LinkError
from nao_hil.runs.executors.base import Finished, Job, RunFailed, Versions, WorkerRefused, carry_out

ANSWER_TIMEOUT: Final = 15.0
"""s that a scheduler may take to answer."""
_SILENT_LEVEL: Final = 60
"""Above every level of logging."""
_NO_INTERRUPT: Final = "import signal\nsignal.signal(signal.SIGINT, signal.SIG_IGN)\n"
"""A Ctrl-C in the terminal reaches every process of it; the command alone decides."""

_SETTINGS: Final = {
    "distributed.scheduler.worker-saturation": 1.0,
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    # A worker's restart takes longer than dask's 15 s on a busy machine; afterwards dask would start none.
    "distributed.deploy.lost-worker-timeout": "365 days",
    # How it watches itself took 5 % of a core, and 5 % of each worker's time.
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1 s",
    "distributed.admin.system-monitor.interval": "10 s",
    "distributed.admin.system-monitor.gil.enabled": False,
    # Logs for dask's developers, which grow with each walk for its first 10,000.
    "distributed.admin.log-length": 100,
    "distributed.admin.low-level-log-length": 100,
}


def _silence() -> None:
    """Faults are raised; dask's own log would interrupt the progress display."""
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(_SILENT_LEVEL)


class LocalProcesses:
    """A scheduler in this process, and worker processes of one thread each that end with it."""

    def __init__(self, workers: int) -> None:
        self.address = f"local:{workers}"
        self._workers = workers
        self._cluster: Any = None

    def open(self) -> Any:
        """A client; starts the processes when they do not run."""
        _silence()
        if self._cluster is None:
            dask.config.set(_SETTINGS)  # for good: some are read when a worker dies
            self._cluster = LocalCluster(
                n_workers=self._workers,
                threads_per_worker=1,
                memory_limit=0,
                dashboard_address="127.0.0.1:0",
                silence_logs=_SILENT_LEVEL,
                preload=[_NO_INTERRUPT],
            )
        return Client(self._cluster, set_as_default=False)

    def close(self) -> None:
        """Kill the workers: a walk under way would be waited for otherwise."""
        if self._cluster is None:
            return
        for nanny in self._cluster.workers.values():
            nanny.close_gracefully()  # it starts no other worker
            if nanny.pid is not None:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(nanny.pid, signal.SIGKILL)
        self._cluster.close()
        self._cluster = None


class Scheduler:
    """A scheduler that runs elsewhere.

    Args:
        address: `tcp://HOST:PORT`, or `tls://HOST:PORT` with the certificates that dask's own configuration
            names (`distributed.comm.tls`).
    """

    def __init__(self, address: str) -> None:
        self.address = address

    def open(self) -> Any:
        """A client.

        Raises:
            OSError: no answer there.
        """
        _silence()
        security = Security(require_encryption=True) if self.address.startswith("tls") else None
        return Client(self.address, timeout=ANSWER_TIMEOUT, security=security, set_as_default=False)

    def close(self) -> None:
        """Close nothing: the cluster was not started here."""


POLL_INTERVAL: Final = 0.2
"""s between two checks for a stop."""
SPARE_JOBS: Final = 16
"""Jobs under way beyond two for each worker, when new ones are submitted."""
FEW_SPARE_JOBS: Final = 4
"""Jobs under way beyond one for each worker, when new ones are submitted: none waits for this process."""
MAX_LOST_TIME: Final = 300.0
"""s for which a lost scheduler is searched for, and a worker awaited."""
COUNT_INTERVAL: Final = 5.0
"""s between two counts of the workers."""
_LOST: Final = (CancelledError, ClosedClientError, CommClosedError, OSError, TimeoutError)


class _Lost(Exception):
    """The scheduler is lost, with all that it knew."""


class DaskExecutor:
    """A dask cluster.

    A worker that dies has its jobs done by others; dask gives up a job that has killed four. A lost scheduler
    is searched for, and gets all unfinished jobs again. Without workers for as long the run ends.

    Args:
        connection: To the scheduler.
        stop: Once set, running jobs are given up.
        notify: Called with a sentence that names the cause of a wait.
    """

    def __init__(
        self, connection: LocalProcesses | Scheduler, stop: threading.Event, notify: Callable[[str], None]
    ) -> None:
        self._connection, self._stop, self._notify = connection, stop, notify
        self._client: Any = None
        self._threads = 0
        self._counted = -COUNT_INTERVAL
        self._alone: float | None = None
        """Beginning of the time without a worker, s."""

    def run(self, jobs: Iterable[Job]) -> Iterator[Finished]:
        """As `InlineExecutor.run`."""
        if self._client is None:
            self._client = self._reach(first=True)
        flight = _Flight(self._client)
        waiting = enumerate(jobs)
        try:
            while not self._stop.is_set():
                try:
                    self._count()
                    few = len(flight.jobs) <= self._threads + FEW_SPARE_JOBS
                    missing = 2 * self._threads + SPARE_JOBS - len(flight.jobs) if few else 0
                    flight.submit(dict(islice(waiting, missing)))
                    if not flight.jobs:
                        return
                    finished = flight.finished()
                except _Lost:
                    self._drop()
                    if (client := self._reach()) is None:
                        return
                    self._client = client
                    flight.again(client)
                    continue
                yield from finished
        finally:
            flight.give_up()

    def _count(self) -> None:
        """Count the workers, now and then.

        Raises:
            LinkError: there has been none for too long.
        """
        now = time.monotonic()
        if now - self._counted < COUNT_INTERVAL:
            return
        self._counted = now
        try:
            self._threads = sum(self._client.nthreads().values())
        except (*_LOST, AttributeError):  # a client that has given up has no `scheduler`
            raise _Lost from None
        if self._threads:
            self._alone = None
        elif self._alone is None:
            self._alone = now
            self._notify(
                f"{self._connection.address} has no worker; one is waited for, {MAX_LOST_TIME:.0f} s at most."
            )
        elif now - self._alone > MAX_LOST_TIME:
            raise LinkError(
                f"the scheduler at {self._connection.address} has had no worker for {MAX_LOST_TIME:.0f} s; "
                "finished runs are kept; repeat the command."
            )

    def _reach(self, first: bool = False) -> Any:
        """A client; None: stopped meanwhile."""
        until = time.monotonic() + (0.0 if first else MAX_LOST_TIME)
        if not first:
            address = self._connection.address
            bound = f"{MAX_LOST_TIME:.0f} s at most"
            self._notify(f"The scheduler at {address} is gone; it is looked for, {bound}.")
        while not self._stop.is_set():
            try:
                return self._connection.open()
            except (OSError, TimeoutError, ValueError, TypeError) as error:
                if isinstance(error, (ValueError, TypeError)):  # how dask refuses certificates
                    raise ConfigurationError(f"--cluster {self._connection.address}: {error}") from None
                if time.monotonic() > until:
                    raise LinkError(
                        f"no dask scheduler answers at {self._connection.address}"
                        + (
                            "; start one with `dask scheduler`."
                            if first
                            else f" for {MAX_LOST_TIME:.0f} s; finished runs are kept; repeat the command."
                        )
                    ) from None
            self._stop.wait(1.0)
        return None

    def _drop(self) -> None:
        self._alone = None
        if self._client is not None:
            # a busy machine, or a client in search of its scheduler; results are in
            with contextlib.suppress(TimeoutError, asyncio.TimeoutError, OSError, RuntimeError):
                self._client.close(timeout=1)
            self._client = None

    def close(self) -> None:
        """Give up running jobs, and end the processes started for them."""
        if self._stop.is_set():
            self._connection.close()
        self._drop()
        self._connection.close()


class _Flight:
    """Jobs under way at a scheduler."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._versions = Versions.here()
        self.jobs: dict[int, Job] = {}
        """By place."""
        self._futures: dict[int, Any] = {}
        """Futures of the jobs submitted to the scheduler."""
        self._done: queue.Queue[tuple[int, Any]] = queue.Queue()
        self._coming: list[tuple[int, Any]] = []
        """Futures of those whose results are fetched: the place and the future."""
        self._fetch: concurrent.futures.Future[list[Finished]] | None = None

    def submit(self, jobs: Mapping[int, Job]) -> None:
        """Give the scheduler these and all others that it lacks, at once: it keeps a note of each submission.

        Raises:
            _Lost: the scheduler is lost.
        """
        self.jobs |= jobs
        new = {place: job for place, job in self.jobs.items() if place not in self._futures}
        if not new:
            return
        keys = [f"{job.function.__name__}-{uuid.uuid4().hex}" for job in new.values()]
        try:
            futures = self._client.map(
                carry_out, list(new), list(new.values()), asked=self._versions, key=keys, pure=False
            )
        except _LOST:
            raise _Lost from None
        for place, future in zip(new, futures, strict=True):
            self._futures[place] = future
            future.add_done_callback(lambda done, place=place, to=self._done: to.put((place, done)))

    def again(self, client: Any) -> None:
        """Another scheduler, without jobs."""
        self._client = client
        self._done = queue.Queue()
        self._fetch = None
        self._futures.clear()

    def finished(self) -> list[Finished]:
        """Finished jobs; waits a moment for them.

        Raises:
            WorkerRefused: a worker has other sources.
            _Lost: the scheduler is lost.
        """
        arrived = [] if self._fetch else self._begin_to_fetch()
        if self._fetch and concurrent.futures.wait([self._fetch], POLL_INTERVAL).done:
            try:
                fetched = self._fetch.result()
            except _LOST:
                raise _Lost from None
            self._fetch = None
            arrived += fetched
            there = {each.place for each in fetched}
            for place, future in self._coming:  # lost with its worker, and failed when repeated
                if place not in there:
                    self._done.put((place, future))
        if not arrived and self._client.status == "closed":
            raise _Lost
        for each in arrived:
            del self.jobs[each.place], self._futures[each.place]
        return arrived

    def _begin_to_fetch(self) -> list[Finished]:
        """Request the results of finished jobs; returns the failed ones.

        The answer is not awaited: jobs lost with their worker are repeated first.
        """
        batch = []
        try:
            batch.append(self._done.get(timeout=POLL_INTERVAL))
            while True:
                batch.append(self._done.get_nowait())
        except queue.Empty:
            pass
        failed = [each for each in batch if each[1].status in ("error", "cancelled", "lost")]
        self._coming = [each for each in batch if each not in failed]
        if self._coming:
            results = self._client.gather([future for _, future in self._coming], "skip", asynchronous=True)
            self._fetch = asyncio.run_coroutine_threadsafe(results, self._client.loop.asyncio_loop)
        return [self._failed(place, future) for place, future in failed]

    def _failed(self, place: int, future: Any) -> Finished:
        if future.status != "error":  # cancelled or lost with its scheduler
            raise _Lost
        error, job = future.exception(), self.jobs[place]
        if isinstance(error, WorkerRefused):
            raise error
        if isinstance(error, KilledWorker):
            words = f"run {job.name}: its process died, on each of {error.allowed_failures + 1} workers."
        elif isinstance(error, (ImportError, AttributeError)):  # the call itself cannot be read there
            raise WorkerRefused(f"a worker has no such nao-hil ({error}); install the same one there.")
        else:
            words = f"run {job.name} failed on the cluster: {type(error).__name__}: {error}"
        return Finished(place, None, RunFailed(words), 0.0)

    def give_up(self) -> None:
        """Cancel them."""
        if self._fetch:
            self._fetch.cancel()
        if self._futures and self._client.status == "running":
            self._client.cancel(list(self._futures.values()), force=True)
        self.jobs.clear()
