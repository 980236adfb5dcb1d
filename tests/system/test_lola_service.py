"""A served LoLA, its robot a thread of the test, its client a raw socket and a msgpack as teams write it."""

from __future__ import annotations

import contextlib
import select
import socket
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgpack
import msgspec
import pytest

from bridge.adapters.lola.address import listen, parse_address
from bridge.adapters.lola.client import ClientGone, LolaClient
from bridge.adapters.lola.packets import Identity
from bridge.adapters.lola.server import LolaServer, Served
from bridge.dcm.actuators import led_names
from bridge.link import ControllerLink, RobotLink
from bridge.messages import ActuatorFrame
from tests.frames import info_of_robot, standing_frame
from tests.loops import TIMEOUT, repeat_while, until

STILL = standing_frame(position=tuple(0.01 * slot for slot in range(25)), stiffness=(0.5,) * 25)


def pack(**values: Any) -> bytes:
    return bytes(msgpack.packb(values, use_single_float=True, use_bin_type=False))


class Client:
    """As team code does it: connect, read 896 bytes, write a reply."""

    def __init__(self, path: str) -> None:
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(TIMEOUT)
        self.socket.connect(path)

    def read(self) -> dict[str, Any]:
        data = b""
        for _ in range(896):
            if len(data) == 896:
                break
            piece = self.socket.recv(896 - len(data))
            if not piece:
                raise EOFError
            data += piece
        values: dict[str, Any] = msgpack.unpackb(data)
        return values

    def send(self, data: bytes) -> None:
        self.socket.sendall(data)

    def drain(self) -> None:
        """Read away whatever has come."""
        for _ in repeat_while(lambda: select.select([self.socket], [], [], 0.0)[0], 1000):
            if not self.socket.recv(1 << 16):
                break


class Robot:
    """The robot's side of the link: a frame when told to, and the commands that came."""

    def __init__(self, link: RobotLink, cycle: float) -> None:
        self.link, self.cycle = link, cycle
        self.seq = -1
        self.ended = threading.Event()
        self._thread = threading.Thread(target=self._repeat)
        self._thread.start()

    def publish(self) -> None:
        """The next frame."""
        self.seq += 1
        self._send()

    def _send(self) -> None:
        frame = msgspec.structs.replace(STILL, seq=self.seq, time=self.seq * self.cycle)
        self.link.publish(frame)

    def _repeat(self) -> None:
        """A robot in lockstep sends its frame again while no answer comes."""
        for _ in repeat_while(lambda: not self.ended.wait(0.1), 10_000):
            if self.seq >= 0:
                self._send()

    def end(self) -> None:
        self.ended.set()
        self._thread.join()

    def command(self, **fields: Any) -> ActuatorFrame:
        """The next command that answers the present frame and has these values.

        A frame that was sent again may have been answered before the client's next demand.
        """

        def wanted() -> ActuatorFrame | None:
            command = self.link.wait_command(0.1)
            fits = command is not None and command.reply_to == self.seq
            return command if fits and all(getattr(command, k) == v for k, v in fields.items()) else None

        command: ActuatorFrame = until(wanted, f"a command with {fields}")
        return command


@pytest.fixture
def served(
    endpoint: str, tmp_path: Path
) -> Iterator[Callable[..., tuple[Robot, Callable[[], Client], Callable[[], Served]]]]:
    """Start a robot and a service over it; gives the robot, a maker of clients, and what ends the service."""
    with contextlib.ExitStack() as stack:

        def begin(
            mode: str = "lockstep", cycle: float = 0.012
        ) -> tuple[Robot, Callable[[], Client], Callable[[], Served]]:
            path, stop, results = str(tmp_path / "robocup"), threading.Event(), []
            info = info_of_robot(body="nao-v6", mode=mode, cycle=cycle)
            robot = stack.enter_context(RobotLink(info, endpoint))
            link = stack.enter_context(ControllerLink("nao", endpoint, "lola"))
            listener = stack.enter_context(listen(parse_address(path)))
            service = LolaServer(link, listener, Identity(), stop)
            thread = threading.Thread(target=lambda: results.append(service.run()))
            thread.start()

            def connect() -> Client:
                client = Client(path)
                stack.callback(client.socket.close)
                return client

            def end() -> Served:
                stop.set()
                thread.join(TIMEOUT)
                return results[0]

            stack.callback(end)
            fake = Robot(robot, cycle)
            stack.callback(fake.end)
            return fake, connect, end

        yield begin


def test_a_packet_for_each_frame_and_an_answer_for_each_packet(served: Any) -> None:
    robot, connect, end = served()
    robot.publish()
    client = connect()
    for turn in range(5):
        values = client.read()
        assert values["Position"] == pytest.approx(STILL.position, abs=0.0008)
        assert values["Accelerometer"][2] == pytest.approx(-9.81, abs=0.005)
        client.send(pack(Position=[0.125 * turn] * 25, Stiffness=[0.5] * 25))
        command = robot.command()
        assert command.reply_to == robot.seq
        assert command.position == (0.125 * turn,) * 25
        assert command.stiffness == (0.5,) * 25
        robot.publish()
    assert end().maps == 5


def test_what_a_map_leaves_out_stays(served: Any) -> None:
    """Stiffness alone, an empty map, lights, positions alone, reordered and unknown keys; -1 is free."""
    robot, connect, _ = served()
    robot.publish()
    client = connect()

    def turn(*replies: bytes) -> ActuatorFrame:
        client.read()
        for reply in replies:
            client.send(reply)
        command: ActuatorFrame = robot.command()
        robot.publish()
        return command

    first = turn(pack(Stiffness=[1.0, -1.0, *[0.25] * 23]))
    assert first.position == STILL.position  # as measured: the client has not said where
    assert first.stiffness == (1.0, -1.0, *(0.25,) * 23)
    second = turn(pack(), pack(Chest=[1.0, 0.0, 0.0]), pack(Position=[0.5] * 25))
    assert (second.position, second.stiffness) == ((0.5,) * 25, first.stiffness)
    third = turn(pack(Unheard=[1, 2], Stiffness=[0.75] * 25, LEar=[0.0] * 10, Position=[-0.5] * 25))
    assert (third.position, third.stiffness) == ((-0.5,) * 25, (0.75,) * 25)


def test_what_a_web_browser_sends_to_a_tcp_port_moves_nothing() -> None:
    """A page of any site may post bytes of its choice to this machine; an HTTP request stands before them."""
    reply = pack(Position=[0.5] * 25)
    for sent, maps in ((reply, 1), (b"POST / HTTP/1.1\r\nOrigin: http://evil.example\r\n\r\n" + reply, None)):
        with (
            socket.create_server(("127.0.0.1", 0)) as listener,
            socket.create_connection(listener.getsockname()) as peer,
        ):
            client = LolaClient(listener.accept()[0])
            try:
                peer.sendall(sent)
                assert select.select([client], [], [], TIMEOUT)[0]
                if maps is None:
                    with pytest.raises(ClientGone):
                        client.receive()
                else:
                    assert len(client.receive()) == maps
            finally:
                client.close()


def test_leds_reach_the_robot_in_the_order_of_its_dcm() -> None:
    """The vendor's page on LoLA: eyes begin at 45 (left) and 0 degrees (right), the right ear at 324."""
    ours, theirs = socket.socketpair()
    with theirs:
        client = LolaClient(ours)
        lit = {"LEye": [1.0] + [0.0] * 23, "REye": [0.0] * 23 + [0.5], "REar": [1.0] + [0.0] * 9}
        theirs.sendall(pack(**lit, Skull=[0.0] * 6 + [2.0] + [0.0] * 5, Chest=[1.0] * 4))
        client.update(client.receive(), standing_frame())
        client.close()
    assert {name: value for name, value in zip(led_names(), client.leds, strict=True) if value} == {
        "Face/Led/Red/Left/45Deg": 255,
        "Face/Led/Blue/Right/315Deg": 128,
        "Ears/Led/Right/324Deg": 255,
        "Head/Led/Rear/Right/2": 255,
    }
    assert client.setpoints is None


def test_a_robot_of_10_ms_gives_a_packet_per_12_ms_of_its_time(served: Any) -> None:
    """Lockstep: six frames for five packets; the frame between two packets gets the last demand again."""
    robot, connect, _ = served(cycle=0.01)
    robot.publish()
    client = connect()
    packets = 0

    def answer() -> None:
        nonlocal packets
        with contextlib.suppress(EOFError, OSError):
            for _ in repeat_while(client.read, 1000):
                packets += 1
                client.send(pack(Position=[0.5] * 25))

    thread = threading.Thread(target=answer, daemon=True)
    thread.start()
    for _ in range(61):
        assert robot.command().position == (0.5,) * 25
        robot.publish()
    # 0 ms to 600 ms: 0, 20, 30, 40, 50, 60, 80 ms, ...
    assert packets in (51, 52)
    client.socket.shutdown(socket.SHUT_RDWR)
    thread.join(TIMEOUT)


def test_the_lease_is_the_client_s_from_its_first_command_to_its_end(served: Any) -> None:
    robot, connect, _ = served()
    robot.publish()
    client = connect()
    client.read()
    client.send(pack(Chest=[0.0] * 3))
    assert robot.link.wait_command(0.3) is None
    assert robot.link.holder is None  # lights are no reason to hold the robot
    client.send(pack(Stiffness=[0.0] * 25))
    robot.command()
    assert robot.link.holder.name == "lola"
    client.socket.close()
    until(lambda: robot.link.holder is None, "the lease to be given back")
    assert not robot.link.leases.abandoned  # it left the robot limp: in good order
    client = connect()
    client.read()
    client.send(pack(Stiffness=[1.0] * 25))
    robot.command(stiffness=(1.0,) * 25)
    client.socket.close()
    until(lambda: robot.link.holder is None, "the lease to be given up")
    assert robot.link.leases.abandoned  # it left the robot stiff: the watchdog is to bring it down


def test_a_server_that_ends_leaves_a_stiff_robot_to_its_guard(served: Any) -> None:
    robot, connect, end = served()
    robot.publish()
    client = connect()
    client.read()
    client.send(pack(Stiffness=[1.0] * 25))
    robot.command(stiffness=(1.0,) * 25)
    end()
    until(lambda: robot.link.holder is None, "the lease to be given up")
    assert robot.link.leases.abandoned


def test_a_client_that_does_not_read_is_closed_and_may_connect_again(
    served: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot, connect, _ = served(mode="real-time", cycle=0.01)
    leases, asked = robot.link.leases, list[str]()

    def noted(name: str) -> Callable[..., Any]:
        """Of the leases, as one may be over before anybody looks."""
        act = getattr(leases, name)
        return lambda *values, **more: (asked.append(name), act(*values, **more))[1]

    for name in ("acquire", "release"):
        monkeypatch.setattr(leases, name, noted(name))
    pacing = threading.Event()

    def run() -> None:
        for _ in repeat_while(lambda: not pacing.wait(0.004), 100_000):
            robot.publish()

    thread = threading.Thread(target=run)
    thread.start()
    try:
        client = connect()
        client.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
        client.read()
        client.send(pack(Stiffness=[0.0] * 25))
        until(lambda: asked[-1:] == ["release"], "the server to give up its client")
        taken = asked.count("acquire")
        assert taken
        with pytest.raises((EOFError, ConnectionResetError)):
            for _ in range(10_000):
                client.read()
        again = connect()
        for _ in range(3):
            again.read()
        again.send(pack(Position=[0.5] * 25))
        until(lambda: asked.count("acquire") > taken, "the lease")
    finally:
        pacing.set()
        thread.join()


def test_in_lockstep_a_client_may_read_several_packets_before_its_first_map(served: Any) -> None:
    """It would wait for a packet, and the robot for a map, for ever; after the first map each waits for one."""
    robot, connect, _ = served()
    robot.publish()
    client = connect()
    for _ in range(20):
        assert client.read()["Position"] == pytest.approx(STILL.position, abs=0.0008)
    client.send(pack(Position=[0.5] * 25))
    robot.command(position=(0.5,) * 25)
    client.drain()
    assert not select.select([client.socket], [], [], 0.5)[0]
    robot.publish()
    client.read()


def test_the_client_s_connection_ends_with_the_robot(served: Any) -> None:
    robot, connect, _ = served()
    robot.publish()
    client = connect()
    client.read()
    robot.end()
    robot.link.close()
    with pytest.raises(EOFError):
        client.read()


def test_a_robot_that_somebody_else_holds_is_only_watched(served: Any, endpoint: str) -> None:
    robot, connect, _ = served()
    robot.publish()
    with ControllerLink("nao", endpoint, "other") as other:
        other.wait_robot(timeout=TIMEOUT)
        other.acquire()
        client = connect()
        client.read()
        client.send(pack(Stiffness=[1.0] * 25))
        assert robot.link.wait_command(0.5) is None
        other.release()
        assert robot.command().stiffness == (1.0,) * 25
