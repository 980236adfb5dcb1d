"""The services of a served robot: the table of their methods, and calls."""

from __future__ import annotations

import itertools
import logging
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from pathlib import Path
from threading import RLock
from typing import Annotated, Any

from bridge.adapters.naoqi.core.breathing import Breathing
from bridge.adapters.naoqi.core.cameras import CameraFeed, NoCameraFeed
from bridge.adapters.naoqi.core.cartesian import Cartesian
from bridge.adapters.naoqi.core.frames import RobotFrames
from bridge.adapters.naoqi.core.joint_motion import JointMotion
from bridge.adapters.naoqi.core.joints import DcmService, Joints, UpperBodyShare, moved_joints
from bridge.adapters.naoqi.core.memory import Events, Memory, Publish
from bridge.adapters.naoqi.core.motion_tasks import MAX_WAIT, AsyncCalls, MotionTasks
from bridge.adapters.naoqi.core.navigation import Navigation, VisualCompass
from bridge.adapters.naoqi.core.postures import Postures
from bridge.adapters.naoqi.core.protection import ArmProtection, FallManager, WalkProtection, stays_stiff
from bridge.adapters.naoqi.core.robot_facts import InertSettings, Preferences, RobotConfig, RobotFacts
from bridge.adapters.naoqi.core.sensing import (
    BUTTON_KEYS,
    QUIET_SERVICES,
    QUIET_VISION,
    BatteryAndHeat,
    Extractor,
    RobotEvents,
    Sonar,
    Touch,
    VisionExtractor,
)
from bridge.adapters.naoqi.core.video import VideoDevice
from bridge.adapters.naoqi.core.walking import WalkingMethods
from bridge.adapters.naoqi.core.whole_body import WholeBody
from bridge.adapters.naoqi.declared import REFUSED, Method, Range, as_vendor, declared, offers, refusals
from bridge.adapters.naoqi.interaction.animations import (
    BEHAVIOUR_EVENT,
    GESTURE_CHAINS,
    Animations,
    is_animation,
)
from bridge.adapters.naoqi.interaction.audio import AudioPlayer, Microphones, Recorder
from bridge.adapters.naoqi.interaction.autonomy import AutonomousLife, Awareness
from bridge.adapters.naoqi.interaction.detection import Detection, Faces, LandMarks, Scene
from bridge.adapters.naoqi.interaction.dialog import Dialog
from bridge.adapters.naoqi.interaction.hearing import SpeechRecognition
from bridge.adapters.naoqi.interaction.leds import Leds
from bridge.adapters.naoqi.interaction.photos import PhotoCapture, VideoRecorder
from bridge.adapters.naoqi.interaction.speech import Speech
from bridge.adapters.naoqi.interaction.tracker import Following, OldTracker, Tracker
from bridge.adapters.naoqi.robot_files import RobotFiles
from bridge.errors import NaoHilError, NaoqiRefused
from bridge.messages import SensorFrame
from bridge.validation import unknown_name

logger = logging.getLogger(__name__)

NAO_HIL_SERVICE = "NaoHil"
"""Service of nao-hil itself: the robot's surroundings."""
_MOVED_JOINTS = {"lookAt": ["Head"], "startTracker": ["Head"]}
_MOVED_JOINTS |= {m: list(GESTURE_CHAINS) for m in ("run", "runTag", "runBehavior", "startBehavior")}
"""Joints moved by methods without a first argument that names joints."""


class Services:
    """All services of one robot, from its first frame on.

    Args:
        config: facts about the robot.
        frame: its first one.
        lock: of joints and memory.
        walking: walks, with the handover of the joints.
        require_lease: raises `NaoHilError` unless the joints may be commanded.
        commanded: called, with the lock held, after a call that may have changed the joints' commands.
        publish: called for each event of ALMemory.
        home: folder that stands for its `/home/nao`; made at the first file.
        feed: its cameras.
        has_signal: as of `Events`.
    """

    def __init__(
        self,
        config: RobotConfig,
        frame: SensorFrame,
        lock: RLock,
        walking: WalkingMethods,
        require_lease: Callable[[], None],
        commanded: Callable[[], None],
        publish: Publish,
        home: Path,
        feed: CameraFeed | None = None,
        has_signal: Callable[[str], bool] = lambda _: False,
    ) -> None:
        self._config, self._lock, self.handover = config, lock, walking.handover
        self._require_lease, self._commanded = require_lease, commanded
        self.joints = Joints(config.body, frame)
        numbers = self._numbers = itertools.count(1)
        self._tasks, self._others = MotionTasks(numbers), MotionTasks(numbers)
        """Motions of joints; and other lasting calls, which a stop of all motions leaves alone."""
        self.motion = JointMotion(self.joints, self._tasks, config)
        self.upper_body = UpperBodyShare(self.joints)
        self._async_calls = AsyncCalls([self._tasks, self._others], numbers, self.motion.end_task)
        self._files = RobotFiles(home, lock)
        self._audio = AudioPlayer(self._others, lambda: self.joints.now, numbers, self._files)
        self._postures = Postures(self.joints, self.motion, self._tasks)
        self._frames = RobotFrames(self.joints, self._robot_place, walking.steps_ahead)
        self._arms = ArmProtection(self.joints, self._frames.links)
        self._breathing = Breathing(self.joints, self._postures)
        self._falls = FallManager(self.joints, self.motion)
        self._protection = WalkProtection(self.joints)
        self._walking = walking
        self._walks = {name: method.call for name, method in declared(walking).get("ALMotion", {}).items()}
        self.memory = Memory(config.body, lambda: self.joints.dcm, config.keys())
        self.memory.provide(self.joints.keys())
        self.memory.update(frame)
        self.events = Events(self.memory, self._publisher(publish), has_signal)
        self._speech = Speech(self._others, self.events, lambda: self.joints.now, self._files, self._animate)
        self._dialog = Dialog(self.events, self.memory.get, self._speech.answer, self._files)
        self._microphones = Microphones(publish)
        self._robot_events = RobotEvents(self.events, self.memory, self._postures, frame)
        self._recognition = SpeechRecognition(self.events, self._files)
        self._feed = feed or NoCameraFeed()
        self._scene = Scene(config.body, self._frames, self._feed, self._hear)
        self._video = VideoDevice(config.body, self._feed)
        self._sonar = Sonar(self.joints, self.events)
        seeing = (self._scene, self._frames, self.events)
        self._detections = (
            Faces(*seeing, self._others, lambda: self.joints.now),
            LandMarks("ALLandMarkDetection", "landmark", "LandmarkDetected", *seeing),
            Detection("ALRedBallDetection", "ball", "redBallDetected", *seeing),
        )
        self._compass = VisualCompass(self._frames, self.events, self._robot_place)
        neck = config.body.lengths.NeckOffsetZ
        walk = self._walks.get("move")
        self._awareness = Awareness(self._scene, self._frames, self.motion, self.events, self.memory)
        self._following = Following(self._scene, self._frames, self.motion, self.events, neck, walk)
        self._table = self._build()

    def _hear(self, said: str) -> list[str]:
        """Process an utterance of a person; the recognized words."""
        self._dialog.hear(said)
        return self._recognition.hear(said)

    def _animate(self, name: str) -> Future[Any] | None:
        """Begin an animation that a text names; another behaviour is for a program that has it."""
        if not is_animation(name):
            self.events.raise_event(BEHAVIOUR_EVENT, name)
            return None
        try:
            playing: Future[Any] = self.call("ALAnimationPlayer", "run", [name])
        except NaoHilError as error:
            logger.warning("%s", error)
            return None
        return playing

    def _publisher(self, publish: Publish) -> Publish:
        """A publisher of events that also passes them to the dialogues."""

        def publish_and_answer(event: str, value: Any, callbacks: list[list[Any]]) -> None:
            publish(event, value, callbacks)
            self._dialog.answer_event(event, value)

        return publish_and_answer

    def _robot_place(self) -> Sequence[float]:
        position = self._walks.get("getRobotPosition")
        place: Sequence[float] = position(False) if position else (0.0, 0.0, 0.0)
        return place

    def cycle(self, frame: SensorFrame) -> None:
        """Take a new frame; the lock is held."""
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
        """End motions of the legs for the walker; the lock is held."""
        self.motion.end_using("Legs")
        self.upper_body.begin()

    def hold(self, targets: tuple[float, ...] = ()) -> None:
        """Hold the joints in place, except the program's share, see `Joints.hold`; the lock is held."""
        self.joints.hold(self.upper_body.taken, targets)

    def abandon(self) -> None:
        """Fail calls that wait for a motion of a lost robot; the lock is held."""
        self._tasks.abandon()
        self._others.abandon()

    def names(self) -> dict[str, list[str]]:
        """Service -> methods, including the refused ones."""
        return {name: list(methods) for name, methods in self._table.items()}

    def table(self) -> Mapping[str, Mapping[str, Method]]:
        """Service -> method."""
        return self._table

    def offered(self, service: str) -> list[str]:
        """Methods of a service without the refused ones."""
        return sorted(name for name, method in self._table[service].items() if not method.refuses)

    def call(self, service: str, method: str, arguments: list[Any]) -> Any:
        """Carry out a call: its result, or a future of it.

        Args:
            service: name of the service.
            method: name of the method.
            arguments: of the program.

        Raises:
            NaoHilError: a refusal; one sentence.
        """
        if service not in self._table:
            raise NaoqiRefused(f"NAOqi: {unknown_name('service', service, self._table)}.")
        entry = self._table[service].get(method)
        if entry is None:
            raise NaoqiRefused(f"{service}: {unknown_name('method', method, self.offered(service))}.")
        entry.require_count(arguments)
        if entry.begins_walk and not _is_zero(arguments[:3]):
            with self._lock:
                if not self.handover.has_robot:
                    self._protection.require(f"{service}.{method}")
        moves = _MOVED_JOINTS.get(method) or next(iter(arguments), None)
        if service == "DCM" and entry.kind == "joints":
            moves = moved_joints(self.joints.dcm, moves)
        stiff = method == "setStiffnesses" and stays_stiff(arguments[1])
        return self._carry_out(entry, arguments, moves, stiff=stiff)

    def _post(self, service: str, method: Any = None, *arguments: Any) -> int:
        """Begin a call without waiting for it; its number."""
        name, *rest = method if isinstance(method, list) and method else [method, *arguments]
        if not isinstance(name, str):
            raise NaoqiRefused(f"{service}.pCall: method is {name!r:.60}; a name is expected.")
        try:
            result = self.call(service, name, rest)
        except NaoHilError as error:
            logger.warning("%s", error)  # as on a robot, the caller gets a number
            return next(self._numbers)
        if isinstance(result, Future):
            result.add_done_callback(_log_error)
        walks = self._table[service][name].kind == "walk"
        key = self._async_calls.add(result, self._walks.get("stopMove") if walks else None)
        if service == "ALAudioPlayer":
            self._audio.name_by_call(result, key)
        return key

    def _carry_out(self, entry: Method, arguments: list[Any], moves: Any, *, stiff: bool) -> Any:
        if entry.kind == "walk":
            return entry(arguments)
        if entry.kind == "read":
            with self._lock:
                return entry(arguments)

        def command() -> Any:
            with self._lock:
                self._require_lease()
                result = entry(arguments)
                self._commanded()
                return result

        if self.handover.has_robot:
            with self._lock:
                upper = self.upper_body.within(moves)
                if upper is not None or (stiff and self.handover.active):  # a walking robot's legs are stiff
                    self.upper_body.taken |= set(upper or ())
                    result = entry(arguments)
                    self._commanded()
                    return result
            return self.handover.with_joints(command, stop=entry.kind == "posture")
        return command()

    def _build(self) -> dict[str, dict[str, Method]]:
        now = lambda: self.joints.now  # noqa: E731
        cartesian = Cartesian(self.joints, self.motion, self._tasks, self._frames)
        photos = PhotoCapture(self._feed, self._others, now, self._files)
        films = VideoRecorder(self._feed, self._others, now, self._files)
        table = declared(
            InertSettings(),
            DcmService(self.joints),
            self.memory,
            self.events,
            self.motion,
            self._postures,
            self._robot_events,
            self.upper_body,
            self._protection,
            self._falls,
            self._frames,
            self._breathing,
            self._arms,
            cartesian,
            WholeBody(self.joints, self.motion, self._tasks, cartesian, self._frames),
            self._walking,
            *([Navigation(self._walks)] if "moveTo" in self._walks else []),
            self._compass.extractor,
            self._compass,
            self._sonar.extractor,
            self._sonar,
            Touch(self.joints, self.events),
            Extractor("ALSensors", self.events, [], BUTTON_KEYS),
            BatteryAndHeat(self.joints),
            RobotFacts(self._config),
            Preferences(),
            Leds(self.joints, self._others),
            self._speech,
            self._audio,
            Recorder(now, self._files),
            self._microphones,
            AutonomousLife(self.events),
            self._awareness,
            self._recognition.extractor,
            self._recognition,
            *(part for detection in self._detections for part in (detection.extractor, detection)),
            self._video,
            self._scene,
            photos.setup,
            photos,
            films.setup,
            films,
            self._dialog,
            self._dialog.concepts,
            self._files,
            Animations(self.joints, self.motion),
            Tracker(self.joints, self.motion, self._frames, self._following),
            OldTracker("RedBall", 0.06, self._following),
            OldTracker("Face", 0.15, self._following),
            *(Extractor(name, self.events, [event], quiet=True) for name, event in QUIET_SERVICES.items()),
            *(VisionExtractor(name, self.events, [event], quiet=True) for name, event in QUIET_VISION.items()),
        )
        for name in sorted({*table, *REFUSED}):
            methods = table.get(name, {})
            module = declared(_Module(name, self, methods))[name]
            table[name] = refusals(name, {*module, *methods}) | module | methods
        return table

    def parameters(self, service: str, method: str) -> Method:
        """An offered method.

        Raises:
            NaoqiRefused: no such method.
        """
        if method not in self.offered(service):
            raise NaoqiRefused(f"{service}: {unknown_name('method', method, self.offered(service))}.")
        return self._table[service][method]


class _Module:
    """Methods of every service.

    Args:
        service: its name.
        services: all of them.
        methods: of its own.
    """

    def __init__(self, service: str, services: Services, methods: Mapping[str, Method]) -> None:
        self.service, self._services, self._methods = service, services, methods

    _ping = offers(".ping")(lambda self: True)
    _version = offers(".version")(lambda self: self._services._config.naoqi_version)
    _get_broker_name = offers(".getBrokerName")(lambda self: "naoqi")
    _get_method_list = offers(".getMethodList")(lambda self: sorted(self._methods))
    _get_module_help = offers(".getModuleHelp")(lambda self: [f"{self.service}, served by nao-hil", []])
    _is_running = offers(".isRunning")(lambda self, key: self._services._async_calls.running(key))
    _stop = offers(".stop")(lambda self, key: self._services._async_calls.stop(key))
    _exit = offers(".exit", partly="the module stays")(lambda self: None)

    @offers(".pCall", kind="walk")
    def _post(self, method: Any = None, *arguments: Any) -> int:
        return self._services._post(self.service, method, *arguments)

    @offers(".getMethodHelp")
    def _help(self, method: str) -> list[Any]:
        return self._services.parameters(self.service, method).help

    @offers(".getUsage")
    def _usage(self, method: str) -> str:
        names = map(as_vendor, self._services.parameters(self.service, method).signature.parameters)
        return f"{self.service}.{method}({', '.join(names)})"

    @offers(".wait")
    def _wait(self, key: Any, timeout: Annotated[float, Range(0, MAX_WAIT, "ms")] = 0) -> Future[Any]:
        return self._services._async_calls.wait(key, timeout)


def _is_zero(velocity: Sequence[Any]) -> bool:
    """Whether a velocity, or a way, is none: a robot that stands or lies takes it too."""
    return all(isinstance(part, int | float) and part == 0 for part in velocity)


def _log_error(done: Future[Any]) -> None:
    """Log the error of a call without a waiting caller."""
    if (error := done.exception()) is not None:
        logger.warning("%s", error)
