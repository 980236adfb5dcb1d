"""Sensor frames for the tests of NAOqi."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from bridge.messages import SensorFrame
from tests.frames import standing_frame


@pytest.fixture
def standing() -> Callable[..., SensorFrame]:
    return standing_frame
