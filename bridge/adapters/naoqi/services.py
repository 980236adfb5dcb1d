"""The services of a served robot: a table of their methods, and the calls of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from threading import RLock
from typing import Any

from bridge.adapters.naoqi.config import RobotConfig
from bridge.adapters.naoqi.fall_manager import FallManager
from bridge.adapters.naoqi.inert_settings import ABILITIES, MOTION, InertSettings
from bridge.adapters.naoqi.joint_motion import JointMotion
from bridge.adapters.naoqi.joints import Joints
from bridge.adapters.naoqi.leds import Leds
from bridge.adapters.naoqi.memory import Memory
from bridge.adapters.naoqi.methods import VENDOR, Method, of_kind, refused
from bridge.adapters.naoqi.motion_tasks import MotionTasks, robot_gone
from bridge.adapters.naoqi.postures import Postures
from bridge.adapters.naoqi.small_services import dcm_methods, small_services
from bridge.adapters.naoqi.walking import WalkingMethods
from bridge.errors import NaoqiRefused
from bridge.messages import SensorFrame


class Services:
    """All services of one robot, from its first frame on.

    Args:
        config: facts about the robot.
        frame: its first one.
        lock: held while joints and memory are touched.
        walking: walks, and hands the joints back and forth.
        require_lease: raises `NaoHilError` unless the joints may be commanded.
        commanded: called, with the lock held, when a call may have changed the joints' commands.
        publish: called with name and value of each event of ALMemory.
    """

    def __init__(
        self,
        config: RobotConfig,
        frame: SensorFrame,
        lock: RLock,
        walking: WalkingMethods,
        require_lease: Callable[[], None],
        commanded: Callable[[], None],
        publish: Callable[[str, Any], None],
    ) -> None:
        self._config, self._lock, self._walking = config, lock, walking
        self._require_lease, self._commanded = require_lease, commanded
        self.joints = Joints(config.body, frame)
        self._tasks = MotionTasks()
        self.motion = JointMotion(self.joints, self._tasks, config)
        self._postures = Postures(self.joints, self.motion, self._tasks)
        self._falls = FallManager(self.joints, self.motion)
        self.memory = Memory(config.body, lambda: self.joints.dcm, config.keys(), publish)
        self.memory.update(frame)
        self._table = self._build()

    def cycle(self, frame: SensorFrame) -> None:
        """A new frame; the lock is held."""
        self.joints.cycle(frame)
        self.memory.update(frame)
        self._falls.update(frame)
        self._tasks.run(self.joints.dcm.clock.previous)

    def abandon(self) -> None:
        """The robot is gone: calls that wait for a motion fail; the lock is held."""
        self._tasks.end(robot_gone())

    def names(self) -> dict[str, list[str]]:
        """Service -> methods, those included that only refuse."""
        return {name: list(methods) for name, methods in self._table.items()}

    def call(self, service: str, method: str, arguments: list[Any]) -> Any:
        """Carry out a call: its result, or a future of it.

        Args:
            service: name of the service.
            method: name of the method.
            arguments: as the program gave them.

        Raises:
            NaoHilError: it cannot be carried out; one sentence.
        """
        entry = self._table.get(service, {}).get(method)
        if entry is None:
            raise NaoqiRefused(f"{service}.{method} is not known here.")
        try:
            entry.signature.bind(*arguments)
        except TypeError as error:
            raise NaoqiRefused(
                f"{service}.{method}: {len(arguments)} arguments do not fit ({error})."
            ) from None
        return self._carry_out(entry, arguments)

    def _carry_out(self, entry: Method, arguments: list[Any]) -> Any:
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

        if self._walking.handover.has_robot:
            return self._walking.handover.with_joints(command, stop=entry.kind == "posture")
        return command()

    def _build(self) -> dict[str, dict[str, Method]]:
        settings = InertSettings()
        moving_postures: dict[str, Callable[..., Any]] = {
            "goToPosture": self._postures.go_to,
            "applyPosture": self._postures.apply,
            "stopMove": self.motion.end_all,
        }
        table: dict[str, dict[str, Method]] = {
            "ALMotion": self._motion_methods(settings),
            "ALMemory": of_kind("read", self.memory.methods()),
            "DCM": dcm_methods(self.joints),
            "ALRobotPosture": of_kind("read", self._postures.methods()) | of_kind("posture", moving_postures),
            "ALLeds": of_kind("read", Leds(self.joints, self._tasks).methods()),
            **small_services(self._config, self.joints),
        }
        table |= {name: of_kind("read", settings.methods(name, of)) for name, of in ABILITIES.items()}
        for name, methods in table.items():
            common = of_kind("read", self._common(name, methods))
            missing = {m: refused(name, m) for m in VENDOR.get(name, ()) if m != "subscriber"}
            table[name] = missing | common | methods
        return table

    def _motion_methods(self, settings: InertSettings) -> dict[str, Method]:
        ending_walks: dict[str, Callable[..., Any]] = {
            "wakeUp": self._postures.wake_up,
            "rest": lambda *_: self._postures.rest(),
            "killAll": self.motion.end_all,
            "killTasksUsingResources": self.motion.end_using,
            "killTask": self.motion.end_task,
            "stop": self.motion.end_task,
        }
        reading = self.motion.reading() | {"robotIsWakeUp": lambda: self._postures.awake}
        return (
            of_kind("read", reading | settings.methods("ALMotion", MOTION) | settings.arms())
            | of_kind("read", self._falls.methods())
            | of_kind("joints", self.motion.moving())
            | of_kind("posture", ending_walks)
            | of_kind("walk", self._walking.methods())
        )

    def _common(self, service: str, methods: Mapping[str, Method]) -> dict[str, Callable[..., Any]]:
        """Methods of every service."""
        return {
            "ping": lambda: True,
            "version": lambda: self._config.naoqi_version,
            "getBrokerName": lambda: "naoqi",
            "getMethodList": lambda: sorted(methods),
            "getModuleHelp": lambda: [f"{service}, served by nao-hil", []],
            "isRunning": lambda _number: False,
            "wait": lambda *_: True,
        }
