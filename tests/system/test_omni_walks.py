"""The omnidirectional gait on emulated robots, each axis, in process: it stays up and goes where it is told."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bridge import rotations
from nao_hil.runs.config import RunConfig
from nao_hil.runs.walk import Walk, walk

WALKED = 4.0
"""s"""


@pytest.mark.parametrize("robot", ["nao-v3", "nao-v6"])
@pytest.mark.parametrize(
    ("velocity", "axis"),
    [((0.2, 0.0, 0.0), 0), ((-0.1, 0.0, 0.0), 0), ((0.0, 0.08, 0.0), 1), ((0.0, 0.0, 0.8), 2)],
)
def test_walks_along_each_axis(robot, velocity, axis):
    parameters = dict(zip(("v_x", "v_y", "v_yaw"), velocity, strict=True))
    config = RunConfig(robot=robot, gait="omni", seed=2001, parameters=parameters)
    outcome = walk(Walk(name="axis", config=config, duration=WALKED))
    assert outcome.end.survived
    assert outcome.end.tilt_max < math.radians(20.0)
    track = outcome.track
    late = track["time"] > 2.0
    place, time = track["torso"][late, :2], track["time"][late]
    yaw = np.unwrap(rotations.yaw(track["orientation"][late]))
    turned = (yaw[-1] - yaw[0]) / (time[-1] - time[0])
    way = (place[-1] - place[0]) / (time[-1] - time[0])
    c, s = math.cos(yaw[0]), math.sin(yaw[0])
    measured = (c * way[0] + s * way[1], c * way[1] - s * way[0], turned)[axis]
    assert 0.5 * abs(velocity[axis]) < math.copysign(1.0, velocity[axis]) * measured < 1.5 * abs(velocity[axis])
