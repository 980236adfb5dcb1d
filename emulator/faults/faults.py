"""The faults of one robot: which are in force, since when, until when."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from bridge.errors import FrameError
from bridge.messages import ActuatorFrame, SensorFrame
from bridge.messages.faults import (
    CommandFault,
    DcmPause,
    Fault,
    HalError,
    InertialRezero,
    JointFault,
    JointLimp,
    PowerLoss,
    SensorFault,
)
from emulator.engine.base import Multibody
from emulator.faults.commands import CommandChannel
from emulator.faults.joints import JointFaults
from emulator.faults.sensors import FrameFault, FrameFaults
from emulator.scenarios.events import FaultEvent
from emulator.servo.servo import Servo


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
        rezero: Starts the inertial unit anew.
        planned: Faults of the scenario.
        random: Source of everything random in the faults.
        say: Told in one sentence when a fault begins and ends, with a short code.
    """

    def __init__(
        self,
        robot: Multibody,
        servo: Servo,
        rezero: Callable[[], None],
        planned: Sequence[FaultEvent],
        random: np.random.Generator,
        say: Callable[[str, str], None],
    ) -> None:
        self._say, self._rezero = say, rezero
        self._planned = sorted(planned, key=lambda event: event.time, reverse=True)
        self._running: dict[str, _Running] = {}
        chance = random.spawn(2)
        self._channel = CommandChannel(chance[0])
        self._frames = FrameFaults(chance[1])
        self._joints = JointFaults(robot, servo)
        self.stalled = False
        """The DCM stands still."""
        self._of_commands: list[CommandFault] = []
        self._of_frames: list[FrameFault] = []
        self._look_ahead()

    @property
    def names(self) -> tuple[str, ...]:
        """Of the faults in force."""
        return tuple(self._running)

    def begin_cycle(self, time: float) -> None:
        """What begins and ends with the cycle that begins now; `time` is robot time, s."""
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
                self._say("fault-refused", str(error))
        self._look_ahead()

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
            self._say("fault", f"Fault {name} struck.")
            return name
        self._frames.forget(name)
        self._running.pop(name, None)
        self._running[name] = _Running(fault, time + duration if duration > 0.0 else math.inf)
        self._changed()
        self._say("fault", f"Fault {name} begins.")
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
            self._say("fault", f"Fault {ended} ends.")
        self._changed()

    def _changed(self) -> None:
        faults = [running.fault for running in self._running.values()]
        self._of_commands = [fault for fault in faults if isinstance(fault, CommandFault)]
        self._of_frames = [
            fault for fault in faults if isinstance(fault, SensorFault | JointLimp | HalError | PowerLoss)
        ]
        self.stalled = any(isinstance(fault, DcmPause) for fault in faults)
        powered = not any(isinstance(fault, HalError | PowerLoss) for fault in faults)
        self._joints.apply((fault for fault in faults if isinstance(fault, JointFault)), powered)
        self._look_ahead()

    def _look_ahead(self) -> None:
        """Next time at which something begins or ends."""
        ends = [running.until for running in self._running.values()]
        self._next = min([*ends, *(event.time for event in self._planned[-1:])], default=math.inf)

    def carry(self, command: ActuatorFrame | None) -> ActuatorFrame | None:
        """The command that reaches the DCM in this cycle, of the one sent in it and those on the way."""
        if not self._of_commands and self._channel.empty:
            return command
        return self._channel.carry(command, self._of_commands)

    def spoil(self, frame: SensorFrame) -> SensorFrame:
        """The frame that leaves the DCM, of the one that was measured."""
        return self._frames.spoil(frame, self._of_frames) if self._of_frames else frame
