"""Calls that a program began without waiting for them: `pCall` and the methods that take their numbers."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from typing import Any, Final

from bridge.adapters.naoqi.arguments import number
from bridge.adapters.naoqi.motion_tasks import MotionTasks
from bridge.errors import NaoqiRefused

MAX_POSTS: Final = 10_000
"""Calls that have not ended."""
_LONGEST: Final = 3_600_000
"""ms that a call may wait for another."""


class Posts:
    """Numbers of calls that run; thread-safe but for `stop`, whose caller locks.

    Args:
        tasks: among which the calls' tasks are.
        numbers: for the calls; none is a task's.
        end_motion: ends a motion by its number, and holds its joints.
    """

    def __init__(
        self, tasks: Sequence[MotionTasks], numbers: Iterator[int], end_motion: Callable[[int], bool]
    ) -> None:
        self._tasks, self._numbers, self._end_motion = tasks, numbers, end_motion
        self._running: dict[int, Future[Any]] = {}
        self._ends: dict[int, Callable[[], Any]] = {}
        """Of calls that are no tasks: what ends them."""

    def add(self, result: Any, end: Callable[[], Any] | None = None) -> int:
        """The number of a call.

        Args:
            result: what it gave, or a future of it.
            end: ends it, if it is no task.
        """
        key = next(self._numbers)
        if isinstance(result, Future):
            if len(self._running) >= MAX_POSTS:
                raise NaoqiRefused(f"{MAX_POSTS} calls run already; wait for some.")
            self._running[key] = result
            if end is not None:
                self._ends[key] = end
            result.add_done_callback(lambda _: self._forget(key))
        return key

    def _forget(self, key: int) -> None:
        self._running.pop(key, None)
        self._ends.pop(key, None)

    def running(self, key: Any) -> bool:
        """Whether the call of this number has not ended."""
        return _key(key) in self._running

    def wait(self, key: Any, timeout: Any = 0) -> Future[Any]:
        """Wait for the end of a call; true when the time was over before.

        Args:
            key: number of the call.
            timeout: ms; 0: as long as it takes.
        """
        milliseconds = number(timeout, "wait: timeout", 0, _LONGEST)
        ended: Future[Any] = Future()
        once = threading.Lock()

        def end(over: bool) -> None:
            with once:
                if not ended.done():
                    ended.set_result(over)

        call = self._running.get(_key(key))
        if call is None:
            end(False)
            return ended
        if milliseconds:
            timer = threading.Timer(milliseconds / 1000.0, end, [True])
            timer.daemon = True
            timer.start()
        call.add_done_callback(lambda _: end(False))
        return ended

    def stop(self, key: Any) -> bool:
        """Stop a call, or a motion by its number in `getTaskList`; whether there was one."""
        wanted = _key(key)
        done = self._running.get(wanted)
        if done is None:
            return self._end_motion(wanted)
        for tasks in self._tasks:
            for task in tasks.of(done):
                if not (task.joints and self._end_motion(task.number)):
                    tasks.end_these([task])
                return True
        end = self._ends.get(wanted)
        if end is not None:
            end()
        return end is not None


def _key(key: Any) -> int:
    if isinstance(key, bool) or not isinstance(key, int):
        raise NaoqiRefused(f"{key!r:.40} was given; the number of a call is expected.")
    return key
