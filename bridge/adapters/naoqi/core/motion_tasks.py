"""Lasting motions, and calls for which a program does not wait (`pCall`)."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace
from typing import Any, Final

from bridge.errors import NaoqiRefused

MotionTask = Generator[int, None, Any]
"""Yields the moment of its next step (robot time, ms); returns the result of its call."""


def robot_lost() -> NaoqiRefused:
    """Error of a call that waits for a motion of a lost robot."""
    return NaoqiRefused("The robot went away before the motion ended.")


@dataclass(frozen=True)
class RunningTask:
    """A running motion."""

    number: int
    """Counts up from 1."""
    name: str
    """Name of its method."""
    joints: tuple[str, ...]
    moment: int
    """Time of its next step, ms."""
    steps: MotionTask
    done: Future[Any]
    locks: bool = False
    """Later locking motions of its joints wait for its end."""
    stopped: Any = None
    """Result of the call if the task is stopped."""


class MotionTasks:
    """Runs tasks in the robot's cycles; not thread-safe, the caller locks.

    Args:
        numbers: of the tasks; None: from 1 on.
    """

    def __init__(self, numbers: Iterator[int] | None = None) -> None:
        self._running: list[RunningTask] = []
        self._numbers = itertools.count(1) if numbers is None else numbers
        self._abandoned = False

    def begin(
        self,
        task: MotionTask,
        name: str = "",
        joints: Sequence[str] = (),
        *,
        locks: bool = False,
        stopped: Any = None,
    ) -> Future[Any]:
        """Run a task to its first wait; the future gets its result or its exception.

        Args:
            name: of its method; empty: not a motion of joints.
            locks: it waits for the end of earlier tasks that lock one of its joints, and locks them (vendor's
                page on motion tasks).
        """
        if self._abandoned:
            raise robot_lost()
        done: Future[Any] = Future()
        number = next(self._numbers)
        steps = self._postponed(task, number, set(joints)) if locks else task
        self._advance(RunningTask(number, name, tuple(joints), 0, steps, done, locks, stopped))
        return done

    def _postponed(self, task: MotionTask, number: int, joints: set[str]) -> MotionTask:
        while any(one.locks and one.number < number and joints & set(one.joints) for one in self._running):
            yield 0  # until the next cycle
        return (yield from task)

    @property
    def motions(self) -> list[RunningTask]:
        """Tasks that use joints, oldest first."""
        return [task for task in self._running if task.joints]

    def of(self, done: Future[Any]) -> list[RunningTask]:
        """The running task with this future."""
        return [task for task in self._running if task.done is done]

    def run(self, now: int) -> None:
        """Advance the tasks that are due at `now`, ms."""
        due = [task for task in self._running if task.moment <= now]
        self._running = [task for task in self._running if task.moment > now]
        for task in due:
            self._advance(task)

    def end(self) -> None:
        """Stop all tasks."""
        self.stop_tasks(list(self._running))

    def abandon(self) -> None:
        """Fail all tasks, and refuse further ones, after the loss of the robot."""
        self._abandoned = True
        self.stop_tasks(list(self._running), robot_lost())

    def stop_tasks(self, tasks: Sequence[RunningTask], error: Exception | None = None) -> None:
        """Stop some tasks; their callers get the error, or the result of a stopped motion."""
        numbers = {task.number for task in tasks}
        self._running = [task for task in self._running if task.number not in numbers]
        for task in tasks:
            task.steps.close()
            if error is None:
                task.done.set_result(task.stopped)
            else:
                task.done.set_exception(error)

    def _advance(self, task: RunningTask) -> None:
        try:
            moment = next(task.steps)
        except StopIteration as end:
            task.done.set_result(end.value)
        except Exception as error:
            task.done.set_exception(error)
        else:
            self._running.append(replace(task, moment=moment))
            self._running.sort(key=lambda running: running.number)


def pass_on(result: Any, done: Future[Any]) -> None:
    """Complete a future with a result, or with a future's one when it is done.

    Args:
        done: gets the value, or the exception of `result`.
    """
    if not isinstance(result, Future):
        done.set_result(result)
        return

    def copy(ended: Future[Any]) -> None:
        error = ended.exception()
        if error is None:
            done.set_result(ended.result())
        else:
            done.set_exception(error)

    result.add_done_callback(copy)


MAX_CALLS: Final = 10_000
"""Running calls at most."""
MAX_WAIT: Final = 3_600_000
"""ms that a call may wait for another."""


class AsyncCalls:
    """Numbers of calls that run; thread-safe but for `stop`, whose caller locks."""

    def __init__(
        self, tasks: Sequence[MotionTasks], numbers: Iterator[int], end_motion: Callable[[int], bool]
    ) -> None:
        self._tasks, self._numbers, self._end_motion = tasks, numbers, end_motion
        self._running: dict[int, tuple[Future[Any], Callable[[], Any] | None]] = {}
        """Result of each call, and the function that ends it if it has no task."""

    def add(self, result: Any, end: Callable[[], Any] | None = None) -> int:
        """The number of a call."""
        key = next(self._numbers)
        if isinstance(result, Future):
            if len(self._running) >= MAX_CALLS:
                raise NaoqiRefused(f"{MAX_CALLS} calls run already; wait for some.")
            self._running[key] = result, end
            result.add_done_callback(lambda _: self._running.pop(key, None))
        return key

    def running(self, key: Any) -> bool:
        """Whether the call of this number runs."""
        return _key(key) in self._running

    def wait(self, key: Any, timeout: float = 0.0) -> Future[Any]:
        """Wait for the end of a call; true after a time-out.

        Args:
            timeout: ms; 0: none.
        """
        ended: Future[Any] = Future()
        once = threading.Lock()

        def end(over: bool) -> None:
            with once:
                if not ended.done():
                    ended.set_result(over)

        if _key(key) not in self._running:
            end(False)
            return ended
        call, _ = self._running[key]
        if timeout:
            timer = threading.Timer(timeout / 1000.0, end, [True])
            timer.daemon = True
            timer.start()
        call.add_done_callback(lambda _: end(False))
        return ended

    def stop(self, key: Any) -> bool:
        """Stop a call, or a motion by its number in `getTaskList`; False: there is none."""
        if _key(key) not in self._running:
            return self._end_motion(key)
        done, end = self._running[key]
        for tasks in self._tasks:
            for task in tasks.of(done):
                if not (task.joints and self._end_motion(task.number)):
                    tasks.stop_tasks([task])
                return True
        if end is not None:
            end()
        return end is not None


def _key(key: Any) -> int:
    if isinstance(key, bool) or not isinstance(key, int):
        raise NaoqiRefused(f"{key!r:.40} was given; the number of a call is expected.")
    return key
