"""ALTracker follows what the cameras saw, also when they tell it late."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from concurrent.futures import Future
from typing import Any

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.cameras import CAMERA_LINK, cameras
from bridge.body.joints import INDEX
from bridge.body.kinematics import BodyTree, homogeneous
from bridge.messages import SensorFrame
from bridge.rotations import R_pitch
from tests.bridge.adapters.naoqi.served import Robot

BODY = load_body("nao-v5")
TREE = BodyTree(BODY)
BALL = (0.5, 0.24, 0.15)
"""In the Torso frame, m."""


class LateEyes:
    """They see a ball, and tell of it some cycles later."""

    def __init__(self, cycles: int) -> None:
        self._told: deque[list[list[Any]]] = deque([[]] * cycles)

    def picture(self, *_: Any) -> Future[Any]:
        return Future()

    def look(self, frame: SensorFrame) -> None:
        head = [frame.position[INDEX[name]] for name in ("HeadYaw", "HeadPitch")]
        links = TREE.link_frames(frame.position)
        seen = []
        for i, camera in enumerate(cameras(BODY)):
            view = links[CAMERA_LINK] @ homogeneous(R_pitch(camera.pitch), camera.place)
            seen.append([i, "ball", "b", (np.linalg.inv(view) @ (*BALL, 1.0))[:3].tolist(), 0.06, head])
        self._told.append(seen)
        self._told.popleft()

    def sights(self) -> Sequence[Sequence[Any]]:
        return self._told[0]


@pytest.mark.parametrize("cycles", [1, 50])
def test_the_head_turns_to_the_ball_and_stays_there(cycles: int) -> None:
    eyes = LateEyes(cycles)
    robot = Robot(feed=eyes)
    robot.call("ALTracker", "registerTarget", "RedBall", 0.06)
    robot.call("ALTracker", "track", "RedBall")
    yaws = []
    for _ in range(500):
        eyes.look(robot.frame)
        robot.run(0.01)
        yaws.append(robot.angle("HeadYaw"))
    # The cameras are in the head's plane of symmetry, which goes through its yaw axis.
    assert yaws[200:] == pytest.approx([math.atan2(BALL[1], BALL[0])] * 300, abs=1e-3)
    assert not robot.call("ALTracker", "isTargetLost")
    assert robot.call("ALTracker", "getTargetPosition", 0) == pytest.approx(BALL, abs=1e-3)


@pytest.fixture
def robot() -> Robot:
    robot = Robot()
    robot.motion("setStiffnesses", "Body", 1.0)
    robot.call("NaoHil", "show", "face", "Anna", [1.0, 0.3, 0.5])
    return robot


def raised(robot: Robot, event: str) -> list[Any]:
    return [value for name, value in robot.events if name == f"ALBasicAwareness/{event}"]


def test_somebody_is_tracked_by_the_head_and_lost(robot: Robot) -> None:
    robot.run(1.0)
    assert raised(robot, "HumanTracked") == []
    robot.call("ALBasicAwareness", "startAwareness")
    robot.run(3.0)
    assert raised(robot, "StimulusDetected") == ["People"]
    (person,) = raised(robot, "HumanTracked")
    assert person >= 0
    key = f"PeoplePerception/Person/{person}/"
    place = robot.call("ALMemory", "getData", key + "PositionInWorldFrame")
    assert place == pytest.approx([1.0, 0.3, 0.5], abs=0.03)
    assert robot.call("ALMemory", "getData", key + "Distance") == pytest.approx(1.05, abs=0.1)
    assert robot.call("ALMemory", "getData", "PeoplePerception/PeopleList") == [person]
    assert robot.angle("HeadYaw") == pytest.approx(0.29, abs=0.05)  # atan(0.3 / 1.0)
    robot.call("NaoHil", "hide", "face", "Anna")
    robot.run(2.0)
    assert raised(robot, "HumanTracked") == [person]
    robot.run(2.0)
    assert raised(robot, "HumanTracked") == [person, -1]
    assert raised(robot, "PeopleLeft") == [person]
    assert robot.call("ALMemory", "getData", "PeoplePerception/PeopleList") == []
