"""The wire format of rmw_zenoh against what hiroz 0.2.1, an independent implementation, put on the wire."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
import zenoh

from bridge.adapters.ros.wire import Listening, RosNode
from bridge.link.session import open_robot, try_client
from tests.loops import until
from tests.ports import free_endpoint

TWIST = (
    "geometry_msgs::msg::dds_::Twist_/RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"
)
NODE = "@ros2_lv/0/99ea50c5f8bccdd7704992b134e21759/0/0/NN/%/%/probe"
PUBLISHER = f"@ros2_lv/0/99ea50c5f8bccdd7704992b134e21759/0/1/MP/%/%/probe/%cmd_vel/{TWIST}/::,10:,:,:,,"
SUBSCRIBER = PUBLISHER.replace("/MP/", "/MS/")
KEY = f"0/cmd_vel/{TWIST}"
ZERO_TWIST = bytes.fromhex("00010000" + 48 * "00")
ATTACHMENT = bytes.fromhex("00000000000000005e8d950a0cc0eb1810590afadb08907ca9dd026f3b39157938")
SESSION = 2
"""Part of a token that names the session."""


class Graph:
    """A router, a session that sees all, and nodes."""

    def __init__(self) -> None:
        self.endpoint = free_endpoint()
        self.router = open_robot(self.endpoint)
        self.raw = self.session()
        self.tokens: list[str] = []
        self.samples: list[zenoh.Sample] = []
        self._kept = [
            self.raw.liveliness().declare_subscriber(
                "@ros2_lv/**", lambda s: self.tokens.append(str(s.key_expr)), history=True
            ),
            self.raw.declare_subscriber("*/cmd_vel/**", self.samples.append),
        ]

    def session(self) -> zenoh.Session:
        session: Any = until(lambda: try_client(self.endpoint, timestamps=True), "the router")
        return session

    def node(self, name: str = "probe", **options: Any) -> RosNode:
        return RosNode(self.session(), name, **options)

    def close(self) -> None:
        self.raw.close()
        self.router.close()


@pytest.fixture()
def graph() -> Iterator[Graph]:
    found = Graph()
    yield found
    found.close()


def nameless(token: str) -> list[str]:
    """Parts of a token but for the session."""
    parts = token.split("/")
    return parts[:SESSION] + parts[SESSION + 1 :]


def twist(node: RosNode, x: float) -> Any:
    types = node.store.types
    vector = types["geometry_msgs/msg/Vector3"]
    return types["geometry_msgs/msg/Twist"](
        linear=vector(x=x, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=0.0)
    )


def test_a_node_and_its_publisher_look_like_those_of_hiroz(graph: Graph) -> None:
    node = graph.node()
    publisher = node.publisher("cmd_vel", "geometry_msgs/msg/Twist")
    until(lambda: len(graph.tokens) == 2, "two tokens")
    assert sorted(map(nameless, graph.tokens)) == sorted(map(nameless, (NODE, PUBLISHER)))
    publisher.publish(twist(node, 0.0))
    until(lambda: graph.samples, "a message")
    sample = graph.samples[0]
    assert str(sample.key_expr) == KEY
    assert sample.payload.to_bytes() == ZERO_TWIST
    attachment = sample.attachment
    assert attachment is not None
    assert len(attachment.to_bytes()) == len(ATTACHMENT)
    assert attachment.to_bytes()[16] == ATTACHMENT[16]
    node.close()


def test_a_message_of_hiroz_is_heard_and_one_that_is_none_is_not(graph: Graph) -> None:
    node, heard = graph.node(), []
    node.subscribe("cmd_vel", "geometry_msgs/msg/Twist", heard.append)
    until(lambda: len(graph.tokens) == 2, "two tokens")
    assert nameless(SUBSCRIBER) in map(nameless, graph.tokens)
    graph.raw.put(KEY, b"\x00\x01", attachment=ATTACHMENT)
    graph.raw.put(KEY, ZERO_TWIST, attachment=ATTACHMENT)
    until(lambda: heard, "a message")
    assert heard == [twist(node, 0.0)]
    node.close()


def test_a_node_of_hiroz_is_seen_to_listen_until_it_goes(graph: Graph) -> None:
    node = graph.node("nao")
    other = graph.session()
    token = other.liveliness().declare_token(SUBSCRIBER)
    until(lambda: node.listening == {Listening("/probe", "cmd_vel")}, "a listener")
    token.undeclare()
    until(lambda: not node.listening, "its end")
    other.close()
    node.close()


def test_a_latched_message_reaches_a_later_subscriber(graph: Graph) -> None:
    node = graph.node()
    publisher = node.publisher("robot_description", "std_msgs/msg/String", latched=True)
    publisher.publish(node.store.types["std_msgs/msg/String"](data="<robot/>"))
    key = "0/robot_description/std_msgs::msg::dds_::String_/*"
    heard: list[Any] = []
    late = zenoh.ext.declare_advanced_subscriber(
        graph.raw, key, heard.append, history=zenoh.ext.HistoryConfig(detect_late_publishers=True)
    )
    until(lambda: heard, "the message")
    assert heard[0].payload.to_bytes().endswith(b"<robot/>\0")
    late.undeclare()
    node.close()


def test_another_domain_hears_nothing(graph: Graph) -> None:
    node, other, heard, ours = graph.node(domain=1), graph.node(domain=2), [], []
    other.subscribe("cmd_vel", "geometry_msgs/msg/Twist", heard.append)
    node.subscribe("cmd_vel", "geometry_msgs/msg/Twist", ours.append)
    node.publisher("cmd_vel", "geometry_msgs/msg/Twist").publish(twist(node, 1.0))
    until(lambda: graph.samples and ours, "the message")
    assert heard == []
    node.close()
    other.close()
