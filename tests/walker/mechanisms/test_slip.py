"""Slip of the stance foot: soles that hold their place, and soles that move, by rigid kinematics."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.kinematics import FloatingBase
from bridge.body.postures import POSTURES
from bridge.body.quantities import GRAVITY
from bridge.types import Array
from tests.frames import standing_frame
from tests.loops import repeat_while
from walker.gaits import GaitCommand, gait_parameters, make_gait
from walker.gaits.plan import Feedback
from walker.mechanisms.slip import SlipDetector, SlipParameters

BODY = load_body("nao-v6")
BASE = FloatingBase(BODY)
P = SlipParameters()
GAIT = make_gait("omni", gait_parameters("omni"), BODY)
PLAN = replace(GAIT.step(GAIT.initial(), 0.01, GaitCommand(walk=False))[0], support="L")
DT = 0.01
LEFT, RIGHT = (6.0,) * 4 + (0.5,) * 4, (0.5,) * 4 + (6.0,) * 4


def cycle(
    detector: SlipDetector,
    position: Sequence[float] = POSTURES["StandInit"],
    acceleration: Sequence[float] | Array = (0.0, 0.0),
    turn: float = 0.0,
    fsr: tuple[float, ...] = LEFT,
) -> bool:
    """Whether the left foot slips in a cycle of a level torso that accelerates and turns."""
    x, y = acceleration
    frame = standing_frame(
        position=tuple(position), accelerometer=(x, y, GRAVITY), gyroscope=(0.0, 0.0, turn), fsr=fsr
    )
    return detector.update(frame, (0.0, 0.0), PLAN, DT)


def test_a_sole_that_is_carried_along_slides_as_fast_as_the_torso() -> None:
    """Stiff joints: s' = a - s / leak, so s = a leak (1 - exp(-t / leak)), until it is a slip."""
    detector, acceleration, slips = SlipDetector(P, BASE), (1.6, -1.2), []
    for _ in range(22):
        slips.append(cycle(detector, acceleration=acceleration))
    speed = 2.0 * P.leak * (1.0 - math.exp(-0.2 / P.leak))
    assert detector.slide == pytest.approx((0.8 * speed, -0.6 * speed), rel=0.06)
    begins = -P.leak * math.log(1.0 - P.slide / (2.0 * P.leak)) + P.hold
    assert slips.index(True) * DT == pytest.approx(begins, abs=3 * DT)


def swung(time: float) -> list[float]:
    """Joint angles of a left leg that moves the torso over its sole by some centimetres."""
    angles, s = list(POSTURES["StandInit"]), math.sin(8.0 * time)
    for joint, amplitude in (
        ("LAnklePitch", 0.1),
        ("LKneePitch", 0.1),
        ("LAnkleRoll", 0.08),
        ("LHipYawPitch", 0.05),
    ):
        angles[INDEX[joint]] += amplitude * s
    return angles


def place(time: float) -> tuple[Array, float]:
    """Of the accelerometer over the left sole in the heading of the torso, m, and that heading, rad."""
    foot = BASE.foot(BASE.in_torso(swung(time)), "L")
    yaw = math.atan2(foot[1, 0], foot[0, 0])
    return np.array(BODY.inertial_unit.accelerometer)[:2] - (foot @ BASE.centres["L"])[:2], -yaw


def test_a_leg_that_moves_the_torso_over_its_sole_does_not_slip() -> None:
    detector, h = SlipDetector(P, BASE), 1e-4
    for k in range(80):
        time = k * DT
        (before, yaw_0), (now, yaw_1), (after, yaw_2) = (place(time + d) for d in (-h, 0.0, h))
        # in the axes of now: the torso's heading turns
        before, after = (
            np.array([math.cos(y) * v[0] - math.sin(y) * v[1], math.sin(y) * v[0] + math.cos(y) * v[1]])
            for v, y in ((before, yaw_0 - yaw_1), (after, yaw_2 - yaw_1))
        )
        slips = cycle(detector, swung(time), (after - 2.0 * now + before) / h**2, (yaw_2 - yaw_0) / (2.0 * h))
        assert not slips
        assert math.hypot(*detector.slide) < 0.2 * P.slide
    for k in range(80):  # the same leg on a torso that does not move: the sole does
        cycle(detector, swung(k * DT))
        if k == 40:
            assert math.hypot(*detector.slide) > 0.5 * P.slide


def test_only_the_foot_that_bears_the_weight_can_slip() -> None:
    detector = SlipDetector(P, BASE)
    for _ in range(30):
        assert not cycle(detector, acceleration=(5.0, 0.0), fsr=RIGHT)
    assert detector.pace == 1.0


def test_the_pace_drops_at_a_slip_and_returns() -> None:
    detector = SlipDetector(P, BASE)
    for _ in repeat_while(lambda: not cycle(detector, acceleration=(5.0, 0.0))):
        assert detector.pace == 1.0
    assert detector.pace == P.pace
    for _ in range(round(0.5 * P.recovery / DT)):
        cycle(detector, fsr=RIGHT)
    assert detector.pace == pytest.approx(0.5 * (1.0 + P.pace), abs=0.02)


def test_the_gait_walks_at_the_share_of_the_command_that_the_floor_is_trusted_with() -> None:
    state, velocity = GAIT.initial(), (0.2, 0.1, 0.4)
    for _ in range(500):
        plan, state = GAIT.step(
            state, DT, GaitCommand(walk=True, velocity=velocity, feedback=Feedback(pace=0.5))
        )
    assert plan.pendulum is not None
    assert plan.pendulum.velocity == pytest.approx((0.1, 0.05, 0.2))
