"""Sensor frames for the tests of NAOqi."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import pytest

from bridge.datasheet.postures import POSTURES
from bridge.messages import SensorFrame


def _standing(seq: int = 0, **changes: Any) -> SensorFrame:
    """A robot that stands upright in StandInit, stiff, 2 kg on each foot."""
    frame = SensorFrame(
        seq=seq,
        time=0.01 * seq,
        position=POSTURES["StandInit"],
        stiffness=(1.0,) * 25,
        current=(0.1,) * 25,
        temperature=(38.0,) * 25,
        fsr=(4.905,) * 8,
        accelerometer=(0.0, 0.0, 9.81),
        gyroscope=(0.0, 0.0, 0.0),
        angle=(0.0, 0.0),
        touch=(0.0,) * 14,
        battery=(0.9, -1.5, 0.0, 30.0),
        sonar=(0.5, 0.6),
    )
    return msgspec.structs.replace(frame, **changes)


@pytest.fixture
def standing() -> Callable[..., SensorFrame]:
    return _standing
