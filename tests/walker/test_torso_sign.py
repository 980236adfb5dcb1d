"""The sign between AnklePitch and AngleY, from rotation matrices written out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bridge.body import joint_tree, load_body
from walker.mechanisms.torso_control import ankle_pitch_from_lean


def rotation_y(angle: float) -> np.ndarray:
    """Right-handed rotation about y (pitch of the thesis' (2.4)): turns x towards -z."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def torso_pitch_on_flat_sole(hip: float, knee: float, ankle: float) -> float:
    """AngleY when the sole lies flat: R_torso R_y(hip) R_y(knee) R_y(ankle) = 1."""
    torso = (rotation_y(hip) @ rotation_y(knee) @ rotation_y(ankle)).T
    nose = torso @ np.array([1.0, 0.0, 0.0])
    return math.asin(-nose[2])  # nose down is positive


def test_the_pitch_joints_turn_about_plus_y() -> None:
    tree = joint_tree(load_body("nao-v3"))
    for joint in ("LAnklePitch", "RAnklePitch", "LKneePitch", "LHipPitch"):
        assert tree[joint].axis == (0.0, 1.0, 0.0)


def test_positive_ankle_pitch_is_toe_down_when_the_foot_is_free() -> None:
    toe = rotation_y(0.2) @ np.array([0.1, 0.0, 0.0])
    assert toe[2] < 0.0


@pytest.mark.parametrize(("hip", "knee", "ankle"), [(0.0, 0.0, 0.0), (-0.5, 1.0, -0.5), (-0.4, 0.7, -0.2)])
def test_a_lean_tips_the_torso_forwards_by_as_much(hip: float, knee: float, ankle: float) -> None:
    before = torso_pitch_on_flat_sole(hip, knee, ankle)
    after = torso_pitch_on_flat_sole(hip, knee, ankle + ankle_pitch_from_lean(0.1))
    assert after - before == pytest.approx(0.1, abs=1e-12)
    assert torso_pitch_on_flat_sole(hip, knee, ankle + 0.1) < before
