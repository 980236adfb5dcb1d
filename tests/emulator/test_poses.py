"""Poses against scipy's rotations in double precision, and against PyBullet's own functions bit for bit."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from emulator.engine.pybullet.client import bullet
from emulator.poses import ORIGIN, Pose, compose, inverse, matrix, point_of, quaternion, yaw_of


def random_pose(rng: np.random.Generator, size: float) -> Pose:
    """With a rotation of about this size, so that every branch of the quaternion is met."""
    q = np.append(size * rng.normal(size=3), 1.0)
    return Pose(tuple(rng.normal(size=3).tolist()), tuple((q / np.linalg.norm(q)).tolist()))


@pytest.mark.parametrize("size", [0.0, 0.01, 1.0, 100.0])
def test_composition_and_inverse(size: float) -> None:
    rng = np.random.default_rng(3)
    for _ in range(200):
        a, b = random_pose(rng, size), random_pose(rng, size)
        turn, found = Rotation.from_quat(a.orientation), compose(a, b)
        np.testing.assert_allclose(found.position, turn.apply(b.position) + a.position, atol=2e-6)
        turned = turn * Rotation.from_quat(b.orientation)
        np.testing.assert_allclose(np.reshape(matrix(found.orientation), (3, 3)), turned.as_matrix(), atol=2e-6)
        assert point_of(a, b.position) == found.position
        assert found == bullet.multiplyTransforms(*a, *b)
        assert inverse(a) == bullet.invertTransform(*a)
        assert matrix(a.orientation) == bullet.getMatrixFromQuaternion(a.orientation)
    assert inverse(ORIGIN) == ORIGIN


def test_roll_pitch_yaw() -> None:
    rng = np.random.default_rng(4)
    for roll, pitch, yaw in rng.uniform(-1.5, 1.5, (200, 3)).tolist():
        q = quaternion(roll, pitch, yaw)
        np.testing.assert_allclose(
            q, Rotation.from_euler("ZYX", (yaw, pitch, roll)).as_quat(canonical=True), atol=1e-12
        )
        assert yaw_of(q) == pytest.approx(yaw, abs=1e-12)
        assert q == bullet.getQuaternionFromEuler((roll, pitch, yaw))
