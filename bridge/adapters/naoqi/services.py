"""The services of a served robot: the table of their methods, and calls."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Annotated, Any

from bridge.adapters.naoqi.core.breathing import Breathing
from bridge.adapters.naoqi.core.cartesian import Cartesian
from bridge.adapters.naoqi.core.joints import DcmService, UpperBodyShare, moved_joints
from bridge.adapters.naoqi.core.motion_tasks import MAX_WAIT, AsyncCalls
from bridge.adapters.naoqi.core.navigation import Navigation, VisualCompass
from bridge.adapters.naoqi.core.postures import Postures
from bridge.adapters.naoqi.core.protection import ArmProtection, FallManager, WalkProtection, stays_stiff
from bridge.adapters.naoqi.core.robot_facts import Preferences, RobotFacts
from bridge.adapters.naoqi.core.sensing import (
    BatteryAndHeat,
    RobotEvents,
    Sensors,
    Sonar,
    Touch,
    quiet_services,
)
from bridge.adapters.naoqi.core.served import ServedRobot
from bridge.adapters.naoqi.core.video import VideoDevice
from bridge.adapters.naoqi.core.whole_body import WholeBody
from bridge.adapters.naoqi.declared import (
    MODULE,
    VENDOR_METHODS,
    Method,
    Range,
    as_vendor,
    declared,
    offers,
    refusals,
    rows,
)
from bridge.adapters.naoqi.interaction.animations import (
    BEHAVIOUR_EVENT,
    GESTURE_CHAINS,
    Animations,
    is_animation,
)
from bridge.adapters.naoqi.interaction.audio import AudioPlayer, Microphones, Recorder
from bridge.adapters.naoqi.interaction.autonomy import AutonomousLife, Awareness
from bridge.adapters.naoqi.interaction.detection import Balls, Faces, LandMarks, Scene
from bridge.adapters.naoqi.interaction.dialog import Dialog
from bridge.adapters.naoqi.interaction.hearing import SpeechRecognition
from bridge.adapters.naoqi.interaction.leds import Leds
from bridge.adapters.naoqi.interaction.photos import PhotoCapture, VideoRecorder
from bridge.adapters.naoqi.interaction.speech import Speech
from bridge.adapters.naoqi.interaction.tracker import OldTracker, Tracker
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
    """All services of one robot.

    Args:
        robot: its joints and memory are locked by its lock.
        require_lease: raises `NaoHilError` unless the joints may be commanded.
        commanded: called, with the lock held, after a call that may have changed the joints' commands.
    """

    def __init__(
        self, robot: ServedRobot, require_lease: Callable[[], None], commanded: Callable[[], None]
    ) -> None:
        self.robot, self._lock, self.handover = robot, robot.lock, robot.walking.handover
        self._require_lease, self._commanded = require_lease, commanded
        self.joints, self.motion, self.events = robot.joints, robot.motion, robot.events
        self.upper_body = UpperBodyShare(robot.joints)
        self._async_calls = AsyncCalls([robot.tasks, robot.others], robot.numbers, robot.motion.end_task)
        self._postures = Postures(robot)
        self._robot_events = RobotEvents(robot, self._postures)
        self._breathing = Breathing(robot, self._postures)
        self._falls, self._protection = FallManager(robot), WalkProtection(robot)
        self._audio, self._microphones = AudioPlayer(robot), Microphones(robot)
        speech = Speech(robot, self._animate)
        self._dialog, self._recognition = Dialog(robot, speech.answer), SpeechRecognition(robot)
        self._sonar, self._compass = Sonar(robot), VisualCompass(robot)
        scene, cartesian = Scene(robot, self._hear), Cartesian(robot)
        self._detections = (Faces(robot, scene), LandMarks(robot, scene), Balls(robot, scene))
        self._awareness, self._tracker = Awareness(robot, scene), Tracker(robot, scene)
        self._table = self._build(
            rows(),
            DcmService(robot.joints),
            robot.memory,
            robot.events,
            robot.motion,
            robot.frames,
            robot.files,
            self._postures,
            self._robot_events,
            self.upper_body,
            self._protection,
            self._falls,
            self._breathing,
            ArmProtection(robot),
            cartesian,
            WholeBody(robot, cartesian),
            robot.walking,
            *([Navigation(robot)] if "moveTo" in robot.walks else []),
            self._compass,
            self._sonar,
            Touch(robot),
            Sensors(robot),
            BatteryAndHeat(robot),
            RobotFacts(robot.config),
            Preferences(),
            Leds(robot),
            speech,
            self._audio,
            Recorder(robot),
            self._microphones,
            AutonomousLife(robot),
            self._awareness,
            self._recognition,
            *self._detections,
            VideoDevice(robot),
            scene,
            PhotoCapture(robot),
            VideoRecorder(robot),
            self._dialog,
            self._dialog.concepts,
            Animations(robot),
            self._tracker,
            *(OldTracker(self._tracker, name, size) for name, size in (("RedBall", 0.06), ("Face", 0.15))),
            *quiet_services(robot),
        )

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

    def cycle(self, frame: SensorFrame) -> None:
        """Take a new frame; the lock is held."""
        self.joints.cycle(frame)
        self.robot.memory.update(frame)
        self._robot_events.update(frame)
        if self._falls.update(frame, leaning=self._postures.leaning):
            self.events.raise_event("ALMotion/RobotIsFalling", True)
        now = self.joints.dcm.clock.previous
        for detection in self._detections:
            detection.update(now)
        self._compass.update(now)
        self._microphones.update(now)
        self._tracker.update(now)
        self._awareness.update(now)
        self._sonar.update()
        if not self.handover.has_robot:
            self._breathing.update()
        self.robot.tasks.run(now)
        self.robot.others.run(now)

    def give_away(self) -> None:
        """End motions of the legs for the walker; the lock is held."""
        self.motion.end_using("Legs")
        self.upper_body.begin()

    def hold(self, targets: tuple[float, ...] = ()) -> None:
        """Hold the joints in place, except the program's share, see `Joints.hold`; the lock is held."""
        self.joints.hold(self.upper_body.taken, targets)

    def abandon(self) -> None:
        """Fail calls that wait for a motion of a lost robot; the lock is held."""
        self.robot.tasks.abandon()
        self.robot.others.abandon()

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

        Raises:
            NaoHilError: a refusal; one sentence.
        """
        if service not in self._table:
            raise NaoqiRefused(f"NAOqi: {unknown_name('service', service, self._table)}.")
        entry = self._table[service].get(method)
        if entry is None:
            raise NaoqiRefused(f"{service}: {unknown_name('method', method, self.offered(service))}.")
        entry.require_count(arguments)
        if entry.begins_walk and any(part != 0 for part in arguments[:3]):
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
            return next(self.robot.numbers)
        if isinstance(result, Future):
            result.add_done_callback(_log_error)
        walks = self._table[service][name].kind == "walk"
        key = self._async_calls.add(result, self.robot.walks.get("stopMove") if walks else None)
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

    def _build(self, *owners: object) -> dict[str, dict[str, Method]]:
        """Service -> name -> method; of two methods of a name the later owner's counts."""
        table = declared(*owners)
        for name in sorted({*table, *VENDOR_METHODS} - {MODULE}):
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
    """Methods of every service."""

    def __init__(self, service: str, services: Services, methods: Mapping[str, Method]) -> None:
        self.service, self._services, self._methods = service, services, methods

    _ping = offers(".ping")(lambda self: True)
    _version = offers(".version")(lambda self: self._services.robot.config.naoqi_version)
    _get_broker_name = offers(".getBrokerName")(lambda self: "naoqi")
    _get_method_list = offers(".getMethodList")(lambda self: sorted(self._methods))
    _get_module_help = offers(".getModuleHelp")(lambda self: [f"{self.service}, served by nao-hil", []])
    _is_running = offers(".isRunning")(lambda self, key: self._services._async_calls.running(key))
    _stop = offers(".stop")(lambda self, key: self._services._async_calls.stop(key))
    _exit = offers(".exit")(lambda self: None)

    @offers(".pCall", kind="walk")
    def _post(self, method: Any = None, *arguments: Any) -> int:
        return self._services._post(self.service, method, *arguments)

    @offers(".getMethodHelp")
    def _help(self, method: str) -> list[Any]:
        return self._services.parameters(self.service, method).help

    @offers(".getUsage")
    def _usage(self, method: str) -> str:
        names = map(as_vendor, self._services.parameters(self.service, method).types)
        return f"{self.service}.{method}({', '.join(names)})"

    @offers(".wait")
    def _wait(self, key: Any, timeout: Annotated[float, Range(0, MAX_WAIT, "ms")] = 0) -> Future[Any]:
        return self._services._async_calls.wait(key, timeout)


def _log_error(done: Future[Any]) -> None:
    """Log the error of a call without a waiting caller."""
    if (error := done.exception()) is not None:
        logger.warning("%s", error)
