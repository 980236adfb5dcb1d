"""World commands: checked in the thread they come in, carried out at a cycle boundary, then answered."""

from __future__ import annotations

from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from typing import Final, Protocol

import msgspec

from bridge.errors import FrameError, LinkError
from bridge.guard import Guard
from bridge.messages import TruthFrame, decode_command, encode
from bridge.messages.world import (
    EndFault,
    LayDown,
    Pause,
    Press,
    Reset,
    Resume,
    StandUp,
    StartFault,
    Status,
    Step,
    WorldCommand,
)
from bridge.messages.world_state import WorldReply
from emulator.boundary import BoundaryQueue
from emulator.faults import Faults
from emulator.sensors.suite import Sensors
from emulator.world.events import EventExecutor
from emulator.world.world import World

MAX_STEP_WAIT: Final = 600.0
"""s of wall clock that a `step` may take before its sender is told so."""


class RobotInWorld(Protocol):
    """What world commands need of a robot; all of it is new after a reset."""

    world: World
    world_events: EventExecutor
    faults: Faults
    sensors: Sensors

    @property
    def posture(self) -> tuple[float, ...]:
        """What it stands up to, 25 angles, rad."""

    def truth(self) -> TruthFrame:
        """Ground truth now."""

    @property
    def time(self) -> float:
        """Robot time, s."""

    @property
    def seq(self) -> int:
        """Number of the present boundary."""

    def reset(self) -> None:
        """Begin anew."""

    def stand_up(self) -> tuple[str, ...]:
        """Back on its feet; the boxes that were taken away for that."""

    def lay_down(self, name: str) -> tuple[str, ...]:
        """Into a start pose, where it is; likewise."""


class WorldQueries:
    """Handler of the query `world/command`, and whether the world runs.

    Args:
        robot: Touched at cycle boundaries only.
        boundary: Where commands wait for them.
        guard: Of the robot; it is told when somebody put the robot on its feet.
    """

    def __init__(self, robot: RobotInWorld, boundary: BoundaryQueue, guard: Guard) -> None:
        self._robot, self._boundary, self._guard = robot, boundary, guard
        self._paused = False
        self._steps = 0
        self._stepping: Future[WorldReply] | None = None
        self.began_anew = False
        """The robot was reset; whoever publishes its frames takes note and sets it back."""

    @property
    def stands_still(self) -> bool:
        """No cycle is to be run now."""
        return self._paused and self._steps == 0

    @property
    def steps(self) -> bool:
        """Cycles that were asked for one by one are being run."""
        return self._steps > 0

    def answer(self, payload: bytes) -> bytes:
        """Carry out one command; any thread but the loop's.

        Raises:
            FrameError: not a command, or not possible in this world.
            LinkError: the loop came to no boundary in time.
        """
        command = decode_command(payload, WorldCommand, "World command")
        if not isinstance(command, Step):
            return encode(self._boundary.call(lambda: self._execute(command)))
        done = self._boundary.call(lambda: self._start_steps(command.cycles))
        try:
            return encode(done.result(MAX_STEP_WAIT))
        except FutureTimeoutError:
            raise LinkError(f"The {command.cycles} cycles were not done within {MAX_STEP_WAIT:g} s.") from None

    def cycle_done(self) -> None:
        """The loop has run a cycle."""
        if self._steps > 0:
            self._steps -= 1
            if self._steps == 0:
                self._end_steps("The cycles have run.")

    def close(self) -> None:
        """The loop has ended: whoever waits for steps is told."""
        self._end_steps("The robot's process ended.")

    def _execute(self, command: WorldCommand) -> WorldReply:
        text = "Nothing was done."
        if isinstance(command, Pause):
            self._paused, text = True, "The world stands still."
            self._end_steps("The cycles were ended by a pause.")
        elif isinstance(command, Resume):
            self._paused, text = False, "The world runs."
            self._end_steps("The world runs on.")
        elif isinstance(command, Reset):
            self._end_steps("The world began anew.")
            self._robot.reset()
            self.began_anew, text = True, "The world began anew."
        elif isinstance(command, StandUp):
            if self._guard.moves and not self._robot.truth().fell:
                raise FrameError("The robot is on its feet and under command; `stand-up` is for one that fell.")
            text = carry_out(self._robot, command)
            self._guard.stood_up(self._robot.seq, self._robot.posture)
        elif isinstance(command, LayDown):
            text = carry_out(self._robot, command)
            self._guard.laid_down(self._robot.seq)
        elif not isinstance(command, (Status, Step)):
            text = carry_out(self._robot, command)
        reply = self._reply(text)
        if isinstance(command, Status) and command.terrain:
            reply = msgspec.structs.replace(reply, terrain=self._robot.world.terrain)
        return reply

    def _start_steps(self, cycles: int) -> Future[WorldReply]:
        self._end_steps("Other cycles were asked for.")
        self._paused, self._steps = True, cycles
        self._stepping = Future()
        return self._stepping

    def _end_steps(self, text: str) -> None:
        stepping, self._stepping, self._steps = self._stepping, None, 0
        if stepping is not None:
            stepping.set_result(self._reply(text))

    def _reply(self, text: str) -> WorldReply:
        robot = self._robot
        return WorldReply(
            text=text,
            seq=robot.seq,
            time=robot.time,
            paused=self._paused,
            floor=robot.world.tilt,
            friction=robot.world.surface.friction,
            objects=robot.world_events.objects(),
            things=robot.world.seen_things(),
            faults=robot.faults.names,
        )


def carry_out(robot: RobotInWorld, command: WorldCommand) -> str:
    """Carry out a command that does not concern the robot's clock, between two cycles.

    Args:
        robot: Whose world.
        command: Any but those of the clock.

    Returns:
        What was done, in one sentence.

    Raises:
        FrameError: not possible in this world.
        ConfigurationError: no such button.
    """
    if isinstance(command, StartFault):
        name = robot.faults.start(command.fault, robot.time, command.duration)
        return f"Fault {name} begins."
    if isinstance(command, EndFault):
        robot.faults.end(command.name)
        return f"Fault {command.name} ends." if command.name else "No fault is in force."
    if isinstance(command, Press):
        robot.sensors.touch.press(command.button, float(command.pressed))
        return f"Button {command.button} is {'pressed' if command.pressed else 'released'}."
    if isinstance(command, StandUp):
        return "The robot was put back on its feet." + _taken_away(robot.stand_up())
    if isinstance(command, LayDown):
        boxes = robot.lay_down(command.pose)
        return f"The robot was put into the pose `{command.pose}`." + _taken_away(boxes)
    if isinstance(command, (Status, Reset, Pause, Resume, Step)):
        raise TypeError(f"{type(command).__name__} is for whoever keeps the robot's clock")
    return robot.world_events.execute(command)


def _taken_away(boxes: tuple[str, ...]) -> str:
    return "".join(f" Box `{name}` was there and was taken away." for name in boxes)
