"""The pose in which a robot meets the ground: by the kinematics of the legs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from bridge.body import load_body
from bridge.body.joints import INDEX_WITH_MIRROR, LEG_JOINTS
from bridge.body.kinematics import BodyTree, CentreOfMass, FloatingBase
from bridge.body.quantities import limits
from bridge.types import SIDES
from emulator.engine.shapes import link_shapes, lowest_point
from emulator.poses import Pose
from tests.frames import standing_frame
from walker.states.down import brace


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


@pytest.mark.parametrize("name", ["nao-v3", "nao-v6"])
@pytest.mark.parametrize("way", [-60, -30, 0, 30, 60])
def test_an_arm_bears_the_fall_far_ahead_of_the_mass(name, way):
    """0.12 m, once an arm and a leg lie on the ground, in a fall ahead or half to the side.

    With 0.07 to 0.12 m robots went over the arm, and the head came down at up to 2.3 m/s.
    """
    body, angle = load_body(name), math.radians(way)
    axis = np.array([-math.sin(angle), math.cos(angle)])
    position = brace(standing_frame(gyroscope=(*(2.0 * axis), 0.0), angle=tuple(0.1 * axis)))
    shapes, tree = link_shapes(body), BodyTree(body)
    frames = dict(zip(tree.links, tree.frames(position), strict=True))

    def lowest(lean, joints):
        """Height of the lowest point of these links' shapes, and the link."""
        links = [link for link in shapes if link[1:] in joints]
        return min((_height(frames[link], shapes[link], lean * axis), link) for link in links)

    arm, leg = ("ElbowRoll", "WristYaw"), ("KneePitch", "HipPitch", "AnklePitch", "AnkleRoll")
    lean = brentq(lambda lean: lowest(lean, arm)[0] - lowest(lean, leg)[0], math.radians(30), math.radians(120))
    level = Rotation.from_rotvec([*(lean * axis), 0.0])
    ahead = np.array([math.cos(angle), math.sin(angle), 0.0])
    bears = frames[lowest(lean, arm)[1]][:3, 3]
    assert ahead @ level.apply(bears - CentreOfMass(body)(position)[:3]) > 0.12


def _height(frame, shape, lean):
    """Of the lowest point of a shape, with the torso turned by a rotation vector, m."""
    turn = Rotation.from_rotvec([*lean, 0.0])
    orientation = turn * Rotation.from_matrix(frame[:3, :3])
    return lowest_point(shape, Pose(tuple(turn.apply(frame[:3, 3])), tuple(orientation.as_quat())))


def _tilt_of_sole(base, position, side):
    """Roll and pitch in the torso, rad."""
    up = base.place(base.in_torso(position), np.eye(4)).feet[side][:3, 2]
    return np.array([math.atan2(-up[1], up[2]), math.atan2(up[0], up[2])])
