"""A real robot's side of the link, common to LoLA and NAOqi: settings, counts, guard and host of a connection.

Each connection to a robot is a boot of its own: at its end the robot's token disappears, and the next one
begins at `seq` 0, disarmed. The robot itself keeps its last command.
"""

from __future__ import annotations

import contextlib
import logging
import threading
from collections.abc import Iterator
from typing import Final

import msgspec

from bridge.body import Body
from bridge.errors import LinkError
from bridge.guard import Guard, GuardSettings
from bridge.host import RobotHost, robot_info
from bridge.link import RobotLink
from bridge.realtime import quiet_process
from bridge.recording.observer import NoticeLog

logger = logging.getLogger(__name__)

_RETRY_INTERVAL: Final = 0.5
"""s between two attempts to connect."""


class BridgeSettings(msgspec.Struct, frozen=True, kw_only=True):
    """Settings of a bridge to any robot."""

    robot: str
    """Id on the link."""
    listen: str
    """Zenoh endpoint."""
    software: str
    """For `Info`."""
    body: str | None = None
    """Data sheet; None: by the robot's reported version."""
    mode: str = "real-time"
    """`lockstep`: for a served LoLA of a robot in lockstep, which waits for answers."""
    guard: GuardSettings = GuardSettings()
    dry_run: bool = False
    """Send no commands to the robot."""
    priority: int | None = None
    """SCHED_FIFO priority to ask for; None: none."""


class BridgeCounts(msgspec.Struct, kw_only=True):
    """Counts of a bridge to any robot."""

    connections: int = 0
    left_out: int = 0
    """Cycles of the robot without a reading."""
    commands: int = 0
    """Sent to the robot."""
    missed: int = 0
    """Expected answers that were not in time, cycles."""


class Retry:
    """Waits between attempts to connect, and logs each reason once.

    Args:
        stop: set when the bridge is to end.
    """

    def __init__(self, stop: threading.Event) -> None:
        self._stop = stop
        self._reason = ""

    def wait(self, reason: object) -> None:
        """Wait for the next attempt; a new reason is logged."""
        if str(reason) != self._reason:
            self._reason = str(reason)
            logger.warning("%s Trying again.", reason)
        self._stop.wait(_RETRY_INTERVAL)

    def succeeded(self) -> None:
        """Log the next reason in any case."""
        self._reason = ""


@contextlib.contextmanager
def hosted(settings: BridgeSettings, body: Body, counts: BridgeCounts, side: str) -> Iterator[RobotHost]:
    """The host of one connection, whose end is logged and ends the context.

    Args:
        settings: of the bridge.
        body: of the robot.
        counts: of the bridge.
        side: protocol of the robot, `lola` or `naoqi`.
    """
    info = robot_info(body, robot=settings.robot, side=side, mode=settings.mode, software=settings.software)
    counts.connections += 1
    with RobotLink(info, settings.listen, announced=False) as link:
        guard = Guard(body, settings.guard, armed=False, dry_run=settings.dry_run)
        host = RobotHost(link, guard, [NoticeLog()], dry_run=settings.dry_run)
        link.announce()
        logger.info("robot `%s` (%s) at %s: %s", info.robot, body.name, settings.listen, guard.status.text)
        if settings.mode == "real-time":
            quiet_process(settings.priority)
        try:
            yield host
        except LinkError as error:
            logger.warning("%s The robot is gone until it answers again.", error)
        counts.missed += host.missed
