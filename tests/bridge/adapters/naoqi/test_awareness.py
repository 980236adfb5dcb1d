"""ALBasicAwareness by the vendor's page and its sample: somebody is tracked, is somewhere, and gets lost."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from bridge.messages import SensorFrame
from tests.bridge.adapters.naoqi.served import Robot


@pytest.fixture
def robot(standing: Callable[..., SensorFrame]) -> Robot:
    robot = Robot(standing())
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


def test_who_stops_it_tracks_nobody(robot: Robot) -> None:
    robot.call("ALBasicAwareness", "setEnabled", True)
    robot.run(1.0)
    robot.call("ALBasicAwareness", "stopAwareness")
    robot.run(1.0)
    assert raised(robot, "HumanTracked")[-1] == -1
    robot.call("ALBasicAwareness", "setStimulusDetectionEnabled", "People", False)
    robot.call("ALBasicAwareness", "startAwareness")
    robot.run(1.0)
    assert len(raised(robot, "HumanTracked")) == 2
