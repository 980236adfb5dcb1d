"""Motions that take time, and calls that a program began without waiting for them (`pCall`)."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace
from typing import Any, Final

from bridge.errors import NaoqiRefused

MotionTask = Generator[int, None, Any]
"""Yields the moment (robot time, ms) to go on at; returns the result of the call that began it."""


def robot_gone() -> NaoqiRefused:
    """The error of a call that waited for a motion when the robot went away."""
    return NaoqiRefused("The robot went away before the motion ended.")


@dataclass(frozen=True)
class RunningTask:
    """A motion that has not ended."""

    number: int
    """Counts up from 1."""
    name: str
    """Of the method that began it."""
    joints: tuple[str, ...]
    moment: int
    """To go on at, ms."""
    steps: MotionTask
    done: Future[Any]
    locks: bool = False
    """Later motions of its joints that lock wait for its end."""
    stopped: Any = None
    """Result of the call if the task is ended before."""


class MotionTasks:
    """Runs tasks along the robot's cycles; not thread-safe, the caller locks.

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
            task: to run.
            name: of the method that begins it; nothing: not a motion of joints.
            joints: that it moves or stiffens.
            locks: it waits for the end of earlier tasks that lock one of its joints, and locks them (vendor's
                page on motion tasks).
            stopped: result of the call if the task is ended before.

        Raises:
            NaoqiRefused: the robot has gone.
        """
        if self._abandoned:
            raise robot_gone()
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
        """The task whose result a future gets, if it has not ended."""
        return [task for task in self._running if task.done is done]

    def run(self, now: int) -> None:
        """A cycle at `now`, ms: go on with whatever has waited for it."""
        due = [task for task in self._running if task.moment <= now]
        self._running = [task for task in self._running if task.moment > now]
        for task in due:
            self._advance(task)

    def end(self) -> None:
        """End all of them here, as motions that are stopped."""
        self.end_these(list(self._running))

    def abandon(self) -> None:
        """The robot is gone: its cycles come no more, so all that waits fails, and nothing can begin."""
        self._abandoned = True
        self.end_these(list(self._running), robot_gone())

    def end_these(self, tasks: Sequence[RunningTask], error: Exception | None = None) -> None:
        """End some of them here; their callers get the error, or the result of a motion that was stopped."""
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
    """Complete a future with a result, at once or when the result comes.

    Args:
        result: a value, or a future of one.
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


MAX_POSTS: Final = 10_000
"""Calls that have not ended."""
LONGEST_WAIT: Final = 3_600_000
"""ms that a call may wait for another."""


class AsyncCalls:
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
        """Functions that end calls which are no tasks."""

    def add(self, result: Any, end: Callable[[], Any] | None = None) -> int:
        """The number of a call.

        Args:
            result: of the call, or a future of it.
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

    def wait(self, key: Any, timeout: float = 0.0) -> Future[Any]:
        """Wait for the end of a call; true when the time was over before.

        Args:
            key: number of the call.
            timeout: ms; 0: as long as it takes.
        """
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
        if timeout:
            timer = threading.Timer(timeout / 1000.0, end, [True])
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
