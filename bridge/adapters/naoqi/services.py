"""The services of a served robot: a table of their methods, and the calls of them."""

from __future__ import annotations

import itertools
import logging
import re
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from functools import partial
from threading import RLock
from typing import Any

from bridge.adapters.naoqi.arguments import text
from bridge.adapters.naoqi.core.breathing import Breathing
from bridge.adapters.naoqi.core.cameras import Eyes, NoEyes
from bridge.adapters.naoqi.core.cartesian import Cartesian
from bridge.adapters.naoqi.core.frames import LinkFrames, RobotFrames
from bridge.adapters.naoqi.core.joint_motion import JointMotion
from bridge.adapters.naoqi.core.joints import Joints, dcm_methods, moved_joints
from bridge.adapters.naoqi.core.memory import Events, Memory, Publish
from bridge.adapters.naoqi.core.motion_tasks import MotionTasks, Posts
from bridge.adapters.naoqi.core.navigation import VisualCompass, navigation_methods
from bridge.adapters.naoqi.core.postures import Postures
from bridge.adapters.naoqi.core.protection import (
    BEGINNING,
    ArmProtection,
    FallManager,
    WalkProtection,
    stays_stiff,
)
from bridge.adapters.naoqi.core.robot_facts import RobotConfig, system_services
from bridge.adapters.naoqi.core.sensing import (
    QUIET,
    QUIET_VISION,
    Extractor,
    RobotEvents,
    Sonar,
    VisionExtractor,
    sensing_services,
)
from bridge.adapters.naoqi.core.upper_body import UpperBodyShare
from bridge.adapters.naoqi.core.video import VideoDevice
from bridge.adapters.naoqi.core.walking import WalkingMethods
from bridge.adapters.naoqi.core.whole_body import WholeBody
from bridge.adapters.naoqi.inert_settings import MOTION, SETTINGS, InertSettings
from bridge.adapters.naoqi.interaction.animations import GESTURE_CHAINS, Animations
from bridge.adapters.naoqi.interaction.audio import AudioPlayer, Microphones, Recorder
from bridge.adapters.naoqi.interaction.autonomy import AutonomousLife, Awareness
from bridge.adapters.naoqi.interaction.detection import Detection, Faces, LandMarks, Stage
from bridge.adapters.naoqi.interaction.dialog import Dialog
from bridge.adapters.naoqi.interaction.hearing import SpeechRecognition
from bridge.adapters.naoqi.interaction.leds import Leds
from bridge.adapters.naoqi.interaction.photos import PhotoCapture, VideoRecorder
from bridge.adapters.naoqi.interaction.speech import Speech
from bridge.adapters.naoqi.interaction.tracker import Following, Tracker
from bridge.adapters.naoqi.methods import VENDOR, Method, Table, of_kind, refusals
from bridge.body import Body
from bridge.errors import NaoHilError, NaoqiRefused
from bridge.messages import SensorFrame
from bridge.validation import unknown_name

logger = logging.getLogger(__name__)

STAGE = "NaoHil"
"""Service that the vendor does not have: what is around the robot."""
_MOVES = {"lookAt": ["Head"], "startTracker": ["Head"]}
_MOVES |= {m: list(GESTURE_CHAINS) for m in ("run", "runTag", "runBehavior", "startBehavior")}
"""What methods move whose first argument is no name of a joint."""


class Services:
    """All services of one robot, from its first frame on.

    Args:
        config: facts about the robot.
        frame: its first one.
        lock: held while joints and memory are touched.
        walking: walks, and hands the joints back and forth.
        links: forward kinematics of a body.
        require_lease: raises `NaoHilError` unless the joints may be commanded.
        commanded: called, with the lock held, when a call may have changed the joints' commands.
        publish: called for each event of ALMemory.
        eyes: its cameras.
    """

    def __init__(
        self,
        config: RobotConfig,
        frame: SensorFrame,
        lock: RLock,
        walking: WalkingMethods,
        links: Callable[[Body], LinkFrames],
        require_lease: Callable[[], None],
        commanded: Callable[[], None],
        publish: Publish,
        eyes: Eyes | None = None,
    ) -> None:
        self._config, self._lock, self.handover = config, lock, walking.handover
        self._require_lease, self._commanded = require_lease, commanded
        self.joints = Joints(config.body, frame)
        numbers = self._numbers = itertools.count(1)
        self._tasks, self._others = MotionTasks(numbers), MotionTasks(numbers)
        """Motions of joints; and all else that takes time, which a stop of all motions leaves alone."""
        self.motion = JointMotion(self.joints, self._tasks, config)
        self.upper_body = UpperBodyShare(self.joints)
        self._posts = Posts([self._tasks, self._others], numbers, self.motion.end_task)
        self._audio = AudioPlayer(self._others, lambda: self.joints.now, numbers)
        self._postures = Postures(self.joints, self.motion, self._tasks)
        self._frames = RobotFrames(self.joints, links(config.body), self._robot_place, walking.steps_ahead)
        self._arms = ArmProtection(self.joints, self._frames.links)
        self._breathing = Breathing(self.joints, self._postures)
        self._falls = FallManager(self.joints, self.motion)
        self._protection = WalkProtection(self.joints)
        self._walks = walking.methods()
        self.memory = Memory(config.body, lambda: self.joints.dcm, config.keys())
        self.memory.provide(self.joints.keys())
        self.memory.update(frame)
        self.events = Events(self.memory, self._told(publish))
        self._speech = Speech(self._others, self.events, lambda: self.joints.now)
        self._dialog = Dialog(self.events, self.memory.get, self._speech.say)
        self._microphones = Microphones(publish)
        self._robot_events = RobotEvents(self.events, self.memory, self._postures, frame)
        self._recognition = SpeechRecognition(self.events)
        self._eyes = eyes or NoEyes()
        self._stage = Stage(config.body, self._frames, self._eyes, self._hear)
        self._video = VideoDevice(config.body, self._eyes)
        self._sonar = Sonar(self.joints, self.events)
        seeing = (self._stage, self._frames, self.events)
        self._detections = (
            Faces(*seeing),
            LandMarks("ALLandMarkDetection", "landmark", "LandmarkDetected", *seeing),
            Detection("ALRedBallDetection", "ball", "redBallDetected", *seeing),
        )
        self._compass = VisualCompass(self._frames, self.events, self._walks, self._robot_place)
        neck = config.body.lengths.NeckOffsetZ
        walk = self._walks.get("move")
        self._awareness = Awareness(self._stage, self._frames, self.motion, self.events, self.memory)
        self._following = Following(self._stage, self._frames, self.motion, self.events, neck, walk)
        self._table = self._build()

    def _hear(self, said: str) -> list[str]:
        """Somebody says something; the words that were recognized."""
        self._dialog.hear(said)
        return self._recognition.hear(said)

    def _told(self, publish: Publish) -> Publish:
        """Tells of an event, and has dialogues answer it."""

        def tell(event: str, value: Any, callbacks: list[list[Any]]) -> None:
            publish(event, value, callbacks)
            self._dialog.notice(event, value)

        return tell

    def _robot_place(self) -> Sequence[float]:
        position = self._walks.get("getRobotPosition")
        place: Sequence[float] = position(False) if position else (0.0, 0.0, 0.0)
        return place

    def cycle(self, frame: SensorFrame) -> None:
        """A new frame; the lock is held."""
        self.joints.cycle(frame)
        self.memory.update(frame)
        self._robot_events.update(frame)
        if self._falls.update(frame, leaning=self._postures.leaning):
            self.events.raise_event("ALMotion/RobotIsFalling", True)
        now = self.joints.dcm.clock.previous
        for detection in self._detections:
            detection.update(now)
        self._compass.update(now)
        self._microphones.update(now)
        self._following.update(now)
        self._awareness.update(now)
        self._sonar.update()
        if not self.handover.has_robot:
            self._breathing.update()
        self._tasks.run(now)
        self._others.run(now)

    def give_away(self) -> None:
        """The walker gets the robot: motions of the legs end; the lock is held."""
        self.motion.end_using("Legs")
        self.upper_body.begin()

    def hold(self) -> None:
        """Hold the joints where they are, except the program's share; the lock is held."""
        self.joints.hold(self.upper_body.taken)

    def abandon(self) -> None:
        """The robot is gone: calls that wait for a motion fail; the lock is held."""
        self._tasks.abandon()
        self._others.abandon()

    def names(self) -> dict[str, list[str]]:
        """Service -> methods, those included that only refuse."""
        return {name: list(methods) for name, methods in self._table.items()}

    def offered(self, service: str) -> list[str]:
        """Methods of a service that do more than refuse."""
        return sorted(name for name, method in self._table[service].items() if method.offered)

    def call(self, service: str, method: str, arguments: list[Any]) -> Any:
        """Carry out a call: its result, or a future of it.

        Args:
            service: name of the service.
            method: name of the method.
            arguments: as the program gave them.

        Raises:
            NaoHilError: it cannot be carried out; one sentence.
        """
        if service not in self._table:
            raise NaoqiRefused(f"NAOqi: {unknown_name('service', service, self._table)}.")
        entry = self._table[service].get(method)
        if entry is None:
            raise NaoqiRefused(f"{service}: {unknown_name('method', method, self.offered(service))}.")
        try:
            entry.signature.bind(*arguments)
        except TypeError as error:
            raise NaoqiRefused(
                f"{service}.{method}: {len(arguments)} arguments do not fit ({_as_vendor(str(error))})."
            ) from None
        if entry.kind == "walk" and method in BEGINNING:
            with self._lock:
                if not self.handover.has_robot:
                    self._protection.require(f"{service}.{method}")
        moves = _MOVES.get(method) or next(iter(arguments), None)
        if service == "DCM" and entry.kind == "joints":
            moves = moved_joints(self.joints.dcm, moves)
        stiff = method == "setStiffnesses" and stays_stiff(arguments[1])
        return self._carry_out(entry, arguments, moves, stiff=stiff)

    def _post(self, service: str, method: Any = None, *arguments: Any) -> int:
        """Begin a call and do not wait for it; its number."""
        name, *rest = method if isinstance(method, list) and method else [method, *arguments]
        text(name, f"{service}.pCall: method")
        try:
            result = self.call(service, name, rest)
        except NaoHilError as error:
            logger.warning("%s", error)  # as a robot: the caller gets a number all the same
            return next(self._numbers)
        if isinstance(result, Future):
            result.add_done_callback(_log_error)
        walks = self._table[service][name].kind == "walk"
        key = self._posts.add(result, self._walks.get("stopMove") if walks else None)
        if service == "ALAudioPlayer":
            self._audio.begun(result, key)
        return key

    def _carry_out(self, entry: Method, arguments: list[Any], moves: Any, *, stiff: bool) -> Any:
        if entry.kind == "walk":
            return entry.call(*arguments)
        if entry.kind == "read":
            with self._lock:
                return entry.call(*arguments)

        def command() -> Any:
            with self._lock:
                self._require_lease()
                result = entry.call(*arguments)
                self._commanded()
                return result

        if self.handover.has_robot:
            with self._lock:
                upper = self.upper_body.within(moves)
                if upper is not None or (stiff and self.handover.active):  # the walk has its legs stiff already
                    self.upper_body.taken |= set(upper or ())
                    result = entry.call(*arguments)
                    self._commanded()
                    return result
            return self.handover.with_joints(command, stop=entry.kind == "posture")
        return command()

    def _build(self) -> dict[str, dict[str, Method]]:
        settings = InertSettings()
        tracker = Tracker(self.joints, self.motion, self._frames, self._following)
        gestures = Animations(self.joints, self.motion)
        recorder = Recorder(lambda: self.joints.now)
        reading: dict[str, Table] = {
            "ALMemory": self.memory.methods() | self.events.methods(),
            "ALLeds": Leds(self.joints, self._others).methods(),
            "ALTextToSpeech": self._speech.methods(),
            "ALAnimatedSpeech": self._speech.animated_methods(),
            "ALAudioPlayer": self._audio.methods(),
            "ALAudioDevice": self._audio.device_methods()
            | recorder.device_methods()
            | self._microphones.methods(),
            "ALAudioRecorder": recorder.methods(),
            "ALAutonomousLife": AutonomousLife(self.events).methods(),
            "ALSpeechRecognition": self._recognition.methods(),
            "ALFaceDetection": self._detections[0].methods(),
            "ALLandMarkDetection": self._detections[1].methods(),
            "ALRedBallDetection": self._detections[2].methods(),
            "ALVideoDevice": self._video.methods(),
            STAGE: self._stage.methods(),
            "ALPhotoCapture": PhotoCapture(self._eyes, self._others, lambda: self.joints.now).methods(),
            "ALVideoRecorder": VideoRecorder(self._eyes, self._others, lambda: self.joints.now).methods(),
            "ALDialog": self._dialog.methods(),
            "ALBasicAwareness": self._awareness.methods(),
        }
        quiet = {name: Extractor(name, self.events, [event]) for name, event in QUIET.items()}
        quiet |= {name: VisionExtractor(name, self.events, [event]) for name, event in QUIET_VISION.items()}
        for name, extractor in quiet.items():
            reading[name] = extractor.methods()
        for name, of in SETTINGS.items():
            reading[name] = reading.get(name, {}) | settings.methods(name, of)
        reading["ALPeoplePerception"]["resetPopulation"] = lambda: None
        table: dict[str, dict[str, Method]] = {
            "ALMotion": self._motion_methods(settings),
            "DCM": dcm_methods(self.joints),
            "ALRobotPosture": self._posture_methods(),
            "ALAnimationPlayer": gestures.methods(),
            "ALBehaviorManager": gestures.behavior_methods(),
            "ALTracker": of_kind("read", tracker.methods()) | of_kind("joints", tracker.moving()),
            "ALRedBallTracker": tracker.old_methods("RedBall", 0.06),
            "ALFaceTracker": tracker.old_methods("Face", 0.15),
            **sensing_services(self.joints, self.events, self._sonar),
            **system_services(self._config),
            "ALVisualCompass": of_kind("read", self._compass.methods())
            | of_kind("walk", self._compass.walking()),
            **{name: of_kind("read", methods) for name, methods in reading.items()},
        }
        table["ALNavigation"] |= of_kind("walk", navigation_methods(self._walks))
        for name in [*table, *(name for name in VENDOR if name != "ALModule")]:
            methods = table.get(name, {})
            vendor = [m for m in VENDOR[name].methods if m != "subscriber"] if name in VENDOR else []
            missing = refusals(name, [*vendor, *VENDOR["ALModule"].methods], methods)
            posting = of_kind("walk", {"pCall": partial(self._post, name)})
            table[name] = missing | posting | of_kind("read", self._common(name, methods)) | methods
        return table

    def _posture_methods(self) -> dict[str, Method]:
        moving: Table = {
            "goToPosture": self._postures.go_to,
            "applyPosture": self._postures.apply,
            "stopMove": self.motion.end_all,
        }
        return of_kind("read", self._postures.methods()) | of_kind("posture", moving)

    def _motion_methods(self, settings: InertSettings) -> dict[str, Method]:
        ending_walks: Table = {
            "wakeUp": self._robot_events.told("wakeUp", self._postures.wake_up),
            "rest": self._robot_events.told("rest", self._postures.rest),
            "killAll": self.motion.end_all,
            "killTasksUsingResources": self.motion.end_using,
        }
        reading = self.motion.reading() | {
            "killTask": self.motion.end_task,
            "robotIsWakeUp": lambda: self._postures.awake,
            "setMotionConfig": self._protection.configure,
        }
        cartesian = Cartesian(self.joints, self.motion, self._tasks, self._frames)
        whole_body = WholeBody(self.joints, self.motion, self._tasks, cartesian, self._frames)
        return (
            of_kind("read", reading | settings.methods("ALMotion", MOTION) | self.upper_body.methods())
            | of_kind("read", self._falls.methods() | self._frames.methods() | whole_body.methods())
            | of_kind("read", self._breathing.methods() | self._arms.methods())
            | of_kind("joints", self.motion.moving() | cartesian.methods() | whole_body.moving())
            | of_kind("posture", ending_walks)
            | of_kind("walk", self._walks)
        )

    def _parameters(self, service: str, method: Any) -> list[str]:
        """Names of a method's arguments."""
        name = text(method, f"{service}.getMethodHelp: method")
        if name not in self.offered(service):
            raise NaoqiRefused(f"{service}: {unknown_name('method', name, self.offered(service))}.")
        return list(map(_as_vendor, self._table[service][name].signature.parameters))

    def _common(self, service: str, methods: Mapping[str, Method]) -> Table:
        """Methods of every service."""
        return {
            "ping": lambda: True,
            "exit": lambda: None,
            "version": lambda: self._config.naoqi_version,
            "getBrokerName": lambda: "naoqi",
            "getMethodList": lambda: sorted(methods),
            "getModuleHelp": lambda: [f"{service}, served by nao-hil", []],
            "getMethodHelp": lambda name: [name, [[p, ""] for p in self._parameters(service, name)], "", ""],
            "getUsage": lambda name: f"{service}.{name}({', '.join(self._parameters(service, name))})",
            "isRunning": self._posts.running,
            "wait": self._posts.wait,
            "stop": self._posts.stop,
        }


def _log_error(done: Future[Any]) -> None:
    """Log the error of a call that nobody waits for."""
    if (error := done.exception()) is not None:
        logger.warning("%s", error)


def _as_vendor(words: str) -> str:
    """Names of arguments as the vendor writes them: `useSensors` for `use_sensors`."""
    return re.sub(r"(?<=[a-z])_([a-z])", lambda letter: letter[1].upper(), words)
