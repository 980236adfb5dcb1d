"""Timed commands of one actuator: updates of its buffer, and the value of a cycle."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from enum import Enum
from typing import NamedTuple


class TimedCommand(NamedTuple):
    """A value and the time at which it is to be reached."""

    time: int
    """ms"""
    value: float


class Update(Enum):
    """How new commands are combined with those that are waiting (vendor's page on `set`)."""

    MERGE = "Merge"
    CLEAR_ALL = "ClearAll"
    CLEAR_AFTER = "ClearAfter"
    CLEAR_BEFORE = "ClearBefore"


def updated(waiting: Sequence[TimedCommand], update: Update, new: Sequence[TimedCommand]) -> list[TimedCommand]:
    """The buffer after an update, in order of time; of equal times the one received last comes last.

    Args:
        waiting: the buffer before.
        update: how they are combined.
        new: commands received, in any order.
    """
    if update is Update.CLEAR_ALL:
        kept: Sequence[TimedCommand] = ()
    elif update is Update.MERGE or not new:
        kept = waiting
    elif update is Update.CLEAR_AFTER:
        first = min(command.time for command in new)
        kept = [command for command in waiting if command.time <= first]
    else:
        last = max(command.time for command in new)
        kept = [command for command in waiting if command.time >= last]
    return sorted([*kept, *new], key=_time)


def _time(command: TimedCommand) -> int:
    return command.time


def passed(buffer: Sequence[TimedCommand], now: int) -> int:
    """How many commands at the front of a buffer are due, that is not later than `now`."""
    return bisect_right(buffer, now, key=_time)


def interpolated(buffer: Sequence[TimedCommand], due: int, last: float, previous_cycle: int, now: int) -> float:
    """The value of this cycle (vendor's page on the interpolation of timed commands, 2010).

    It lies on the line from where the actuator was to the next command. The actuator was at the last command
    that came due since the previous cycle, or else, in the previous cycle, at the value computed then.

    Args:
        buffer: the commands in order of time.
        due: how many of them are `passed`.
        last: value computed in the previous cycle.
        previous_cycle: time of that cycle, ms.
        now: time of this cycle, ms.
    """
    start_time, start = previous_cycle, last
    if due:
        start = buffer[due - 1].value
        # A command from before the previous cycle came too late to be executed at its time.
        start_time = max(previous_cycle, buffer[due - 1].time)
    if due == len(buffer):
        return start
    target = buffer[due]
    return start + (target.value - start) * (now - start_time) / (target.time - start_time)
