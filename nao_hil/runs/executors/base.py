"""Executors of jobs: the interface, and the call itself with its check of the sources."""

from __future__ import annotations

import socket
import time
import traceback
from collections.abc import Callable
from typing import Any, NamedTuple

from bridge.errors import NaoHilError
from nao_hil.runs.fingerprint import PROCESSES, library_versions, source_hash


class RunFailed(NaoHilError):
    """A run of a campaign ended in an exception, or took its process with it; names the run."""


class WorkerRefused(NaoHilError):
    """A worker has other sources or libraries than the command that asks it; names both (exit code 2)."""

    exit_code = 2


class Job(NamedTuple):
    """A call to make somewhere."""

    name: str
    """As text for the terminal."""
    function: Callable[[Any], Any]
    """At the top level of a module."""
    argument: Any


class Finished(NamedTuple):
    """A job that is done."""

    place: int
    """Place of the job among those asked for."""
    result: Any
    """None with an error."""
    error: NaoHilError | None
    seconds: float
    """Wall time of the call, s."""


class Versions(NamedTuple):
    """Inputs of a result other than its job."""

    sources: str
    """SHA-256 of all packages."""
    libraries: tuple[tuple[str, str], ...]

    @classmethod
    def here(cls) -> Versions:
        """Versions of this process."""
        return cls(source_hash(PROCESSES), library_versions())


def carry_out(place: int, job: Job, asked: Versions) -> Finished:
    """Make the call, on a worker.

    Args:
        place: Of the job among those asked for.
        job: To call.
        asked: Versions of the command that asks.

    Raises:
        WorkerRefused: this process has others.
    """
    _check(asked, Versions.here())
    begin = time.perf_counter()
    result, error = None, None
    try:
        result = job.function(job.argument)
    except NaoHilError as refused:
        error = refused
    except Exception as fault:
        words = f"run {job.name} failed: {type(fault).__name__}: {fault}\n{traceback.format_exc()}"
        error = RunFailed(words)
    return Finished(place, result, error, time.perf_counter() - begin)


def _check(asked: Versions, here: Versions) -> None:
    if asked == here:
        return
    if asked.sources != here.sources:
        what = f"sources {here.sources[:12]}, the command {asked.sources[:12]}"
    else:
        ours, theirs = dict(here.libraries), dict(asked.libraries)
        names = [name for name in {**theirs, **ours} if ours.get(name) != theirs.get(name)]
        what = "; ".join(f"{name} {ours.get(name)}, the command {theirs.get(name)}" for name in names)
    remedy = "install the same nao-hil and the same requirements.lock on both"
    if what.startswith("numerics "):
        remedy = (
            "its processor or C library rounds differently, so its walks would be others; take hosts of one "
            "kind, or make them alike (docs/campaigns.md)"
        )
    raise WorkerRefused(f"the worker on {socket.gethostname()} has {what}: {remedy}.")
