"""A campaign: walks over processes and hosts; results on disk are reused."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol, TypeVar

import msgspec

from bridge.errors import ConfigurationError, NaoHilError
from bridge.types import Closing
from nao_hil.runs.executors import Job, RunFailed, local_workers, open_executor
from nao_hil.runs.store import key
from nao_hil.runs.walk import Walk, WalkOutcome, walk

if TYPE_CHECKING:
    from nao_hil.runs.dataset import Dataset

_Same = list[tuple[int, Walk]]
"""Walks with their places that one run answers: they differ in name alone."""
LOOKUP_BATCH: Final = 1000
"""Walks looked up on disk at a time."""

Argument = TypeVar("Argument")
Result = TypeVar("Result")


class Interrupted(Exception):
    """The campaign was stopped before an experiment had all that it needs."""


class Progress(Protocol):
    """Receiver of a campaign's progress."""

    def expect(self, runs: int) -> None:
        """Expect so many runs more."""
        ...

    def done(self, name: str, note: str) -> None:
        """Note a finished walk; `note` names its end."""
        ...

    def say(self, text: str) -> None:
        """A sentence for the person who waits."""
        ...


class NoProgress:
    """Progress without output."""

    def expect(self, runs: int) -> None:
        """Nothing."""

    def done(self, name: str, note: str) -> None:
        """Nothing."""

    def say(self, text: str) -> None:
        """Nothing."""


class Campaign(Closing):
    """Runs walks; to be used with `with`.

    A run that fails ends no other; the first failure is raised when all others are done.

    Args:
        folder: Data set in which walks are kept; None: nowhere.
        cluster: Where runs are carried out, see `open_executor`.
        stop: Set from outside: running jobs are given up, and each call returns the results so far.
        progress: Receiver of the progress.

    Raises:
        ConfigurationError: a folder that cannot be written, or no such cluster.
    """

    def __init__(
        self,
        folder: Path | None = None,
        *,
        cluster: str = "local",
        stop: threading.Event | None = None,
        progress: Progress | None = None,
    ) -> None:
        self._stop = stop or threading.Event()
        self._progress = progress or NoProgress()
        self._executor = open_executor(cluster, self._stop, self._progress.say)
        self._at_once = local_workers(cluster)
        self._dataset = _open_dataset(folder) if folder is not None else None
        self._telling = threading.Lock()

    @property
    def interrupted(self) -> bool:
        """The campaign was stopped: results may be incomplete."""
        return self._stop.is_set()

    def walk(self, walks: Sequence[Walk]) -> list[WalkOutcome]:
        """Walk them all; when stopped, the finished ones, in the given order.

        Raises:
            NaoHilError: a configuration that cannot be walked, or a run that failed; names it.
        """
        self._progress.expect(len(walks))
        results = dict(self.stream(walks))
        return [results[place] for place in sorted(results)]

    def stream(self, walks: Iterable[Walk]) -> Iterator[tuple[int, WalkOutcome]]:
        """Walk any number of walks; yields the place and result of each, in the order of completion.

        Raises:
            NaoHilError: as `walk`, after the last.
        """
        known: deque[tuple[int, WalkOutcome]] = deque()
        under_way: dict[int, _Same] = {}
        failures: list[NaoHilError] = []
        for finished in self._executor.run(self._jobs(walks, known, under_way)):
            yield from _emptied(known)
            same = under_way.pop(finished.place)
            if finished.error is not None:
                failures.append(_named(finished.error, same[0][1]))
                for _, task in same:
                    self._progress.done(task.name, "failed")
                continue
            if self._dataset:
                self._dataset.put(finished.result, finished.seconds)
            for place, task in same:
                self._progress.done(task.name, _note(finished.result))
                yield place, replace(finished.result, walk=task)
        yield from _emptied(known)
        _raise_first(failures)

    def _jobs(
        self, walks: Iterable[Walk], known: deque[tuple[int, WalkOutcome]], under_way: dict[int, _Same]
    ) -> Iterator[Job]:
        """A job for each walk that is not on disk; results on disk are added to `known`."""
        job, numbered = 0, enumerate(walks)
        while block := list(islice(numbered, LOOKUP_BATCH)):
            waiting: dict[str, _Same] = {}
            for place, task in block:
                waiting.setdefault(key(task), []).append((place, task))
            kept = self._dataset.find({k: same[0][1] for k, same in waiting.items()}) if self._dataset else {}
            for each, same in waiting.items():
                if (before := kept.get(each)) is not None:
                    known.extend((place, replace(before, walk=task)) for place, task in same)
                    for _, task in same:
                        self._progress.done(task.name, f"{_note(before)}, walked before")
                    continue
                under_way[job], first = same, same[0][1]
                job += 1
                yield Job(f"{first.name} (seed {first.config.seed})", walk, first.with_contents())

    def map(self, name: str, function: Callable[[Any], Any], arguments: Sequence[Any]) -> list[Any]:
        """Call a function of a module's top level with each argument, in the workers; as `walk`, not kept."""
        self._progress.expect(len(arguments))
        jobs = [Job(f"{name} ({i + 1} of {len(arguments)})", function, a) for i, a in enumerate(arguments)]
        results: dict[int, Any] = {}
        failures = []
        for finished in self._executor.run(jobs):
            if finished.error is not None:
                failures.append(finished.error)
            else:
                results[finished.place] = finished.result
            self._progress.done(name, "failed" if finished.error else "")
        _raise_first(failures)
        return [results[place] for place in sorted(results)]

    def watch(
        self,
        function: Callable[[Argument], Result],
        arguments: Sequence[Argument],
        note: Callable[[Argument, Result], tuple[str, str]],
    ) -> list[Result | None]:
        """Call a function with each argument, in as many threads as a local cluster would have processes.

        For runs that are processes of their own and only need watching; the function itself looks at
        `interrupted`.

        Args:
            function: The function; raises `Interrupted` when stopped.
            arguments: One for each call.
            note: Name and result of a finished call, for the progress.

        Returns:
            In the order of the arguments; None: not finished.

        Raises:
            Exception: the first that a call raised; those not begun are not made.
        """
        self._progress.expect(len(arguments))

        failed = threading.Event()

        def call(argument: Argument) -> Result | None:
            """One job; None when the campaign ends before it."""
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

        with ThreadPoolExecutor(self._at_once) as threads:
            return list(threads.map(call, arguments))

    def close(self) -> None:
        """Give up running jobs; finished walks are kept."""
        self._executor.close()
        if self._dataset:
            self._dataset.close()


def _open_dataset(folder: Path) -> Dataset:
    try:
        from nao_hil.runs.dataset import Dataset
    except ModuleNotFoundError as error:
        raise ConfigurationError(f"keeping walks needs {error.name}; install nao-hil[campaign].") from None
    return Dataset(folder)


def _emptied(results: deque[tuple[int, WalkOutcome]]) -> Iterator[tuple[int, WalkOutcome]]:
    while results:
        yield results.popleft()


def _named(error: NaoHilError, task: Walk) -> NaoHilError:
    """The error with the configuration of its walk."""
    words = f"{error}\nconfiguration of {task.name}: {msgspec.json.encode(task.config).decode()}"
    if isinstance(error, RunFailed):
        return RunFailed(words)
    if isinstance(error, ConfigurationError):
        return ConfigurationError(f"{task.name} (seed {task.config.seed}): {error}")
    return error


def _raise_first(failures: Sequence[NaoHilError]) -> None:
    if not failures:
        return
    first = failures[0]
    if len(failures) > 1 and isinstance(first, RunFailed):
        raise RunFailed(f"{len(failures)} runs failed; the first: {first}") from None
    raise first


def _note(result: WalkOutcome) -> str:
    end = result.end
    return f"{end.ending} {end.time:.1f} s" if end.survived else f"{end.ending} at {end.time:.1f} s"
