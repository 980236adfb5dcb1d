"""The methods that programs call most (counted in forty public repositories): results, and errors."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Any

import pytest

from bridge.errors import NaoqiRefused
from tests.bridge.adapters.naoqi.served import Robot
from tests.frames import standing_frame


def none(value: Any) -> bool:
    return value is None


def true(value: Any) -> bool:
    return value is True


def numbers(*expected: float) -> Callable[[Any], bool]:
    """A list of floats, each about as expected: m, rad, or 0 to 1."""
    return lambda value: all(type(x) is float for x in value) and value == pytest.approx(expected, abs=0.01)


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


class Eyes:
    """They draw at once."""

    def picture(self, camera: int, width: int, height: int, space: int, file: str = "") -> Future[Any]:
        done: Future[Any] = Future()
        done.set_result([TAKEN, bytes(width * height * 3)])
        return done

    def sights(self) -> Sequence[Sequence[Any]]:
        return ()


HEAD_KEY = "Device/SubDeviceList/HeadYaw/Position/Sensor/Value"
SPEECH, MEMORY, LEDS, VIDEO = "ALTextToSpeech.", "ALMemory.", "ALLeds.", "ALVideoDevice."
MOTION, POSTURE, TRACKER, PLAYER = "ALMotion.", "ALRobotPosture.", "ALTracker.", "ALAudioPlayer."
MOST_USED: list[tuple[str, list[Any], Callable[[Any], bool], list[Any]]] = [
    # method, arguments, what fits its result, wrong arguments
    (SPEECH + "say", ["Hi"], none, [[1]]),
    (SPEECH + "setLanguage", ["French"], none, ["Klingon"]),
    (SPEECH + "setVolume", [0.5], none, [50]),
    (SPEECH + "setParameter", ["speed", 90.0], none, ["loudness", 1.0]),
    (SPEECH + "stopAll", [], none, [1]),
    ("ALAnimatedSpeech.say", ["Hi", {"bodyLanguageMode": "disabled"}], none, ["Hi", {"bodyLanguageMode": "x"}]),
    (MOTION + "wakeUp", [], none, [1]),
    (MOTION + "rest", [], none, ["Nose"]),
    (MOTION + "setStiffnesses", ["Head", 0.5], none, ["Head", "stiff"]),
    (MOTION + "stiffnessInterpolation", ["Head", 0.5, 0.2], none, ["HeadYaw", [0.5, 0.1], [0.2]]),
    (MOTION + "setAngles", ["Head", [0.1, 0.1], 0.5], none, ["Head", [0.1], 0.5]),
    (MOTION + "changeAngles", ["HeadYaw", 0.1, 0.5], none, ["HeadYaw", 0.1, 0.0]),
    (
        MOTION + "angleInterpolation",
        ["HeadYaw", [0.1, 0.0], [0.1, 0.2], True],
        none,
        ["HeadYaw", 0.1, -1.0, True],
    ),
    (MOTION + "angleInterpolationWithSpeed", ["Head", [0.1, 0.0], 0.5], none, ["Head", 0.1, 0.0]),
    (MOTION + "angleInterpolationBezier", [["HeadYaw"], [[0.2]], [[0.1]]], none, [["HeadYaw"], [[0.2]], 0.1]),
    (MOTION + "getAngles", ["Head", True], numbers(0.0, 0.0), ["Head"]),
    (MOTION + "getStiffnesses", ["Head"], numbers(1.0, 1.0), ["Tail"]),
    (
        MOTION + "getTransform",
        ["Torso", 0, True],
        numbers(*[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
        ["Torso", 3, True],
    ),
    (MOTION + "getPosition", ["Torso", 0, True], numbers(0, 0, 0, 0, 0, 0), ["Tail", 0, True]),
    (MOTION + "openHand", ["LHand"], none, ["LFoot"]),
    (MOTION + "closeHand", ["RHand"], none, ["Head"]),
    (MOTION + "getBodyNames", ["Head"], lambda v: v == ["HeadYaw", "HeadPitch"], ["Tail"]),
    (MOTION + "wbEnable", [True], none, ["yes"]),
    (MOTION + "wbFootState", ["Fixed", "Legs"], none, ["Firm", "Legs"]),
    (
        MOTION + "setTransforms",
        ["LArm", 0, [1.0, 0, 0, 0.1, 0, 1, 0, 0.1, 0, 0, 1, 0.1], 0.5, 7],
        none,
        ["LArm", 0, [1.0], 0.5, 7],
    ),
    (MOTION + "getSummary", [], lambda v: "HeadYaw" in v, [1]),
    (
        MOTION + "setMotionConfig",
        [[["ENABLE_FOOT_CONTACT_PROTECTION", True]]],
        none,
        [[["ENABLE_FOOT_CONTACT_PROTECTION", "yes"]]],
    ),
    (POSTURE + "goToPosture", ["StandInit", 0.5], true, ["Headstand", 0.5]),
    (POSTURE + "getPostureFamily", [], lambda v: v == "Standing", [1]),
    (MEMORY + "getData", [HEAD_KEY], lambda v: abs(v) < 0.01, ["no/such/key"]),
    (MEMORY + "insertData", ["Mine", [1, "two"]], none, [1, 2]),
    (MEMORY + "removeData", ["DCM/Mine"], none, ["Yours"]),
    (MEMORY + "raiseEvent", ["MyEvent", 1.0], none, [1, 2]),
    (MEMORY + "subscribeToEvent", ["MyEvent", "Me", "onEvent"], none, ["MyEvent"]),
    (MEMORY + "unsubscribeToEvent", ["MyEvent", "Me"], none, ["MyEvent", 1]),
    (VIDEO + "subscribeCamera", ["me", 0, 1, 11, 5], lambda v: v == "me_0", ["me", 2, 1, 11, 5]),
    (VIDEO + "getImageRemote", ["seen_0"], image, [0]),
    (VIDEO + "releaseImage", ["seen_0"], true, [1]),
    (VIDEO + "unsubscribe", ["nobody_0"], lambda v: v is False, [1]),
    (VIDEO + "setActiveCamera", [1], true, [7]),
    (LEDS + "fadeRGB", ["FaceLeds", "red", 0.1], none, ["NoseLeds", "red", 0.1]),
    (LEDS + "fade", ["FaceLeds", 0.5, 0.1], none, ["FaceLeds", 2.0, 0.1]),
    (LEDS + "on", ["FaceLeds"], none, ["NoseLeds"]),
    (LEDS + "reset", ["AllLeds"], none, ["NoseLeds"]),
    ("ALSonar.subscribe", ["me"], none, ["me", -1]),
    ("ALSonar.unsubscribe", ["me"], none, [1]),
    ("ALSpeechRecognition.setVocabulary", [["yes"], False], none, ["yes", False]),
    ("ALBehaviorManager.getInstalledBehaviors", [], lambda v: v == [], [1]),
    ("ALBehaviorManager.stopBehavior", ["dance"], none, [1]),
    ("ALBehaviorManager.isBehaviorRunning", ["dance"], lambda v: v is False, [1]),
    ("ALBehaviorManager.isBehaviorInstalled", ["dance"], lambda v: v is False, [1]),
    ("ALBehaviorManager.getRunningBehaviors", [], lambda v: v == [], [1]),
    ("ALAutonomousLife.setState", ["disabled"], none, ["asleep"]),
    ("ALBasicAwareness.stopAwareness", [], none, [1]),
    ("ALBattery.getBatteryCharge", [], lambda v: v == 90, [1]),
    ("ALAudioDevice.setOutputVolume", [50], none, [101]),
    (PLAYER + "playFile", ["/usr/share/naoqi/wav/a.wav"], none, [3]),
    (PLAYER + "loadFile", ["/usr/share/naoqi/wav/a.wav"], lambda v: type(v) is int, [1]),
    (PLAYER + "stopAll", [], none, [1]),
    (TRACKER + "registerTarget", ["RedBall", 0.06], none, ["RedBall", "big"]),
    (TRACKER + "track", ["RedBall"], none, [1]),
    (TRACKER + "stopTracker", [], none, [1]),
]


MOST_USED.sort(key=lambda row: row[2] in (none, true))  # what only reads comes first: they share a robot


@pytest.fixture(scope="module")
def robot() -> Robot:
    robot = Robot(standing_frame(), feed=Eyes())
    robot.call("ALMemory", "insertData", "DCM/Mine", 1)
    robot.call("ALVideoDevice", "subscribeCamera", "seen", 1, 1, 11, 30)
    return robot


@pytest.mark.parametrize(
    ("call", "arguments", "fits", "wrong"), MOST_USED, ids=[call for call, *_ in MOST_USED]
)
def test_a_method_returns_what_its_page_says_and_refuses_wrong_arguments(
    robot: Robot, call: str, arguments: list[Any], fits: Callable[[Any], bool], wrong: list[Any]
) -> None:
    """The refusal names the method or the wrong value."""
    service, method = call.split(".")
    value = robot.call(service, method, *arguments)
    assert fits(robot.wait(value, 20.0) if isinstance(value, Future) else value)
    with pytest.raises(NaoqiRefused) as refused:
        robot.call(service, method, *wrong)
    assert any(name in str(refused.value) for name in (method, *re.findall(r"[\w.-]+", str(wrong))))


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
