"""Several robots of one link, each by its name: stopped, reset, and served to the programs of others."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import nao_hil
from bridge.body.joints import INDEX
from bridge.link import keys
from bridge.link.client import GuardClient, WorldClient
from bridge.link.session import open_client, subscribe, try_client
from bridge.messages import SensorFrame, decode
from bridge.messages.world import Status
from tests.loops import TIMEOUT, repeat_while, until
from tests.ports import free_port
from tests.system.test_lola_service import Client, pack
from tests.system.test_worlds import until_there

Start = Callable[..., Any]
HEAD = INDEX["HeadYaw"]
ANGLES = {"nao1": 0.5, "nao2": -0.4}


def words(text: str) -> str:
    return " ".join(text.split())


@pytest.fixture
def pair(start: Start, endpoint: str, tmp_path: Path) -> str:
    """Two V6 that hang, in real time; the endpoint of their link."""
    settings = ("--robot", "nao-v6", "--start", "hang", "--engine", "mujoco", "--robots", "2")
    start("emulate", *settings, "--listen", endpoint, "--out", str(tmp_path / "run"))
    until_there(endpoint, len(ANGLES))
    return endpoint


def head(endpoint: str, name: str) -> float:
    with open_client(endpoint) as session:
        seen: list[float] = []
        key = keys.topic_key(name, SensorFrame)
        kept = subscribe(session, key, lambda b: seen.append(decode(b, SensorFrame).position[HEAD]))
        until(lambda: seen, "a frame")
        kept.undeclare()
    return seen[-1]


def test_a_robot_is_stopped_by_its_name_and_all_at_once(start: Start, pair: str) -> None:
    where = ("--connect", pair)
    with GuardClient("nao1", pair) as first, GuardClient("nao2", pair) as second:
        stopped = start("stop", "nao2", *where, "--json")
        assert stopped.wait() == 0 and stopped.result["armed"] is False
        assert (first.status().armed, second.status().armed) == (True, False)
        armed = start("arm", "nao2", "--yes", *where)
        assert armed.wait() == 0 and second.status().armed
        both = start("stop", "--all", *where, "--json")
        assert both.wait() == 0
        assert [status["armed"] for status in both.result["robots"].values()] == [False, False]
        assert list(both.result["robots"]) == ["nao1", "nao2"]
        assert not first.status().armed and not second.status().armed


def test_a_wrong_name_is_answered_with_the_names_that_are_there(
    start: Start, pair: str, tmp_path: Path
) -> None:
    """A command that the machine starves may end before it has the names; it is asked again."""
    lola = ("serve", "lola", "--socket", str(tmp_path / "lola"))
    named = (("walk",), ("world", "reset"), lola, ("ros",), ("record",))
    lines = [("stop", "nao3"), *((*command, "--name", "nao3") for command in named)]
    running = {line: start(*line, "--connect", pair) for line in lines}

    def lists_names(line: tuple[str, ...]) -> bool:
        if "`nao1`, `nao2`" in words(running[line].stderr):
            return True
        if running[line].process.poll() is not None:
            running[line] = start(*line, "--connect", pair)
        return False

    for line in lines:
        until(lambda line=line: lists_names(line), f"the names that {line[0]} may have", pause=0.1)


def test_one_robot_of_the_link_is_reset_by_its_name(start: Start, pair: str) -> None:
    with WorldClient("nao1", pair) as first, WorldClient("nao2", pair) as second:
        until(lambda: second.send(Status()).seq > 200, "some cycles")
        assert start("world", "reset", "--name", "nao2", "--connect", pair).wait() == 0
        one, other = first.send(Status()), second.send(Status())
        assert other.seq < one.seq - 200


def test_a_ball_is_placed_in_front_of_a_robot_by_its_name(start: Start, pair: str) -> None:
    """The robots stand side by side, 0.8 m apart, and look along x."""
    with WorldClient("nao1", pair) as world:
        assert start("world", "place", "ball", "0.5", "-0.1", "--name", "nao2", "--connect", pair).wait() == 0
        (ball,) = (thing for thing in world.send(Status()).objects if thing.name == "ball")
        assert (ball.shape, ball.mass, ball.size) == ("ball", 0.044, (0.1, 0.1, 0.1))
        assert ball.position[0] == pytest.approx(0.5, abs=0.1)
        assert abs(ball.position[1]) > 0.4  # not in front of the first one, at y = 0
        assert start("world", "remove", "ball", "--name", "nao2", "--connect", pair).wait() == 0


def test_a_server_that_ends_is_named_and_the_others_go_on(start: Start, pair: str, tmp_path: Path) -> None:
    (tmp_path / "lola-nao2").mkdir()  # its server cannot listen
    served = start("serve", "lola", "--all", "--socket", str(tmp_path / "lola"), "--connect", pair, "--json")
    until(lambda: "nao2: has ended" in words(served.stderr), "the end of one")
    until((tmp_path / "lola-nao1").exists, "the other's socket")
    client = Client(str(tmp_path / "lola-nao1"))
    assert client.read()["Position"]
    client.socket.close()
    served.interrupt()
    assert served.process.returncode == 3
    assert served.result["robots"]["nao1"]["clients"] == 1 and "`nao2`" in words(served.stderr)


def test_each_robot_has_a_lola_socket(start: Start, pair: str, tmp_path: Path) -> None:
    served = start("serve", "lola", "--all", "--socket", str(tmp_path / "lola"), "--connect", pair, "--json")
    paths = {name: tmp_path / f"lola-{name}" for name in ANGLES}
    until(lambda: all(path.exists() for path in paths.values()), "the sockets")
    clients = {name: Client(str(path)) for name, path in paths.items()}

    def turned(name: str) -> bool:
        read = clients[name].read()
        clients[name].send(pack(Position=[ANGLES[name], *[0.0] * 24], Stiffness=[0.8] * 25))
        return abs(float(read["Position"][0]) - ANGLES[name]) < 0.1

    until(lambda: all([turned(name) for name in ANGLES]), "both heads")
    for client in clients.values():
        client.socket.close()
    served.interrupt()
    assert {name: result["clients"] for name, result in served.result["robots"].items()} == {
        "nao1": 1,
        "nao2": 1,
    }
    assert not any(path.exists() for path in paths.values())


def test_each_robot_has_a_port_of_naoqi(start: Start, pair: str) -> None:
    qi = pytest.importorskip("qi")
    port = free_port(len(ANGLES))
    url = f"tcp://127.0.0.1:{port}"
    served = start("serve", "naoqi", "--all", "--listen", url, "--connect", pair, "--json")
    until(lambda: words(served.stderr).count("is served at") == 2, "both servers")
    for number, name in enumerate(ANGLES):
        session = qi.Session()
        session.connect(f"tcp://127.0.0.1:{port + number}")
        motion = session.service("ALMotion")

        def turned(name: str = name, motion: Any = motion) -> bool:
            """Whether its head is there; the guard of a server that was starved takes it back."""
            motion.setStiffnesses("Head", 1.0)
            motion.angleInterpolation("HeadYaw", ANGLES[name], 1.0, True)
            return abs(head(pair, name) - ANGLES[name]) < 0.1

        until(turned, f"the head of {name}")
        session.close()
    served.interrupt()
    assert all(result["calls"] > 0 for result in served.result["robots"].values())


def test_each_robot_has_a_namespace_of_ros(start: Start, pair: str) -> None:
    pytest.importorskip("rosbags")
    from bridge.adapters.ros.wire import RosNode

    with nao_hil.connect(pair, robot="nao2", timeout=TIMEOUT) as robot:
        position = list(robot.first_target)
        position[HEAD] = 0.5
        for _ in repeat_while(lambda: abs(robot.frame.position[HEAD] - 0.5) > 0.1):
            robot.step(position)
    served = start("ros", "--all", "--connect", pair, "--json")
    session = until(lambda: try_client(pair, timestamps=True), "the link")
    node = RosNode(session, "listener")
    heads: dict[str, float] = {}
    for name in ANGLES:
        node.subscribe(
            f"{name}/joint_states",
            "sensor_msgs/msg/JointState",
            lambda state, name=name: heads.update({name: state.position[state.name.index("HeadYaw")]}),
        )
    until(lambda: len(heads) == 2, "the states of both")
    until(lambda: "/nao2/joint_states" in words(served.stderr), "the listener to be named")
    node.close()
    served.interrupt()
    assert abs(heads["nao1"]) < 0.1 < 0.3 < heads["nao2"]
    assert all(result["messages"] > 0 for result in served.result["robots"].values())
