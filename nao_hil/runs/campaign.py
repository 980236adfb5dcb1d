"""A campaign: walks over the cores, with what was walked before taken from disk, and progress shown."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, TypeVar

from nao_hil.runs.executor import Job, WorkerPool
from nao_hil.runs.store import Store
from nao_hil.runs.walk import Walk, WalkOutcome, walk

Argument = TypeVar("Argument")
Result = TypeVar("Result")


class Interrupted(Exception):
    """The campaign was stopped before an experiment had what it cannot do without."""


class Progress(Protocol):
    """Who is told how far it is."""

    def expect(self, runs: int) -> None:
        """So many runs more."""
        ...

    def done(self, name: str, note: str) -> None:
        """One of them is done; the note says how it ended."""
        ...


class Silent:
    """Progress that nobody sees."""

    def expect(self, runs: int) -> None:
        """Nothing."""

    def done(self, name: str, note: str) -> None:
        """Nothing."""


class Campaign:
    """Runs walks; to be used with `with`.

    Results are in the order of what was asked, whatever the order in which they came.

    Args:
        folder: Where walks are kept; None: nowhere.
        workers: Processes; None: one per core.
        stop: Set from outside: what is under way is given up, and each call returns what is there.
        progress: Who is told.
    """

    def __init__(
        self,
        folder: Path | None = None,
        *,
        workers: int | None = None,
        stop: threading.Event | None = None,
        progress: Progress | None = None,
    ) -> None:
        self._stop = stop or threading.Event()
        self._pool = WorkerPool(workers, self._stop)
        self._store = Store(folder) if folder is not None else None
        self._progress = progress or Silent()
        self._telling = threading.Lock()

    @property
    def workers(self) -> int:
        """Most runs at a time."""
        return self._pool.workers

    @property
    def interrupted(self) -> bool:
        """It was stopped: what is there may be less than what was asked for."""
        return self._stop.is_set()

    def walk(self, walks: Sequence[Walk]) -> list[WalkOutcome]:
        """Walk them all; when stopped, those that are done.

        Raises:
            NaoHilError: a configuration that cannot be walked, or a run that failed; names it.
        """
        self._progress.expect(len(walks))
        results = [self._store.get(task) if self._store else None for task in walks]
        for task, result in zip(walks, results, strict=True):
            if result is not None:
                self._progress.done(task.name, f"{_note(result)}, walked before")
        left = [i for i, result in enumerate(results) if result is None]
        jobs = [Job(f"{walks[i].name} (seed {walks[i].config.seed})", walk, walks[i]) for i in left]
        for place, result in self._pool.run(jobs):
            results[left[place]] = result
            if self._store:
                self._store.put(result)
            self._progress.done(result.walk.name, _note(result))
        return [result for result in results if result is not None]

    def map(self, name: str, function: Callable[[Any], Any], arguments: Sequence[Any]) -> list[Any]:
        """Call a function of a module's top level with each argument, in the workers; as `walk`, not kept."""
        self._progress.expect(len(arguments))
        jobs = [Job(f"{name} ({i + 1} of {len(arguments)})", function, a) for i, a in enumerate(arguments)]
        found: dict[int, Any] = {}
        for place, result in self._pool.run(jobs):
            found[place] = result
            self._progress.done(name, "")
        return [found[place] for place in sorted(found)]

    def watch(
        self,
        function: Callable[[Argument], Result],
        arguments: Sequence[Argument],
        note: Callable[[Argument, Result], tuple[str, str]],
    ) -> list[Result | None]:
        """Call a function with each argument, in as many threads as there are workers.

        For runs that are processes of their own and only need watching; the function itself looks at
        `interrupted`.

        Args:
            function: What to call; raises `Interrupted` when it was stopped.
            arguments: One for each call.
            note: What to tell of a call that is done: its name, and how it ended.

        Returns:
            In the order of the arguments; None: stopped before it was done.

        Raises:
            Exception: the first that a call raised; those not begun are not made.
        """
        self._progress.expect(len(arguments))

        failed = threading.Event()

        def call(argument: Argument) -> Result | None:
            if self.interrupted or failed.is_set():
                return None
            try:
                result = function(argument)
            except Interrupted:
                return None
            except Exception:
                failed.set()
                raise
            with self._telling:
                self._progress.done(*note(argument, result))
            return result

        with ThreadPoolExecutor(self.workers) as threads:
            return list(threads.map(call, arguments))

    def __enter__(self) -> Campaign:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._pool.__exit__(kind, error, trace)


def _note(result: WalkOutcome) -> str:
    end = result.end
    return f"{end.ending} {end.time:.1f} s" if end.survived else f"{end.ending} at {end.time:.1f} s"
