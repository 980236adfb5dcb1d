"""ALTracker follows what the cameras saw, also when they tell it late."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Any

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.cameras import LINK, cameras
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
            view = links[LINK] @ homogeneous(R_pitch(camera.pitch), camera.place)
            seen.append([i, "ball", "b", (np.linalg.inv(view) @ (*BALL, 1.0))[:3].tolist(), 0.06, head])
        self._told.append(seen)
        self._told.popleft()

    def sights(self) -> Sequence[Sequence[Any]]:
        return self._told[0]


@pytest.mark.parametrize("cycles", [1, 50])
def test_the_head_turns_to_the_ball_and_stays_there(standing: Callable[..., SensorFrame], cycles: int) -> None:
    eyes = LateEyes(cycles)
    robot = Robot(standing(), eyes=eyes)
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
