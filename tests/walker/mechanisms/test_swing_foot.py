"""Orientation of the swing foot."""

from __future__ import annotations

import math

import pytest

from tests.plans import supported_plan
from walker.estimation.contact import Contacts, SupportState
from walker.mechanisms.capture_step import LandedFootParameters
from walker.mechanisms.swing_foot import SwingFootOrientation, SwingFootOrientationParameters

DT = 0.01


BOTH, LEFT, NEITHER = Contacts(True, True), Contacts(True, False), Contacts(False, False)


def test_orientation_control_puts_the_swing_sole_level_at_its_planned_height() -> None:
    """Rotate the swing foot about the stance foot by the torso's tilt: level and at height, to first order."""
    p = SwingFootOrientationParameters()
    control = SwingFootOrientation(p, LandedFootParameters())
    roll, pitch = math.radians(5.0), math.radians(-3.0)
    for k in range(200):
        corrections = control.update(
            (roll, pitch), supported_plan("L"), SupportState("L", progress=min(k / 100, 0.9)), LEFT, DT
        )
    right = corrections["R"]
    assert (right.roll, right.pitch) == pytest.approx((-roll, -pitch))
    # 0.1 m to the right a foot goes down with a roll about +x, 0.06 m ahead with a nose-down pitch.
    sunk = -math.sin(roll) * 0.1 - math.sin(pitch) * 0.06
    assert right.lift == pytest.approx(-sunk, rel=0.01)
    assert corrections["L"] == (0.0, 0.0, 0.0)


def test_orientation_control_holds_at_contact_and_returns_in_stance() -> None:
    control = SwingFootOrientation(SwingFootOrientationParameters(return_rate=0.2), LandedFootParameters())
    for _ in range(200):
        control.update((0.1, 0.0), supported_plan("L"), SupportState("L", progress=0.9), LEFT, DT)
    held = control.update((0.2, 0.0), supported_plan("L"), SupportState("L", progress=0.95), BOTH, DT)["R"]
    assert held.roll == pytest.approx(-0.1)
    after = control.update((0.2, 0.0), supported_plan("both"), SupportState("both"), BOTH, DT)["R"]
    assert after.roll == pytest.approx(-0.1 + 0.2 * DT)
    for _ in range(100):
        after = control.update((0.2, 0.0), supported_plan("both"), SupportState("both"), BOTH, DT)["R"]
    assert after.roll == 0.0
