"""LoLA in lockstep to a robot of this process, for what the robot does rather than the processes between."""

from __future__ import annotations

from bridge.adapters.lola.client import Setpoints
from bridge.adapters.lola.codec import ACTUATORS, MapStream
from bridge.adapters.lola.packets import Identity, sensor_packet
from bridge.guard import Guard
from bridge.messages import ActuatorFrame
from emulator.robot import EmulatedRobot
from tests.loops import repeat_while


class LolaSocket:
    """What a client has of a socket: each map that it sends is a cycle behind the guard."""

    def __init__(self, robot: EmulatedRobot) -> None:
        self.robot, self._guard, self._lease = robot, Guard(robot.body), 0
        self.connect("")

    def connect(self, _path: str) -> None:
        self._lease += 1
        self._stream, self._setpoints = MapStream(ACTUATORS), Setpoints(self.robot.frame.stiffness)

    def settimeout(self, _seconds: float) -> None:
        """There is nothing to wait for."""

    def sendall(self, data: bytes) -> None:
        for values in self._stream.feed(data):
            assert not self._setpoints.update(values)
        frame, wanted = self.robot.frame, self._setpoints
        command = ActuatorFrame(
            reply_to=frame.seq,
            position=wanted.position(frame.position),
            stiffness=wanted.stiffness,
            lease=self._lease,
        )
        self._cycle(self._guard.check(command, frame.seq))

    def recv(self, _size: int, _flags: int = 0) -> bytes:
        return sensor_packet(self.robot.frame, Identity())

    def abandon(self) -> None:
        """The client ends and leaves the robot stiff; the guard brings it down."""
        for _ in repeat_while(lambda: self._guard.state != "rest", 1000):
            self._cycle(None)

    def _cycle(self, command: ActuatorFrame | None) -> None:
        frame = self.robot.frame
        self.robot.advance(self._guard.cycle(frame, command, supervised=True, direct=True))
