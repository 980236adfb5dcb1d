"""A quick step whose commands break off: the guard brings the feet side by side."""

from __future__ import annotations

import pytest

from bridge.body.joints import INDEX
from bridge.body.postures import POSTURES
from bridge.guard import Guard
from tests.guarded import BODY, SETTINGS, STAND, Robot, until_rest


def stride(k: int, speed: float) -> tuple[float, ...]:
    """A leg that is lifted at a speed of its knee, rad/s, from the stand on."""
    position = list(STAND)
    lifted = min(k * BODY.cycle * speed, 0.4)
    for joint, share in (("LHipPitch", -0.5), ("LKneePitch", 1.0), ("LAnklePitch", -0.5)):
        position[INDEX[joint]] += share * lifted
    return tuple(position)


def in_stride(speed: float = 9.0, every: int = 1) -> Robot:
    """A robot that is commanded so each `every` cycles, in the middle of the way."""
    robot = Robot(Guard(BODY))
    for k in range(-30, 5):
        if k % every == 0:
            robot.command(stride(max(k, 0), speed))
        else:
            robot.cycle(None)
    robot.guard.take_notices()
    return robot


def uneven(robot: Robot) -> float:
    """Largest difference of both legs' pitch joints, rad."""
    pairs = ((f"L{joint}", f"R{joint}") for joint in ("HipPitch", "KneePitch", "AnklePitch"))
    return max(abs(robot.position[INDEX[a]] - robot.position[INDEX[b]]) for a, b in pairs)


def test_a_quick_step_whose_commands_break_off_ends_with_the_feet_side_by_side() -> None:
    robot, dog = in_stride(), SETTINGS.watchdog
    knee = robot.position[INDEX["LKneePitch"]]
    other = robot.position[INDEX["RKneePitch"]]
    assert uneven(robot) > 0.2
    robot.silence(dog.stride_cycles - 1)
    assert uneven(robot) > 0.2
    states = robot.silence(round(0.15 / BODY.cycle) + 1)
    assert set(states) == {"active"} and [n.code for n in robot.guard.take_notices()] == ["guard-close"]
    assert uneven(robot) < 1e-9
    assert robot.position[INDEX["LKneePitch"]] == pytest.approx(0.5 * (knee + other))
    robot.command(stride(5, 9.0))
    assert robot.guard.state == "active"


@pytest.mark.parametrize(("speed", "every"), [(2.0, 1), (7.0, 1), (9.0, 4)])
def test_a_slow_step_and_one_by_sparse_commands_are_held_as_they_are(speed: float, every: int) -> None:
    robot = in_stride(speed, every)
    before = robot.position
    robot.silence(SETTINGS.watchdog.silence_cycles)
    assert robot.guard.state == "hold" and robot.position == before
    assert "guard-close" not in [notice.code for notice in robot.guard.take_notices()]


@pytest.mark.parametrize("end", ["stop", "release"])
def test_a_stop_and_a_release_in_a_quick_step_bring_the_feet_together_first(end: str) -> None:
    robot = in_stride()
    if end == "stop":
        robot.guard.stop("crouch")
    else:
        robot.guard.released(robot.seq)
    robot.silence(round(0.15 / BODY.cycle) + 1, supervised=False)
    assert uneven(robot) < 0.02
    codes = [notice.code for notice in robot.guard.take_notices()]
    if end == "stop":
        assert codes[:3] == ["guard-stop", "guard-close", "guard-crouch"]
        until_rest(robot)
        assert robot.position[INDEX["LKneePitch"]] == pytest.approx(POSTURES["Crouch"][INDEX["LKneePitch"]])
    else:
        assert codes == ["guard-close", "guard-hold"] and robot.guard.state == "hold"


def test_a_robot_that_lies_is_held_as_it_is() -> None:
    robot = Robot(Guard(BODY))
    robot.angle = (0.0, 1.4)
    for k in range(-30, 5):
        robot.command(stride(max(k, 0), 9.0))
    before = robot.position
    robot.silence(SETTINGS.watchdog.silence_cycles - 1)
    assert robot.position == before
