"""The DCM's command side: turns requests into the values of the motor boards in each cycle."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bridge.body import Body
from bridge.body.joints import INDEX, N_JOINTS
from bridge.dcm.actuators import IGNORED_NAMES, Actuator, actuators, driven_joints, short
from bridge.dcm.requests import (
    AliasRequest,
    Clock,
    SetAliasRequest,
    SetRequest,
    TimedCommand,
    Update,
    interpolated,
    passed,
    shown,
    updated,
)
from bridge.errors import DcmRefused
from bridge.messages.dcm import PREFIX
from bridge.messages.frames import N_LEDS
from bridge.types import Array

Places = NDArray[np.int_]
BUFFER_LIMIT: Final = 512
"""Timed commands per actuator (vendor's 2.x page; 4096 on the page of 2010)."""
MAX_ALIASES: Final = 256
"""Aliases kept (assumed)."""


class ActuatorTable:
    """Rows: positions of the driven joints, their stiffnesses in the same order, LEDs, discrete actuators.

    Args:
        body: data sheet.
    """

    def __init__(self, body: Body) -> None:
        self.rows: tuple[Actuator, ...] = actuators(body)
        self.index = {actuator.name: i for i, actuator in enumerate(self.rows)}
        """Row of each name, without the prefix."""
        self.slots = [INDEX[joint] for joint in driven_joints(body)]
        """Frame slot of each driven joint."""
        self.n_joints = len(self.slots)
        self._frame = np.arange(2 * self.n_joints)
        self._wanted = np.array(self.slots + [N_JOINTS + slot for slot in self.slots])
        """Slot of each row of a frame: its place among 25 positions and 25 stiffnesses."""
        self._gain = np.array([actuator.gain for actuator in self.rows])
        self._offset = np.array([actuator.offset for actuator in self.rows])
        # Rounded inwards, so that no integer is beyond the range.
        lower = np.array([actuator.lower for actuator in self.rows])
        upper = np.array([actuator.upper for actuator in self.rows])
        self._lower = np.ceil((lower - self._offset) / self._gain - 1e-9)
        self._upper = np.floor((upper - self._offset) / self._gain + 1e-9)
        # the other way round, 0 for joints that the body lacks
        self._rows_sent = np.zeros(2 * N_JOINTS, dtype=int)
        self._gain_sent, self._offset_sent = np.zeros((2, 2 * N_JOINTS))
        self._rows_sent[self._wanted] = self._frame
        self._gain_sent[self._wanted] = self._gain[self._frame]
        self._offset_sent[self._wanted] = self._offset[self._frame]

    def to_counts(self, row: int, value: float) -> float:
        """A value of an actuator as its board's integer, inside the range."""
        actuator = self.rows[row]
        counts = round(min(max((value - actuator.offset) / actuator.gain, -1e9), 1e9))
        return float(min(max(counts, self._lower[row]), self._upper[row]))

    def value(self, row: int, counts: float) -> float:
        """Value that the board of an actuator reads back for unrounded counts."""
        return float(np.rint(counts) * self._gain[row] + self._offset[row])

    def frame_rows(self, without: Collection[int] = ()) -> Places:
        """Rows that a frame sets: of all positions and stiffnesses, but of those slots."""
        if not without:
            return self._frame
        kept = [row for row in range(len(self._frame)) if self.slots[row % self.n_joints] not in without]
        return np.array(kept, dtype=int)

    def frame_counts(self, position: Sequence[float], stiffness: Sequence[float]) -> Array:
        """Counts of all positions and stiffnesses, inside their ranges, shape (2 n_joints,).

        Args:
            position: 25 in frame order, rad (hands: 0..1).
            stiffness: 25 in frame order.
        """
        n = len(self._frame)
        counts: Array = np.array((*position, *stiffness), dtype=np.float64).take(self._wanted)
        counts -= self._offset[:n]
        counts /= self._gain[:n]
        np.rint(counts, out=counts)
        np.maximum(counts, self._lower[:n], out=counts)
        np.minimum(counts, self._upper[:n], out=counts)
        return counts

    def frame_values(self, counts: Array) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """25 positions and 25 stiffnesses in frame order, 0 for absent joints, of counts, shape (rows,)."""
        sent = np.rint(counts.take(self._rows_sent))
        sent *= self._gain_sent
        sent += self._offset_sent
        values = tuple(sent.tolist())
        return values[:N_JOINTS], values[N_JOINTS:]


@dataclass(frozen=True)
class Targets:
    """Values that the motor boards get in one cycle, in frame order; 0 for joints that the body lacks."""

    position: tuple[float, ...]
    """rad (hands: 0..1)"""
    stiffness: tuple[float, ...]


class Dcm:
    """Buffers, aliases and clock of one robot; to be used by one thread.

    Args:
        body: Data sheet.
        position: Where the joints are held at the start, frame order, rad; the stiffnesses are 1, all else 0.
        start: Reading of the clock at the start, ms.
        limit: Timed commands that an actuator's buffer takes.
    """

    def __init__(
        self, body: Body, position: Sequence[float], *, start: int = 0, limit: int = BUFFER_LIMIT
    ) -> None:
        self.clock = Clock(body.cycle, start)
        self._cycle = 1000.0 * body.cycle
        self._limit = limit
        self._table = ActuatorTable(body)
        self._last = np.zeros(len(self._table.rows))
        """Value computed last for each actuator, in counts but not rounded."""
        self._buffers: dict[int, list[TimedCommand]] = {}
        self._aliases: dict[str, tuple[int | None, ...]] = {}
        first = 2 * self._table.n_joints
        self._led_rows = range(first, first + N_LEDS)
        self._lit = False
        """A command has set LEDs."""
        self.modes_sent: dict[str, float] = {}
        """Values sent in the last cycle to actuators that do not interpolate (the sonar's mode)."""
        self.put_frame(position, (1.0,) * N_JOINTS)
        self._framed = False

    @property
    def table(self) -> tuple[Actuator, ...]:
        """All actuators of the body."""
        return self._table.rows

    def create_alias(self, request: AliasRequest) -> list[str | list[str]]:
        """Create or replace an alias; the reply repeats the request, with "" for every unknown actuator.

        Raises:
            DcmRefused: too many aliases.
        """
        if request.alias not in self._aliases and len(self._aliases) >= MAX_ALIASES:
            raise DcmRefused(f"createAlias: there are {MAX_ALIASES} aliases already; reuse the name of one.")
        self._aliases[request.alias] = tuple(self._table.index.get(short(name)) for name in request.names)
        known = self._table.index.keys() | IGNORED_NAMES
        return [request.alias, [name if short(name) in known else "" for name in request.names]]

    def names_of(self, name: str) -> tuple[str, ...]:
        """The actuator of a name, or those of an alias; none when there is neither."""
        index = self._table.index.get(short(name))
        rows = (index,) if index is not None else self._aliases.get(name, ())
        return tuple(self.table[row].name for row in rows if row is not None)

    def set(self, request: SetRequest) -> None:
        """Put the same commands into the buffer of an actuator, or of every actuator of an alias.

        Raises:
            DcmRefused: unknown name, or a buffer would be too full; nothing is changed then.
        """
        name = short(request.name)
        if name in IGNORED_NAMES:
            return
        index = self._table.index.get(name)
        targets = (index,) if index is not None else self._aliases.get(request.name)
        if targets is None:
            raise DcmRefused(f"set: {shown(request.name)} is neither an actuator of this body nor an alias.")
        self._update(((target, request.commands) for target in targets), request.update)

    def set_alias(self, request: SetAliasRequest) -> None:
        """Put commands of their own into the buffer of each actuator of an alias.

        Raises:
            DcmRefused: unknown alias, wrong number of entries, or a buffer would be too full; nothing is
                changed then.
        """
        targets = self._aliases.get(request.alias)
        if targets is None:
            raise DcmRefused(f"setAlias: {shown(request.alias)} is no alias; make it with createAlias first.")
        if len(targets) != len(request.commands):
            raise DcmRefused(
                f"setAlias: {shown(request.alias)} has {len(targets)} actuators; commands for "
                f"{len(request.commands)} came."
            )
        self._update(zip(targets, request.commands, strict=True), request.update)

    def _update(self, commands: Iterable[tuple[int | None, Sequence[TimedCommand]]], update: Update) -> None:
        changed: dict[int, list[TimedCommand]] = {}
        for index, new in commands:
            if index is None:
                continue
            waiting = changed[index] if index in changed else self._buffers.get(index, [])
            counts = self._table.to_counts
            timed = [TimedCommand(self.clock.since_start(one.time), counts(index, one.value)) for one in new]
            buffer = updated(waiting, update, timed)
            if len(buffer) > self._limit:
                raise DcmRefused(
                    f"The buffer of `{self.table[index].name}` takes {self._limit} timed commands; with this "
                    f"request it would hold {len(buffer)}."
                )
            changed[index] = buffer
        self._lit = self._lit or any(index in self._led_rows for index in changed)
        for index, buffer in changed.items():
            if buffer:
                self._buffers[index] = buffer
            else:
                self._buffers.pop(index, None)

    def put_frame(
        self, position: Sequence[float], stiffness: Sequence[float], without: Collection[int] = ()
    ) -> None:
        """An actuator frame: ClearAll at the time of now, for all positions and stiffnesses.

        Args:
            position: 25 in frame order, rad (hands: 0..1).
            stiffness: 25 in frame order.
            without: slots whose actuators go on as they are.
        """
        counts = self._table.frame_counts(position, stiffness)
        if without or self._buffers:
            rows = self._table.frame_rows(without)
            self._last[rows] = counts[rows]
            for row in rows.tolist():
                self._buffers.pop(row, None)
        else:
            self._last[: len(counts)] = counts
        self._framed = True

    @property
    def leds(self) -> tuple[int, ...]:
        """Brightness of each LED, 0 to 255; empty while all are dark."""
        counts = self._last[self._led_rows.start : self._led_rows.stop]
        return tuple(np.clip(np.rint(counts), 0, 255).astype(int).tolist()) if counts.any() else ()

    def light(self, leds: Sequence[int]) -> None:
        """Set the brightness of each LED, 0 to 255; their waiting commands are dropped."""
        self._lit = True
        self._last[self._led_rows.start : self._led_rows.stop] = leds
        for row in self._led_rows:
            self._buffers.pop(row, None)

    def light_unused(self, lights: Mapping[str, Sequence[int]]) -> None:
        """Light LEDs for which there is no command; nothing happens once a command has set any LED.

        Args:
            lights: `ChestBoard`, `LFoot` or `RFoot` -> red, green and blue, 0 to 255.
        """
        for board, rgb in {} if self._lit else lights.items():
            for colour, value in zip(("Red", "Green", "Blue"), rgb, strict=True):
                self._last[self._table.index[f"{board}/Led/{colour}/Actuator/Value"]] = value

    def move(self, name: str, value: float) -> None:
        """Put an actuator at a value; its waiting commands go on from there."""
        index = self._table.index[short(name)]
        self._last[index] = self._table.to_counts(index, value)

    def run_cycle(self) -> Targets | None:
        """Compute the values of the cycle that begins now, and advance the clock to the next boundary.

        Returns:
            Values for the motor boards, or None when they cannot have changed.
        """
        moved, self._framed = self._framed, False
        self.modes_sent = {}
        for index in list(self._buffers):
            moved |= index < 2 * self._table.n_joints
            self._run(index)
        self.clock.tick()
        return Targets(*self._table.frame_values(self._last)) if moved else None

    def ahead(self) -> Targets:
        """Values that `run_cycle` would send now."""
        last = self._last.copy()
        for index in self._buffers:
            if index < 2 * self._table.n_joints:  # all of them interpolate
                last[index] = self._computed(index)[0]
        return Targets(*self._table.frame_values(last))

    @property
    def busy(self) -> bool:
        """Timed commands wait."""
        return bool(self._buffers)

    def skip_cycle(self) -> None:
        """Pass over a cycle while the DCM is paused: it sends nothing, its clock runs on."""
        self.modes_sent = {}
        self.clock.skip()

    def _run(self, index: int) -> None:
        """One cycle of one actuator that has commands waiting."""
        actuator, buffer = self.table[index], self._buffers[index]
        self._last[index], due = self._computed(index)
        if due and not actuator.interpolates:
            self.modes_sent[actuator.name] = self._sent(index)
        del buffer[:due]
        if not buffer:
            del self._buffers[index]

    def _computed(self, index: int) -> tuple[float, int]:
        """Value of this cycle of an actuator that has commands waiting, and how many of them are due."""
        buffer, last, now = self._buffers[index], float(self._last[index]), self.clock.now
        due = passed(buffer, now)
        if self.table[index].interpolates:
            return interpolated(buffer, due, last, self.clock.previous, now), due
        return buffer[due - 1].value if due else last, due

    def read(self, names: Iterable[str], measured: Sequence[float]) -> list[float]:
        """Values behind keys of actuators and of the DCM.

        Args:
            names: keys, with or without the prefix.
            measured: joint angles in frame order, rad: the positions' reading while the stiffness is not above
                0.

        Raises:
            DcmRefused: a key that is none of these.
        """
        return [self._read(name, measured) for name in names]

    def _read(self, name: str, measured: Sequence[float]) -> float:
        times = {
            "DCM/Time": float(self.clock.shown()),
            "DCM/CycleTime": self._cycle,
            "DCM/TargetCycleTime": self._cycle,
        }
        if name in times:
            return times[name]
        base, _, item = short(name).rpartition("/")
        index = self._table.index.get(f"{base}/Value")
        if index is not None:
            actuator = self.table[index]
            if item == "Value":
                return self._value(index, measured)
            fixed = {
                "Min": actuator.lower,
                "Max": actuator.upper,
                "Gain": actuator.gain,
                "Offset": actuator.offset,
            }
            if item in fixed:
                return fixed[item]
        raise DcmRefused(f"read: {shown(name)} is no key of an actuator of this body, nor of the DCM itself.")

    def _value(self, index: int, measured: Sequence[float]) -> float:
        if index < self._table.n_joints and self._sent(index + self._table.n_joints) <= 0.0:
            return float(measured[self._table.slots[index]])
        return self._sent(index)

    def _sent(self, index: int) -> float:
        return self._table.value(index, self._last[index])

    def prefixes(self) -> list[str]:
        """Reply of `getPrefix`."""
        return [PREFIX]

    def waiting(self, name: str) -> tuple[TimedCommand, ...]:
        """The buffer of an actuator: times in ms since the start, values in counts."""
        return tuple(self._buffers.get(self._table.index[short(name)], ()))
