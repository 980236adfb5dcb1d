"""The pose in which a robot meets the ground: by the kinematics of the legs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX_WITH_MIRROR, LEG_JOINTS
from bridge.body.quantities import limits
from tests.frames import standing_frame
from walker.model.floating_base import SIDES, FloatingBase
from walker.states.fallen import brace


@pytest.mark.parametrize("name", ["nao-v3", "nao-v6"])
@pytest.mark.parametrize("way", range(0, 360, 45))
def test_the_torso_is_turned_against_the_fall_over_the_legs(name, way):
    """By 15 degrees at least about the axis of the fall, within the joints' ranges."""
    body, axis = load_body(name), np.array([math.cos(math.radians(way)), math.sin(math.radians(way))])
    position = brace(standing_frame(gyroscope=(*(2.0 * axis), 0.0), angle=tuple(0.1 * axis)))
    for joint in {*LEG_JOINTS["L"], *LEG_JOINTS["R"]} - {"RHipYawPitch"}:
        low, high = limits(body, joint)
        assert low <= position[INDEX_WITH_MIRROR[joint]] <= high
    base = FloatingBase(body)
    level = np.mean([_tilt_of_sole(base, standing_frame().position, side) for side in SIDES], axis=0)
    held = np.mean([_tilt_of_sole(base, position, side) for side in SIDES], axis=0)
    assert (held - level) @ axis > math.radians(15.0)


def _tilt_of_sole(base, position, side):
    """Roll and pitch in the torso, rad."""
    up = base.place(base.in_torso(position), np.eye(4)).feet[side][:3, 2]
    return np.array([math.atan2(-up[1], up[2]), math.atan2(up[0], up[2])])
