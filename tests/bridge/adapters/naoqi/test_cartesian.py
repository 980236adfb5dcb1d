"""ALMotion's Cartesian control, ALTracker and the detections against the body's lengths and plain geometry."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import N_JOINTS
from bridge.body.sole import sole_hull
from tests.bridge.adapters.naoqi.served import Robot
from tests.frames import standing_frame

LENGTH = load_body("nao-v5").lengths


@pytest.fixture
def straight() -> Robot:
    """All joints at zero: legs straight, arms straight forward."""
    return Robot(standing_frame(position=(0.0,) * N_JOINTS))


def test_effectors_of_a_straight_robot_are_where_its_lengths_add_up(straight: Robot) -> None:
    hand = straight.motion("getPosition", "LArm", 0, True)
    reach = LENGTH.UpperArmLength + LENGTH.LowerArmLength + LENGTH.HandOffsetX
    side = LENGTH.ShoulderOffsetY + LENGTH.ElbowOffsetY
    assert hand == pytest.approx([reach, side, LENGTH.ShoulderOffsetZ - LENGTH.HandOffsetZ, 0, 0, 0], abs=1e-9)
    height = LENGTH.HipOffsetZ + LENGTH.ThighLength + LENGTH.TibiaLength + LENGTH.FootHeight
    assert straight.motion("getPosition", "RLeg", 0, True)[:3] == pytest.approx(
        [0, -LENGTH.HipOffsetY, -height]
    )
    for measured in (True, False):
        assert straight.motion("getPosition", "Torso", 2, measured) == pytest.approx(
            [0, 0, height, 0, 0, 0], abs=1e-3
        )
    head = straight.motion("getTransform", "Head", 0, True)
    assert (head[3], head[7], head[11]) == pytest.approx((0.0, 0.0, LENGTH.NeckOffsetZ))


def test_a_torso_that_leans_is_seen_in_the_robots_space_by_the_sensors(straight: Robot) -> None:
    straight.run(0.02, angle=(0.0, 0.2))
    assert straight.motion("getPosition", "Torso", 2, True)[4] == pytest.approx(0.2, abs=1e-6)
    assert straight.motion("getPosition", "Torso", 2, False)[4] == pytest.approx(0.0, abs=1e-3)


def test_the_worlds_space_stays_where_the_robot_began() -> None:
    robot = Robot(walks={"getRobotPosition": lambda _: [1.0, 2.0, math.pi / 2.0]})
    x, y, *_, yaw = robot.motion("getPosition", "Torso", 1, True)
    ahead = robot.motion("getPosition", "Torso", 2, True)[0]
    assert (x, y, yaw) == pytest.approx((1.0, 2.0 + ahead, math.pi / 2.0), abs=1e-3)


def test_the_centre_of_mass_of_the_parts_is_that_of_the_whole(robot: Robot) -> None:
    parts = ["Head", "LArm", "LLeg", "RLeg", "RArm", "Torso"]
    masses = np.array([robot.motion("getMass", part) for part in parts])
    places = np.array([robot.motion("getCOM", part, 0, True) for part in parts])
    assert masses.sum() == pytest.approx(robot.motion("getMass", "Body"))
    assert masses @ places / masses.sum() == pytest.approx(robot.motion("getCOM", "Body", 0, True))


@pytest.mark.parametrize("effector", ["LArm", "RArm"])
def test_a_hand_goes_where_it_is_sent(robot: Robot, effector: str) -> None:
    wanted = robot.motion("getPosition", effector, 0, False)
    wanted[0] += 0.03
    wanted[2] += 0.04
    robot.motion("setPositions", effector, 0, wanted, 0.5, 7)
    robot.run(2.0)
    assert robot.motion("getPosition", effector, 0, True)[:3] == pytest.approx(wanted[:3], abs=1e-3)


def test_the_torso_goes_down_between_the_feet(robot: Robot) -> None:
    start = robot.motion("getPosition", "Torso", 2, False)
    low = [*start[:2], start[2] - 0.03, *start[3:]]
    foot = robot.motion("getPosition", "LLeg", 2, False)
    done = robot.motion("positionInterpolations", ["Torso"], 2, [[low, start]], 63, [[0.5, 1.0]])
    robot.run(0.5)
    assert robot.motion("getPosition", "Torso", 2, False) == pytest.approx(low, abs=2e-3)
    assert robot.motion("getPosition", "LLeg", 2, False) == pytest.approx(foot, abs=2e-3)
    assert not done.done()
    robot.run(0.6)
    assert done.done()
    assert robot.motion("getPosition", "Torso", 2, False) == pytest.approx(start, abs=2e-3)


def test_a_path_is_a_line_and_takes_its_time(robot: Robot) -> None:
    """The singular form with relative places, as in old programs: `path, mask, durations, isAbsolute`."""
    start = np.array(robot.motion("getPosition", "RArm", 0, False)[:3])
    done = robot.motion("positionInterpolation", "RArm", 0, [0.0, 0.0, 0.05, 0.0, 0.0, 0.0], 7, 1.0, False)
    heights = []
    for _ in range(11):
        robot.run(0.1)
        off = np.array(robot.motion("getPosition", "RArm", 0, True)[:3]) - start
        heights.append(off[2])
        assert np.abs(off[:2]).max() < 3e-3
    assert done.done()
    assert heights[4] == pytest.approx(0.025, abs=2e-3)
    assert heights[-1] == pytest.approx(0.05, abs=1e-3)


def test_a_place_out_of_reach_is_gone_to_as_near_as_the_arm_allows(robot: Robot) -> None:
    robot.motion("setPosition", "LArm", 0, [1.0, 0.1, 0.1, 0.0, 0.0, 0.0], 0.5, 7)
    robot.run(3.0)
    x, y, z, *_ = robot.motion("getPosition", "LArm", 0, True)
    shoulder = (0.0, LENGTH.ShoulderOffsetY, LENGTH.ShoulderOffsetZ)
    assert math.dist((x, y, z), shoulder) > 0.2


@pytest.mark.parametrize("space", [1, 2])
def test_a_foot_goes_where_it_is_sent_though_the_spaces_hang_on_the_feet(robot: Robot, space: int) -> None:
    """Torso and the other foot stay: the ankle rises by 30 mm in the Torso frame, not by twice that."""
    before = robot.motion("getPosition", "RLeg", 0, False)
    place = robot.motion("getPosition", "RLeg", space, False)
    place[2] += 0.03
    robot.wait(robot.motion("positionInterpolations", "RLeg", space, [place], 63, [1.0]))
    after = robot.motion("getPosition", "RLeg", 0, False)
    assert math.dist(before[:3], after[:3]) == pytest.approx(0.03, abs=2e-4)


@pytest.mark.parametrize(("leg", "side"), [("LLeg", 1.0), ("RLeg", -1.0), ("Legs", 0.0)])
def test_the_centre_of_mass_goes_over_a_foot(robot: Robot, leg: str, side: float) -> None:
    """Over the middle of its sole, which is a little outside of the ankle."""
    corners = np.array(sole_hull(load_body("nao-v5"), "L"))
    x, y = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    feet = [robot.motion("getPosition", one, 2, False) for one in ("LLeg", "RLeg")]
    assert robot.wait(robot.motion("wbGoToBalance", leg, 1.0)) is True
    com = robot.motion("getCOM", "Body", 2, False)
    assert com[:2] == pytest.approx([x, side * (0.05 + y)], abs=3e-3)
    for foot, one in zip(feet, ("LLeg", "RLeg"), strict=True):
        assert robot.motion("getPosition", one, 2, False)[:3] == pytest.approx(foot[:3], abs=2e-3)


def test_feet_that_are_fixed_stay_flat_below_the_torso_while_the_knees_move(robot: Robot) -> None:
    """As the vendor's sample of the balance constraint stretches and bends the knees."""
    before = {leg: robot.motion("getPosition", leg, 0, False) for leg in ("LLeg", "RLeg")}
    robot.motion("wbEnable", True)
    robot.motion("wbFootState", "Fixed", "Legs")
    knees = ["LKneePitch", "RKneePitch"]
    robot.wait(robot.motion("angleInterpolation", knees, [[1.0], [1.0]], [[2.0], [2.0]], True))
    robot.run(0.1)
    assert robot.motion("getAngles", knees, False) == pytest.approx([1.0, 1.0], abs=1e-3)
    for leg, place in before.items():
        x, y, z, *angles = robot.motion("getPosition", leg, 0, False)
        assert [x, y, *angles] == pytest.approx([*place[:2], *place[3:]], abs=5e-3)
        assert z > place[2] + 0.01


def test_effectors_follow_targets_in_the_robots_space_while_that_is_enabled(robot: Robot) -> None:
    hand = robot.motion("getPosition", "LArm", 2, False)[:3]
    wanted = [hand[0] + 0.02, hand[1] + 0.01, hand[2] + 0.02]
    robot.motion("wbSetEffectorControl", "LArm", wanted)
    robot.run(1.0)
    assert robot.motion("getPosition", "LArm", 2, False)[:3] == pytest.approx(hand, abs=1e-3)
    for effector in ("LArm", "Head"):
        robot.motion("wbEnableEffectorControl", effector, True)
    robot.motion("wbSetEffectorControl", "LArm", wanted)
    robot.motion("wbSetEffectorControl", "Head", [0.0, 0.2, 0.4])
    robot.run(3.0)
    assert robot.motion("getPosition", "LArm", 2, False)[:3] == pytest.approx(wanted, abs=1e-3)
    assert robot.motion("getPosition", "Head", 2, False)[4:] == pytest.approx([0.2, 0.4], abs=0.01)


@pytest.mark.parametrize("arguments", [(0, 0.5), (0.5,)])
def test_an_arm_points_at_a_place(robot: Robot, arguments: tuple[Any, ...]) -> None:
    point = np.array([1.0, 0.4, 0.3])
    robot.wait(robot.call("ALTracker", "pointAt", "LArm", point.tolist(), *arguments))
    hand = np.array(robot.motion("getPosition", "LArm", 0, True)[:3])
    shoulder = np.array([0.0, LENGTH.ShoulderOffsetY, LENGTH.ShoulderOffsetZ])
    along, arm = point - shoulder, hand - shoulder
    assert math.degrees(math.acos(along @ arm / np.linalg.norm(along) / np.linalg.norm(arm))) < 8.0


def test_a_landmark_is_detected_where_the_cameras_geometry_says(robot: Robot) -> None:
    robot.call("ALLandMarkDetection", "subscribe", "me", 100, 0.0)
    robot.run(0.3)
    assert robot.events == []
    camera = np.array(robot.motion("getTransform", "CameraTop", 1, True)).reshape(4, 4)
    place = camera @ (1.0, 0.2, -0.1, 1.0)  # ahead of the camera, to its left and below its axis
    robot.call("NaoHil", "show", "landmark", 80, [float(x) for x in place[:3]], 0.1)
    robot.run(0.3)
    name, value = robot.events[-1]
    assert name == "LandmarkDetected" and len(value) == 5 and value[4] == "CameraTop"
    [[shape, [number]]] = value[1]
    assert number == 80
    assert shape[1:3] == pytest.approx([math.atan2(0.2, 1.0), math.atan2(0.1, 1.0)], abs=1e-6)
    assert shape[3] == pytest.approx(0.1 / math.sqrt(1.05), rel=0.01)
    robot.call("NaoHil", "hide", "landmark", 80)
    robot.run(0.2)
    assert robot.events[-1] == ("LandmarkDetected", [])


@pytest.mark.parametrize("period", [100, 500, 1000])
def test_a_face_is_told_within_two_seconds(robot: Robot, period: int) -> None:
    camera = np.array(robot.motion("getTransform", "CameraTop", 1, True)).reshape(4, 4)
    robot.call("ALFaceDetection", "subscribe", "me", period, 0.0)
    robot.signals.add("FaceDetected")
    robot.run(1.5)
    assert not robot.events
    robot.call("NaoHil", "show", "face", "Anna", [float(x) for x in (camera @ (0.8, 0.0, 0.0, 1.0))[:3]])
    robot.run(2.0)
    assert "FaceDetected" in dict(robot.events)


def test_a_face_is_known_once_it_was_learnt(robot: Robot) -> None:
    camera = np.array(robot.motion("getTransform", "CameraTop", 1, True)).reshape(4, 4)
    place: list[Any] = [float(x) for x in (camera @ (0.8, 0.0, 0.0, 1.0))[:3]]
    robot.call("NaoHil", "show", "face", "somebody", place)
    assert robot.wait(robot.call("ALFaceDetection", "learnFace", "Anna")) is True
    robot.call("ALMemory", "subscribeToEvent", "FaceDetected", "Module", "onFace")  # starts the extractor, too
    robot.run(0.2)
    [_, [face, filtered], *_] = robot.call("ALMemory", "getData", "FaceDetected")
    assert face[1][2] == "Anna"
    assert len(face[0]) == 5 and [len(points) for points in face[1][3:5]] == [14, 14]
    assert filtered in ([], [2, ["Anna"]])
