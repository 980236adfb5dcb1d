"""Carries out jobs one after the other in this process."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator

from nao_hil.runs.executors.base import Finished, Job, Versions, carry_out


class InlineExecutor:
    """This process; a stop waits for the job that is under way.

    Args:
        stop: Once set, no further job is begun.
    """

    def __init__(self, stop: threading.Event) -> None:
        self._stop = stop

    def run(self, jobs: Iterable[Job]) -> Iterator[Finished]:
        """As `Executor.run`."""
        here = Versions.here()
        for place, job in enumerate(jobs):
            if self._stop.is_set():
                return
            yield carry_out(place, job, here)

    def close(self) -> None:
        """Nothing is under way."""
