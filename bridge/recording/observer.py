"""Who may look on while robot and controller run: statistics, recordings, progress."""

from __future__ import annotations

import logging

from bridge.messages import ActuatorFrame, Notice, SensorFrame, TruthFrame, WalkTelemetry

logger = logging.getLogger(__name__)


class Observer:
    """Told of a run in its own order, the same in every mode. Each method does nothing unless overridden."""

    def sensors(self, frame: SensorFrame, truth: TruthFrame) -> None:
        """A boundary of the DCM cycle, with the ground truth of the same instant."""

    def command(self, frame: ActuatorFrame) -> None:
        """The actuator frame that was put in force, after the guard."""

    def telemetry(self, message: WalkTelemetry) -> None:
        """What the walker says of its walk."""

    def notice(self, message: Notice) -> None:
        """What the robot side says that happened in its world: pushes, plates, faults."""


class NoticeLog(Observer):
    """Tells a bridge's terminal what the guard says: what it does and why, who armed it and who stopped it."""

    def notice(self, message: Notice) -> None:
        """Its sentence, as a warning unless it is one of level `info`."""
        logger.log(logging.INFO if message.level == "info" else logging.WARNING, "%s", message.text)
