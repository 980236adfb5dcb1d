"""ALMotion's breathing by the vendor's page on idle: slow, of a robot that stands and is not moved."""

from __future__ import annotations

import itertools
import math

import pytest

from bridge.body.joints import INDEX
from bridge.errors import NaoqiRefused
from tests.bridge.adapters.naoqi.served import Robot

LEG = ("LHipPitch", "LKneePitch", "LAnklePitch")


def test_a_standing_robot_breathes_twelve_times_a_minute_under_ten_degrees(robot: Robot) -> None:
    assert robot.motion("getBreathConfig") == [["Bpm", 12.0], ["Amplitude", 0.5]]
    rest = robot.frame.position
    robot.motion("setBreathEnabled", "Body", True)
    assert robot.motion("getBreathEnabled", "LArm") is True
    sent = robot.run(20.0)
    for joint in (*LEG, "HeadPitch", "LShoulderRoll", "RShoulderRoll"):
        course = [position[INDEX[joint]] - rest[INDEX[joint]] for position in sent]
        furthest = max(course, key=abs)
        assert math.radians(1.0) < abs(furthest) < math.radians(10.0)
        away = [abs(x) > abs(furthest) / 2 for x in course]
        assert sum(b and not a for a, b in itertools.pairwise(away)) == 4  # in 20 s
    for position in sent:  # torso upright, soles flat
        assert sum(position[INDEX[j]] for j in LEG) == pytest.approx(sum(rest[INDEX[j]] for j in LEG), abs=1e-3)
    robot.motion("setBreathEnabled", "Body", False)
    assert robot.run(4.0)[-1] == pytest.approx(rest, abs=1e-3)


def test_what_the_program_commands_has_precedence_and_is_where_the_breath_goes_on(robot: Robot) -> None:
    robot.motion("setBreathEnabled", "Head", True)
    robot.run(3.0)
    robot.wait(robot.motion("angleInterpolation", "HeadPitch", 0.3, 1.0, True))
    assert robot.angle("HeadPitch") == pytest.approx(0.3, abs=0.01)
    course = [position[INDEX["HeadPitch"]] for position in robot.run(10.0)]
    assert max(course) == pytest.approx(0.3, abs=1e-3)
    assert 0.3 - math.radians(3.0) < min(course) < 0.3 - math.radians(1.0)


def test_a_robot_that_does_not_stand_does_not_breathe(robot: Robot) -> None:
    robot.wait(robot.motion("rest"), 20.0)
    robot.motion("setBreathEnabled", "Arms", True)
    before = robot.frame.position
    assert robot.run(5.0)[-1] == pytest.approx(before, abs=1e-6)


def test_fast_breaths_are_small_ones(robot: Robot) -> None:
    """The page: all amplitudes at 5 breaths a minute, none at 30, linear in between."""
    robot.motion("setBreathConfig", [["Bpm", 5.0], ["Amplitude", 1.0]])
    assert robot.motion("getBreathConfig") == [["Bpm", 5.0], ["Amplitude", 1.0]]
    robot.motion("setBreathConfig", [["Bpm", 17.5]])
    assert robot.motion("getBreathConfig") == [["Bpm", 17.5], ["Amplitude", 0.5]]
    for wrong in ([["Bpm", 31.0]], [["Speed", 1.0]], "fast"):
        with pytest.raises(NaoqiRefused, match="setBreathConfig"):
            robot.motion("setBreathConfig", wrong)
    with pytest.raises(NaoqiRefused, match="'Leg'"):
        robot.motion("setBreathEnabled", "Leg", True)
