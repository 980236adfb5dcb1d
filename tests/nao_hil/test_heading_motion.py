"""Velocity in the robot's own heading, against motions with a closed form."""

from __future__ import annotations

import math

import msgspec
import pytest
from scipy.spatial.transform import Rotation

from bridge.rotations import R_yaw
from nao_hil.runs.heading_motion import SETTLING, HeadingMotion


class Truth(msgspec.Struct):
    time: float
    torso_position: tuple[float, float, float]
    torso_orientation: tuple[float, float, float, float]


def truth(time, x, y, yaw):
    quaternion = tuple(Rotation.from_matrix(R_yaw(yaw)).as_quat())
    return Truth(time, (x, y, 0.3), quaternion)


@pytest.mark.parametrize("turn", [0.0, 0.7, -1.5])
def test_motion_on_a_circle_has_a_constant_velocity(turn):
    """A body that goes at (u, v) in its own axes and turns at w: its place is the integral in closed form."""
    u, v, motion = 0.2, -0.05, HeadingMotion()
    motion.begin(0.0)
    for k in range(1001):
        t = 0.01 * k
        s, c = (math.sin(turn * t) / turn, (1.0 - math.cos(turn * t)) / turn) if turn else (t, 0.0)
        motion.add(truth(t, u * s - v * c, u * c + v * s, turn * t))
    assert motion.velocity == pytest.approx((u, v, turn), abs=1e-5)
    assert motion.turned == pytest.approx(10.0 * turn, abs=1e-9)


def test_the_beginning_and_what_follows_the_end_do_not_count():
    motion = HeadingMotion()
    motion.begin(1.0)
    x = 0.0
    for k in range(800):
        t = 0.01 * k
        motion.add(truth(t, x, 0.0, 0.0))
        x += 0.01 * (0.3 if 1.0 + SETTLING <= t < 5.0 else 9.0)
        if k == 499:
            motion.end()
    assert motion.velocity[0] == pytest.approx(0.3, abs=1e-6)
