"""The whole robot: weight, centre of pressure, repeatability, falls, and a machine without PyBullet."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from bridge.body import BODIES, Body, load_body
from bridge.body.joints import INDEX
from bridge.body.postures import POSTURES
from bridge.messages import ActuatorFrame, SensorFrame
from bridge.messages.faults import CommandLost, DcmPause, JointWeak
from emulator.engine.pybullet.client import bullet
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from tests.processes import python

START = POSTURES["StandInit"]
G = 9.81


def posture(**offsets: float) -> tuple[float, ...]:
    angles = list(START)
    for joint, offset in offsets.items():
        angles[INDEX[joint]] += offset
    return tuple(angles)


LEANS = {
    "upright": posture(),
    "forward": posture(LAnklePitch=-0.08, RAnklePitch=-0.08),
    "back": posture(LAnklePitch=0.06, RAnklePitch=0.06),
    "left": posture(LHipRoll=-0.08, LAnkleRoll=0.08, RHipRoll=-0.08, RAnkleRoll=0.08),
    "right": posture(LHipRoll=0.08, LAnkleRoll=-0.08, RHipRoll=0.08, RAnkleRoll=-0.08),
    "bowed": posture(LHipPitch=-0.15, RHipPitch=-0.15),
}


def weight(body: Body) -> float:
    return G * sum(link.mass for link in body.links.values())


def cells_in_world(robot: EmulatedRobot) -> np.ndarray:
    """Places of the eight cells in the world, m."""
    model, places = robot.multibody.model, []
    for side, cells in (("L", robot.body.fsr.L), ("R", robot.body.fsr.R)):
        link = bullet.getLinkState(
            model.robot, model.feet[side], computeForwardKinematics=True, physicsClientId=model.client
        )
        places.append(Rotation.from_quat(link[5]).apply(cells) + np.array(link[4]))
    return np.vstack(places)


@pytest.mark.parametrize("name", BODIES)
def test_every_body_stands(name: str) -> None:
    body = load_body(name)
    with EmulatedRobot(body, seed=0, engine="mujoco") as robot:
        first = robot.truth()
        for _ in range(round(2.0 / body.cycle)):
            robot.advance(None)
        last = robot.truth()
        np.testing.assert_allclose(last.torso_position, first.torso_position, atol=1e-3)
        assert not last.fell
        assert sum(robot.frame.fsr) == pytest.approx(weight(body), rel=0.01)
        assert robot.frame.time == pytest.approx(2.0, abs=body.cycle)


@pytest.mark.parametrize(("side", "mirror"), [("L", 1.0), ("R", -1.0)])
def test_the_true_sole_touches_the_floor(side: str, mirror: float) -> None:
    body = load_body("nao-v3")
    outline = ConvexHull(np.array(body.foot.sole) * (1.0, mirror))
    with EmulatedRobot(body, seed=0) as robot:
        model = robot.multibody.model
        link = bullet.getLinkState(
            model.robot, model.feet[side], computeForwardKinematics=True, physicsClientId=model.client
        )
        points = bullet.getContactPoints(model.robot, linkIndexA=model.feet[side], physicsClientId=model.client)
    corners = Rotation.from_quat(link[5]).inv().apply([np.array(p[5]) - link[4] for p in points])
    assert len(corners) >= 3
    np.testing.assert_allclose(corners[:, 2], -body.lengths.FootHeight, atol=2e-4)
    # every contact lies on the outline: a, b, c of its edges give 0 there and less than 0 inside
    edge = (outline.equations[:, :2] @ corners[:, :2].T + outline.equations[:, 2:]).max(axis=0)
    np.testing.assert_allclose(edge, 0.0, atol=2e-4)


@pytest.mark.parametrize("name", ["Crouch", "Stand", "StandInit"])
def test_it_starts_looking_along_x_with_level_soles(name: str) -> None:
    with EmulatedRobot(load_body("nao-v3"), seed=0, posture=name, settle=0.0) as robot:
        model = robot.multibody.model
        forward = Rotation.from_quat(robot.truth().torso_orientation).apply([1.0, 0.0, 0.0])
        assert forward[0] > 0.9
        assert forward[1] == pytest.approx(0.0, abs=1e-6)
        sole = bullet.getLinkState(
            model.robot, model.feet["L"], computeForwardKinematics=True, physicsClientId=model.client
        )
        up = Rotation.from_quat(sole[5]).apply([0.0, 0.0, 1.0])
        np.testing.assert_allclose(up, (0.0, 0.0, 1.0), atol=1e-6)


def test_force_sensors_tell_weight_and_centre_of_pressure_of_a_robot_that_leans() -> None:
    body, loads = load_body("nao-v3"), {}
    for lean, angles in LEANS.items():
        with EmulatedRobot(body, seed=0, posture=angles, settle=2.0) as robot:
            truth, frame = robot.truth(), robot.frame
            model = robot.multibody.model
            points = bullet.getContactPoints(model.robot, physicsClientId=model.client)
            cells = cells_in_world(robot)[:, :2]
        loads[lean] = np.array(frame.fsr)
        total = loads[lean].sum()
        assert not truth.fell
        assert total == pytest.approx(sum(point[9] * point[7][2] for point in points), rel=0.01)
        assert total == pytest.approx(weight(body), rel=0.01)
        # at rest the centre of pressure of all cells is below the centre of mass
        np.testing.assert_allclose(loads[lean] @ cells / total, truth.com[:2], atol=1e-3)
        assert truth.zmp is not None
        np.testing.assert_allclose(truth.zmp, truth.com[:2], atol=1e-3)
        for side, felt, contact in (
            (body.fsr.L, loads[lean][:4], truth.left),
            (body.fsr.R, loads[lean][4:], truth.right),
        ):
            assert contact.cop is not None
            np.testing.assert_allclose(felt @ np.array(side)[:, :2] / felt.sum(), contact.cop, atol=1e-3)
    left, front = [0, 1, 2, 3], [0, 1, 4, 5]
    assert loads["left"][left].sum() > 1.1 * loads["upright"][left].sum()
    assert loads["right"][left].sum() < 0.9 * loads["upright"][left].sum()
    assert loads["forward"][front].sum() > 1.1 * loads["upright"][front].sum()
    assert loads["back"][front].sum() < 0.9 * loads["upright"][front].sum()


def script(seq: int) -> ActuatorFrame | None:
    """Squats with every fourth command missing."""
    bend = 0.1 * np.sin(seq / 8.0)
    angles = posture(
        LHipPitch=-bend,
        LKneePitch=2 * bend,
        LAnklePitch=-bend,
        RHipPitch=-bend,
        RKneePitch=2 * bend,
        RAnklePitch=-bend,
    )
    return None if seq % 4 == 3 else ActuatorFrame(reply_to=seq, position=angles, stiffness=(0.9,) * 25)


def test_frame_bookkeeping() -> None:
    with EmulatedRobot(load_body("nao-v3"), seed=0) as robot:
        assert (robot.frame.seq, robot.frame.command, robot.frame.missed) == (0, -1, 0)
        robot.advance(script(0))
        robot.advance(None, expected=True)
        frame = robot.advance(None)
        assert (frame.seq, frame.command, frame.missed) == (3, 0, 1)
        assert frame.time == pytest.approx(0.03)
        counts = np.array(frame.position) / (2.0 * np.pi / 4096)
        np.testing.assert_allclose(counts, np.rint(counts), atol=1e-6)
        assert robot.absent == ("LWristYaw", "RWristYaw", "LHand", "RHand")
        assert all(frame.position[INDEX[name]] == 0.0 for name in robot.absent)


def test_hands_open_at_their_own_pace() -> None:
    with EmulatedRobot(load_body("nao-v6"), seed=0) as robot:
        assert robot.absent == ()
        open_hands = list(START)
        open_hands[INDEX["LHand"]], open_hands[INDEX["RHand"]] = 1.0, 7.0
        seen = []
        for seq in range(60):
            frame = robot.advance(
                ActuatorFrame(reply_to=seq, position=tuple(open_hands), stiffness=(1.0,) * 25)
            )
            seen.append(frame.position[INDEX["LHand"]])
        assert START[INDEX["LHand"]] < seen[0] < seen[5] < 1.0
        assert frame.position[INDEX["LHand"]] == frame.position[INDEX["RHand"]] == 1.0


def test_without_pybullet() -> None:
    """MuJoCo takes its place, unless PyBullet was asked for."""
    code = """
import sys
sys.modules["pybullet"] = None
from bridge.body import load_body
from bridge.errors import ConfigurationError
from emulator.robot import EmulatedRobot
with EmulatedRobot(load_body("nao-v3"), seed=0, settle=0.0) as robot:
    print(type(robot.engine).__name__)
try:
    EmulatedRobot(load_body("nao-v3"), seed=0, engine="pybullet")
except ConfigurationError as error:
    print(error)
"""
    done = python("-c", code)
    assert done.stdout.startswith("MujocoEngine\nPyBullet is not installed"), done.stderr


V6 = load_body("nao-v6")
STAND = POSTURES["StandInit"]


def squat(frame: SensorFrame) -> ActuatorFrame | None:
    """Knees and hands in motion; now and then no answer."""
    if frame.seq % 7 == 3:
        return None
    bend = 0.2 * (1.0 - math.cos(2.0 * frame.time))
    position = list(STAND)
    for side in "LR":
        position[INDEX[f"{side}HipPitch"]] -= bend
        position[INDEX[f"{side}KneePitch"]] += 2.0 * bend
        position[INDEX[f"{side}AnklePitch"]] -= bend
        position[INDEX[f"{side}Hand"]] = 0.5 + 0.5 * math.sin(frame.time)
    stiffness = 0.9 if frame.seq < 60 else 0.6
    return ActuatorFrame(reply_to=frame.seq, position=tuple(position), stiffness=(stiffness,) * 25)


def frames(wear: str, *, ahead: bool) -> list[SensorFrame]:
    with EmulatedRobot(V6, seed=4, engine="mujoco", wear=load_wear(wear)) as robot:
        robot.faults.start(CommandLost(probability=0.2), robot.time, 0.0)
        seen = [robot.frame]
        for cycle in range(150):
            if cycle == 50:
                robot.faults.start(DcmPause(), robot.time, 0.1)
            if cycle == 90:
                robot.faults.start(JointWeak(joint="LKneePitch", fraction=0.5), robot.time, 0.3)
            if ahead:
                robot.world.run_ahead()
            seen.append(robot.advance(squat(robot.frame), expected=True))
        return seen


@pytest.mark.parametrize("wear", ["ideal", "worn"])
def test_the_same_frames_with_the_physics_before_or_after_the_command(wear: str) -> None:
    assert frames(wear, ahead=True) == frames(wear, ahead=False)


@pytest.mark.parametrize(("wear", "moves"), [("nominal", True), ("ideal", False)])
def test_the_world_moves_before_the_command_only_where_that_cannot_act_yet(wear: str, moves: bool) -> None:
    with EmulatedRobot(V6, seed=4, engine="mujoco", wear=load_wear(wear)) as robot:
        for _ in range(20):
            robot.advance(squat(robot.frame))
        before = robot.multibody.position.copy()
        robot.world.run_ahead()
        assert bool((robot.multibody.position != before).any()) is moves
        assert robot.frame.seq == robot.seq == 20
