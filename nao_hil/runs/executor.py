"""Worker processes that take one job after the other, and say which one they failed in.

The standard library's pools tell no more than that some worker died; here each worker has its own pipe, so
that a crash names its run, and a stop kills what is under way without waiting for it.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from types import TracebackType
from typing import Any, Final, NamedTuple

from bridge.errors import NaoHilError

POLL: Final = 0.2
"""s between looks at whether to stop."""
_ONE_THREAD: Final = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Matrices here are small: threads of the linear algebra would only take the cores from the other workers."""


class RunFailed(NaoHilError):
    """A run of a campaign ended in an exception, or took its process with it; names the run."""


class Job(NamedTuple):
    """A call to make somewhere."""

    name: str
    """For people."""
    function: Callable[[Any], Any]
    """At the top level of a module."""
    argument: Any


class _Worker(NamedTuple):
    process: BaseProcess
    pipe: Connection


class WorkerPool:
    """Processes that carry out jobs; to be used with `with`.

    Each is started when it is first needed, and ends with this process.

    Args:
        workers: How many; None: as many as there are cores to run on.
        stop: Once set, what is under way is given up.
    """

    def __init__(self, workers: int | None = None, stop: threading.Event | None = None) -> None:
        self._most = workers or len(os.sched_getaffinity(0))
        self._stop = stop or threading.Event()
        self._context = multiprocessing.get_context("spawn")
        self._idle: list[_Worker] = []
        self._busy: dict[Connection, tuple[_Worker, int]] = {}

    @property
    def workers(self) -> int:
        """Most processes at a time."""
        return self._most

    def run(self, jobs: Sequence[Job]) -> Iterator[tuple[int, Any]]:
        """Carry out jobs; yields the place of each among `jobs` with its result, in the order of completion.

        Ends early when stopped.

        Raises:
            NaoHilError: what a job raised of that kind, as it is.
            RunFailed: any other exception of a job, or a process that died; names the job.
        """
        waiting = deque(enumerate(jobs))
        while (waiting or self._busy) and not self._stop.is_set():
            while waiting and len(self._busy) < self._most:
                place, job = waiting.popleft()
                self._give(place, job)
            for pipe in wait(list(self._busy), timeout=POLL):
                assert isinstance(pipe, Connection)
                worker, place = self._busy.pop(pipe)
                yield place, self._take(worker, jobs[place])
        if self._stop.is_set():
            self._kill()

    def _give(self, place: int, job: Job) -> None:
        worker = self._idle.pop() if self._idle else self._start()
        worker.pipe.send((job.function, job.argument))
        self._busy[worker.pipe] = (worker, place)

    def _start(self) -> _Worker:
        ours, theirs = self._context.Pipe()
        process = self._context.Process(target=_work, args=(theirs,), daemon=True)
        before = {name: os.environ.get(name) for name in _ONE_THREAD}
        os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
        try:
            process.start()
        finally:
            for name, value in before.items():
                if value is None:
                    del os.environ[name]
                else:
                    os.environ[name] = value
        theirs.close()
        return _Worker(process, ours)

    def _take(self, worker: _Worker, job: Job) -> Any:
        try:
            answer = worker.pipe.recv()
        except (EOFError, OSError):
            worker.process.join()
            raise RunFailed(
                f"run {job.name}: its process died (exit code {worker.process.exitcode})."
            ) from None
        self._idle.append(worker)
        if isinstance(answer, NaoHilError):
            raise answer
        if isinstance(answer, _Failure):
            raise RunFailed(f"run {job.name} failed: {answer.error}\n{answer.trace}")
        return answer

    def _kill(self) -> None:
        for worker in [*self._idle, *(worker for worker, _ in self._busy.values())]:
            worker.process.kill()
            worker.process.join()
            worker.pipe.close()
        self._idle.clear()
        self._busy.clear()

    def __enter__(self) -> WorkerPool:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._kill()


class _Failure(NamedTuple):
    """What a worker sends in place of a result."""

    error: str
    trace: str


def _work(pipe: Connection) -> None:
    """A worker's life: until the pipe ends, which it does with the parent."""
    # a Ctrl-C in the terminal reaches every process of it; the parent alone decides
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    while True:
        try:
            function, argument = pipe.recv()
        except (EOFError, OSError):
            return
        try:
            answer = function(argument)
        except NaoHilError as error:
            answer = error
        except Exception as error:
            answer = _Failure(f"{type(error).__name__}: {error}", traceback.format_exc())
        pipe.send(answer)
