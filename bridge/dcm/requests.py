"""Requests of the DCM: the lists of `createAlias`, `set` and `setAlias`; clock and buffers of timed commands.

Formats: vendor's pages on the DCM's commands, and the clients that use them.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, Final, NamedTuple

from bridge.errors import DcmRefused

MIN_TIME: Final = -(2**31)
MAX_TIME: Final = 2**31 - 1
MAX_NAMES: Final = 256
"""Actuators in one alias (assumed; a body has fewer than 150)."""
MAX_NAME: Final = 256
"""Characters in a name (assumed)."""


def wrapped(milliseconds: int) -> int:
    """A number of milliseconds as a signed 4-byte integer."""
    return (milliseconds - MIN_TIME) % 2**32 + MIN_TIME


class Clock:
    """Time of the present cycle boundary, by the number of cycles.

    Inside, time is a plain count of milliseconds since the start; outside, it is the wrapped integer.

    Args:
        cycle: cycle time, s.
        start: reading of the clock at the start, ms.
    """

    def __init__(self, cycle: float, start: int) -> None:
        self._cycle, self._start = 1000.0 * cycle, start
        self._cycles = 0
        self.now = 0
        """Time of the present boundary, ms since the start."""
        self.previous = -round(self._cycle)
        """Time of the previous cycle."""

    def tick(self) -> None:
        """End a cycle."""
        self._cycles += 1
        self.previous, self.now = self.now, round(self._cycles * self._cycle)

    def skip(self) -> None:
        """Pass over a cycle without the DCM."""
        self._cycles += 1
        self.now = round(self._cycles * self._cycle)

    def shown(self, offset: int = 0) -> int:
        """Reading of the clock `offset` ms from now."""
        return wrapped(self._start + self.now + offset)

    def since_start(self, shown: int) -> int:
        """Time since the start of a reading of the clock, ms: the one less than 24.8 days from now."""
        return self.now + wrapped(shown - self._start - self.now)


class TimedCommand(NamedTuple):
    """A value and the time at which it is to be reached."""

    time: int
    """DCM time, ms."""
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
    return sorted([*kept, *new], key=_time_of)


def _time_of(command: TimedCommand) -> int:
    return command.time


def passed(buffer: Sequence[TimedCommand], now: int) -> int:
    """How many commands at the front of a buffer are due, that is not later than `now`."""
    return bisect_right(buffer, now, key=_time_of)


def interpolated(buffer: Sequence[TimedCommand], due: int, last: float, previous_cycle: int, now: int) -> float:
    """The value of this cycle (vendor's page on the interpolation of timed commands, 2010).

    It is on the line to the next command from the last command that fell due since the previous cycle, or else
    from the value of the previous cycle.

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
        # A command from before the previous cycle is too late to be executed at its time.
        start_time = max(previous_cycle, buffer[due - 1].time)
    if due == len(buffer):
        return start
    target = buffer[due]
    return start + (target.value - start) * (now - start_time) / (target.time - start_time)


@dataclass(frozen=True)
class AliasRequest:
    """`createAlias`."""

    alias: str
    names: tuple[str, ...]


@dataclass(frozen=True)
class SetRequest:
    """`set`: the same commands for one actuator, or for each one of an alias; times as the clock shows them."""

    name: str
    update: Update
    commands: tuple[TimedCommand, ...]


@dataclass(frozen=True)
class SetAliasRequest:
    """`setAlias`: commands for each entry of an alias, in its order."""

    alias: str
    update: Update
    commands: tuple[tuple[TimedCommand, ...], ...]


def alias_request(command: Sequence[Any]) -> AliasRequest:
    """`[alias, [actuator, ...]]`.

    Raises:
        DcmRefused: anything else; names the item.
    """
    _require_length("createAlias", command, (2,), "[alias, [actuator, ...]]")
    names = _list(command[1], "createAlias item 1")
    if len(names) > MAX_NAMES:
        raise DcmRefused(f"createAlias: {len(names)} actuators; an alias takes at most {MAX_NAMES}.")
    alias = _name(command[0], "createAlias item 0")
    if not alias:
        raise DcmRefused("createAlias: the alias has no name; item 0 must be a string that is not empty.")
    return AliasRequest(
        alias, tuple(_name(name, f"createAlias item 1, entry {i}") for i, name in enumerate(names))
    )


def set_request(command: Sequence[Any]) -> SetRequest:
    """`[name, update, [[value, time], ...]]`; a pair may have a third item, the importance.

    Raises:
        DcmRefused: anything else; names the item.
    """
    _require_length("set", command, (3,), "[name, update, [[value, time], ...]]")
    return SetRequest(
        _name(command[0], "set item 0"), _update(command[1], "set"), _pairs(command[2], "set item 2")
    )


def set_alias_request(command: Sequence[Any]) -> SetAliasRequest:
    """The time-separate form of 6 items, the time-mixed form of 4, or `[alias, time, [value, ...]]`.

    Raises:
        DcmRefused: anything else; names the item.
    """
    _require_length("setAlias", command, (3, 4, 6), "the 6 items of time-separate, the 4 of time-mixed, or 3")
    alias = _name(command[0], "setAlias item 0")
    if len(command) == 3:
        time = _time(command[1], "setAlias item 1")
        values = _list(command[2], "setAlias item 2")
        commands = tuple(
            (TimedCommand(time, _number(value, f"setAlias item 2, entry {i}")),)
            for i, value in enumerate(values)
        )
        return SetAliasRequest(alias, Update.CLEAR_ALL, commands)
    update = _update(command[1], "setAlias")
    form = "time-mixed" if len(command) == 4 else "time-separate"
    if command[2] != form:
        raise DcmRefused(
            f'setAlias item 2 is {shown(command[2])}; a command of {len(command)} items says "{form}".'
        )
    return SetAliasRequest(alias, update, _mixed(command) if form == "time-mixed" else _separate(command))


def _mixed(command: Sequence[Any]) -> tuple[tuple[TimedCommand, ...], ...]:
    entries = _list(command[3], "setAlias item 3")
    return tuple(_pairs(entry, f"setAlias item 3, entry {i}") for i, entry in enumerate(entries))


def _separate(command: Sequence[Any]) -> tuple[tuple[TimedCommand, ...], ...]:
    times = [
        _time(time, f"setAlias item 4, entry {i}")
        for i, time in enumerate(_list(command[4], "setAlias item 4"))
    ]
    rows = []
    for i, row in enumerate(_list(command[5], "setAlias item 5")):
        values = _list(row, f"setAlias item 5, entry {i}")
        if len(values) != len(times):
            raise DcmRefused(
                f"setAlias item 5, entry {i} has {len(values)} values; item 4 has {len(times)} times."
            )
        where = f"setAlias item 5, entry {i}"
        rows.append(tuple(TimedCommand(t, _number(v, where)) for t, v in zip(times, values, strict=True)))
    return tuple(rows)


def _pairs(value: Any, where: str) -> tuple[TimedCommand, ...]:
    commands = []
    for i, pair in enumerate(_list(value, where)):
        here = f"{where}, command {i}"
        if not isinstance(pair, list) or len(pair) not in (2, 3):
            raise DcmRefused(f"{here} is {shown(pair)}; [value, time] is expected.")
        commands.append(TimedCommand(_time(pair[1], f"{here}, time"), _number(pair[0], f"{here}, value")))
    return tuple(commands)


def _require_length(method: str, command: Sequence[Any], lengths: tuple[int, ...], form: str) -> None:
    if len(command) not in lengths:
        raise DcmRefused(f"{method}: a list of {len(command)} items; {form} is expected.")


def _update(value: Any, method: str) -> Update:
    for update in Update:
        if update.value == value:
            return update
    known = ", ".join(update.value for update in Update)
    raise DcmRefused(f"{method} item 1 is {shown(value)}; one of {known} is expected.")


def _name(value: Any, where: str) -> str:
    if not isinstance(value, str) or len(value) > MAX_NAME:
        raise DcmRefused(f"{where} is {shown(value)}; a name of at most {MAX_NAME} characters is expected.")
    return value


def _list(value: Any, where: str) -> list[Any]:
    if not isinstance(value, list):
        raise DcmRefused(f"{where} is {shown(value)}; a list is expected.")
    return value


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise DcmRefused(f"{where} is {shown(value)}; a finite number is expected.")
    return float(value)


def _time(value: Any, where: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not MIN_TIME <= value <= MAX_TIME:
        raise DcmRefused(f"{where} is {shown(value)}; a time in ms, a signed 4-byte integer, is expected.")
    return value


def shown(value: Any) -> str:
    """A value for an error sentence: on one line and short."""
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
