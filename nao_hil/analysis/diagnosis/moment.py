"""All that was said of one cycle, put together from messages in the order they came."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from bridge.messages import ActuatorFrame, Notice, SensorFrame, TruthFrame, WalkTelemetry
from bridge.recording.canonical import Recordable
from bridge.recording.playback import Recorded


class Moment(NamedTuple):
    """One sensor frame with the messages that belong to it."""

    sensors: SensorFrame
    truth: TruthFrame | None = None
    """Of the same instant; None on a real robot."""
    walk: WalkTelemetry | None = None
    """The newest word of the walker up to the next frame; None before its first."""
    notices: tuple[Notice, ...] = ()
    """Notices of the robot's side since the frame before."""
    asked: ActuatorFrame | None = None
    """The newest command up to the next frame; None before the first."""


class MomentBuilder:
    """Groups messages into moments: one is complete when the next sensor frame comes."""

    def __init__(self) -> None:
        self._sensors: SensorFrame | None = None
        self._truth: TruthFrame | None = None
        self._walk: WalkTelemetry | None = None
        self._notices: list[Notice] = []
        self._asked: ActuatorFrame | None = None

    def add(self, message: Recordable) -> Moment | None:
        """Take in a message; the moment that it completes, if it is a sensor frame."""
        complete = None
        if isinstance(message, SensorFrame):
            complete = self.rest()
            if complete is not None and message.seq < complete.sensors.seq:
                self._walk = self._asked = None  # the robot restarted
            self._sensors, self._truth = message, None
        elif isinstance(message, TruthFrame):
            self._truth = message
        elif isinstance(message, WalkTelemetry):
            self._walk = message
        elif isinstance(message, ActuatorFrame):
            self._asked = message
        elif isinstance(message, Notice):
            self._notices.append(message)
        return complete

    def rest(self) -> Moment | None:
        """The moment that is under way."""
        if self._sensors is None:
            return None
        truth = self._truth if self._truth is not None and self._truth.seq == self._sensors.seq else None
        moment = Moment(self._sensors, truth, self._walk, tuple(self._notices), self._asked)
        self._sensors, self._notices = None, []
        return moment


def moments(messages: Iterable[Recorded]) -> Iterator[Moment]:
    """The moments of a recording, as `bridge.recording.playback.read_recording` gives its messages."""
    builder = MomentBuilder()
    for recorded in messages:
        if (moment := builder.add(recorded.message)) is not None:
            yield moment
    if (last := builder.rest()) is not None:
        yield last
