"""Orders of ROS nodes: velocities of the walk, paths of head and arms, motions, and speech."""

from __future__ import annotations

import contextlib
import itertools
import logging
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any, Final

import msgspec
import numpy as np
import zenoh

from bridge.adapters.naoqi.interaction.speech import Voice
from bridge.adapters.ros.wire import RosNode
from bridge.body.joints import UPPER_JOINTS
from bridge.errors import NaoHilError
from bridge.link import keys
from bridge.link.client import WalkClient
from bridge.messages import encode
from bridge.messages.walk import UpperBody
from bridge.types import Array, Vec3

logger = logging.getLogger(__name__)

HOLD_TIME: Final = 0.5
"""s after the last velocity at which the walk stops."""
_VELOCITY_RATE: Final = 10.0
"""Orders to the walker a second."""
_PATH_RATE: Final = 50.0
"""Points a second of the path of head and arms."""
_MAX_PATH_DURATION: Final = 600.0
"""s of a path"""
_PATH_STIFFNESS: Final = 0.7


class RosCounts(msgspec.Struct):
    """Counts of a bridge; the JSON of `nao-hil ros`."""

    frames: int = 0
    messages: int = 0
    pictures: int = 0
    orders: int = 0


class Orders:
    """Takes the orders of one robot; close it.

    Args:
        robot: id of the robot.
        connect: Zenoh endpoint of the robot.
        session: to it.
        node: of the ROS graph.
        counts: counts the orders.
    """

    def __init__(
        self, robot: str, connect: str, session: zenoh.Session, node: RosNode, counts: RosCounts
    ) -> None:
        self._counts = counts
        self._walker = WalkClient(robot, connect)
        self._upper = session.declare_publisher(keys.topic_key(robot, UpperBody))
        self._voice = Voice()
        self._ended = threading.Event()
        self._velocity: Vec3 | None = None
        """The newest unsent one."""
        self._path: JointPath | None = None
        node.subscribe("cmd_vel", "geometry_msgs/msg/Twist", self._on_velocity)
        node.subscribe("joint_trajectory", "trajectory_msgs/msg/JointTrajectory", self._on_path)
        node.subscribe("posture", "std_msgs/msg/String", self._on_posture)
        node.subscribe("speech", "std_msgs/msg/String", self._on_speech)
        self._threads = [
            threading.Thread(target=work, name=name)
            for name, work in (("velocities", self._send_velocities), ("paths", self._send_paths))
        ]
        for thread in self._threads:
            thread.start()

    def _on_velocity(self, twist: Any) -> None:
        velocity = (float(twist.linear.x), float(twist.linear.y), float(twist.angular.z))
        if np.isfinite(velocity).all():
            self._velocity = velocity

    def _send_velocities(self) -> None:
        """Send the newest velocity at a limited rate; after the last one the walker's hold stops the walk."""
        while not self._ended.wait(1.0 / _VELOCITY_RATE):
            velocity, self._velocity = self._velocity, None
            if velocity is None:
                continue
            self._counts.orders += 1
            if any(velocity):
                self._run_logged("cmd_vel", partial(self._walker.walk, velocity, hold=HOLD_TIME))
            else:
                self._run_logged("cmd_vel", self._walker.stop)

    def _on_path(self, message: Any) -> None:
        try:
            self._path = JointPath(message)
        except ValueError as error:
            logger.warning("joint_trajectory: %s", error)
        else:
            self._counts.orders += 1

    def _send_paths(self) -> None:
        while not self._ended.wait(1.0 / _PATH_RATE):
            path = self._path
            if path is not None:
                order, finished = path.now(time.monotonic())
                self._upper.put(encode(order))
                if finished and self._path is path:
                    self._path = None

    def _on_posture(self, message: Any) -> None:
        """Play one of the walker's motions, for example `sit-down`."""
        self._counts.orders += 1
        self._begin("posture", lambda: self._walker.motion(message.data))

    def _on_speech(self, message: Any) -> None:
        self._counts.orders += 1
        logger.info("the robot says: %s", message.data[:1000])
        self._begin("speech", lambda: self._voice.speak(message.data[:1000], "English", 100.0, 1.0))

    def _begin(self, topic: str, work: Callable[[], Any]) -> None:
        """Carry out a lasting order in a thread of its own, for which Zenoh's does not wait."""
        threading.Thread(target=self._run_logged, args=(topic, work), daemon=True).start()

    @staticmethod
    def _run_logged(topic: str, work: Callable[[], Any]) -> None:
        try:
            work()
        except NaoHilError as error:
            logger.warning("%s: %s", topic, error)

    def close(self) -> None:
        """End a walk, and take no more orders."""
        self._ended.set()
        for thread in self._threads:
            thread.join()
        with contextlib.suppress(NaoHilError):
            self._walker.stop()
        self._walker.close()


class JointPath:
    """A `JointTrajectory` of head and arms, linear between its points, from the first call of `now` on.

    Raises:
        ValueError: other joints, or points that do not fit.
    """

    def __init__(self, message: Any) -> None:
        self._joints = tuple(message.joint_names)
        others = [joint for joint in self._joints if joint not in UPPER_JOINTS]
        if others or not self._joints:
            raise ValueError(f"{', '.join(others)[:200] or 'no joint'} cannot be moved; head and arms can")
        times = [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in message.points]
        if not times or any(b <= a for a, b in itertools.pairwise(times)) or times[0] < 0.0:
            raise ValueError("the times of its points must increase from 0 on")
        if times[-1] > _MAX_PATH_DURATION:
            raise ValueError(f"it lasts longer than {_MAX_PATH_DURATION:g} s")
        if any(len(p.positions) != len(self._joints) for p in message.points):
            raise ValueError("each point needs a position for each joint")
        self._times, self._points = np.array(times), np.array([p.positions for p in message.points])
        if not np.isfinite(self._points).all():
            raise ValueError("its positions must be finite")
        self._began: float | None = None

    def now(self, moment: float) -> tuple[UpperBody, bool]:
        """The order for a moment, and whether it is the last one."""
        self._began = moment if self._began is None else self._began
        passed = moment - self._began
        position = self._at(passed)
        stiffness = (_PATH_STIFFNESS,) * len(self._joints)
        order = UpperBody(joints=self._joints, position=tuple(position.tolist()), stiffness=stiffness)
        return order, bool(passed >= self._times[-1])

    def _at(self, passed: float) -> Array:
        return np.array([np.interp(passed, self._times, column) for column in self._points.T])
