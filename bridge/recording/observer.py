"""Observers of a run (statistics, recordings, progress), and notices in logs, logs as notices."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Sequence
from typing import Final

from bridge.messages import ActuatorFrame, Notice, SensorFrame, TruthFrame, WalkTelemetry
from bridge.messages.topics import Message

logger = logging.getLogger(__name__)


class Observer:
    """Receives the events of a run, in the same order in every mode; each method does nothing by default."""

    def sensors(self, frame: SensorFrame, truth: TruthFrame) -> None:
        """A boundary of the DCM cycle, with the ground truth of the same instant."""

    def command(self, frame: ActuatorFrame) -> None:
        """The actuator frame in force, after the guard."""

    def message(self, message: Message) -> None:
        """Any other recorded message of `TOPICS`; telemetry and notices have a method each."""
        if isinstance(message, WalkTelemetry):
            self.telemetry(message)
        elif isinstance(message, Notice):
            self.notice(message)

    def telemetry(self, message: WalkTelemetry) -> None:
        """The walker's report on its walk."""

    def notice(self, message: Notice) -> None:
        """An event in the robot's world: a push, a plate, a fault."""


class DeferredObserver(Observer):
    """Keeps the events of a run for other observers until `deliver`.

    Args:
        observers: get each event in its order.
    """

    def __init__(self, observers: Sequence[Observer]) -> None:
        self._observers = observers
        self._waiting: deque[Callable[[Observer], None]] = deque()

    def sensors(self, frame: SensorFrame, truth: TruthFrame) -> None:
        """Keep both."""
        self._waiting.append(lambda observer: observer.sensors(frame, truth))

    def command(self, frame: ActuatorFrame) -> None:
        """Keep the command in force."""
        self._waiting.append(lambda observer: observer.command(frame))

    def message(self, message: Message) -> None:
        """Keep it."""
        self._waiting.append(lambda observer: observer.message(message))

    def deliver(self) -> None:
        """Call the observers for all that waits."""
        while self._waiting:
            event = self._waiting.popleft()
            for observer in self._observers:
                event(observer)


class NoticeLog(Observer):
    """Logs the guard's notices: its acts with their reasons, who armed it and who stopped it."""

    def notice(self, message: Notice) -> None:
        """Its sentence, as a warning unless it is one of level `info`."""
        logger.log(logging.INFO if message.level == "info" else logging.WARNING, "%s", message.text)


SERVER: Final = "server"
"""Code of notices that are warnings of a server's log."""
_LEVELS: Final = {"info": logging.INFO, "error": logging.ERROR}


def log_notice(logger: logging.Logger, notice: Notice) -> None:
    """Log a notice at its own level; clipped angles, which may come in each cycle, only for debugging.

    Args:
        logger: of the server.
        notice: from the robot.
    """
    if notice.code == SERVER:
        return
    level = logging.DEBUG if notice.code == "clipped" else _LEVELS.get(notice.level, logging.WARNING)
    logger.log(level, _NOTICE_FORMAT, notice.text)


_NOTICE_FORMAT: Final = "the robot says: %s"


class NoticeHandler(logging.Handler):
    """Publishes the warnings of a server, for the page and other listeners.

    Args:
        publish: one notice.
    """

    def __init__(self, publish: Callable[[Notice], None]) -> None:
        super().__init__(logging.WARNING)
        self._publish = publish

    def emit(self, record: logging.LogRecord) -> None:
        """Publish a warning that is not itself a notice."""
        if record.msg != _NOTICE_FORMAT:
            self._publish(Notice(seq=0, level="warning", code=SERVER, text=record.getMessage()))
