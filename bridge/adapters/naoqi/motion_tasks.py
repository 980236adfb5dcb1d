"""Motions that take time: generators that wait for moments of the robot's clock, and futures of results."""

from __future__ import annotations

from collections.abc import Generator
from concurrent.futures import Future
from typing import Any

from bridge.errors import NaoqiRefused

MotionTask = Generator[int, None, Any]
"""Yields the moment (robot time, ms) to go on at; returns the result of the call that began it."""


def robot_gone() -> NaoqiRefused:
    """The error of a call that waited for a motion when the robot went away."""
    return NaoqiRefused("The robot went away before the motion ended.")


class MotionTasks:
    """Runs tasks along the robot's cycles; not thread-safe, the caller locks."""

    def __init__(self) -> None:
        self._running: list[tuple[int, MotionTask, Future[Any]]] = []

    def begin(self, task: MotionTask) -> Future[Any]:
        """Run a task to its first wait; the future gets its result or its exception."""
        done: Future[Any] = Future()
        self._advance(task, done)
        return done

    def run(self, now: int) -> None:
        """A cycle at `now`, ms: go on with whatever has waited for it."""
        due = [entry for entry in self._running if entry[0] <= now]
        self._running = [entry for entry in self._running if entry[0] > now]
        for _, task, done in due:
            self._advance(task, done)

    def end(self, error: Exception | None = None) -> None:
        """End all of them here; their callers get the error, or None as of a motion that was stopped."""
        running, self._running = self._running, []
        for _, task, done in running:
            task.close()
            if error is None:
                done.set_result(None)
            else:
                done.set_exception(error)

    def _advance(self, task: MotionTask, done: Future[Any]) -> None:
        try:
            moment = next(task)
        except StopIteration as end:
            done.set_result(end.value)
        except Exception as error:
            done.set_exception(error)
        else:
            self._running.append((moment, task, done))


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
