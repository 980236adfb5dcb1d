"""The way to a dask scheduler: one of our own with local processes, or one that runs elsewhere."""

from __future__ import annotations

import contextlib
import logging
import os
import signal
from typing import Any, Final, Protocol

import dask
from distributed import Client, LocalCluster, Security

ANSWER: Final = 5.0
"""s that a scheduler may take to answer."""
_QUIET: Final = 60
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


class SchedulerConnection(Protocol):
    """Makes clients of one scheduler."""

    address: str
    """As text for the terminal."""

    def open(self) -> Any:
        """A client.

        Raises:
            OSError: nobody answers there.
        """
        ...

    def close(self) -> None:
        """End the started processes and their jobs."""
        ...


def _silence() -> None:
    """Faults are raised; dask's own log would interrupt the progress display."""
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(_QUIET)


class LocalProcesses:
    """A scheduler in this process, and worker processes of one thread each that end with it.

    Args:
        workers: Processes.
    """

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
                silence_logs=_QUIET,
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
        """A client."""
        _silence()
        security = Security(require_encryption=True) if self.address.startswith("tls") else None
        return Client(self.address, timeout=ANSWER, security=security, set_as_default=False)

    def close(self) -> None:
        """Nothing was started here."""
