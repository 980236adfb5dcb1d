"""Names of the sensor frame's elements, for faults and buttons: `gyroscope.x`, `fsr.LFL`, `touch.chest`."""

from __future__ import annotations

from typing import Final

from bridge.body.joints import JOINTS
from bridge.validation import unknown_name

_CELLS: Final = ("LFL", "LFR", "LRL", "LRR", "RFL", "RFR", "RRL", "RRR")
_BUTTONS: Final = (
    *("chest", "head_front", "head_middle", "head_rear", "left_bumper_left", "left_bumper_right"),
    *("left_hand_back", "left_hand_left", "left_hand_right", "right_bumper_left", "right_bumper_right"),
    *("right_hand_back", "right_hand_left", "right_hand_right"),
)
ELEMENTS: Final[dict[str, tuple[str, ...]]] = {
    "position": JOINTS,
    "stiffness": JOINTS,
    "current": JOINTS,
    "temperature": JOINTS,
    "fsr": _CELLS,
    "accelerometer": ("x", "y", "z"),
    "gyroscope": ("x", "y", "z"),
    "angle": ("x", "y"),
    "touch": _BUTTONS,
    "battery": ("charge", "current", "status", "temperature"),
    "sonar": ("left", "right"),
}
"""Fields of `SensorFrame` that can fail, and the names of their elements in order."""


def sensor_slots(sensor: str) -> tuple[str, tuple[int, ...]]:
    """Field of the sensor frame and the indices in it that a selector means.

    Raises:
        ValueError: no such field or element; names the nearest one there is.
    """
    field, _, element = sensor.partition(".")
    if field not in ELEMENTS:
        raise ValueError(unknown_name("sensor", field, ELEMENTS))
    names = ELEMENTS[field]
    if not element:
        return field, tuple(range(len(names)))
    if element not in names:
        raise ValueError(unknown_name(f"element of `{field}`", element, names))
    return field, (names.index(element),)
