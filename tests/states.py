"""Measured states of made robots."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bridge.body import Body
from bridge.body.kinematics import FloatingBase
from bridge.types import Vec2, Vec3
from walker.estimation.com import ComEstimator
from walker.estimation.state import BaseState

ZERO: Vec3 = (0.0, 0.0, 0.0)


def rigid_state(body: Body, angles: Sequence[float], lean: Vec2 = (0.0, 0.0), rate: Vec3 = ZERO) -> BaseState:
    """A robot whose joints do not move, leaning and turning as a whole; its torso at the odometry's origin."""
    base = FloatingBase(body)
    com = ComEstimator(base, 0.03).update(angles, lean, rate, 0.01)
    pose = base.place(base.in_torso(angles), np.eye(4))
    return BaseState(pose, com, angle=lean, lean=lean, angular_velocity=rate)
