"""The methods that programs call most (counted in forty public repositories): results, and errors."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

import pytest

from bridge.adapters.naoqi.core.cameras import CameraFeed
from bridge.errors import NaoqiRefused
from tests.bridge.adapters.naoqi.served import TABLE, Robot, same


def image(value: Any) -> bool:
    """The vendor's page: width, height, layers, colour space, time (s, us), pixels, camera, and the angles
    (rad) of its left, upper, right and lower edge; a V5 sees 60.97 x 47.64 degrees."""
    *facts, seconds, micros, pixels, camera, left, top, right, bottom = value
    assert len(value) == 12
    assert facts == [320, 240, 3, 11]
    assert camera == 1
    assert abs(seconds + 1e-6 * micros - TAKEN) < 1e-5
    assert 0 <= micros < 1_000_000
    assert len(pixels) == 320 * 240 * 3
    edges = [math.degrees(angle) for angle in (left, top, right, bottom)]
    return all(type(x) is int for x in (*facts, seconds, micros, camera)) and edges == pytest.approx(
        [30.48, -23.82, -30.48, 23.82], abs=0.05
    )


TAKEN = 1_700_000_000.123456


class Eyes(CameraFeed):
    """They draw at once."""

    def picture(self, camera: int, width: int, height: int, space: int, file: str = "") -> Future[Any]:
        done: Future[Any] = Future()
        done.set_result([TAKEN, bytes(width * height * 3)])
        return done


HEAD_KEY = "Device/SubDeviceList/HeadYaw/Position/Sensor/Value"
MOST_USED: list[tuple[str, list[Any], list[Any], Callable[[Any], bool]]] = [
    # method, arguments, wrong arguments, what fits its result; what only reads comes first: they share a robot
    ("ALMotion.getSummary", [], [1], lambda v: "HeadYaw" in v),
    ("ALMemory.getData", [HEAD_KEY], ["no/such/key"], lambda v: abs(v) < 0.01),
    ("ALVideoDevice.getImageRemote", ["seen_0"], [0], image),
    ("ALAudioPlayer.loadFile", ["/usr/share/naoqi/wav/a.wav"], [1], lambda v: type(v) is int),
    *((call, given, wrong, same(*result)) for call, given, wrong, *result in TABLE["most_used"]),
]


@pytest.fixture(scope="module")
def robot() -> Robot:
    robot = Robot(feed=Eyes())
    robot.call("ALMemory", "insertData", "DCM/Mine", 1)
    robot.call("ALVideoDevice", "subscribeCamera", "seen", 1, 1, 11, 30)
    return robot


@pytest.mark.parametrize(
    ("call", "arguments", "wrong", "fits"), MOST_USED, ids=[call for call, *_ in MOST_USED]
)
def test_a_method_returns_what_its_page_says_and_refuses_wrong_arguments(
    robot: Robot, call: str, arguments: list[Any], wrong: list[Any], fits: Callable[[Any], bool]
) -> None:
    """The refusal names the method or the wrong value."""
    assert fits(robot.result(call, *arguments))
    with pytest.raises(NaoqiRefused) as refused:
        robot.call(*call.split("."), *wrong)
    assert any(name in str(refused.value) for name in (call.split(".")[1], *re.findall(r"[\w.-]+", str(wrong))))


def test_a_loop_of_sound_lasts_until_it_is_stopped_and_a_sound_as_long_as_it_is(robot: Robot) -> None:
    """Seconds; both wait for the end, and give nothing."""
    looped = robot.call("ALAudioPlayer", "playFileInLoop", "/usr/share/naoqi/wav/a.wav")
    robot.run(20.0)
    assert not looped.done()
    robot.call("ALAudioPlayer", "stopAll")
    assert robot.wait(looped) is None
    key = robot.wait(robot.call("ALAudioPlayer", "loadFile", "/usr/share/naoqi/wav/a.wav"))
    played = robot.call("ALAudioPlayer", "play", key)
    robot.run(0.5 * robot.call("ALAudioPlayer", "getFileLength", key))
    assert not played.done()
    assert robot.wait(played, 20.0) is None
    with pytest.raises(NaoqiRefused):
        robot.call("ALAudioPlayer", "play", 10_000)


def test_an_animation_of_the_vendor_is_a_gesture_and_said_once(
    robot: Robot, caplog: pytest.LogCaptureFixture
) -> None:
    robot.motion("setStiffnesses", "Body", 1.0)
    before = robot.motion("getAngles", "Body", True)
    waving = robot.call("ALAnimationPlayer", "run", "animations/Stand/Gestures/Hey_1")
    robot.run(1.0)
    assert robot.angle("RShoulderPitch") < -0.5 and not waving.done()
    robot.wait(waving)
    assert robot.motion("getAngles", "Body", True) == pytest.approx(before, abs=0.01)
    assert robot.call("ALBehaviorManager", "isBehaviorInstalled", "animations/Stand/Gestures/Yes_1")
    robot.wait(robot.call("ALBehaviorManager", "runBehavior", "animations/Stand/Gestures/Yes_1"))
    assert caplog.text.count("a gesture of nao-hil") == 1
    with pytest.raises(NaoqiRefused, match="'my-dance' is not installed"):
        robot.call("ALBehaviorManager", "runBehavior", "my-dance")
