"""Sends random calls and garbage to an emulated robot in real time, by every way in, and says what ended.

Usage from the root, with qi installed: python -m tests.fuzz.robot [COUNT] [SEED] [FORMAT ...]; by default
100000, 0 and all formats. They go to each method of `serve naoqi`, the socket of `serve lola`, topics and
queries of the link, topics and tokens of `nao-hil ros`. The last line is JSON; the exit code is 1 when a
process ended or printed a traceback.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import random
import socket
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np
import zenoh
from rosbags.typesys import Stores, get_typestore

from bridge.adapters.lola.address import Address, connect
from bridge.adapters.lola.packets import actuator_map
from bridge.adapters.ros.wire import dds_name
from bridge.link import keys
from bridge.link.session import open_client
from bridge.messages import ActuatorFrame, LeaseRequest, encode
from bridge.messages.topics import TOPICS
from nao_hil.runs.supervisor import Child
from tests.fuzz.values import some
from tests.loops import repeat_while, until
from tests.ports import free_endpoint, free_port

Way = Callable[[random.Random], object]
PUBLISHED: Final = (
    *(topic.suffix for topic in TOPICS.values()),
    "nothing",
)
ROS: Final = {
    "cmd_vel": "geometry_msgs/msg/Twist",
    "joint_trajectory": "trajectory_msgs/msg/JointTrajectory",
    "posture": "std_msgs/msg/String",
    "speech": "std_msgs/msg/String",
}
"""Topics that `nao-hil ros` hears, with their types."""
QUERIES: Final = (
    *(keys.INFO, keys.LEASE, keys.GUARD, keys.STOP, keys.ARM, "world/command", "walk/command", "nothing"),
    *("dcm/set", "dcm/setAlias", "dcm/createAlias", "dcm/getTime", "dcm/getPrefix"),
)
FIELDS: Final = (
    *("version", "op", "controller", "key", "lease", "reply_to", "position", "stiffness", "command", "how"),
    *("who", "velocity", "steps", "target", "name", "value", "at", "force", "object", "time"),
)
KEY: Final = "09" + 62 * "0"
"""Of a controller; its private key is not known to the fuzzer."""
LEASES: Final = (
    LeaseRequest(op="acquire", controller="fuzz", key=KEY),
    LeaseRequest(op="release", controller="fuzz", key=KEY),
    LeaseRequest(op="status", controller="fuzz"),
)
FORMATS: Final = ("naoqi", "lola", "link", "ros")
OUTSTANDING: Final = 200
"""Calls of NAOqi that wait for their end at once."""


def payload(draw: random.Random) -> bytes:
    """A message: nothing, noise, a map of known fields, one of a controller, or one of these cut or changed."""
    kind = draw.randrange(5)
    if kind == 0:
        return draw.randbytes(draw.choice((0, 1, 10, 1000, 70_000)))
    if kind == 1:
        return msgspec.msgpack.encode({draw.choice(FIELDS): some(draw) for _ in range(draw.randrange(6))})
    if kind == 2:
        return encode(draw.choice(LEASES))
    angles = tuple(draw.uniform(-2.0, 2.0) for _ in range(25))
    data = encode(
        ActuatorFrame(reply_to=draw.randrange(10_000), position=angles, stiffness=(draw.random(),) * 25)
    )
    return data if kind == 3 else _hurt(draw, data)


def _hurt(draw: random.Random, data: bytes) -> bytes:
    """A message with some bytes changed, and its end cut off."""
    hurt = bytearray(data)
    for _ in range(draw.randrange(8)):
        hurt[draw.randrange(len(hurt))] = draw.randrange(256)
    return bytes(hurt[: draw.randrange(len(hurt) + 1)])


class NaoqiCalls:
    """Calls of all methods of all services, with any arguments.

    Args:
        url: of the server.
    """

    def __init__(self, url: str) -> None:
        import qi

        self._session = qi.Session()
        self._session.connect(url)
        names = [s["name"] for s in self._session.services()]
        services = {name: self._session.service(name) for name in names if name != "ServiceDirectory"}
        self._methods = [
            getattr(service, method)
            for service in services.values()
            for method in dir(service)
            if method[:1] != "_" and method not in dir(qi.Object) and callable(getattr(service, method))
        ]
        self._waiting: list[Any] = []
        self.bad: list[str] = []
        """Errors of calls that are tracebacks."""

    def __call__(self, draw: random.Random) -> None:
        """One of them; it is not waited for."""
        arguments = [some(draw) for _ in range(draw.randrange(6))]
        with contextlib.suppress(RuntimeError, TypeError, OverflowError, ValueError, UnicodeError):
            self._waiting.append(draw.choice(self._methods)(*arguments, _async=True))
        for _ in repeat_while(lambda: len(self._waiting) > OUTSTANDING):
            ended = [future for future in self._waiting if not future.isRunning()]
            errors = (future.error() for future in ended if future.hasError(0))
            self.bad += [error for error in errors if "Traceback" in error]
            self._waiting = [future for future in self._waiting if future.isRunning()]
            if len(self._waiting) > OUTSTANDING:  # walks and interpolations: let go of the oldest ones
                self._waiting = self._waiting[OUTSTANDING // 2 :]
                time.sleep(0.01)


class LolaClient:
    """Garbage and commands for LoLA's socket; connects anew when it is put out.

    Args:
        path: of the socket.
    """

    def __init__(self, path: str) -> None:
        self._path = path
        self._peer: socket.socket | None = None

    def __call__(self, draw: random.Random) -> None:
        """One piece."""
        if self._peer is None or draw.random() < 0.005:
            if self._peer is not None:
                self._peer.close()
            self._peer = connect(Address(path=self._path), 5.0)
            self._peer.setblocking(False)
        whole = actuator_map([draw.uniform(-3.0, 3.0) for _ in range(25)], [draw.uniform(-2.0, 2.0)] * 25)
        data = draw.choice((whole, _hurt(draw, whole), payload(draw)))
        try:
            with contextlib.suppress(BlockingIOError):
                self._peer.recv(1 << 20)
            self._peer.sendall(data)
        except OSError:
            self._peer = None


class LinkMessages:
    """Publications and queries.

    Args:
        endpoint: of the robot.
    """

    def __init__(self, endpoint: str) -> None:
        self._session: zenoh.Session = open_client(endpoint)

    def publish(self, draw: random.Random) -> None:
        """One publication."""
        self._session.put(keys.key(keys.DEFAULT_ROBOT, draw.choice(PUBLISHED)), payload(draw))

    def ask(self, draw: random.Random) -> None:
        """One query; its reply is not waited for."""
        self._session.get(
            keys.key(keys.DEFAULT_ROBOT, draw.choice(QUERIES)),
            lambda _: None,
            payload=payload(draw),
            timeout=1.0,
        )


class RosMessages:
    """Messages of a node of ROS 2, whole and hurt, and liveliness tokens with any parts.

    Args:
        endpoint: of the robot.
    """

    def __init__(self, endpoint: str) -> None:
        self._session: zenoh.Session = open_client(endpoint)
        self._store = get_typestore(Stores.ROS2_JAZZY)

    def __call__(self, draw: random.Random) -> None:
        """One of them."""
        if draw.random() < 0.02:
            parts = [
                draw.choice(("0", "x", "%", "%cmd_vel", "MS", "NN", "a%b")) for _ in range(draw.randrange(13))
            ]
            self._session.liveliness().declare_token("/".join(["@ros2_lv/0/z/0/1/MS", *parts])).undeclare()
            return
        topic = draw.choice(list(ROS))
        data = bytes(self._store.serialize_cdr(self._message(topic, draw), ROS[topic]))
        data = draw.choice((data, _hurt(draw, data), payload(draw)))
        kind = draw.choice((dds_name(ROS[topic]), "none"))
        self._session.put(f"0/{topic}/{kind}/any", data, attachment=draw.randbytes(draw.choice((0, 33))))

    def _message(self, topic: str, draw: random.Random) -> Any:
        types, number = (
            self._store.types,
            lambda: float(draw.choice((0.0, 0.2, -1.0, 1e300, math.nan, math.inf))),
        )
        if topic == "cmd_vel":
            vectors = [types["geometry_msgs/msg/Vector3"](number(), number(), number()) for _ in range(2)]
            return types[ROS[topic]](*vectors)
        if topic != "joint_trajectory":
            return types[ROS[topic]](draw.choice(("", "sit-down", "get-up", "x" * 3000)))
        time_of, point = (
            types["builtin_interfaces/msg/Duration"],
            types["trajectory_msgs/msg/JointTrajectoryPoint"],
        )
        points = []
        for _ in range(draw.randrange(4)):
            rows = [np.array([number() for _ in range(draw.randrange(3))]) for _ in range(4)]
            points.append(point(*rows, time_of(draw.randrange(-2, 3), draw.randrange(1000))))
        header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](0, 0), "")
        return types[ROS[topic]](header, draw.choices(("HeadYaw", "LHand", "LKneePitch", "?"), k=2), points)


def attack(count: int, seed: int, names: Sequence[str], folder: Path) -> dict[str, Any]:
    """Robot and servers under `count` messages in these formats; what ended."""
    os.chdir(folder)  # whatever a call writes comes here
    draw, endpoint, url = random.Random(seed), free_endpoint(), f"tcp://127.0.0.1:{free_port()}"
    path = str(folder / "robocup")
    children = [
        Child("robot", ["emulate", "--robot", "nao-v5", "--listen", endpoint, "--out", "run"], folder),
        Child("naoqi", ["serve", "naoqi", "--listen", url, "--connect", endpoint], folder),
        Child("lola", ["serve", "lola", "--socket", path, "--connect", endpoint], folder),
        Child("ros", ["ros", "--connect", endpoint], folder),
    ]
    try:
        until(lambda: "is served at" in children[1].stderr and Path(path).exists(), "the servers")
        until(lambda: "is on ROS 2" in " ".join(children[3].stderr.split()), "the robot on ROS 2")
        naoqi, lola, link, ros = (
            NaoqiCalls(url),
            LolaClient(path),
            LinkMessages(endpoint),
            RosMessages(endpoint),
        )
        every: dict[str, list[Way]] = {
            "naoqi": [naoqi],
            "lola": [lola],
            "link": [link.publish, link.ask],
            "ros": [ros],
        }
        ways = [(name, way) for name in names for way in every[name]]
        sent = dict.fromkeys(names, 0)

        for _ in range(count):
            name, way = draw.choice(ways)
            way(draw)
            sent[name] += 1
        ended = {child.name: child.stderr[-3000:] for child in children if not child.running}
    finally:
        logs = {child.name: child.end(10.0).stderr for child in reversed(children)}
    tracebacks = {
        f"{name} {i}": "Traceback" + part[:2000]
        for name, log in logs.items()
        for i, part in enumerate(log.split("Traceback")[1:])
    }
    tracebacks |= {f"call {i}": error for i, error in enumerate(naoqi.bad[:10])}
    return {"sent": sent, "ended": ended, "tracebacks": tracebacks}


def main() -> None:
    """Attack one robot."""
    count, seed = (int(given) for given in [*sys.argv[1:3], *("100000", "0")[len(sys.argv[:3]) - 1 :]])
    with tempfile.TemporaryDirectory() as folder:
        result = attack(count, seed, sys.argv[3:] or FORMATS, Path(folder))
    print(json.dumps(result), flush=True)
    os._exit(1 if result["ended"] or result["tracebacks"] else 0)  # taking qi apart can take seconds


if __name__ == "__main__":
    main()
