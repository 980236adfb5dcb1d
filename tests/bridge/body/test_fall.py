"""The definition of a fallen robot against the rotation matrix of its torso."""

from __future__ import annotations

import math

import pytest
from scipy.spatial.transform import Rotation

from bridge.body.fall import has_fallen, tilt


@pytest.mark.parametrize(
    ("roll", "pitch"), [(0.0, 0.0), (40.0, 40.0), (-20.0, 40.0), (0.0, -46.0), (100.0, 0.0)]
)
def test_a_torso_that_is_more_than_45_degrees_off_the_vertical_has_fallen(roll: float, pitch: float) -> None:
    """Roll and pitch add up: 40 and 40 degrees are 54 degrees off."""
    up = Rotation.from_euler("xyz", (roll, pitch, 30.0), degrees=True).as_matrix()[2, 2]
    angle = tilt((math.radians(roll), math.radians(pitch)))
    assert angle == pytest.approx(math.acos(up), abs=1e-9)
    assert has_fallen(angle) == (math.degrees(math.acos(up)) > 45.0)
