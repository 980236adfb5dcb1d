"""The qi server against the vendor's client, which is libqi."""

from __future__ import annotations

import asyncio
import logging
import random
import socket
import struct
import threading
from collections.abc import Iterator
from concurrent.futures import Future
from types import SimpleNamespace
from typing import Any

import pytest

from bridge.adapters.naoqi.qi_connection import Message
from bridge.adapters.naoqi.qi_directory import Directory, meta_object
from bridge.adapters.naoqi.qi_server import QiServer
from bridge.adapters.naoqi.qi_values import QiError
from bridge.errors import NaoqiRefused
from tests.loops import TIMEOUT, until
from tests.ports import free_port

qi = pytest.importorskip("qi", reason="qi has no wheel here")
SERVICES = {"ALMemory": ["echo", "subscribeToEvent"], "ALVideoDevice": ["getImageRemote", "refuse"]}


def call(service: str, method: str, arguments: list[Any]) -> Any:
    if method == "refuse":
        raise NaoqiRefused("ALVideoDevice: no.")
    if method == "getImageRemote":
        later: Future[Any] = Future()
        threading.Timer(0.05, lambda: later.set_result([2, 1, b"\xff\x00\x80", 0.5])).start()
        return later
    return arguments


class Served:
    """A server and a client of it."""

    def __init__(self) -> None:
        self.port = free_port()
        self.server = QiServer(f"tcp://127.0.0.1:{self.port}", SERVICES, call)
        self.session = qi.Session()
        self.session.connect(f"tcp://127.0.0.1:{self.port}")

    def close(self) -> None:
        self.session.close()
        self.server.close()


@pytest.fixture()
def served() -> Iterator[Served]:
    found = Served()
    yield found
    found.close()


def test_calls_carry_values_both_ways(served: Served) -> None:
    memory = served.session.service("ALMemory")
    given = [1, 2.5, "ä", [True, None, [3]], {"a": 1}, -5, 1 << 40]
    assert memory.echo(*given) == given
    assert memory.echo() == []
    assert served.server.calls == 2


def test_a_picture_arrives_as_raw_bytes(served: Served) -> None:
    picture = served.session.service("ALVideoDevice").getImageRemote("handle")
    assert picture == [2, 1, bytearray(b"\xff\x00\x80"), 0.5]


def test_a_refusal_is_its_sentence(served: Served) -> None:
    with pytest.raises(RuntimeError, match=r"^ALVideoDevice: no\.$"):
        served.session.service("ALVideoDevice").refuse()
    with pytest.raises(RuntimeError, match="Cannot find service 'ALNothing'"):
        served.session.service("ALNothing")


def test_an_event_reaches_its_subscribers_and_no_others(served: Served) -> None:
    memory, heard, other = served.session.service("ALMemory"), [], []
    subscriber = memory.subscriber("FrontTactilTouched")
    link = subscriber.signal.connect(heard.append)
    silent = memory.subscriber("RearTactilTouched")
    silent.signal.connect(other.append)
    for count, value in enumerate((1.0, 0.0), start=1):  # libqi calls back from several threads, in no order
        served.server.publish("FrontTactilTouched", value, [])
        until(lambda count=count: len(heard) == count, "the event")
    subscriber.signal.disconnect(link)
    served.server.publish("FrontTactilTouched", 1.0, [])
    memory.echo()
    assert heard == [1.0, 0.0]
    assert other == []


def test_two_subscribers_of_one_program_are_both_called(served: Served) -> None:
    """With one object for both, libqi gives the reply of the second connect to the wrong one, and it hangs."""
    memory, heard = served.session.service("ALMemory"), list[tuple[int, float]]()
    keep = [memory.subscriber("FrontTactilTouched") for _ in range(2)]
    for number, subscriber in enumerate(keep):
        connected = subscriber.signal.connect(lambda v, n=number: heard.append((n, v)), _async=True)
        assert connected.wait(round(1000 * TIMEOUT)) == qi.FutureState.FinishedWithValue
    served.server.publish("FrontTactilTouched", 1.0, [])
    until(lambda: len(heard) == 2, "both calls")
    assert sorted(heard) == [(0, 1.0), (1, 1.0)]


def test_the_objects_of_a_program_that_is_gone_are_dropped(served: Served) -> None:
    other = qi.Session()
    other.connect(f"tcp://127.0.0.1:{served.port}")
    keep = [other.service("ALMemory").subscriber(f"event {i}") for i in range(3)]
    assert len(served.server._objects) == len(keep)
    assert served.server.has_signal("event 2")
    other.close()
    until(lambda: not served.server._objects, "the end of its objects")
    assert not served.server.has_signal("event 2")


def test_a_long_message_delays_no_other_call(served: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    decoding, decoded, values = threading.Event(), threading.Event(), Message.values

    def slow(message: Message, signature: str) -> list[Any]:
        if len(message.payload) > 1 << 20:
            decoding.set()
            decoded.wait(TIMEOUT)
        return values(message, signature)

    monkeypatch.setattr(Message, "values", slow)
    memory = served.session.service("ALMemory")
    long = memory.echo("x" * (1 << 20), _async=True)
    assert decoding.wait(TIMEOUT)
    assert memory.echo(1) == [1]
    decoded.set()
    assert len(long.value()[0]) == 1 << 20


def test_a_message_that_is_too_long_is_refused_and_the_next_one_is_answered(served: Served) -> None:
    memory = served.session.service("ALMemory")
    with pytest.raises(RuntimeError, match=str(1 << 24)):
        memory.echo("x" * (1 << 24))
    assert memory.echo(1) == [1]


def test_a_module_of_a_program_is_called_in_the_order_of_the_events(served: Served) -> None:
    heard: list[Any] = []

    class Module:
        def on(self, *arguments: Any) -> None:
            heard.append(arguments)

    memory = served.session.service("ALMemory")
    served.session.registerService("Mine", Module())
    assert "Mine" in [service["name"] for service in served.session.services()]
    assert memory.subscribeToEvent("event", "Mine", "on") == ["event", "Mine", "on"]
    for number in range(5):
        served.server.publish("event", number, [["Mine", "on", "message"], ["Nobody", "on", ""]])
    until(lambda: len(heard) == 5, "five calls")
    assert heard == [("event", number, "message") for number in range(5)]
    with pytest.raises(RuntimeError, match=r"Mine.*off"):
        memory.subscribeToEvent("event", "Mine", "off")


def test_a_module_that_is_registered_after_its_subscription_is_called(served: Served) -> None:
    """As in public programs, which subscribe in the module's constructor."""
    heard: list[Any] = []
    assert served.session.service("ALMemory").subscribeToEvent("event", "Late", "on") == ["event", "Late", "on"]
    served.server.publish("event", 0, [["Late", "on", ""]])
    module = type("Late", (), {"on": lambda self, *arguments: heard.append(arguments)})()
    served.session.registerService("Late", module)

    def called() -> bool:
        served.server.publish("event", 1, [["Late", "on", ""]])  # a call before libqi takes calls is lost
        return ("event", 1, "") in heard

    until(called, "the call", pause=0.1)


def test_a_module_is_called_only_once_its_program_says_that_it_is_ready() -> None:
    """libqi binds a service between its registration and `serviceReady`, and refuses calls before."""
    asked: list[int] = []

    async def describe(number: int, *_: Any) -> bytes:
        asked.append(number)
        return meta_object({100: ("on", "(m)", "v")}, {})

    program: Any = SimpleNamespace(takes_calls=True, call=describe, event=lambda *_: None)
    directory = Directory([])
    number = directory.call(program, "registerService", [["Late", 0, "", 0, [], "", ""]])
    with pytest.raises(QiError, match="Late"):
        asyncio.run(directory.module("Late"))
    assert not asked
    directory.call(program, "serviceReady", [number])
    assert "on" in asyncio.run(directory.module("Late")).actions
    assert asked == [number]


def test_log_manager_tells_the_servers_log(served: Served) -> None:
    """A ROS driver asks for its listener when it starts, and splits `source` at colons."""
    heard: list[Any] = []
    manager, second = served.session.service("LogManager"), list[Any]()
    listener, other = manager.getListener(), manager.createListener()
    listener.onLogMessage.connect(heard.append)
    connected = other.onLogMessage.connect(second.append, _async=True)
    assert connected.wait(round(1000 * TIMEOUT)) == qi.FutureState.FinishedWithValue
    listener.clearFilters()
    logging.getLogger("bridge.test").warning("the robot is %s", "gone")
    until(lambda: heard and second, "a message of the log for both")
    assert heard[0]["message"] == "the robot is gone"
    assert heard[0]["level"] == {"level": 3}
    assert len(heard[0]["source"].split(":")) == 3


def test_an_old_client_that_does_not_authenticate_is_told_the_capabilities_and_answered(served: Served) -> None:
    head = struct.pack(">I", 0x42DEAD42) + struct.pack("<IIHBBIII", 7, 0, 0, 1, 0, 1, 1, 108)
    with socket.create_connection(("127.0.0.1", served.port)) as client, client.makefile("rb") as stream:
        client.sendall(head)
        kinds = []
        for _ in range(2):
            header = stream.read(28)
            _, size, _, kind, *_ = struct.unpack("<IIHBBIII", header[4:])
            stream.read(size)
            kinds.append(kind)
    assert kinds == [6, 2]


def test_garbage_ends_no_server(served: Served) -> None:
    draw = random.Random(45)
    for _ in range(20):
        with socket.create_connection(("127.0.0.1", served.port)) as client:
            for _ in range(200):
                payload = draw.randbytes(draw.randrange(60))
                address = [draw.randrange(4) for _ in range(2)] + [draw.choice((0, 2, 8, 100, 101, 102, 104))]
                size = draw.choice((len(payload), len(payload), draw.randrange(1 << 26)))
                header = struct.pack("<IIHBBIII", 1, size, 0, draw.randrange(9), draw.randrange(3), *address)
                try:
                    client.sendall(struct.pack(">I", 0x42DEAD42) + header + payload)
                except OSError:
                    break  # put out: a size that no message has
    assert served.session.service("ALMemory").echo(1) == [1]
