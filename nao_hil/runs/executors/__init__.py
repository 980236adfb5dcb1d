"""Executors of a campaign's runs: in this process, in local processes, on a dask cluster."""

from __future__ import annotations

import os
import re
import threading
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Final, TypeAlias

from bridge.errors import ConfigurationError
from nao_hil.runs.executors.base import Finished, Job, RunFailed, Versions, WorkerRefused, carry_out

if TYPE_CHECKING:  # dask is an extra
    from nao_hil.runs.executors.dask import DaskExecutor

__all__ = ["Executor", "Finished", "Job", "RunFailed", "WorkerRefused", "local_workers", "open_executor"]


class InlineExecutor:
    """Runs in this process; a stop waits for the job that is under way.

    Args:
        stop: Once set, no further job is begun.
    """

    def __init__(self, stop: threading.Event) -> None:
        self._stop = stop

    def run(self, jobs: Iterable[Job]) -> Iterator[Finished]:
        """Carry out jobs; each once, in the order of completion; ends early when stopped.

        Takes a few jobs ahead of those that are done, so that any number of them can be streamed through.

        Raises:
            WorkerRefused: a worker has other sources.
            LinkError: the cluster cannot be reached, or cannot be reached any more.
        """
        here = Versions.here()
        for place, job in enumerate(jobs):
            if self._stop.is_set():
                return
            yield carry_out(place, job, here)

    def close(self) -> None:
        """Nothing is under way."""


Executor: TypeAlias = "InlineExecutor | DaskExecutor"
FORMS: Final = "`inline`, `local`, `local:N`, `tcp://HOST:PORT` or `tls://HOST:PORT`"


def local_workers(cluster: str) -> int:
    """Number of processes of this machine for a campaign: N of `local:N`, otherwise one per core."""
    named = re.fullmatch(r"local:(\d+)", cluster)
    return 1 if cluster == "inline" else int(named[1]) if named else len(os.sched_getaffinity(0))


def open_executor(
    cluster: str, stop: threading.Event | None = None, notify: Callable[[str], None] = lambda _: None
) -> Executor:
    """An executor; it starts its processes, or connects to its scheduler, with the first job.

    Args:
        cluster: `inline`: this process; `local`: a process per core; `local:N`: N processes; an address:
            the scheduler of a dask cluster.
        stop: Once set, running jobs are given up.
        notify: Called with a sentence that names the cause of a wait.

    Raises:
        ConfigurationError: none of these, or dask is not installed.
    """
    stop = stop or threading.Event()
    if cluster == "inline":
        return InlineExecutor(stop)
    local = re.fullmatch(r"local(:[1-9]\d{0,3})?", cluster)
    if not local and not re.fullmatch(r"(tcp|tls)://[^\s/]+:\d+", cluster):
        raise ConfigurationError(f"--cluster {cluster}: must be {FORMS}.")
    try:
        from nao_hil.runs.executors.dask import DaskExecutor, LocalProcesses, Scheduler
    except ModuleNotFoundError as error:
        raise ConfigurationError(
            f"--cluster {cluster} needs {error.name}; install nao-hil[campaign], or say --cluster inline."
        ) from None
    return DaskExecutor(LocalProcesses(local_workers(cluster)) if local else Scheduler(cluster), stop, notify)
