"""ALNavigation and ALVisualCompass: the walks that they ask ALMotion for."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

import pytest

from bridge.body.joints import INDEX
from tests.bridge.adapters.naoqi.served import Robot


class Walks:
    """Of ALMotion: each walk ends at once, where it was to end."""

    def __init__(self) -> None:
        self.asked: list[Any] = []
        self.place = [0.0, 0.0, 0.0]
        self.ends_well = True

    def move_to(self, *arguments: Any) -> Future[Any]:
        self.asked.append(list(arguments))
        done: Future[Any] = Future()
        done.set_result(self.ends_well)
        return done

    def table(self) -> dict[str, Callable[..., Any]]:
        return {
            "moveTo": self.move_to,
            "getRobotPosition": lambda _: list(self.place),
            "stopMove": lambda: None,
            "waitUntilMoveIsFinished": lambda: None,
        }


@pytest.fixture
def walks() -> Walks:
    return Walks()


@pytest.fixture
def robot(walks: Walks) -> Robot:
    return Robot(walks=walks.table())


def test_navigate_to_walks_to_places_nearer_than_3_m(robot: Robot, walks: Walks) -> None:
    assert robot.call("ALNavigation", "navigateTo", 2.0, 0.5).result(0.0) is True
    assert robot.call("ALNavigation", "navigateTo", 2.0, 0.0, [["SpeedFactor", 1.5]]).result(0.0) is True
    assert robot.call("ALNavigation", "navigateTo", 3.0, 0.1) is False
    assert walks.asked == [[2.0, 0.5, 0.0, []], [2.0, 0.0, 0.0, [["MaxStepFrequency", 1.0]]]]
    assert robot.call("ALNavigation", "moveTo", 0.1, 0.0, 0.0).result(0.0) is True


def test_the_compass_turns_goes_ahead_and_turns(robot: Robot, walks: Walks) -> None:
    robot.call("ALVisualCompass", "moveTo", 0.0, 1.0, math.pi)
    robot.call("ALVisualCompass", "moveTo", 1.0, 0.0, 0.0)
    robot.call("ALVisualCompass", "moveStraightTo", -0.5)
    ((first,), (second,), third) = walks.asked
    assert first == [pytest.approx(way) for way in ([0, 0, math.pi / 2], [1, 0, 0], [0, 0, math.pi / 2])]
    assert (second, third) == ([[1.0, 0.0, 0.0]], [-0.5, 0.0, 0.0])


def test_the_compass_tells_how_far_the_camera_turned_since_the_subscription(robot: Robot) -> None:
    """About the vertical, also with the head bent down."""
    robot.motion("setAngles", "HeadPitch", 0.4, 0.5)
    robot.run(2.0)
    robot.call("ALVisualCompass", "subscribe", "me")
    robot.run(0.1)
    position = list(robot.frame.position)
    position[INDEX["HeadYaw"]] += 0.3
    robot.motion("setAngles", "HeadYaw", position[INDEX["HeadYaw"]], 0.5)
    robot.run(2.0)
    (wy, wz), place, stamp = dict(robot.events)["VisualCompass/Deviation"]
    assert wz == pytest.approx(0.3, abs=0.01) and wy == pytest.approx(0.0, abs=0.02)
    assert (len(place), len(stamp)) == (3, 2)
    robot.call("ALVisualCompass", "setCurrentImageAsReference")
    robot.run(0.2)
    assert dict(robot.events)["VisualCompass/Deviation"][0] == pytest.approx([0.0, 0.0], abs=1e-3)
