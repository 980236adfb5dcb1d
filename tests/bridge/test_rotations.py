"""Rotations against scipy's."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bridge import rotations

TURNS = Rotation.random(200, random_state=1)


def test_matrices_and_angles_of_quaternions() -> None:
    q = TURNS.as_quat()
    np.testing.assert_allclose(rotations.matrix(q), TURNS.as_matrix(), atol=1e-12)
    angles = np.column_stack([rotations.yaw(q), rotations.pitch(q), rotations.roll(q)])
    np.testing.assert_allclose(angles, TURNS.as_euler("ZYX"), atol=1e-9)
    np.testing.assert_allclose(np.cos(rotations.tilt(q)), TURNS.as_matrix()[:, 2, 2], atol=1e-12)


def test_one_quaternion_gives_one_matrix_and_one_angle() -> None:
    turn = Rotation.from_euler("ZYX", [0.7, -0.2, 0.3])
    q = tuple(turn.as_quat().tolist())
    np.testing.assert_allclose(rotations.matrix(q), turn.as_matrix(), atol=1e-12)
    assert (float(rotations.roll(q)), float(rotations.pitch(q))) == pytest.approx((0.3, -0.2))
    assert rotations.heading(turn.as_matrix()) == pytest.approx(0.7)
    np.testing.assert_allclose(rotations.rotation(0.3, -0.2, 0.7), turn.as_matrix(), atol=1e-12)
    assert rotations.angles(turn.as_matrix()) == pytest.approx((0.3, -0.2, 0.7))


def test_a_point_in_the_plane() -> None:
    turned = Rotation.from_euler("z", 0.7).apply((0.3, -0.4, 0.0))
    assert rotations.planar_point((1.0, 2.0, 0.7), (0.3, -0.4)) == pytest.approx(
        (1.0 + turned[0], 2.0 + turned[1])
    )


def test_about_an_axis() -> None:
    axis = (0.0, 0.6, -0.8)
    wanted = Rotation.from_rotvec(0.9 * np.array(axis)).as_matrix()
    np.testing.assert_allclose(rotations.about_axis(axis, 0.9), wanted, atol=1e-12)
