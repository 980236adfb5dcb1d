"""A served robot for the tests of NAOqi."""

from __future__ import annotations

import pytest

from tests.bridge.adapters.naoqi.served import Robot


@pytest.fixture
def robot() -> Robot:
    return Robot()
