"""Methods of NAOqi's services: the shape and the unit of what they return, by the vendor's pages."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import pytest

from bridge.errors import NaoHilError, NaoqiRefused
from bridge.messages import SensorFrame
from tests.bridge.adapters.naoqi.served import Robot
from tests.loops import TIMEOUT


@pytest.fixture
def robot(standing: Callable[..., SensorFrame]) -> Robot:
    return Robot(standing())


def is_list_of(kind: Any) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, list) and all(isinstance(item, kind) for item in value)


def is_a(kind: Any) -> Callable[[Any], bool]:
    return lambda value: type(value) is kind


NUMBERS, NAMES = is_list_of(float), is_list_of(str)


@pytest.mark.parametrize(
    ("call", "arguments", "fits"),
    [
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
        ("ALMotion.getMotionCycleTime", [], lambda v: v == 20),
        ("ALMotion.getTaskList", [], lambda v: v == []),
        ("ALRobotPosture.getPosture", [], lambda v: v == "StandInit"),
        ("ALRobotPosture.getPostureFamilyList", [], lambda v: len(v) == 12 and "Crouching" in v),
        ("ALMotion.isCollision", ["LArm"], lambda v: v == "none"),
        ("ALMemory.getData", ["SoundDetected", 0], lambda v: v == []),
        ("ALAudioDevice.getFrontMicEnergy", [], lambda v: v == 0.0),
        ("ALVideoDevice.getParam", [18], lambda v: v == 0),
        ("ALMemory.getData", ["Device/SubDeviceList/InertialSensor/AccZ/Sensor/Value"], is_a(float)),
        ("ALRobotPosture.getPostureList", [], lambda v: NAMES(v) and "Sit" in v),
        ("ALTextToSpeech.getLanguage", [], lambda v: v == "English"),
        ("ALTextToSpeech.getAvailableLanguages", [], lambda v: NAMES(v) and "French" in v),
        ("ALTextToSpeech.getVolume", [], lambda v: v == 1.0),
        ("ALTextToSpeech.getParameter", ["speed"], lambda v: v == 100.0),
        ("ALAnimatedSpeech.getBodyLanguageMode", [], lambda v: v == 2),
        ("ALAnimatedSpeech.getBodyLanguageModeToStr", [], lambda v: v == "contextual"),
        ("ALMemory.getDataList", ["Battery/"], lambda v: NAMES(v) and len(v) >= 4),
        (
            "ALMemory.getTimestamp",
            ["DCM/Time"],
            lambda v: len(v) == 3 and v[1] > 1_600_000_000 and v[2] < 1_000_000,
        ),
        ("ALMemory.getData", ["footContact"], lambda v: v == 1.0),
        ("ALMemory.getData", ["leftFootTotalWeight"], lambda v: v == pytest.approx(2.0)),
        ("ALMemory.getData", ["WordRecognized"], lambda v: v[0] == "" and v[1] < 0.0),
        ("ALMemory.getData", ["FaceDetected"], lambda v: v == []),
        ("ALMemory.getData", ["BatteryChargeChanged"], lambda v: v == 90),
        ("ALMemory.getData", ["PostureFamilyChanged"], lambda v: v == "Standing"),
        ("ALMemory.getData", ["TouchChanged"], lambda v: v == []),
        ("ALMemory.getEventList", [], lambda v: {"FrontTactilTouched", "SonarLeftDetected"} <= set(v)),
        ("ALMemory.getExtractorEvent", ["ALSonar"], lambda v: len(v) == 4),
        ("ALMemory.getSubscribers", ["TouchChanged"], lambda v: v == []),
        (
            "ALLeds.listGroups",
            [],
            lambda v: NAMES(v) and {"FaceLeds", "BrainLedsFront", "LeftFaceLed1"} <= set(v),
        ),
        ("ALLeds.listGroup", ["FaceLeds"], lambda v: len(v) == 48),
        ("ALLeds.listLEDs", [], NAMES),
        ("ALLeds.getIntensity", ["ChestLeds"], is_a(float)),
        ("ALSonar.getSubscribersInfo", [], lambda v: v == []),
        ("ALSonar.getMemoryKeyList", [], lambda v: "Device/SubDeviceList/US/Left/Sensor/Value" in v),
        ("ALTouch.getStatus", [], lambda v: len(v) == 14 and v[1] == ["Head/Touch/Front", False]),
        ("ALBodyTemperature.getTemperatureDiagnosis", [], lambda v: v == []),
        ("ALRobotModel.getRobotType", [], lambda v: v == "Nao"),
        ("ALSystem.systemVersion", [], lambda v: v.startswith("2.1")),
        ("ALSystem.robotName", [], lambda v: v == "nao"),
        ("ALAutonomousLife.getState", [], lambda v: v == "disabled"),
        ("ALMemory.getData", ["AutonomousLife/State"], lambda v: v == "disabled"),
        ("ALLeds.listGroup", ["FaceLedsRightTop"], lambda v: len(v) == 6),
        ("ALLeds.listGroup", ["LeftEarLedsBack"], lambda v: len(v) == 5),
        ("ALBasicAwareness.isEnabled", [], lambda v: v is False),
        ("ALBasicAwareness.getTrackingMode", [], lambda v: v == "Head"),
        ("ALSpeechRecognition.getLanguage", [], lambda v: v == "English"),
        ("ALFaceDetection.getLearnedFacesList", [], lambda v: v == []),
        ("ALFaceDetection.learnFace", ["nobody"], lambda v: v is False),
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
        ("ALVideoDevice.getParameter", [0, 99], lambda v: v == 233493508),
        ("ALTracker.getTargetPosition", [0], lambda v: v == []),
        ("ALTracker.getSupportedTargets", [], lambda v: NAMES(v) and "RedBall" in v),
        ("ALTracker.isActive", [], lambda v: v is False),
        ("ALTracker.isTargetLost", [], lambda v: v is True),
        ("ALAudioDevice.getOutputVolume", [], lambda v: v == 100),
        ("ALAudioPlayer.getMasterVolume", [], lambda v: v == 1.0),
        ("ALPhotoCapture.getCaptureInterval", [], lambda v: v == 200),  # ms: five pictures a second
        ("ALPhotoCapture.halfPress", [], lambda v: v is True),
        ("ALPhotoCapture.isHalfPressEnabled", [], lambda v: v is False),
        ("ALVideoRecorder.isRecording", [], lambda v: v is False),
        ("ALVideoRecorder.getVideoFormat", [], lambda v: v == "MJPG"),
        ("ALNavigation.getSecurityDistance", [], lambda v: v == 0.4),  # m
        ("ALVisualCompass.setCurrentImageAsReference", [], lambda v: v is True),
        ("ALConnectionManager.state", [], lambda v: v in ("online", "ready", "offline")),
        ("ALConnectionManager.service", ["ethernet_wired"], lambda v: dict(v)["Type"] == "ethernet"),
        ("ALConnectionManager.getTetheringEnable", ["wifi"], lambda v: v is False),
        ("ALSystem.freeMemory", [], lambda v: type(v) is int and 0 < v <= 1_000_000),  # kB
        ("ALSystem.diskFree", [True], lambda v: [type(part) for part in v[0]] == [str, str, int, int]),
        ("ALRobotModel.getConfigMap", [], lambda v: v["RobotConfig/Body/BaseVersion"] == "V50"),
        ("ALMotion.getUsage", ["getAngles"], lambda v: v == "ALMotion.getAngles(names, useSensors)"),
        ("ALMotion.getUsage", ["openHand"], lambda v: v == "ALMotion.openHand(name)"),
        ("ALDialog.getAllLoadedTopics", [], lambda v: v == []),
        ("ALPeoplePerception.getMaximumDetectionRange", [], is_a(float)),
        ("ALMemory.getData", ["BarcodeReader/BarcodeDetected"], lambda v: v == []),
        ("ALTextToSpeech.getAvailableVoices", [], lambda v: NAMES(v) and "naoenu" in v),
    ],
)
def test_a_method_returns_what_its_page_says(
    robot: Robot, call: str, arguments: list[Any], fits: Callable[[Any], bool]
) -> None:
    service, method = call.split(".")
    value = robot.call(service, method, *arguments)
    assert fits(robot.wait(value) if isinstance(value, Future) else value), value


@pytest.mark.parametrize(
    ("call", "arguments", "sentence"),
    [
        ("ALMotion.getPosition", ["LArm", 7, True], "space 7"),
        ("ALMotion.setPositions", ["Nose", 0, [0.0] * 6, 0.5, 7], "'Nose'"),
        ("ALMotion.setPositions", ["LArm", 0, [0.0] * 5, 0.5, 7], "6"),
        ("ALMotion.setTransforms", ["LArm", 0, [0.0] * 12, 0.5, 7], "rotation"),
        ("ALMotion.positionInterpolations", ["LArm", 0, [[0.1] * 6], 7, [-1.0]], "times"),
        ("ALMotion.setMotionConfig", [[["ENABLE_FOOT_CONTACT", True]]], "ENABLE_FOOT_CONTACT_PROTECTION"),
        ("ALTextToSpeech.setParameter", ["speed", 1000], "50.*400"),
        ("ALAutonomousLife.getActivityNature", ["a/."], "activity"),
        ("ALTracker.track", ["Face"], "Face"),
        ("ALTracker.setMode", ["Feet"], "'Feet'"),
        ("ALVideoDevice.subscribeCamera", ["me", 0, 5, 11, 10], "resolution 5"),
        ("ALVideoDevice.subscribeCamera", ["me", 0, 1, {}, 10], "space"),
        ("ALVideoDevice.subscribeCamera", ["me", 0, [1], 11, 10], "resolution"),
        (
            "ALAudioRecorder.startMicrophonesRecording",
            ["/home/nao/heard.wav", "wav", [16000], [0, 0, 1, 0]],
            "16000",
        ),
        ("ALAudioDevice.startMicrophonesRecording", ["heard.wav"], "/home/nao"),
        ("ALNavigation.explore", [1.0], "explore"),
        ("ALPhotoCapture.setResolution", [3], "0, 1, 2"),
        ("ALPhotoCapture.setPictureFormat", ["gif"], "'gif'"),
        ("ALPhotoCapture.takePicture", ["pictures", "one"], "/home/nao"),
        ("ALVideoRecorder.setVideoFormat", ["IYUV"], "MJPG"),
        ("ALVideoRecorder.setFrameRate", [2], "3.*30"),  # MJPG needs more than 2 a second
        ("ALVideoRecorder.stopRecording", [], "stopRecording"),
        ("ALConnectionManager.service", ["wifi_1"], "ethernet_wired"),
        ("ALConnectionManager.connect", ["wifi_1"], "connect"),
        ("ALDialog.loadTopic", ["/nothing.top"], "/nothing.top"),
        ("ALDialog.loadTopicContent", ["u: (hello) hello"], "topic: ~name"),
        ("ALDialog.activateTopic", ["greeting"], "'greeting'"),
        ("ALDialog.tell", ["hi"], "forceInput"),
        ("ALMotion.getMethodHelp", ["setAngels"], "'setAngles'"),
        ("ALTextToSpeech.setVoice", ["Nobody"], "'Nobody'"),
    ],
)
def test_an_error_says_what_is_wrong_and_what_would_be_right(
    robot: Robot, call: str, arguments: list[Any], sentence: str
) -> None:
    with pytest.raises(NaoHilError, match=sentence):
        robot.wait(robot.call(*call.split("."), *arguments))


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
def test_a_walk_begins_with_stiff_legs_on_the_ground_only(
    changes: dict[str, Any], sentence: str, standing: Callable[..., SensorFrame]
) -> None:
    robot = Robot(standing(**changes), walks={"moveTo": lambda *_: "walks"})
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


def test_the_robot_s_home_is_a_folder_for_recordings(
    standing: Callable[..., SensorFrame], tmp_path: Path
) -> None:
    """Programs record to the folder that the vendor's samples name, and play from there."""
    home = tmp_path / "home"
    robot, path = Robot(standing(), home=home), "/home/nao/recordings/microphones/heard.wav"
    robot.call("ALAudioRecorder", "startMicrophonesRecording", path, "wav", 16000, [0, 0, 1, 0])
    robot.run(0.5)
    robot.call("ALAudioRecorder", "stopMicrophonesRecording").result(10.0)
    assert (home / "recordings/microphones/heard.wav").is_file()
    key = robot.call("ALAudioPlayer", "loadFile", path).result(10.0)
    assert robot.call("ALAudioPlayer", "getFileLength", key) == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize(
    "path",
    [
        *("/tmp/heard.wav", "heard.wav", "/home/nao", "/home/nao/../heard.wav", "/home/nao/a/../../b.wav"),
        *("/home/nao/link/heard.wav", "/home/nao/pipe", "/home/nao/folder", "/home/nao/\0", "/home/nao2/a.wav"),
    ],
)
def test_a_program_writes_below_the_robot_s_home_only(
    standing: Callable[..., SensorFrame], tmp_path: Path, path: str
) -> None:
    home, outside = tmp_path / "home", tmp_path / "outside"
    outside.mkdir()
    (home / "folder").mkdir(parents=True)
    (home / "link").symlink_to(outside)
    os.mkfifo(home / "pipe")
    robot = Robot(standing(), home=home)
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


def test_the_robot_s_home_has_two_names(standing: Callable[..., SensorFrame], tmp_path: Path) -> None:
    """A script on the robot's machine has the folder's own name for it."""
    robot = Robot(standing(), home=tmp_path / "home")
    home = robot.call("NaoHil", "home")
    assert Path(home).is_dir()
    for folder in ("/home/nao", home):
        robot.call("ALAudioDevice", "startMicrophonesRecording", f"{folder}/sounds/heard.wav")
        robot.run(0.1)
        robot.call("ALAudioDevice", "stopMicrophonesRecording").result(10.0)
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
