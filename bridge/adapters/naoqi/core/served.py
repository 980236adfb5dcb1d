"""The served robot: the parts that its services share, and the base class of a service.

A service refuses a call by `NaoqiRefused`, one sentence.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from pathlib import Path
from threading import RLock
from typing import Any

from bridge.adapters.naoqi.core.cameras import CameraFeed
from bridge.adapters.naoqi.core.frames import RobotFrames
from bridge.adapters.naoqi.core.joint_motion import JointMotion
from bridge.adapters.naoqi.core.joints import Joints
from bridge.adapters.naoqi.core.memory import Events, Memory, Publish
from bridge.adapters.naoqi.core.motion_tasks import MotionTasks
from bridge.adapters.naoqi.core.robot_facts import RobotConfig
from bridge.adapters.naoqi.core.walking import WalkingMethods
from bridge.adapters.naoqi.declared import VENDOR_METHODS, declared
from bridge.adapters.naoqi.robot_files import RobotFiles
from bridge.messages import SensorFrame


class ServedRobot:
    """Parts of one robot, from its first frame on; not thread-safe, the caller locks.

    Args:
        publish: called for each event of ALMemory.
        home: folder that stands for its `/home/nao`; made at the first file.
        has_signal: as of `Events`.
    """

    def __init__(
        self,
        config: RobotConfig,
        frame: SensorFrame,
        lock: RLock,
        walking: WalkingMethods,
        publish: Publish,
        home: Path,
        feed: CameraFeed | None = None,
        has_signal: Callable[[str], bool] = lambda _: False,
    ) -> None:
        self.lock, self.walking = lock, walking
        self.config, self.body, self.publish = config, config.body, publish
        self.listeners: list[Callable[[str, Any], None]] = []
        """Called with each event after its publication."""
        self.joints = Joints(config.body, frame)
        self.numbers = itertools.count(1)
        """Numbers of the next motions, calls and files."""
        self.tasks, self.others = MotionTasks(self.numbers), MotionTasks(self.numbers)
        """Motions of joints; and other lasting calls, which a stop of all motions leaves alone."""
        self.motion = JointMotion(self.joints, self.tasks, config)
        self.walks: dict[str, Callable[..., Any]] = {
            name: method.call for name, method in declared(walking).get("ALMotion", {}).items()
        }
        """Walking methods of ALMotion by name."""
        self.frames = RobotFrames(self.joints, self.place, walking.steps_ahead)
        self.memory = Memory(config.body, lambda: self.joints.dcm, config.keys())
        self.memory.provide(self.joints.keys())
        self.memory.update(frame)
        self.events = Events(self.memory, self._publish_event, has_signal)
        for service, of in VENDOR_METHODS.items():
            for event, value in of.events.items():
                self.events.declare(event, service, None if value == {} else value)
        self.files = RobotFiles(home, lock)
        self.feed = feed or CameraFeed()

    def _publish_event(self, event: str, value: Any, callbacks: list[list[Any]]) -> None:
        self.publish(event, value, callbacks)
        for listen in self.listeners:
            listen(event, value)

    def place(self) -> Sequence[float]:
        """Pose of the robot's space in the world's, by the odometry: x, y (m) and yaw (rad)."""
        position = self.walks.get("getRobotPosition")
        place: Sequence[float] = position(False) if position else (0.0, 0.0, 0.0)
        return place


class Service:
    """Methods of services of one robot; not thread-safe, the caller locks."""

    service = ""
    """Service of the names that begin with a dot."""

    def __init__(self, robot: ServedRobot) -> None:
        self._robot, self._body, self.files = robot, robot.body, robot.files
        self._joints, self._motion, self._frames = robot.joints, robot.motion, robot.frames
        self._events, self._memory = robot.events, robot.memory
        self._tasks, self._others = robot.tasks, robot.others

    def _now(self) -> int:
        """The robot's clock, ms."""
        return self._joints.now
