"""Topics: which message is published under which key of a robot, by which side, and whether it is recorded.

A new message of the link is a struct, a row here, and a call of `RobotHost.emit` (the robot's) or
`ControllerLink.publish` (a controller's). Rights and recordings follow this table; `columns.py` has
unit and frame of each recorded quantity.
"""

from __future__ import annotations

from typing import Any, Final, Literal, NamedTuple

from bridge.messages.frames import ActuatorFrame, LedFrame, Notice, SensorFrame
from bridge.messages.guard import GuardStatus
from bridge.messages.walk import UpperBody, WalkTelemetry
from bridge.messages.world_state import TruthFrame

Side = Literal["robot", "controller"]
Message = SensorFrame | ActuatorFrame | TruthFrame | WalkTelemetry | Notice | GuardStatus | LedFrame | UpperBody


class Topic(NamedTuple):
    """How a kind of message is published."""

    suffix: str
    """Key below `nao/<robot>/`; also the name in a recording."""
    senders: tuple[Side, ...]
    receiver: Side | None = None
    """Side that acts on it, and so may subscribe to it under certificates; listeners may subscribe to all."""
    recorded: bool = True


TOPICS: Final[dict[type[Message], Topic]] = {
    SensorFrame: Topic("sensors", ("robot",), "controller"),
    ActuatorFrame: Topic("actuators", ("controller",), "robot"),
    TruthFrame: Topic("world/truth", ("robot",)),
    WalkTelemetry: Topic("walk/telemetry", ("controller",), "robot"),
    Notice: Topic("notices", ("robot", "controller"), "controller"),
    GuardStatus: Topic("guard", ("robot",), "controller", recorded=False),
    LedFrame: Topic("leds", ("controller",), "robot", recorded=False),
    UpperBody: Topic("walk/upper-body", ("controller",), "controller", recorded=False),
}


def sent_by(side: Side) -> dict[type[Any], str]:
    """Suffix of each kind of message that a side publishes."""
    return {kind: topic.suffix for kind, topic in TOPICS.items() if side in topic.senders}
