"""The methods that programs call most (counted in forty public repositories): results, and errors."""

from __future__ import annotations

import math
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
MOST_USED: list[tuple[str, list[Any], Callable[[Any], bool], list[Any], str]] = [
    # method, arguments, what fits its result, wrong arguments, the sentence for these
    (SPEECH + "say", ["Hi"], none, [[1]], "a name is expected"),
    (SPEECH + "setLanguage", ["French"], none, ["Klingon"], "unknown language"),
    (SPEECH + "setVolume", [0.5], none, [50], "from 0 to 1"),
    (SPEECH + "setParameter", ["speed", 90.0], none, ["loudness", 1.0], "unknown parameter"),
    (SPEECH + "stopAll", [], none, [1], "1 arguments do not fit"),
    (
        "ALAnimatedSpeech.say",
        ["Hi", {"bodyLanguageMode": "disabled"}],
        none,
        ["Hi", {"bodyLanguageMode": "x"}],
        "no mode",
    ),
    (MOTION + "wakeUp", [], none, [1], "do not fit"),
    (MOTION + "rest", [], none, ["Nose"], "unknown joint or chain 'Nose'"),
    (MOTION + "setStiffnesses", ["Head", 0.5], none, ["Head", 2.0], "from -1 to 1"),
    (
        MOTION + "stiffnessInterpolation",
        ["Head", 0.5, 0.2],
        none,
        ["HeadYaw", [0.5, 0.1], [0.2]],
        "one time for each",
    ),
    (MOTION + "setAngles", ["Head", [0.1, 0.1], 0.5], none, ["Head", [0.1], 0.5], "1 entries for 2 joints"),
    (MOTION + "changeAngles", ["HeadYaw", 0.1, 0.5], none, ["HeadYaw", 0.1, 2.0], "from 0 to 1"),
    (
        MOTION + "angleInterpolation",
        ["HeadYaw", [0.1, 0.0], [0.1, 0.2], True],
        none,
        ["HeadYaw", 0.1, -1.0, True],
        "increasing",
    ),
    (MOTION + "angleInterpolationWithSpeed", ["Head", [0.1, 0.0], 0.5], none, ["Head", 0.1, 0.0], "above 0"),
    (
        MOTION + "angleInterpolationBezier",
        [["HeadYaw"], [[0.2]], [[0.1]]],
        none,
        [["HeadYaw"], [[0.2]], 0.1],
        "a list of lists",
    ),
    (MOTION + "getAngles", ["Head", True], numbers(0.0, 0.0), ["Head"], "1 arguments do not fit"),
    (MOTION + "getStiffnesses", ["Head"], numbers(1.0, 1.0), ["Tail"], "unknown joint or chain 'Tail'"),
    (
        MOTION + "getTransform",
        ["Torso", 0, True],
        numbers(*[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
        ["Torso", 3, True],
        "space 3",
    ),
    (
        MOTION + "getPosition",
        ["Torso", 0, True],
        numbers(0, 0, 0, 0, 0, 0),
        ["Tail", 0, True],
        "'Tail' has no frame",
    ),
    (MOTION + "openHand", ["LHand"], none, ["LFoot"], "no hand"),
    (MOTION + "closeHand", ["RHand"], none, ["Head"], "no hand"),
    (
        MOTION + "getBodyNames",
        ["Head"],
        lambda v: v == ["HeadYaw", "HeadPitch"],
        ["Tail"],
        "unknown joint or chain 'Tail'",
    ),
    (MOTION + "wbEnable", [True], none, ["yes"], "True or False"),
    (MOTION + "wbFootState", ["Fixed", "Legs"], none, ["Firm", "Legs"], "unknown state 'Firm'"),
    (
        MOTION + "setTransforms",
        ["LArm", 0, [1.0, 0, 0, 0.1, 0, 1, 0, 0.1, 0, 0, 1, 0.1], 0.5, 7],
        none,
        ["LArm", 0, [1.0], 0.5, 7],
        "12 or 16",
    ),
    (MOTION + "getSummary", [], lambda v: "HeadYaw" in v, [1], "do not fit"),
    (
        MOTION + "setMotionConfig",
        [[["ENABLE_FOOT_CONTACT_PROTECTION", True]]],
        none,
        [[["ENABLE_FOOT_CONTACT_PROTECTION", "yes"]]],
        "True or False",
    ),
    (POSTURE + "goToPosture", ["StandInit", 0.5], true, ["Headstand", 0.5], "'Headstand' is no posture"),
    (POSTURE + "getPostureFamily", [], lambda v: v == "Standing", [1], "do not fit"),
    (MEMORY + "getData", [HEAD_KEY], lambda v: abs(v) < 0.01, ["no/such/key"], "there is no data under"),
    (MEMORY + "insertData", ["Mine", [1, "two"]], none, [1, 2], "1"),
    (MEMORY + "removeData", ["DCM/Mine"], none, ["Yours"], "no inserted data"),
    (MEMORY + "raiseEvent", ["MyEvent", 1.0], none, [1, 2], "cannot be an event"),
    (MEMORY + "subscribeToEvent", ["MyEvent", "Me", "onEvent"], none, ["MyEvent"], "do not fit|takes"),
    (MEMORY + "unsubscribeToEvent", ["MyEvent", "Me"], none, ["MyEvent", 1], "a name is expected"),
    (
        VIDEO + "subscribeCamera",
        ["me", 0, 1, 11, 5],
        lambda v: v == "me_0",
        ["me", 2, 1, 11, 5],
        "camera 2 is not there",
    ),
    (VIDEO + "getImageRemote", ["seen_0"], image, ["nobody_0"], "nobody subscribed as 'nobody_0'"),
    (VIDEO + "releaseImage", ["seen_0"], true, [1], "a name is expected"),
    (VIDEO + "unsubscribe", ["nobody_0"], lambda v: v is False, [1], "a name is expected"),
    (VIDEO + "setActiveCamera", [1], true, [7], "camera 7 is not there"),
    (LEDS + "fadeRGB", ["FaceLeds", "red", 0.1], none, ["NoseLeds", "red", 0.1], "NoseLeds"),
    (LEDS + "fade", ["FaceLeds", 0.5, 0.1], none, ["FaceLeds", 2.0, 0.1], "from 0 to 1"),
    (LEDS + "on", ["FaceLeds"], none, ["NoseLeds"], "NoseLeds"),
    (LEDS + "reset", ["AllLeds"], none, ["NoseLeds"], "NoseLeds"),
    ("ALSonar.subscribe", ["me"], none, ["me", -1], "period"),
    ("ALSonar.unsubscribe", ["me"], none, [1], "a name is expected"),
    ("ALSpeechRecognition.setVocabulary", [["yes"], False], none, ["yes", False], "a list of words"),
    ("ALBehaviorManager.getInstalledBehaviors", [], lambda v: v == [], [1], "do not fit"),
    ("ALBehaviorManager.stopBehavior", ["dance"], none, [1], "a name is expected"),
    ("ALBehaviorManager.isBehaviorRunning", ["dance"], lambda v: v is False, [1], "a name is expected"),
    ("ALBehaviorManager.isBehaviorInstalled", ["dance"], lambda v: v is False, [1], "a name is expected"),
    ("ALBehaviorManager.getRunningBehaviors", [], lambda v: v == [], [1], "do not fit"),
    ("ALAutonomousLife.setState", ["disabled"], none, ["asleep"], "unknown state"),
    ("ALBasicAwareness.stopAwareness", [], none, [1], "do not fit"),
    ("ALBattery.getBatteryCharge", [], lambda v: v == 90, [1], "do not fit"),
    ("ALAudioDevice.setOutputVolume", [50], none, [101], "from 0 to 100"),
    (PLAYER + "playFile", ["/usr/share/naoqi/wav/a.wav"], none, ["/no.wav"], "cannot be read"),
    (PLAYER + "loadFile", ["/usr/share/naoqi/wav/a.wav"], lambda v: type(v) is int, [1], "a name is expected"),
    (PLAYER + "stopAll", [], none, [1], "do not fit"),
    (TRACKER + "registerTarget", ["RedBall", 0.06], none, ["RedBall", "big"], "RedBall|number"),
    (TRACKER + "track", ["RedBall"], none, [1], "a name is expected"),
    (TRACKER + "stopTracker", [], none, [1], "do not fit"),
]


MOST_USED.sort(key=lambda row: row[2] in (none, true))  # what only reads comes first: they share a robot


@pytest.fixture(scope="module")
def robot() -> Robot:
    robot = Robot(standing_frame(), eyes=Eyes())
    robot.call("ALMemory", "insertData", "DCM/Mine", 1)
    robot.call("ALVideoDevice", "subscribeCamera", "seen", 1, 1, 11, 30)
    return robot


@pytest.mark.parametrize(
    ("call", "arguments", "fits", "wrong", "sentence"), MOST_USED, ids=[call for call, *_ in MOST_USED]
)
def test_a_method_returns_what_its_page_says_and_refuses_wrong_arguments(
    robot: Robot,
    call: str,
    arguments: list[Any],
    fits: Callable[[Any], bool],
    wrong: list[Any],
    sentence: str,
) -> None:
    service, method = call.split(".")
    value = robot.call(service, method, *arguments)
    assert fits(robot.wait(value, 20.0) if isinstance(value, Future) else value)
    with pytest.raises(NaoqiRefused, match=sentence):
        robot.call(service, method, *wrong)


def test_a_loop_of_sound_lasts_until_it_is_stopped_and_a_sound_as_long_as_it_is(robot: Robot) -> None:
    """Seconds; both wait for the end, and give nothing."""
    looped = robot.call("ALAudioPlayer", "playFileInLoop", "/usr/share/naoqi/wav/a.wav")
    robot.run(20.0)
    assert not looped.done()
    robot.call("ALAudioPlayer", "stopAll")
    assert robot.wait(looped) is None
    key = robot.call("ALAudioPlayer", "loadFile", "/usr/share/naoqi/wav/a.wav")
    played = robot.call("ALAudioPlayer", "play", key)
    robot.run(0.5 * robot.call("ALAudioPlayer", "getFileLength", key))
    assert not played.done()
    assert robot.wait(played, 20.0) is None
    for method in ("playFileInLoop", "play"):
        with pytest.raises(NaoqiRefused):
            robot.call("ALAudioPlayer", method, "/no.wav" if method == "playFileInLoop" else 10_000)


def test_a_blocking_call_takes_its_time_and_ends_where_it_was_sent(robot: Robot) -> None:
    """Radians and seconds."""
    robot.motion("setStiffnesses", "Head", 1.0)
    done = robot.motion(
        "angleInterpolation", ["HeadYaw", "HeadPitch"], [0.5, math.radians(10)], [1.0, 2.0], True
    )
    robot.run(1.9)
    assert not done.done()
    robot.run(0.2)
    assert done.result(0.0) is None
    assert robot.motion("getAngles", "Head", True) == pytest.approx([0.5, math.radians(10)], abs=1e-3)
