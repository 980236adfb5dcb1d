"""A robot on ROS 2: orders of nodes reach the walker, and the log tells who listens."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import zenoh

from bridge.adapters.ros.bridge import RosBridge, RosCounts
from bridge.adapters.ros.orders import HOLD_TIME, JointPath
from bridge.adapters.ros.wire import RosNode
from bridge.link import keys
from bridge.link.query import serve_query
from bridge.link.session import subscribe, try_client
from bridge.messages import Notice, decode, encode
from bridge.messages.walk import WALK_COMMAND, UpperBody, WalkCommand
from tests.frames import walk_status
from tests.loops import until
from tests.ports import free_endpoint
from tests.system.naoqi_robot import ObedientRobot


class Bridged:
    """A robot, a walker that writes its commands down, the bridge, and a node of somebody's."""

    def __init__(self) -> None:
        self.endpoint = free_endpoint()
        self.robot = ObedientRobot("nao-v6", self.endpoint)
        self.raw = self._session()
        self.commands: list[WalkCommand] = []
        self.upper: list[UpperBody] = []
        self.notices: list[str] = []
        self._kept = [
            serve_query(self.raw, keys.key("nao", WALK_COMMAND), self._command),
            subscribe(
                self.raw, keys.topic_key("nao", UpperBody), lambda b: self.upper.append(decode(b, UpperBody))
            ),
            subscribe(
                self.raw, keys.topic_key("nao", Notice), lambda b: self.notices.append(decode(b, Notice).text)
            ),
        ]
        self._stop = threading.Event()
        self._counts: list[RosCounts] = []
        self._thread = threading.Thread(target=self._bridge)
        self._thread.start()
        self.node = RosNode(self._session(), "rviz")
        self.states: list[Any] = []
        self.node.subscribe("joint_states", "sensor_msgs/msg/JointState", self.states.append)
        until(lambda: self.states, "joint states")

    def _session(self) -> zenoh.Session:
        session: Any = until(lambda: try_client(self.endpoint, timestamps=True), "the robot")
        return session

    def _command(self, payload: bytes, _: bytes) -> bytes:
        self.commands.append(decode(payload, WalkCommand))
        return encode(walk_status(gait="omni"))

    def _bridge(self) -> None:
        node = RosNode(self._session(), "nao")
        bridge = RosBridge("nao", self.endpoint, node, lambda _: "<robot/>", 10.0, self._stop)
        self._counts.append(bridge.run())
        node.close()

    def publish(self, topic: str, type_name: str, **fields: Any) -> None:
        publisher = self.node.publisher(topic, type_name)
        publisher.publish(self.node.store.types[type_name](**fields))

    def twist(self, x: float) -> None:
        vector = self.node.store.types["geometry_msgs/msg/Vector3"]
        zero = vector(x=0.0, y=0.0, z=0.0)
        self.publish("cmd_vel", "geometry_msgs/msg/Twist", linear=vector(x=x, y=0.0, z=0.0), angular=zero)

    def way(self, joints: list[str], *points: tuple[float, list[float]]) -> None:
        types = self.node.store.types
        time = types["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
        none = np.zeros(0)
        made = [
            types["trajectory_msgs/msg/JointTrajectoryPoint"](
                positions=np.array(positions),
                velocities=none,
                accelerations=none,
                effort=none,
                time_from_start=types["builtin_interfaces/msg/Duration"](sec=0, nanosec=round(1e9 * at)),
            )
            for at, positions in points
        ]
        header = types["std_msgs/msg/Header"](stamp=time, frame_id="")
        self.publish(
            "joint_trajectory",
            "trajectory_msgs/msg/JointTrajectory",
            header=header,
            joint_names=joints,
            points=made,
        )

    def close(self) -> RosCounts:
        self.node.close()
        self._stop.set()
        self._thread.join()
        self.raw.close()
        self.robot.close()
        return self._counts[0]


@pytest.fixture()
def bridged() -> Iterator[Bridged]:
    found = Bridged()
    yield found
    found.close()


def test_a_velocity_walks_as_long_as_it_is_repeated_and_zero_stops(bridged: Bridged) -> None:
    """The hold stops the walk of a node that is gone."""
    bridged.twist(0.1)
    until(lambda: bridged.commands, "a command")
    assert bridged.commands[0] == WalkCommand(op="walk", velocity=(0.1, 0.0, 0.0), hold=HOLD_TIME)
    bridged.twist(float("nan"))
    bridged.twist(0.0)
    until(lambda: len(bridged.commands) > 1, "a stop")
    assert bridged.commands[1].op == "stop"


def test_a_posture_is_a_motion_of_the_walker(bridged: Bridged) -> None:
    bridged.publish("posture", "std_msgs/msg/String", data="sit-down")
    until(lambda: bridged.commands, "a command")
    assert bridged.commands[0] == WalkCommand(op="motion", motion="sit-down")


def test_a_way_of_the_head_is_followed_to_its_end(bridged: Bridged) -> None:
    bridged.way(["LKneePitch"], (0.1, [1.0]))
    bridged.way(["HeadYaw", "HeadPitch"], (0.0, [0.0, 0.0]), (0.2, [0.4, -0.2]))
    until(lambda: bridged.upper and bridged.upper[-1].position == (0.4, -0.2), "the end of the way")
    yaw = [order.position[0] for order in bridged.upper]
    assert yaw == sorted(yaw)
    assert all(order.position[1] == pytest.approx(-0.5 * order.position[0]) for order in bridged.upper)
    assert {order.joints for order in bridged.upper} == {("HeadYaw", "HeadPitch")}


def test_between_two_points_of_a_way_the_joints_move_evenly() -> None:
    def point(at: int, *positions: float) -> SimpleNamespace:
        return SimpleNamespace(time_from_start=SimpleNamespace(sec=at, nanosec=0), positions=positions)

    way = JointPath(SimpleNamespace(joint_names=["HeadYaw"], points=[point(0, 0.0), point(2, 0.4)]))
    orders = [way.now(moment) for moment in (7.0, 7.5, 8.0, 9.0, 12.0)]
    assert [order.position[0] for order, _ in orders] == pytest.approx([0.0, 0.1, 0.2, 0.4, 0.4])
    assert [finished for _, finished in orders] == [False, False, False, True, True]


def test_it_ends_with_its_counts_and_the_walk_stops() -> None:
    bridged = Bridged()
    until(lambda: len(bridged.states) > 20, "some states")
    counts = bridged.close()
    assert counts.frames >= 20
    assert counts.messages > 2 * counts.frames
    assert bridged.commands[-1].op == "stop"
