"""The actuators of a body: their names, ranges, and the integers that their boards take.

Names: vendor's actuator list (NAOqi 2.8; the same on V4 and V5). A float becomes the board's integer by
`(value - offset) / gain`. No gains are published; these are assumed: 16 bits for the inputs of motor boards,
and 1/256 for LEDs, the grid on which the vendor's example (0.4 reads back 0.398) lies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from bridge.body import Body
from bridge.body.joints import JOINTS
from bridge.body.quantities import HANDS, absent_joints, limits
from bridge.messages.dcm import PREFIX

ANGLE_GAIN: Final = 2.0 * math.pi / 65536.0
"""rad per count"""
FRACTION_GAIN: Final = 1.0 / 32768.0
"""Stiffness, and opening of a hand, per count."""
LED_GAIN: Final = 1.0 / 256.0
"""Brightness per count."""
MAX_MODE: Final = 127.0
"""Largest integer that the discrete actuators take (sonar: bits 1, 2, 4, 8 and 64 are known)."""

IGNORED_NAMES: Final = frozenset({"RHipYawPitch/Position/Actuator/Value"})
"""Names that are accepted without an actuator behind them: one motor drives both hips."""

_SUFFIX: Final = "/Actuator/Value"


@dataclass(frozen=True)
class Actuator:
    """One actuator of the DCM."""

    name: str
    """Without the prefix."""
    lower: float
    upper: float
    gain: float
    offset: float = 0.0
    interpolates: bool = True
    """Otherwise a value is sent once, at its time."""


def short(name: str) -> str:
    """A name without the prefix."""
    return name.removeprefix(PREFIX)


def driven_joints(body: Body) -> tuple[str, ...]:
    """Joints and hands of a body in frame order."""
    absent = absent_joints(body)
    return tuple(joint for joint in JOINTS if joint not in absent)


def actuators(body: Body) -> tuple[Actuator, ...]:
    """All actuators: positions of `driven_joints`, their stiffnesses in the same order, LEDs, discrete ones."""
    joints = driven_joints(body)
    positions = [
        Actuator(
            f"{joint}/Position{_SUFFIX}", *limits(body, joint), FRACTION_GAIN if joint in HANDS else ANGLE_GAIN
        )
        for joint in joints
    ]
    hardness = [Actuator(f"{joint}/Hardness{_SUFFIX}", -1.0, 1.0, FRACTION_GAIN) for joint in joints]
    leds = [Actuator(f"{led}{_SUFFIX}", 0.0, 1.0, LED_GAIN) for led in led_names()]
    modes = [
        Actuator(f"{name}{_SUFFIX}", 0.0, MAX_MODE, 1.0, interpolates=False)
        for name in ("ChestBoard/Led/State", "US")
    ]
    return (*positions, *hardness, *leds, *modes)


def led_names() -> tuple[str, ...]:
    """All LEDs, without `/Actuator/Value`."""
    colours, sides = ("Red", "Green", "Blue"), ("Left", "Right")
    face = [f"Face/Led/{c}/{s}/{a}Deg" for c in colours for s in sides for a in range(0, 360, 45)]
    ears = [f"Ears/Led/{s}/{a}Deg" for s in sides for a in range(0, 360, 36)]
    boards = [f"{board}/Led/{c}" for board in ("ChestBoard", "LFoot", "RFoot") for c in colours]
    rows = (("Front", 2), ("Middle", 1), ("Rear", 3))
    head = [f"Head/Led/{row}/{s}/{i}" for row, count in rows for s in sides for i in range(count)]
    return (*face, *ears, *boards, *head)
