"""Sensor frames for tests."""

from __future__ import annotations

from typing import Any, Final

import msgspec

from bridge.body.joints import N_JOINTS
from bridge.body.postures import POSTURES
from bridge.messages import SensorFrame

STANDING: Final = SensorFrame(
    seq=0,
    time=0.0,
    position=POSTURES["StandInit"],
    stiffness=(1.0,) * N_JOINTS,
    current=(0.1,) * N_JOINTS,
    temperature=(38.0,) * N_JOINTS,
    fsr=(4.905,) * 8,
    accelerometer=(0.0, 0.0, 9.81),
    gyroscope=(0.0, 0.0, 0.0),
    angle=(0.0, 0.0),
    touch=(0.0,) * 14,
    battery=(0.9, -1.5, 0.0, 30.0),
    sonar=(0.5, 0.6),
)
"""A robot that stands upright in StandInit, stiff, 2 kg on each foot."""


def standing_frame(seq: int = 0, **changes: Any) -> SensorFrame:
    """The robot of `STANDING` in another cycle of 10 ms, with some fields changed."""
    return msgspec.structs.replace(STANDING, **({"seq": seq, "time": 0.01 * seq} | changes))
