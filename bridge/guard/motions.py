"""The guard's own motions: approach, end of a quick step, descent to the crouch, sitting down; its watchdog.

A biped whose joints stop in a quick step tips over within a few tenths of a second. The mean of both legs'
angles, mirrored, lands the lifted foot next to the other one in any gait. In a slow step the robot may be
balanced on one foot, and landing would make it fall: its joints hold.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Final, Literal

import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX, LEG_SLOTS, N_JOINTS
from bridge.guard.config import ApproachSettings, CrouchSettings, WatchdogSettings
from bridge.messages import SensorFrame
from bridge.motion import Motion, MotionPlayer

_PEAK_RATIO: Final = 1.875
"""Peak over mean speed of a motion that begins and ends at rest without a jump of acceleration (quintic)."""
_MIN_DURATION: Final = 0.5
"""Shortest motion, s."""
_LEGS: Final = frozenset(slot for slots in LEG_SLOTS.values() for slot in slots)
_APPROACH_TIME_FACTOR: Final = 1.5
"""Longest approach over the duration of the motion to the first command, for a command that keeps moving."""
_MIN_APPROACH_TIME: Final = 0.5
"""s that an approach may always take."""
_MIRRORED: Final = tuple(
    (INDEX[f"L{joint}"], INDEX[f"R{joint}"], sign)
    for joint, sign in (
        ("HipRoll", -1.0),
        ("HipPitch", 1.0),
        ("KneePitch", 1.0),
        ("AnklePitch", 1.0),
        ("AnkleRoll", -1.0),
    )
)
"""Slots of both legs' joints, and the sign of the right one's mirror image."""
_LEG_SLOTS: Final = sorted({slot for slots in LEG_SLOTS.values() for slot in slots})
_QUICK_STEP_SPEED: Final = 8.0
"""rad/s of a leg's joint in a step that a robot cannot interrupt (docs/guard.md)."""
_RECENT_CYCLES: Final = 50
"""Cycles of commands within which a fast one counts: two steps of `omni`."""
_MIN_STREAM_EXCESS: Final = 10
"""Excess of cycles with a command over those without that makes a stream (assumed)."""
CLOSE_DURATION: Final = 0.15
"""s; a robot tips over with a time constant of 0.16 s (omega = 6.1 /s)."""


class Watchdog:
    """One update per cycle; counts from the first command on.

    Args:
        settings: the bounds.
    """

    def __init__(self, settings: WatchdogSettings) -> None:
        self._s = settings
        self._silent: int | None = None

    def reset(self) -> None:
        """Wait for the next command before counting again."""
        self._silent = None

    def keepalive(self) -> None:
        """Restart the count at another sign of life, once there has been a command."""
        if self._silent is not None:
            self._silent = 0

    def update(self, *, received: bool, supervised: bool) -> Literal["", "close", "hold", "descend"]:
        """One cycle.

        Args:
            received: there is a command.
            supervised: a controller holds the robot, or died holding it.

        Returns:
            Reaction to the silence so far: none, end a quick step, hold the joints, or bring the robot down.
        """
        if received:
            self._silent = 0
        elif not supervised:
            self._silent = None
        elif self._silent is not None:
            self._silent += 1
        silent = self._silent or 0
        if not self._s.enabled or silent < self._s.stride_cycles:
            return ""
        if silent < self._s.silence_cycles:
            return "close"
        return "hold" if silent < self._s.silence_cycles + self._s.hold_cycles else "descend"


class Descent:
    """Motion from rest to rest in joint space, then a pause, then the ramp of the stiffness.

    Args:
        start: 25 positions put out last, rad.
        stiffness: 25, in force; free joints stay free.
        goal: the crouch, 25 positions.
        settings: speeds and times.
        cycle: s
        moving: False: only the ramp, in the present pose.
        standing: the legs keep `rest_stiffness`, without which a crouched robot may tip over; False: none.
    """

    def __init__(
        self,
        start: Sequence[float],
        stiffness: Sequence[float],
        goal: Sequence[float],
        settings: CrouchSettings,
        cycle: float,
        *,
        moving: bool,
        standing: bool,
    ) -> None:
        self._start, self._goal = np.array(start), np.array(goal if moving else start)
        self._stiffness = np.array(stiffness)
        rest = [settings.rest_stiffness if standing and i in _LEGS else 0.0 for i in range(N_JOINTS)]
        self._rest = np.minimum(self._stiffness, rest)
        way = float(np.abs(self._goal - self._start).max())
        self._duration = (
            max(_PEAK_RATIO * way / settings.speed, _MIN_DURATION) + settings.settle_time if moving else 0.0
        )
        self._moving = self._duration - settings.settle_time
        self._release_time, self._cycle, self._time = settings.release_time, cycle, 0.0
        self.done = False
        """The ramp is over."""

    def advance(self, _frame: SensorFrame) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Positions and stiffnesses of the next cycle."""
        self._time += self._cycle
        s = min(self._time / self._moving, 1.0) if self._moving > 0.0 else 1.0
        blend = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        position = self._start + blend * (self._goal - self._start)
        released = min(max((self._time - self._duration) / max(self._release_time, self._cycle), 0.0), 1.0)
        self.done = released >= 1.0
        ramp = self._stiffness + released * (self._rest - self._stiffness)
        stiffness = self._rest if self.done else ramp
        return tuple(position.tolist()), tuple(stiffness.tolist())


class SitDown:
    """Plays the motion to its end, then releases the joints.

    Args:
        motion: of this body, from a stand or a crouch to the seat.
        body: data sheet; its cycle is the time between two frames.
        settings: of the ramp of the stiffness, and its end.
    """

    def __init__(self, motion: Motion, body: Body, settings: CrouchSettings) -> None:
        self._player, self._cycle, self._settings = MotionPlayer(motion, body), body.cycle, settings
        self._release: Descent | None = None

    @property
    def done(self) -> bool:
        """The ramp is over."""
        return self._release is not None and self._release.done

    def advance(self, frame: SensorFrame) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Positions and stiffnesses of the next cycle.

        Args:
            frame: of the present boundary.
        """
        player = self._player
        if not player.done:
            return player.advance(frame, self._cycle), (player.stiffness,) * N_JOINTS
        if self._release is None:
            position, stiffness = player.position, (player.stiffness,) * N_JOINTS
            self._release = Descent(
                position, stiffness, position, self._settings, self._cycle, moving=False, standing=True
            )
        return self._release.advance(frame)


class Approach:
    """Joints on the way to their first command, each with its remaining cycles.

    A joint leaves when less than a step of its way is left, when it becomes limp, or when its time is over, for
    a command that keeps moving.

    Args:
        settings: tolerance and speed.
        cycle: s
    """

    def __init__(self, settings: ApproachSettings, cycle: float) -> None:
        self._s, self._cycle = settings, cycle
        self._left: dict[int, int] = {}

    @property
    def slots(self) -> Collection[int]:
        """Joints that are limited to the speed of the settings; they arrive together."""
        return self._left.keys()

    def begin(self, distances: Mapping[int, float]) -> bool:
        """Begin with all joints if one is farther than the tolerance, else with none.

        Args:
            distances: distance of each joint from its command, rad.

        Returns:
            Whether there is an approach.
        """
        farthest = max(distances.values(), default=0.0)
        if farthest <= self._s.tolerance:
            return False
        time = max(_APPROACH_TIME_FACTOR * farthest / self._s.speed, _MIN_APPROACH_TIME)
        self._left |= dict.fromkeys(distances, math.ceil(time / self._cycle))
        return True

    def advance(self, distances: Mapping[int, float]) -> None:
        """End a cycle; joints that have arrived, are limp or have had their time leave.

        Args:
            distances: remaining distance of each stiff joint, rad.
        """
        step = self._s.speed * self._cycle
        self._left = {
            slot: left - 1 for slot, left in self._left.items() if left > 1 and distances.get(slot, 0.0) > step
        }

    def clear(self) -> None:
        """End the approach."""
        self._left = {}


class CommandStream:
    """Detects quick steps: commands in nearly every cycle that move the legs fast.

    Args:
        cycle: of the robot, s.
    """

    def __init__(self, cycle: float) -> None:
        self._cycle = cycle
        self.reset()

    def reset(self) -> None:
        """Forget the commands."""
        self._last: Sequence[float] | None = None
        self._count, self._slow = 0, _RECENT_CYCLES

    def update(self, position: Sequence[float] | None) -> None:
        """One cycle.

        Args:
            position: 25, of the command in force, rad; None: there is none, or the robot is not upright.
        """
        if position is None:
            self._count = max(self._count - 1, 0)
            return
        self._count = min(self._count + 1, 2 * _MIN_STREAM_EXCESS)
        last = self._last or position
        fastest = max(abs(position[slot] - last[slot]) for slot in _LEG_SLOTS) / self._cycle
        self._slow = 0 if fastest > _QUICK_STEP_SPEED else self._slow + 1
        self._last = position

    @property
    def in_quick_step(self) -> bool:
        """The newest command is part of a quick step."""
        return self._count >= _MIN_STREAM_EXCESS and self._slow < _RECENT_CYCLES


class CloseStance:
    """Motion of both legs to their mirrored mean.

    Args:
        start: 25 positions put out last, rad.
        stiffness: 25, in force; they stay.
        cycle: s
    """

    def __init__(self, start: Sequence[float], stiffness: Sequence[float], cycle: float) -> None:
        goal = np.array(start)
        for left, right, sign in _MIRRORED:
            goal[left] = 0.5 * (start[left] + sign * start[right])
            goal[right] = sign * goal[left]
        self._start, self._goal, self._stiffness = np.array(start), goal, tuple(stiffness)
        self._cycle, self._time = cycle, 0.0
        self.done = False
        """The feet are side by side."""

    def advance(self, _frame: SensorFrame) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Positions and stiffnesses of the next cycle."""
        self._time += self._cycle
        s = min(self._time / CLOSE_DURATION, 1.0)
        self.done = s >= 1.0
        position = self._start + s * s * (3.0 - 2.0 * s) * (self._goal - self._start)
        return tuple(position.tolist()), self._stiffness
