"""The queries of a robot's process: commands to the world, and the DCM's.

Each is checked in Zenoh's thread, carried out at a cycle boundary, then answered.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from typing import Any, Final

import msgspec

from bridge.dcm import Dcm
from bridge.dcm.requests import alias_request, set_alias_request, set_request
from bridge.errors import DcmRefused, FrameError, LinkError
from bridge.guard import Guard
from bridge.messages import dcm as wire
from bridge.messages import decode, decode_command, encode
from bridge.messages.world import (
    EndFault,
    LayDown,
    Pause,
    Press,
    ReportGame,
    Reset,
    Resume,
    StandUp,
    StartFault,
    Status,
    Step,
    WorldCommand,
)
from bridge.messages.world_state import WorldReply
from emulator.robot import EmulatedRobot
from emulator.timing import BoundaryQueue

Handler = Callable[[bytes], bytes]
MAX_STEP_WAIT: Final = 600.0
"""s of wall clock that a `step` may take before its sender is answered with an error."""


class DcmQueries:
    """Handlers of the `dcm/` queries of one robot.

    Args:
        robot: touched at cycle boundaries only.
        boundary: where work waits for them.
        require_lease: raises `LeaseRefused` unless the number is the lease's; the second argument names the
            refused act.
    """

    def __init__(
        self, robot: EmulatedRobot, boundary: BoundaryQueue, require_lease: Callable[[int, str], None]
    ) -> None:
        self._robot, self._boundary = robot, boundary
        self._require_lease = require_lease

    def handlers(self) -> dict[str, Handler]:
        """Handler of each key below the robot's: payload in, reply out; a `NaoHilError` is a refusal."""
        return {
            wire.CREATE_ALIAS: self._create_alias,
            wire.SET: self._set,
            wire.SET_ALIAS: self._set_alias,
            wire.GET_TIME: self._get_time,
            wire.GET_PREFIX: self._get_prefix,
            wire.READ: self._read,
            wire.PREFERENCES: _refusal("preferences", "the emulated robot has no preference files"),
            wire.SPECIAL: _refusal("special", "there are no boards to reset or program"),
            wire.CALIBRATION: _refusal("calibration", "the emulated joints have no offsets to calibrate"),
        }

    def _create_alias(self, payload: bytes) -> bytes:
        message = decode(payload, wire.DcmCommand)
        request = alias_request(message.command)
        return self._commanded(message, wire.CREATE_ALIAS, lambda dcm: dcm.create_alias(request))

    def _set(self, payload: bytes) -> bytes:
        message = decode(payload, wire.DcmCommand)
        request = set_request(message.command)
        return self._commanded(message, wire.SET, lambda dcm: dcm.set(request))

    def _set_alias(self, payload: bytes) -> bytes:
        message = decode(payload, wire.DcmCommand)
        request = set_alias_request(message.command)
        return self._commanded(message, wire.SET_ALIAS, lambda dcm: dcm.set_alias(request))

    def _get_time(self, payload: bytes) -> bytes:
        offset = decode(payload, wire.DcmTime).offset if payload else 0
        return self._done(lambda: self._robot.dcm.clock.shown(offset))

    def _get_prefix(self, payload: bytes) -> bytes:
        if payload:
            decode(payload, wire.DcmCall)
        return self._done(lambda: self._robot.dcm.prefixes())

    def _read(self, payload: bytes) -> bytes:
        names = decode(payload, wire.DcmRead).names
        return self._done(lambda: self._robot.dcm.read(names, self._robot.frame.position))

    def _commanded(self, message: wire.DcmCommand, key: str, command: Callable[[Dcm], Any]) -> bytes:
        def work() -> Any:
            self._require_lease(message.lease, f"A `{key}` command")
            return command(self._robot.dcm)

        return self._done(work)

    def _done(self, work: Callable[[], Any]) -> bytes:
        return encode(wire.DcmReply(result=self._boundary.call(work)))


def _refusal(method: str, reason: str) -> Handler:
    def refuse(payload: bytes) -> bytes:
        if payload:
            decode(payload, wire.DcmCall)
        raise DcmRefused(f"{method} is not emulated: {reason}.")

    return refuse


class WorldClock:
    """Whether a world runs."""

    def __init__(self) -> None:
        self._stopped = False
        self._steps = 0
        self._stepping: tuple[Future[WorldReply], Callable[[str], WorldReply]] | None = None
        self.restarted: list[str] = []
        """Names of robots that begin again; the publisher of their frames notices and clears them."""

    @property
    def stopped(self) -> bool:
        """It stands still but for the cycles of a `step` command."""
        return self._stopped

    @property
    def paused(self) -> bool:
        """No cycle is to be run now."""
        return self._stopped and self._steps == 0

    @property
    def steps(self) -> bool:
        """Cycles of a `step` command are running."""
        return self._steps > 0

    def stop(self, stopped: bool, text: str) -> None:
        """Stop or resume; cycles that are running end with this text."""
        self._stopped = stopped
        self.end_steps(text)

    def start_steps(self, cycles: int, reply: Callable[[str], WorldReply]) -> Future[WorldReply]:
        """Let so many cycles run, then stop; they are answered with a reply that holds a text."""
        self.stop(True, "Other cycles were asked for.")
        self._steps, self._stepping = cycles, (Future(), reply)
        return self._stepping[0]

    def end_steps(self, text: str) -> None:
        """Answer the running cycles: they have run, or are ended."""
        stepping, self._stepping, self._steps = self._stepping, None, 0
        if stepping is not None:
            done, reply = stepping
            done.set_result(reply(text))

    def cycle_done(self) -> None:
        """The loop has run a cycle."""
        if self._steps > 0:
            self._steps -= 1
            if self._steps == 0:
                self.end_steps("The cycles have run.")


class WorldQueries:
    """Handler of the query `world/command` of one robot.

    Args:
        robot: Touched at cycle boundaries only.
        boundary: Where commands wait for them.
        guard: Of the robot; informed when the robot is put on its feet.
        clock: Of the world.
    """

    def __init__(self, robot: EmulatedRobot, boundary: BoundaryQueue, guard: Guard, clock: WorldClock) -> None:
        self._robot, self._boundary, self._guard, self._clock = robot, boundary, guard, clock

    def answer(self, payload: bytes) -> bytes:
        """Carry out one command; any thread but the loop's.

        Raises:
            FrameError: not a command, or not possible in this world.
            LinkError: the loop reached no boundary in time.
        """
        command = decode_command(payload, WorldCommand, "World command")
        if not isinstance(command, Step):
            return encode(self._boundary.call(lambda: self._execute(command)))
        done = self._boundary.call(lambda: self._clock.start_steps(command.cycles, self._reply))
        try:
            return encode(done.result(MAX_STEP_WAIT))
        except FutureTimeoutError:
            raise LinkError(f"The {command.cycles} cycles were not done within {MAX_STEP_WAIT:g} s.") from None

    def _execute(self, command: WorldCommand) -> WorldReply:
        text = "Nothing was done."
        if isinstance(command, Pause):
            text = "The world stands still."
            self._clock.stop(True, "The cycles were ended by a pause.")
        elif isinstance(command, Resume):
            text = "The world runs."
            self._clock.stop(False, "The world runs on.")
        elif isinstance(command, Reset) and command.scope == "world":
            text = "The world begins again."
            self._clock.end_steps(text)
            self._robot.reset()
            self._clock.restarted += [robot.name for robot in self._robot.world.robots]
        elif isinstance(command, Reset):
            text = carry_out(self._robot, command)
            self._clock.restarted.append(self._robot.name)
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

    def _reply(self, text: str) -> WorldReply:
        robot = self._robot
        return WorldReply(
            text=text,
            seq=robot.seq,
            time=robot.time,
            paused=self._clock.stopped,
            floor=robot.world.tilt,
            friction=robot.world.surface.friction,
            objects=robot.world.object_states(),
            things=robot.world.visible_things(),
            faults=robot.faults.names,
        )


def carry_out(robot: EmulatedRobot, command: WorldCommand) -> str:
    """Carry out a command that does not concern the robot's clock, between two cycles.

    Args:
        robot: Whose world.
        command: Any but those of the clock.

    Returns:
        The act, in one sentence.

    Raises:
        FrameError: not possible in this world.
        ConfigurationError: no such button.
    """
    if isinstance(command, StartFault):
        name = robot.faults.start(command.fault, robot.world_time, command.duration)
        return f"Fault {name} begins."
    if isinstance(command, EndFault):
        robot.faults.end(command.name)
        return f"Fault {command.name} ends." if command.name else "No fault is in force."
    if isinstance(command, Press):
        robot.sensors.touch.press(command.button, float(command.pressed))
        return f"Button {command.button} is {'pressed' if command.pressed else 'released'}."
    if isinstance(command, ReportGame):
        robot.world.report_game(command.game)
        return f"The state of the game is `{command.game.state}`."
    if isinstance(command, StandUp):
        return "The robot was put back on its feet." + _removed_text(robot.stand_up())
    if isinstance(command, LayDown):
        boxes = robot.lay_down(command.pose)
        return f"The robot was put into the pose `{command.pose}`." + _removed_text(boxes)
    if isinstance(command, Reset) and command.scope == "robot":
        return f"Robot `{robot.name}` begins again." + _removed_text(robot.restart())
    if isinstance(command, (Status, Reset, Pause, Resume, Step)):
        raise TypeError(f"{type(command).__name__} is for whoever keeps the robot's clock")
    return robot.world_events.execute(command)


def _removed_text(boxes: tuple[str, ...]) -> str:
    return "".join(f" Box `{name}` was there and was taken away." for name in boxes)
