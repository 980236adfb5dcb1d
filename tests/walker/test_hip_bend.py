"""The bend of the hips in a capture step back: what it leaves alone, and for which pushes it is made."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.kinematics import FloatingBase
from walker.gaits import gait_parameters, make_gait, standing_plan
from walker.gaits.plan import CaptureStep, SolePose
from walker.gaits.pose import PoseMaker
from walker.mechanisms.capture_step import HipBend, HipBendParameters

DT = 0.01
DURATION = 0.2
BODY = load_body("nao-v6")
P = HipBendParameters()
STAND = standing_plan(make_gait("omni", gait_parameters("omni"), BODY))
BEHIND, NEARER = -P.min_behind - 0.02, -P.min_behind + 0.01


def step(x, progress):
    """Plan of a capture step of the right foot to x, m."""
    return replace(STAND, phase="SSL", support="L", capture="R", progress=progress, right=SolePose(x, -0.05))


def bends(xi, x=-0.1, cycles=60):
    """Angles by cycle of a step of 0.2 s and what follows; the stance foot stands at (0, 0.05)."""
    hips, found = HipBend(P, BODY), []
    for k in range(cycles):
        time = k * DT
        plan = step(x, time / DURATION)
        if time >= DURATION:
            plan = replace(plan, phase="stop", support="both")
        measured = CaptureStep((0.0, 0.0), xi) if time < DURATION else None
        found.append(hips.update(plan, measured, DT))
    return found


def test_both_hips_that_bend_by_one_angle_leave_the_feet_as_they_are_to_each_other():
    """The axes of both HipPitches are in line where HipRoll and HipYawPitch are 0 (data sheet)."""
    base = FloatingBase(BODY)
    angles = list(PoseMaker(BODY, STAND).unlimited_angles(replace(STAND, right=SolePose(-0.08, -0.05, 0.02))))
    for name in ("LHipRoll", "RHipRoll", "LHipYawPitch"):
        angles[INDEX[name]] = 0.0

    def feet(position):
        pose = base.place(base.in_torso(position), np.eye(4))
        return pose.feet["L"], pose.feet["R"]

    left, right = feet(angles)
    for name in ("LHipPitch", "RHipPitch"):
        angles[INDEX[name]] -= P.angle
    bent_left, bent_right = feet(angles)
    assert np.linalg.solve(bent_left, bent_right) == pytest.approx(np.linalg.solve(left, right), abs=1e-9)
    # The torso has turned ahead by it, seen from a foot: nose down is positive about y.
    turn = np.linalg.solve(left.T, bent_left.T).T[:3, :3]
    assert math.atan2(-turn[0, 2], turn[0, 0]) == pytest.approx(P.angle)


def test_a_strong_push_straight_back_bends_the_hips_until_the_foot_lands():
    found = bends((BEHIND, 0.0))
    at = round(DURATION / DT)
    changes = [b - a for a, b in itertools.pairwise([0.0, *found])]
    assert max(found[:at]) == found[at - 1] == P.angle
    assert found.index(P.angle) == pytest.approx(P.angle / P.rate / DT, abs=1.0)
    assert max(changes) <= P.rate * DT + 1e-12 and min(changes) >= -P.return_rate * DT - 1e-12
    assert found[-1] == 0.0


def test_a_weaker_push_ends_the_bend_when_it_is_known():
    found = bends((NEARER, 0.0))
    decided = math.floor(P.decision * DURATION / DT)
    assert found[decided] == pytest.approx(P.rate * DT * (decided + 1)) == max(found)
    assert found[decided + 10] == 0.0


@pytest.mark.parametrize("side", [-0.05, 0.05])
def test_a_push_to_a_side_leaves_the_hips(side):
    assert not any(bends((BEHIND, side)))


def test_a_step_ahead_leaves_the_hips():
    assert not any(bends((0.2, 0.0), x=0.1))


def test_what_the_capture_point_does_late_in_the_step_changes_nothing():
    hips = HipBend(P, BODY)
    for k in range(20):
        xi = (BEHIND, 0.0) if k < 5 else (NEARER, 0.05)
        found = hips.update(step(-0.1, k * DT / DURATION), CaptureStep((0.0, 0.0), xi), DT)
    assert found == P.angle
