"""Tilted ground, found from the soles that stand and walked on with the torso upright: closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bridge.body import Body, load_body
from bridge.body.joints import LEG_SLOTS, N_JOINTS
from bridge.body.kinematics import CentreOfMass, foot_in_torso
from bridge.messages import SensorFrame
from bridge.rotations import rotation
from tests.frames import standing_frame
from walker.estimation.ground import Corrections, GroundParameters, GroundTilt
from walker.gaits import dry_walk, gait_parameters, make_gait, standing_plan
from walker.gaits.pose import PoseMaker

CYCLE = 0.01
LEVEL = Corrections()
TILTS = [(0.0, 0.0), (0.08, 0.0), (-0.08, 0.0), (0.0, 0.08), (0.0, -0.08), (0.05, -0.06)]


@pytest.fixture(scope="module")
def body() -> Body:
    return load_body("nao-v3")


def standing(body: Body, ground: tuple[float, float] | None) -> tuple[float, ...]:
    reference = standing_plan(make_gait("static", gait_parameters("static"), body))
    return PoseMaker(body, reference, by_pose=True).unlimited_angles(reference, ground)


def soles(body: Body, angles: tuple[float, ...]) -> list[np.ndarray]:
    return [foot_in_torso(body, side, [angles[i] for i in LEG_SLOTS[side]]) for side in ("L", "R")]  # type: ignore[arg-type,index]


@pytest.mark.parametrize("tilt", TILTS)
def test_the_plan_is_laid_onto_the_ground_with_the_torso_upright(body: Body, tilt: tuple[float, float]) -> None:
    angles = standing(body, tilt)
    left, right = soles(body, angles)
    axes = rotation(tilt[0], tilt[1], 0.0)
    for sole in (left, right):
        # The torso is upright, so its axes are those of the world. The one motor of both hips cannot take out
        # the last of the soles' yaw.
        assert sole[:3, 2] == pytest.approx(axes[:, 2], abs=1e-9)
        assert sole[:3, :3] == pytest.approx(axes, abs=2e-3)
    apart = axes.T @ (left[:3, 3] - right[:3, 3])
    assert apart == pytest.approx([0.0, gait_parameters("static").l_FA, 0.0], abs=1e-9)  # type: ignore[attr-defined]
    # The centre of mass is over the middle between the soles' middles, straight up.
    middle = 0.5 * (left[:3, 3] + right[:3, 3]) + axes @ [body.foot.centre[0], 0.0, -body.lengths.FootHeight]
    assert CentreOfMass(body)(angles)[:2] == pytest.approx(middle[:2], abs=1.5e-3)  # two rounds of refinement


def pushed(angles: tuple[float, ...], fsr: tuple[float, ...]) -> SensorFrame:
    return standing_frame(position=angles, fsr=fsr)


def found(
    body: Body, angles: tuple[float, ...], torso: tuple[float, float], fsr: tuple[float, ...]
) -> tuple[float, float]:
    ground = GroundTilt(GroundParameters(), body, CYCLE)
    tilt = (0.0, 0.0)
    for _ in range(1000):
        tilt = ground.update(pushed(angles, fsr), torso, LEVEL, CYCLE, walking=False)
    return tilt


@pytest.mark.parametrize("tilt", TILTS)
def test_a_tilted_torso_on_legs_made_for_level_ground_tells_the_ground(
    body: Body, tilt: tuple[float, float]
) -> None:
    """Legs as planned, torso tilted with the ground: all of the tilt is the ground's."""
    assert found(body, standing(body, None), tilt, (6.0,) * 8) == pytest.approx(tilt, abs=1e-6)


@pytest.mark.parametrize("tilt", TILTS)
def test_an_upright_torso_on_yielded_legs_tells_the_same(body: Body, tilt: tuple[float, float]) -> None:
    assert found(body, standing(body, tilt), (0.0, 0.0), (6.0,) * 8) == pytest.approx(tilt, abs=1e-6)


def test_what_an_ankle_yielded_to_is_not_the_grounds(body: Body) -> None:
    ground = GroundTilt(GroundParameters(), body, CYCLE)
    angles = standing(body, (0.0, -0.1))
    tilt = (1.0, 1.0)
    for _ in range(1000):
        tilt = ground.update(
            pushed(angles, (6.0,) * 8), (0.0, 0.0), Corrections(ankle_pitch=(-0.1, -0.1)), CYCLE, walking=False
        )
    assert tilt == pytest.approx((0.0, 0.0), abs=1e-6)


def test_nobody_believes_a_wall(body: Body) -> None:
    tilt = found(body, standing(body, None), (0.0, 1.2), (6.0,) * 8)
    assert tilt[1] == pytest.approx(GroundParameters().max_tilt, abs=1e-6)
    assert math.isfinite(tilt[0])


def test_the_mean_is_of_first_order(body: Body) -> None:
    """63 % after a time constant."""
    ground = GroundTilt(GroundParameters(time_constant=0.5), body, CYCLE)
    angles = standing(body, None)
    for _ in range(50):
        tilt = ground.update(pushed(angles, (6.0,) * 8), (0.0, 0.1), LEVEL, CYCLE, walking=False)
    assert tilt[1] == pytest.approx(0.1 * (1.0 - math.exp(-1.0)), rel=1e-6)


def test_a_robot_that_tips_over_its_toes_and_steps_stands_on_the_ground_of_before(body: Body) -> None:
    ground, angles = GroundTilt(GroundParameters(), body, CYCLE), standing(body, None)

    def lean(pitch: float, seconds: float, *, capturing: bool = False) -> float:
        for _ in range(round(seconds / CYCLE)):
            tilt = ground.update(
                pushed(angles, (6.0,) * 8), (0.0, pitch), LEVEL, CYCLE, walking=capturing, capturing=capturing
            )
        return tilt[1]

    before = lean(0.02, 5.0)
    assert before == pytest.approx(0.02, abs=1e-4)
    assert lean(0.15, 0.4) > 0.05  # as if it stood down a slope
    for _ in range(2):
        assert lean(0.3, 0.5, capturing=True) == pytest.approx(before, abs=1e-4)
    assert lean(0.02, 0.1) == pytest.approx(before, abs=1e-4)


def test_a_leg_too_short_brings_the_torso_down(body: Body) -> None:
    """A foot 12 mm deeper than planned at the end of a step is reached from a lower hip, with the knee bent."""
    gait = make_gait("static", gait_parameters("static"), body)
    pose = PoseMaker(body, standing_plan(gait), by_pose=True)
    plans = (plan for plan, _ in dry_walk(gait, CYCLE, 3))
    late = next(plan for plan in plans if plan.phase == "DSR" and plan.progress >= 0.9)
    angles = pose.unlimited_angles(late, (0.0, -0.14))
    assert len(angles) == N_JOINTS
    assert min(angles[LEG_SLOTS["L"][3]], angles[LEG_SLOTS["R"][3]]) > math.radians(11.9)
    left, _ = soles(body, angles)
    assert left[:3, 2] == pytest.approx(rotation(0.0, -0.14, 0.0)[:, 2], abs=1e-9)


def test_what_both_ankles_hold_in_common_becomes_the_grounds(body: Body) -> None:
    """Handed over, the sum of ground and offsets stays, and so does the estimate that follows from it."""
    ground = GroundTilt(GroundParameters(walking_time_constant=0.5), body, CYCLE)
    angles = standing(body, None)  # soles level under an upright torso
    tilt, offset = (0.0, 0.0), -0.06
    for _ in range(2000):
        turned = Corrections(ankle_pitch=(offset, offset))
        tilt = ground.update(pushed(angles, (6.0,) * 8), (0.0, 0.0), turned, CYCLE, walking=True)
    assert tilt[1] == pytest.approx(0.06, abs=1e-6)  # the two cancel each other
    for _ in range(60):
        offset += 0.001
        turned = Corrections(ankle_pitch=(offset, offset), common=(0.0, -0.001))
        tilt = ground.update(pushed(angles, (6.0,) * 8), (0.0, 0.0), turned, CYCLE, walking=True)
        assert tilt[1] + offset == pytest.approx(0.0, abs=1e-6)
    assert tilt[1] == pytest.approx(0.0, abs=1e-6)
