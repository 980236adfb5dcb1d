"""Poses in the plane against products of homogeneous matrices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridge.planar import Pose2D
from bridge.rotations import R_yaw

POSES = st.builds(Pose2D, *(st.floats(-limit, limit) for limit in (5.0, 5.0, 3.0)))


def matrix(pose: Pose2D) -> np.ndarray:
    H = R_yaw(pose.yaw)
    H[:2, 2] = pose[:2]
    return H


@given(POSES, POSES)
def test_poses_compose_as_matrices(outer: Pose2D, inner: Pose2D) -> None:
    np.testing.assert_allclose(matrix(outer.pose(inner)), matrix(outer) @ matrix(inner), atol=1e-12)
    np.testing.assert_allclose(
        matrix(outer.local_pose(inner)), np.linalg.inv(matrix(outer)) @ matrix(inner), atol=1e-12
    )
    assert outer.point(*inner[:2]) == pytest.approx(outer.pose(inner)[:2])
    assert outer.local(*outer.point(*inner[:2])) == pytest.approx(inner[:2], abs=1e-12)
