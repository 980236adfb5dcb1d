"""Columns of a run: name, unit, frame and elements of every recorded quantity, declared once.

A column is a field of a recorded message; a field of a part has both names (`left.force`). A list of parts is a
table of its own, one row for each part of each message (`OBJECTS`).
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

from bridge.body.joints import JOINTS
from bridge.messages.frames import ELEMENTS, N_LEDS, ActuatorFrame, Notice, SensorFrame
from bridge.messages.walk import WalkTelemetry
from bridge.messages.world_state import TruthFrame, WorldObject


class Column(NamedTuple):
    """A quantity, one value or one row of values for each message."""

    unit: str = ""
    """SI, or rad; of a pose those of its lengths and angles; empty: a number, a word or a truth value."""
    frame: str = ""
    """Frame of its coordinates: `torso`, `sole`, `walk` (as planned) or `world`; empty: none."""
    elements: tuple[str, ...] = ()
    """Names of the values of a row; empty: one value."""


_X: Final = ("x", "y")
_XYZ: Final = ("x", "y", "z")
_FEET: Final = ("left", "right")
_SOLE: Final = Column("m, rad", "walk", (*_XYZ, "roll", "pitch", "yaw"))
_FORCE: Final = Column("N", "world", _XYZ)
_COP: Final = Column("m", "sole", _X)

OBJECTS: Final = "world/objects"
"""Table of the objects of all ground truth."""
COLUMNS: Final[dict[type[Any], dict[str, Column]]] = {
    SensorFrame: {
        "seq": Column(),
        "time": Column("s"),
        "position": Column("rad", elements=JOINTS),
        "stiffness": Column(elements=JOINTS),
        "current": Column("A", elements=JOINTS),
        "temperature": Column("°C", elements=JOINTS),
        "fsr": Column("N", "sole", ELEMENTS["fsr"]),
        "accelerometer": Column("m/s²", "torso", _XYZ),
        "gyroscope": Column("rad/s", "torso", _XYZ),
        "angle": Column("rad", "world", _X),
        "touch": Column(elements=ELEMENTS["touch"]),
        "battery": Column(elements=ELEMENTS["battery"]),
        "sonar": Column("m", elements=ELEMENTS["sonar"]),
        "command": Column(),
        "missed": Column(),
    },
    ActuatorFrame: {
        "reply_to": Column(),
        "position": Column("rad", elements=JOINTS),
        "stiffness": Column(elements=JOINTS),
    },
    TruthFrame: {
        "seq": Column(),
        "time": Column("s"),
        "torso_position": Column("m", "world", _XYZ),
        "torso_orientation": Column("", "world", (*_XYZ, "w")),
        "torso_velocity": Column("m/s", "world", _XYZ),
        "torso_angular_velocity": Column("rad/s", "world", _XYZ),
        "joints": Column("rad", elements=JOINTS),
        "com": Column("m", "world", _XYZ),
        "zmp": Column("m", "world", _X),
        "left.force": _FORCE,
        "left.cop": _COP,
        "right.force": _FORCE,
        "right.cop": _COP,
        "fell": Column(),
        "leds": Column(elements=tuple(map(str, range(N_LEDS)))),
        "game.team": Column(),
        "game.player": Column(),
        "game.state": Column(),
        "game.set_play": Column(),
        "game.colour": Column(),
        "game.kicking": Column(),
        "game.left": Column(),
        "game.score": Column(elements=("own", "other")),
        "game.seconds_remaining": Column("s"),
        "game.penalty": Column(),
        "game.penalty_seconds": Column("s"),
    },
    WorldObject: {
        "name": Column(),
        "shape": Column(),
        "size": Column("m", elements=_XYZ),
        "position": Column("m", "world", _XYZ),
        "orientation": Column("", "world", (*_XYZ, "w")),
        "mass": Column("kg"),
    },
    WalkTelemetry: {
        "seq": Column(),
        "state": Column(),
        "phase": Column(),
        "step": Column(),
        "steps": Column(),
        "place": Column("m, rad", "walk", (*_X, "yaw")),
        "zmp": Column("m", "walk", _X),
        "com": Column("m", "walk", _X),
        "left": _SOLE,
        "right": _SOLE,
        "angle": Column("rad", "world", _X),
        "zmp_measured": Column("m", "walk", _X),
        "contact": Column(elements=_FEET),
        "foot_lift": Column("m", elements=_FEET),
        "ankle_roll": Column("rad", elements=_FEET),
        "ankle_pitch": Column("rad", elements=_FEET),
        "torso_control": Column("rad", elements=_FEET),
        "fall_cause": Column(),
        "failure": Column(),
    },
    Notice: {"seq": Column(), "level": Column(), "code": Column(), "text": Column()},
}
"""Kind of message -> its columns. A run has `time`, s, of every message beside them."""
