"""The faults of one robot, in commands, joints and sensors: start, effect, end."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import msgspec
import numpy as np

from bridge.body.joints import INDEX, INDEX_WITH_MIRROR, JOINTS, N_JOINTS
from bridge.errors import FrameError
from bridge.messages import ActuatorFrame, SensorFrame
from bridge.messages.faults import (
    CommandDuplicated,
    CommandFault,
    CommandJitter,
    CommandLate,
    CommandLost,
    CommandReordered,
    DcmPause,
    Fault,
    HalError,
    InertialRezero,
    JointBacklash,
    JointFault,
    JointHot,
    JointLimp,
    JointStuck,
    JointWeak,
    PowerLoss,
    SensorDead,
    SensorFault,
    SensorNoisy,
    SensorOffset,
    SensorStuck,
)
from bridge.messages.frames import sensor_slots
from emulator.engine.base import Multibody
from emulator.scenarios.events import FaultEvent
from emulator.servo.servo import Servo

JAM_TORQUE: Final = 100.0
"""Torque that a jammed gear withstands, N m: far above any motor's stall torque."""
FrameFault = SensorStuck | SensorDead | SensorNoisy | SensorOffset | JointLimp | HalError | PowerLoss


class CommandChannel:
    """Carries commands, each with a delay in cycles; the last to arrive is in force.

    Args:
        random: decides which commands suffer.
    """

    def __init__(self, random: np.random.Generator) -> None:
        self._random = random
        self._cycle = 0
        self._sent = 0
        self._on_the_way: list[tuple[int, int, ActuatorFrame]] = []
        """Cycle of arrival, order among those of one cycle, command."""

    @property
    def empty(self) -> bool:
        """No command is on the way."""
        return not self._on_the_way

    def clear(self) -> None:
        """Drop the commands on the way."""
        self._on_the_way.clear()

    def apply_command_faults(
        self, command: ActuatorFrame | None, faults: Iterable[CommandFault]
    ) -> ActuatorFrame | None:
        """One cycle.

        Args:
            command: Sent in this cycle.
            faults: In force.

        Returns:
            The last command to arrive in this cycle; None when none does.
        """
        self._cycle += 1
        if command is not None:
            for delay, behind in self._fates(faults):
                # an overtaken command arrives after all that were sent up to the cycle of its arrival
                order = 2 * (self._sent + (delay + 1 if behind else 0)) + behind
                self._on_the_way.append((self._cycle + delay, order, command))
            self._sent += 1
        arrived = sorted((item for item in self._on_the_way if item[0] <= self._cycle), key=lambda i: i[:2])
        if not arrived:
            return None
        self._on_the_way = [item for item in self._on_the_way if item[0] > self._cycle]
        return arrived[-1][2]

    def _fates(self, faults: Iterable[CommandFault]) -> list[tuple[int, bool]]:
        """Delays, in cycles, with which copies of one command arrive, and whether behind the newer ones."""
        delay, copies = 0, []
        behind = False
        for fault in faults:
            if isinstance(fault, CommandJitter):
                delay += int(self._random.integers(0, fault.cycles + 1))
                continue
            struck = self._random.random() < fault.probability
            if not struck:
                continue
            if isinstance(fault, CommandLost):
                return []
            if isinstance(fault, CommandLate):
                delay += fault.cycles
            elif isinstance(fault, CommandDuplicated):
                copies.append((fault.cycles, True))
            elif isinstance(fault, CommandReordered):
                delay, behind = delay + 1, True
        return [(delay, behind), *((delay + extra, late) for extra, late in copies)]


class JointFaults:
    """Puts faults into the drives of one robot.

    Args:
        robot: Whose joints.
        servo: Their drives.
    """

    def __init__(self, robot: Multibody, servo: Servo) -> None:
        self._robot, self._servo = robot, servo
        self._sound = (servo.strength.copy(), servo.backlash.copy())
        self._hot: list[tuple[list[int], float]] = []

    def has(self, joint: str) -> bool:
        """The body has this joint, with a motor of its own in the model."""
        return bool(self._numbers(joint))

    def _numbers(self, joint: str) -> list[int]:
        """Places of the mechanical joints that a frame's joint means: HipYawPitch is two."""
        return [i for i, name in enumerate(self._robot.joints) if JOINTS[INDEX_WITH_MIRROR[name]] == joint]

    def apply(self, faults: Iterable[JointFault], powered: bool) -> None:
        """Put exactly these faults in force; to be called when they change.

        Args:
            faults: Of joints.
            powered: The motors have power.
        """
        servo = self._servo
        strength, backlash = (values.copy() for values in self._sound)
        jammed: list[str] = []
        self._hot = []
        for fault in faults:
            numbers = self._numbers(fault.joint)
            if isinstance(fault, JointWeak):
                strength[numbers] *= fault.fraction
            elif isinstance(fault, JointLimp):
                strength[numbers] = 0.0
            elif isinstance(fault, JointBacklash):
                backlash[numbers] += fault.backlash
            elif isinstance(fault, JointHot):
                self._hot.append((numbers, fault.temperature))
            elif isinstance(fault, JointStuck):
                jammed += [self._robot.joints[i] for i in numbers]
        servo.strength[:] = strength if powered else np.zeros_like(strength)
        servo.backlash[:] = backlash
        self._robot.lock(jammed, JAM_TORQUE)
        servo.apply_power()

    def hold_heat(self) -> None:
        """Once per cycle: hold hot motors at their temperature."""
        if self._hot:
            servo = self._servo
            for numbers, temperature in self._hot:
                servo.heat.temperature[numbers] = temperature
            servo.apply_power()


class FrameFaults:
    """Spoils sensor frames.

    Args:
        random: of the noise.
    """

    def __init__(self, random: np.random.Generator) -> None:
        self._random = random
        self._held: dict[str, tuple[float, ...]] = {}
        """Values that a stuck sensor repeats, by fault."""

    def forget(self, name: str) -> None:
        """A fault has ended, or begins again."""
        self._held.pop(name, None)

    def corrupt_frame(self, frame: SensorFrame, faults: Iterable[FrameFault]) -> SensorFrame:
        """The frame as a controller gets to see it."""
        for fault in faults:
            frame = msgspec.structs.replace(frame, **self._changes(frame, fault))
        return frame

    def _changes(self, frame: SensorFrame, fault: FrameFault) -> dict[str, Any]:
        if isinstance(fault, JointLimp):
            slot = INDEX[fault.joint]
            return {
                field: (*values[:slot], 0.0, *values[slot + 1 :])
                for field, values in (("stiffness", frame.stiffness), ("current", frame.current))
            }
        if isinstance(fault, HalError | PowerLoss):
            none = (0.0,) * N_JOINTS
            off = {} if isinstance(fault, HalError) else {"battery": (0.0, 0.0, *frame.battery[2:])}
            return {"stiffness": none, "current": none, **off}
        field, slots = sensor_slots(fault.sensor)
        values = list(getattr(frame, field))
        for i, value in zip(slots, self._values(fault, [values[i] for i in slots]), strict=True):
            values[i] = value
        return {field: tuple(values)}

    def _values(
        self, fault: SensorStuck | SensorDead | SensorNoisy | SensorOffset, values: list[float]
    ) -> Iterable[float]:
        if isinstance(fault, SensorStuck):
            return self._held.setdefault(fault.name, tuple(values))
        if isinstance(fault, SensorDead):
            return [0.0] * len(values)
        if isinstance(fault, SensorOffset):
            return [value + fault.offset for value in values]
        noise: list[float] = self._random.normal(0.0, fault.deviation, len(values)).tolist()
        return [value + error for value, error in zip(values, noise, strict=True)]


@dataclass(frozen=True)
class _Running:
    fault: Fault
    until: float
    """Robot time, s."""


class Faults:
    """Keeps the faults and puts them where they work. Without faults a cycle costs a few comparisons.

    Args:
        robot: Whose faults.
        servo: Its drives.
        rezero: Restarts the inertial unit.
        planned: Faults of the scenario.
        random: Source of everything random in the faults.
        notify: Called with one sentence and a short code when a fault begins and ends.
    """

    def __init__(
        self,
        robot: Multibody,
        servo: Servo,
        rezero: Callable[[], None],
        planned: Sequence[FaultEvent],
        random: np.random.Generator,
        notify: Callable[[str, str], None],
    ) -> None:
        self._notify, self._rezero = notify, rezero
        self._planned = sorted(planned, key=lambda event: event.time, reverse=True)
        self._running: dict[str, _Running] = {}
        chance = random.spawn(2)
        self._channel = CommandChannel(chance[0])
        self._frames = FrameFaults(chance[1])
        self._joints = JointFaults(robot, servo)
        self.stalled = False
        """The DCM has stopped."""
        self._of_commands: list[CommandFault] = []
        self._of_frames: list[FrameFault] = []
        self._find_next_change()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the faults in force."""
        return tuple(self._running)

    def begin_cycle(self, time: float) -> None:
        """Begin and end the faults that are due in this cycle; `time` is robot time, s."""
        self._joints.hold_heat()
        if time + 1e-9 < self._next:
            return
        for name in [n for n, running in self._running.items() if running.until <= time + 1e-9]:
            self.end(name)
        while self._planned and self._planned[-1].time <= time + 1e-9:
            event = self._planned.pop()
            try:
                self.start(event.fault, time, event.duration)
            except FrameError as error:
                self._notify("fault-refused", str(error))
        self._find_next_change()

    def start(self, fault: Fault, time: float, duration: float) -> str:
        """Begin a fault, and return its name.

        Args:
            fault: Which.
            time: Robot time now, s.
            duration: s; 0: until it is ended.

        Raises:
            FrameError: the body has no such joint, or a pause of the DCM without an end.
        """
        name = fault.name
        if isinstance(fault, JointFault) and not self._joints.has(fault.joint):
            raise FrameError(f"This body has no joint {fault.joint} that could fail.")
        if isinstance(fault, DcmPause) and duration <= 0.0:
            raise FrameError("A pause of the DCM needs a `duration` in s: standing still, it hears no end.")
        if isinstance(fault, InertialRezero):
            self._rezero()
            self._notify("fault", f"Fault {name} struck.")
            return name
        self._frames.forget(name)
        self._running.pop(name, None)
        self._running[name] = _Running(fault, time + duration if duration > 0.0 else math.inf)
        self._changed()
        self._notify("fault", f"Fault {name} begins.")
        return name

    def end(self, name: str = "") -> None:
        """End a fault by name; without one, all.

        Raises:
            FrameError: no such fault is in force.
        """
        if name and name not in self._running:
            raise FrameError(f"No fault `{name}` is in force; there are {', '.join(self._running) or 'none'}.")
        for ended in [name] if name else list(self._running):
            del self._running[ended]
            self._frames.forget(ended)
            self._notify("fault", f"Fault {ended} ends.")
        self._changed()

    def restart(self) -> None:
        """End all faults and drop the commands on the way; planned faults stay."""
        self.end()
        self._channel.clear()

    def _changed(self) -> None:
        faults = [running.fault for running in self._running.values()]
        self._of_commands = [fault for fault in faults if isinstance(fault, CommandFault)]
        self._of_frames = [
            fault for fault in faults if isinstance(fault, SensorFault | JointLimp | HalError | PowerLoss)
        ]
        self.stalled = any(isinstance(fault, DcmPause) for fault in faults)
        powered = not any(isinstance(fault, HalError | PowerLoss) for fault in faults)
        self._joints.apply((fault for fault in faults if isinstance(fault, JointFault)), powered)
        self._find_next_change()

    def _find_next_change(self) -> None:
        """Next time at which something begins or ends."""
        ends = [running.until for running in self._running.values()]
        self._next = min([*ends, *(event.time for event in self._planned[-1:])], default=math.inf)

    def apply_command_faults(self, command: ActuatorFrame | None) -> ActuatorFrame | None:
        """The command that reaches the DCM in this cycle, of the one sent in it and those on the way."""
        if not self._of_commands and self._channel.empty:
            return command
        return self._channel.apply_command_faults(command, self._of_commands)

    def corrupt_frame(self, frame: SensorFrame) -> SensorFrame:
        """The frame that leaves the DCM, made from the measured one."""
        return self._frames.corrupt_frame(frame, self._of_frames) if self._of_frames else frame
