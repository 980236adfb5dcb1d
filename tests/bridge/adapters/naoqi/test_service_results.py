"""Methods of NAOqi's services: the shape and the unit of what they return, by the vendor's pages."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bridge.errors import NaoHilError, NaoqiRefused
from bridge.messages import SensorFrame
from tests.bridge.adapters.naoqi.served import TABLE, Robot, same
from tests.frames import standing_frame
from tests.loops import TIMEOUT


def is_list_of(kind: Any) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, list) and all(isinstance(item, kind) for item in value)


def is_a(kind: Any) -> Callable[[Any], bool]:
    return lambda value: type(value) is kind


NUMBERS, NAMES = is_list_of(float), is_list_of(str)


@pytest.mark.parametrize(
    ("call", "arguments", "fits"),
    [
        *((call, arguments, same(value)) for call, arguments, value in TABLE["results"]),
        (
            "ALMotion.getTransform",
            ["LArm", 0, True],
            lambda v: NUMBERS(v) and len(v) == 16 and v[12:] == [0, 0, 0, 1],
        ),
        ("ALMotion.getPosition", ["CameraTop", 2, False], lambda v: NUMBERS(v) and len(v) == 6),
        ("ALMotion.getCOM", ["Body", 0, False], lambda v: NUMBERS(v) and len(v) == 3),
        ("ALMotion.getMass", ["Body"], lambda v: 4.5 < v < 5.5),
        (
            "ALMotion.getSupportPolygon",
            [2, True],
            lambda v: all(NUMBERS(c) and len(c) == 2 for c in v) and len(v) > 3,
        ),
        (
            "ALMotion.getFootSteps",
            [],
            lambda v: v[1:] == [[], []] and v[0][0] == pytest.approx([0.0, 0.05, 0.0], abs=0.002),
        ),
        ("ALRobotPosture.getPostureFamilyList", [], lambda v: len(v) == 12 and "Crouching" in v),
        ("ALMemory.getData", ["Device/SubDeviceList/InertialSensor/AccZ/Sensor/Value"], is_a(float)),
        ("ALRobotPosture.getPostureList", [], lambda v: NAMES(v) and "Sit" in v),
        ("ALTextToSpeech.getAvailableLanguages", [], lambda v: NAMES(v) and "French" in v),
        ("ALMemory.getDataList", ["Battery/"], lambda v: NAMES(v) and len(v) >= 4),
        (
            "ALMemory.getTimestamp",
            ["DCM/Time"],
            lambda v: len(v) == 3 and v[1] > 1_600_000_000 and v[2] < 1_000_000,
        ),
        ("ALMemory.getData", ["leftFootTotalWeight"], lambda v: v == pytest.approx(2.0)),
        ("ALMemory.getData", ["WordRecognized"], lambda v: v[0] == "" and v[1] < 0.0),
        ("ALMemory.getEventList", [], lambda v: {"FrontTactilTouched", "SonarLeftDetected"} <= set(v)),
        ("ALMemory.getExtractorEvent", ["ALSonar"], lambda v: len(v) == 4),
        (
            "ALLeds.listGroups",
            [],
            lambda v: NAMES(v) and {"FaceLeds", "BrainLedsFront", "LeftFaceLed1"} <= set(v),
        ),
        ("ALLeds.listGroup", ["FaceLeds"], lambda v: len(v) == 48),
        ("ALLeds.listLEDs", [], NAMES),
        ("ALLeds.getIntensity", ["ChestLeds"], is_a(float)),
        ("ALSonar.getMemoryKeyList", [], lambda v: "Device/SubDeviceList/US/Left/Sensor/Value" in v),
        ("ALTouch.getStatus", [], lambda v: len(v) == 14 and v[1] == ["Head/Touch/Front", False]),
        ("ALSystem.systemVersion", [], lambda v: v.startswith("2.1")),
        ("ALLeds.listGroup", ["FaceLedsRightTop"], lambda v: len(v) == 6),
        ("ALLeds.listGroup", ["LeftEarLedsBack"], lambda v: len(v) == 5),
        ("ALVideoDevice.getHorizontalFOV", [0], lambda v: v == pytest.approx(math.radians(60.9))),
        ("ALVideoDevice.getVerticalFOV", [1], lambda v: v == pytest.approx(math.radians(47.6))),
        (
            "ALVideoDevice.getAngularPositionFromImagePosition",
            [0, [0.0, 1.0]],  # lower left corner: half the fields of view
            lambda v: v == pytest.approx([math.radians(30.45), math.radians(23.8)]),
        ),
        (
            "ALVideoDevice.getImagePositionFromAngularPosition",
            [0, [0.0, 0.0]],
            lambda v: v == pytest.approx([0.5, 0.5]),
        ),
        ("ALTracker.getSupportedTargets", [], lambda v: NAMES(v) and "RedBall" in v),
        ("ALConnectionManager.state", [], lambda v: v in ("online", "ready", "offline")),
        ("ALConnectionManager.service", ["ethernet_wired"], lambda v: dict(v)["Type"] == "ethernet"),
        ("ALSystem.freeMemory", [], lambda v: type(v) is int and 0 < v <= 1_000_000),
        ("ALSystem.diskFree", [True], lambda v: [type(part) for part in v[0]] == [str, str, int, int]),
        ("ALRobotModel.getConfigMap", [], lambda v: v["RobotConfig/Body/BaseVersion"] == "V50"),
        ("ALPeoplePerception.getMaximumDetectionRange", [], is_a(float)),
        ("ALTextToSpeech.getAvailableVoices", [], lambda v: NAMES(v) and "naoenu" in v),
    ],
)
def test_a_method_returns_what_its_page_says(
    robot: Robot, call: str, arguments: list[Any], fits: Callable[[Any], bool]
) -> None:
    value = robot.result(call, *arguments)
    assert fits(value), value


@pytest.mark.parametrize(("call", "arguments", "named"), TABLE["refusals"])
def test_a_refusal_names_what_is_wrong_or_what_would_be_right(
    robot: Robot, call: str, arguments: list[Any], named: str
) -> None:
    with pytest.raises(NaoHilError, match=named):
        robot.result(call, *arguments)


def test_a_said_text_takes_the_time_of_speech_and_raises_its_events_in_order(robot: Robot) -> None:
    """At 14 letters a second and speed 200: 28 letters last a second; a pause of 500 ms is added."""
    robot.call("ALTextToSpeech", "setParameter", "speed", 200)
    done = robot.call("ALTextToSpeech", "say", r"aaaaaa bbbbbb \pau=500\ cccccc dddddd")
    robot.run(1.4)
    assert not done.done()
    robot.run(0.3)
    assert done.result(0.0) is None
    names = [name.removeprefix("ALTextToSpeech/") for name, _ in robot.events]
    assert names[:3] == ["Status", "CurrentSentence", "TextStarted"]
    assert names[-2:] == ["TextDone", "Status"]
    words = [value for name, value in robot.events if name.endswith("CurrentWord") and "Position" not in name]
    assert words == ["aaaaaa", "bbbbbb", "cccccc", "dddddd"]
    assert robot.call("ALMemory", "getData", "ALTextToSpeech/Status")[1] == "done"


def test_a_part_rests_alone(robot: Robot) -> None:
    robot.motion("rest", "Head")
    robot.run(1.0)
    assert robot.motion("getStiffnesses", ["HeadYaw", "LKneePitch", "LElbowRoll"]) == [0.0, 1.0, 1.0]
    assert robot.motion("robotIsWakeUp") is True


def test_texts_are_said_one_after_the_other_and_stopped_together(robot: Robot) -> None:
    first, second = (robot.call("ALTextToSpeech", "say", "x" * 140) for _ in range(2))
    robot.run(1.0)
    robot.call("ALMotion", "killAll")  # stops motions, not speech
    robot.run(0.1)
    assert not first.done()
    robot.call("ALTextToSpeech", "stopAll")
    robot.run(0.2)
    assert first.done() and second.done()
    assert ("ALTextToSpeech/TextInterrupted", 1) in robot.events


def test_a_module_is_called_for_its_event_until_it_unsubscribes(robot: Robot) -> None:
    told: list[Any] = []
    robot.services.events._publish = lambda *event: told.append(event)
    robot.call("ALMemory", "subscribeToEvent", "MyEvent", "MyModule", "onEvent")
    assert robot.call("ALMemory", "getSubscribers", "MyEvent") == ["MyModule"]
    robot.call("ALMemory", "raiseEvent", "MyEvent", [1, "two"])
    robot.call("ALMemory", "unsubscribeToEvent", "MyEvent", "MyModule")
    robot.call("ALMemory", "raiseEvent", "MyEvent", 3)
    assert told == [("MyEvent", [1, "two"], [["MyModule", "onEvent", ""]]), ("MyEvent", 3, [])]
    assert [value for value, _ in robot.call("ALMemory", "getEventHistory", "MyEvent")] == [[1, "two"], 3]


def test_waiting_for_a_key_ends_with_its_next_value(robot: Robot) -> None:
    done = robot.call("ALMemory", "getDataOnChange", "Mine", 0)
    assert not done.done()
    robot.call("ALMemory", "insertData", "Mine", 5)
    assert done.result(0.0) == 5


def test_the_sonar_tells_near_things_to_its_subscribers_only(robot: Robot) -> None:
    robot.run(0.1)
    assert robot.events == []
    robot.call("ALSonar", "subscribe", "me", 500, 1.0)
    robot.run(0.1)
    assert dict(robot.events) == {"SonarLeftDetected": 0.5, "SonarRightNothingDetected": 0.6}
    robot.call("ALSonar", "unsubscribe", "me")
    robot.run(0.1, sonar=(2.0, 0.3))
    assert len(robot.events) == 2


def test_a_pressed_button_is_an_event(robot: Robot) -> None:
    robot.run(0.02, touch=(0.0, 1.0, *[0.0] * 12))
    assert robot.events == [("FrontTactilTouched", 1.0), ("TouchChanged", [["Head/Touch/Front", True]])]


def test_words_are_recognized_by_the_vocabulary_while_it_listens(robot: Robot) -> None:
    listen = "ALSpeechRecognition"
    robot.call(listen, "setVocabulary", ["yes", "no", "please"], False)
    assert robot.call("NaoHil", "hear", "yes") == []
    robot.call(listen, "subscribe", "me")
    assert robot.call("NaoHil", "hear", "Yes!") == ["yes"]
    assert robot.call("ALMemory", "getData", "WordRecognized")[0] == "yes"
    assert robot.call("NaoHil", "hear", "yes please") == []
    with pytest.raises(NaoqiRefused, match="pause"):
        robot.call(listen, "setVocabulary", ["stop"], True)
    robot.call(listen, "pause", True)
    robot.call(listen, "setVocabulary", ["stop"], True)
    robot.call(listen, "pause", False)
    assert robot.call("NaoHil", "hear", "now stop it") == ["stop"]
    assert robot.call("ALMemory", "getData", "WordRecognized")[0] == "<...> stop <...>"


def test_a_call_begun_with_post_is_waited_for_and_stopped_by_its_number(robot: Robot) -> None:
    key = robot.motion("pCall", ["angleInterpolation", "HeadYaw", 1.0, 2.0, True])
    robot.run(1.0)
    assert robot.motion("isRunning", key) is True
    ended = robot.motion("wait", key, 0)
    assert not ended.done()
    robot.motion("stop", key)
    robot.run(0.5)
    assert ended.result(0.0) is False
    assert robot.motion("isRunning", key) is False
    assert robot.angle("HeadYaw") == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [({"fsr": (0.0,) * 8}, "no foot touches the ground"), ({}, "stiffness of LHipYawPitch")],
)
def test_a_walk_begins_with_stiff_legs_on_the_ground_only(changes: dict[str, Any], sentence: str) -> None:
    robot = Robot(standing_frame(**changes), walks={"moveTo": lambda *_: "walks"})
    if not changes:
        robot.motion("setStiffnesses", "LLeg", 0.5)
        robot.run(0.05)
    with pytest.raises(NaoqiRefused, match=sentence):
        robot.motion("moveTo", 0.1, 0.0, 0.0)
    assert robot.motion("moveTo", 0.0, 0.0, 0.0) == "walks"  # no walk begins
    switched_off = [["ENABLE_FOOT_CONTACT_PROTECTION", False], ["ENABLE_STIFFNESS_PROTECTION", 0]]
    robot.motion("setMotionConfig", [*switched_off, ["ENABLE_DISACTIVATION_OF_FALL_MANAGER", True]])
    assert robot.motion("moveTo", 0.1, 0.0, 0.0) == "walks"


def test_what_is_sent_follows_the_robot_while_another_moves_it(robot: Robot) -> None:
    """`Position/Actuator/Value` of joints that a walker has: the serving process holds them cycle by cycle."""
    position = list(robot.frame.position)
    position[0] = 0.4
    robot.run(0.05)
    frame = SensorFrame(
        **{f: getattr(robot.frame, f) for f in robot.frame.__struct_fields__}
        | {"seq": robot.frame.seq + 1, "position": tuple(position)}
    )
    robot.services.cycle(frame)
    robot.services.joints.hold()
    key = "Device/SubDeviceList/HeadYaw/Position/Actuator/Value"
    assert robot.call("ALMemory", "getData", key) == pytest.approx(0.4, abs=1e-4)


def test_the_robot_s_home_is_a_folder_for_recordings(tmp_path: Path) -> None:
    """Programs record to the folder that the vendor's samples name, and play from there."""
    home = tmp_path / "home"
    robot, path = Robot(home=home), "/home/nao/recordings/microphones/heard.wav"
    robot.call("ALAudioRecorder", "startMicrophonesRecording", path, "wav", 16000, [0, 0, 1, 0])
    robot.run(0.5)
    robot.call("ALAudioRecorder", "stopMicrophonesRecording").result(TIMEOUT)
    assert (home / "recordings/microphones/heard.wav").is_file()
    key = robot.call("ALAudioPlayer", "loadFile", path).result(TIMEOUT)
    assert robot.call("ALAudioPlayer", "getFileLength", key) == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize(
    "path",
    [
        *("/tmp/heard.wav", "heard.wav", "/home/nao", "/home/nao/../heard.wav", "/home/nao/a/../../b.wav"),
        *("/home/nao/link/heard.wav", "/home/nao/pipe", "/home/nao/folder", "/home/nao/\0", "/home/nao2/a.wav"),
    ],
)
def test_a_program_writes_below_the_robot_s_home_only(tmp_path: Path, path: str) -> None:
    home, outside = tmp_path / "home", tmp_path / "outside"
    outside.mkdir()
    (home / "folder").mkdir(parents=True)
    (home / "link").symlink_to(outside)
    os.mkfifo(home / "pipe")
    robot = Robot(home=home)
    folder, name = path.rpartition("/")[::2]
    for call, arguments in (
        ("ALAudioRecorder.startMicrophonesRecording", [path, "wav", 16000, [0, 0, 1, 0]]),
        ("ALAudioDevice.startMicrophonesRecording", [path]),
        ("ALTextToSpeech.sayToFile", ["hello", path]),
        *([("ALVideoRecorder.startRecording", [folder, name])] if name.endswith(".wav") else []),
        *([("ALPhotoCapture.takePicture", [folder, name])] if name.endswith(".wav") else []),
    ):
        with pytest.raises(NaoqiRefused, match=r"is outside the robot's home|is no file that can be written"):
            robot.call(*call.split("."), *arguments)
    assert not any(outside.iterdir())


def test_the_robot_s_home_has_two_names(tmp_path: Path) -> None:
    """A script on the robot's machine has the folder's own name for it."""
    robot = Robot(home=tmp_path / "home")
    home = robot.call("NaoHil", "home")
    assert Path(home).is_dir()
    for folder in ("/home/nao", home):
        robot.call("ALAudioDevice", "startMicrophonesRecording", f"{folder}/sounds/heard.wav")
        robot.run(0.1)
        robot.call("ALAudioDevice", "stopMicrophonesRecording").result(TIMEOUT)
        (Path(home) / "sounds" / "heard.wav").unlink()


@pytest.mark.parametrize(
    ("call", "refused"),
    [
        ("ALDialog.loadTopic", "is a device or a pipe"),
        ("ALSpeechRecognition.loadVocabulary", "is a device or a pipe"),
        ("ALAudioPlayer.loadFile", ""),
        ("ALAudioPlayer.playFile", ""),
    ],
)
def test_no_call_waits_for_a_pipe(robot: Robot, tmp_path: Path, call: str, refused: str) -> None:
    os.mkfifo(tmp_path / "pipe")
    done = robot.call(*call.split("."), str(tmp_path / "pipe"))
    if refused:
        with pytest.raises(NaoHilError, match=refused):
            robot.wait(done)
    else:
        robot.wait(done)


def test_a_file_that_is_slow_to_read_delays_no_other_call(
    robot: Robot, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """As on a file system of the network that does not answer: the reader waits, without the lock."""
    answered, reads = threading.Event(), threading.Event()

    def slow(*_: Any) -> bytes:
        reads.set()
        answered.wait(TIMEOUT)
        return b"topic: ~slow()\nlanguage: enu\nu: (hello) hello\n"

    monkeypatch.setattr("bridge.adapters.naoqi.interaction.dialog.read_limited", slow)
    loading = robot.call("ALDialog", "loadTopic", str(tmp_path / "slow.top"))
    assert reads.wait(TIMEOUT)
    robot.run(0.05)
    assert robot.call("ALDialog", "getAllLoadedTopics") == []
    answered.set()
    assert loading.result(TIMEOUT) == "slow"


def test_a_file_that_is_never_read_delays_no_end() -> None:
    """A Ctrl-C ends the server also then."""
    waiting = "import bridge.adapters.naoqi.robot_files as f, time; f.in_thread(lambda: time.sleep(3600))"
    assert subprocess.run([sys.executable, "-c", waiting], timeout=TIMEOUT, check=False).returncode == 0


def test_a_large_vocabulary_and_a_long_utterance_take_no_long_time(robot: Robot) -> None:
    robot.call("ALSpeechRecognition", "setVocabulary", [f"word{i}" for i in range(10_000)], True)
    robot.call("ALSpeechRecognition", "subscribe", "me")
    began = time.process_time()
    assert robot.call("NaoHil", "hear", "word5 " * 20_000) == ["word5"]
    assert time.process_time() - began < 2.0
    assert robot.call("NaoHil", "hear", "sword5 word55") == ["word55"]
