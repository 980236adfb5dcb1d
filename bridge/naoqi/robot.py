"""A real V3 to V5 becomes `nao/<robot>`: NAOqi's memory as sensor frames, guarded commands to its DCM.

Each connection is a boot of its own: when it ends, the robot's token disappears, and when NAOqi is back the
robot begins anew at `seq` 0, disarmed. The DCM itself keeps the last command it got.
"""

from __future__ import annotations

import logging
import secrets
import threading
from typing import Final

import msgspec

from bridge.datasheet import Body, load_body
from bridge.datasheet.quantities import absent_joints
from bridge.errors import ConfigurationError, LinkError
from bridge.guard import Guard, GuardSettings
from bridge.host import RobotHost
from bridge.link import RobotLink
from bridge.messages import Info, SensorFrame
from bridge.naoqi.device import NaoqiDevice
from bridge.observer import NoticeLog
from bridge.realtime import quiet_process

logger = logging.getLogger(__name__)

LOOK_AHEAD: Final = 0.010
"""s; see `nao-hil bridge naoqi --look-ahead`."""
RETRY: Final = 0.5
"""s between two attempts to connect."""


class BridgeSettings(msgspec.Struct, frozen=True, kw_only=True):
    """How a robot is bridged."""

    url: str
    """Of the robot's NAOqi."""
    robot: str
    """Id on the link."""
    listen: str
    """Zenoh endpoint."""
    body: str | None = None
    """Data sheet; None: by what the robot says it is."""
    look_ahead: float = LOOK_AHEAD
    """s from a frame to the time of the command that answers it."""
    guard: GuardSettings = GuardSettings()
    dry_run: bool = False
    """Everything but the commands."""
    priority: int | None = None
    """SCHED_FIFO priority to ask for; None: none."""


class Bridged(msgspec.Struct, kw_only=True):
    """What was bridged; the JSON of `nao-hil bridge naoqi`."""

    connections: int = 0
    frames: int = 0
    left_out: int = 0
    """Cycles of the robot that were over before they were read."""
    commands: int = 0
    """Sent to the robot."""
    late: int = 0
    """Commands that were not at the robot by the cycle of their time."""
    missed: int = 0
    """Cycles that a controller was expected to serve and did not in time."""


class NaoqiBridge:
    """Connects, bridges, and connects again.

    Args:
        settings: see there.
        software: for `Info`.
        stop: set when it is to end.

    Raises:
        ConfigurationError: no such body.
    """

    def __init__(self, settings: BridgeSettings, software: str, stop: threading.Event) -> None:
        if settings.body is not None:
            load_body(settings.body)  # a misspelt name is told before anyone waits for a robot
        self._s, self._software, self._stop = settings, software, stop
        self._result = Bridged()

    def run(self) -> Bridged:
        """Bridge until stopped.

        Raises:
            ConfigurationError: a robot without a data sheet.
            LinkError: the endpoint cannot be listened on.
        """
        logger.info("waiting for NAOqi at %s", self._s.url)
        said = ""
        while not self._stop.is_set():
            try:
                device = NaoqiDevice(self._s.url, self._s.body, self._s.look_ahead)
            except LinkError as error:
                if str(error) != said:
                    said = str(error)
                    logger.warning("%s Trying again.", said)
                self._stop.wait(RETRY)
                continue
            said = ""
            try:
                self._bridge(device)
            finally:
                self._result.late += device.late
                device.close()
        return self._result

    def _bridge(self, device: NaoqiDevice) -> None:
        """From a first frame to the end of the connection."""
        self._result.connections += 1
        body = device.body
        with RobotLink(self._info(body), self._s.listen) as link:
            guard = Guard(body, self._s.guard, armed=False, dry_run=self._s.dry_run)
            host = RobotHost(link, guard, [NoticeLog()], dry_run=self._s.dry_run)
            logger.info(
                "robot `%s` (%s) at %s: %s", self._s.robot, body.name, self._s.listen, guard.status.text
            )
            quiet_process(self._s.priority)
            try:
                self._cycle(device, host, body.cycle)
            except LinkError as error:
                logger.warning("%s The robot is gone until NAOqi is back.", error)
            self._result.missed += host.missed

    def _cycle(self, device: NaoqiDevice, host: RobotHost, cycle: float) -> None:
        seq = -1
        while not host.ends(self._stop):
            reading = device.read()
            seq += reading.cycles if seq >= 0 else 1
            self._result.frames += 1
            self._result.left_out += reading.cycles - 1
            frame = SensorFrame(seq=seq, time=seq * cycle, **reading.fields)
            host.in_force = device.in_force
            given = host.exchange(frame, wait=device.spare)
            if given is not None:
                device.write(reading.moment, seq, given)
                self._result.commands += 1

    def _info(self, body: Body) -> Info:
        return Info(
            robot=self._s.robot,
            body=body.name,
            side="naoqi",
            mode="real-time",
            cycle=body.cycle,
            absent=absent_joints(body),
            boot=secrets.randbits(47),
            software=self._software,
        )


def check_look_ahead(seconds: float) -> float:
    """A look-ahead that a DCM can use.

    Raises:
        ConfigurationError: negative, or so long that no gait survives it.
    """
    if not 0.0 <= seconds <= 0.2:
        raise ConfigurationError(f"A look-ahead of {seconds:g} s is not possible; 0 to 0.2 s is.")
    return seconds
