"""A bridged LoLA: the robot is a raw socket that sends packets as a V6 does, the controller the link's own."""

from __future__ import annotations

import contextlib
import itertools
import select
import shutil
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgpack
import pytest

from bridge.adapters.lola.address import Address, parse_address
from bridge.adapters.lola.bridge import LolaBridge, LolaCounts, LolaDevice
from bridge.adapters.robot_bridge import BridgeSettings
from bridge.body.postures import POSTURES
from bridge.errors import ConfigurationError, LinkError
from bridge.guard import GuardSettings
from bridge.link import ControllerLink
from bridge.link.client import GuardClient
from bridge.messages import ActuatorFrame, SensorFrame
from tests.loops import TIMEOUT, repeat_while, until

PACKET: dict[str, Any] = msgpack.unpackb(
    (Path(__file__).parents[1] / "bridge" / "adapters" / "lola" / "data" / "sensors.msgpack").read_bytes()
)
RELAY = Path(__file__).parents[2] / "bridge" / "adapters" / "lola" / "relay.py"


class FakeLola:
    """LoLA's end of its socket: sends a packet every 12 ms, or when told to, and keeps what it is sent."""

    def __init__(self, path: str) -> None:
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(path)
        self.listener.listen()
        self.values = dict(PACKET)
        self.maps: list[dict[str, Any]] = []
        self.garbage = b""
        self.echo = False
        """Packets have the stiffness of the newest map, as those of a robot."""
        self._ended = threading.Event()
        self._drop = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        for _ in repeat_while(lambda: not self._ended.is_set(), 100_000):
            if not select.select([self.listener], [], [], 0.05)[0]:
                continue
            peer = self.listener.accept()[0]
            with peer, contextlib.suppress(OSError):
                self._serve(peer)

    def _serve(self, peer: socket.socket) -> None:
        unpacker = msgpack.Unpacker()
        if self.garbage:
            peer.sendall(self.garbage)
        for _ in repeat_while(lambda: not (self._ended.is_set() or self._drop.is_set()), 100_000):
            peer.sendall(msgpack.packb(self.values, use_single_float=True))
            if select.select([peer], [], [], 0.012)[0]:
                data = peer.recv(65536)
                if not data:
                    return
                unpacker.feed(data)
                self.maps += list(unpacker)
                if self.echo and self.maps and "Stiffness" in self.maps[-1]:
                    self.values["Stiffness"] = self.maps[-1]["Stiffness"]
        self._drop.clear()

    def drop(self) -> None:
        """End the connection, as a LoLA that starts anew does."""
        self._drop.set()

    def end(self) -> None:
        self._ended.set()
        self._thread.join()
        self.listener.close()


@pytest.fixture
def lola(tmp_path: Path) -> Iterator[FakeLola]:
    fake = FakeLola(str(tmp_path / "robocup"))
    yield fake
    fake.end()


@pytest.fixture
def bridged(
    lola: FakeLola, tmp_path: Path, endpoint: str
) -> Iterator[Callable[..., tuple[ControllerLink, Callable[[], LolaCounts]]]]:
    """Start the bridge; gives a controller that has found the robot, and what ends the bridge."""
    stop, results = threading.Event(), []
    with contextlib.ExitStack() as stack:

        def begin(
            address: str = str(tmp_path / "robocup"), **settings: Any
        ) -> tuple[ControllerLink, Callable[[], LolaCounts]]:
            bridge = LolaBridge(
                parse_address(address),
                BridgeSettings(robot="nao", software="test", listen=endpoint, **settings),
                stop,
            )
            thread = threading.Thread(target=lambda: results.append(bridge.run()))
            thread.start()

            def end() -> LolaCounts:
                stop.set()
                thread.join(TIMEOUT)
                return results[0]

            stack.callback(end)
            link = stack.enter_context(ControllerLink("nao", endpoint, "tester"))
            link.wait_robot(timeout=TIMEOUT)
            return link, end

        yield begin


def newest(link: ControllerLink) -> SensorFrame:
    # none also when the robot has just gone
    frame: SensorFrame = until(lambda: link.latest(1.0), "a frame")
    return frame


def test_a_v6_is_a_robot_on_the_link(bridged: Any, lola: FakeLola) -> None:
    link, _ = bridged()
    info = link.wait_robot(timeout=TIMEOUT)
    assert (info.body, info.side, info.mode, info.cycle) == ("nao-v6", "lola", "real-time", 0.012)
    first, second = newest(link), newest(link)
    assert second.seq > first.seq
    assert second.time == pytest.approx(0.012 * second.seq)
    assert second.position == pytest.approx(PACKET["Position"])
    assert second.accelerometer == pytest.approx([-a for a in PACKET["Accelerometer"]])
    assert second.fsr == pytest.approx([9.81 * f for f in PACKET["FSR"]])
    assert second.battery == pytest.approx((0.99, 0.016, -32552.0, 3.6), rel=1e-6)
    assert lola.maps == []


def answer(link: ControllerLink, condition: Callable[[], bool], **fields: Any) -> None:
    """Answer frames with where the robot is, except for `fields`, until a condition is true."""

    def answered() -> bool:
        frame = newest(link)
        wanted = {"position": frame.position, "stiffness": (0.5,) * 25} | fields
        link.send(ActuatorFrame(reply_to=frame.seq, **wanted))
        return condition()

    condition() or until(answered, "what the answers are to bring about")


def test_it_takes_no_command_before_it_is_armed(bridged: Any, lola: FakeLola, endpoint: str) -> None:
    link, end = bridged()
    link.acquire()
    refused: list[str] = []

    def told() -> bool:
        refused.extend(n.text for n in link.notices() if n.code == "frame-refused")
        return bool(refused)

    answer(link, told)
    assert "not armed" in refused[0]
    assert lola.maps == []
    with GuardClient("nao", endpoint) as guard:
        assert not guard.status().armed
        guard.arm("test")
    answer(link, lambda: len(lola.maps) > 3, stiffness=(0.0,) * 25)
    assert set(lola.maps[0]) == {"Position", "Stiffness"}
    assert lola.maps[-1]["Stiffness"] == [0.0] * 25
    assert [len(v) for v in lola.maps[-1].values()] == [25, 25]
    assert end().commands >= 4


def test_its_end_brings_a_robot_down_that_it_held_up(bridged: Any, lola: FakeLola, endpoint: str) -> None:
    lola.values |= {"Position": [0.0] * 25, "Angles": [0.0, 0.0]}
    link, end = bridged()
    with GuardClient("nao", endpoint) as guard:
        guard.arm("test")
    link.acquire()
    answer(link, lambda: len(lola.maps) > 2, position=(0.0,) * 25, stiffness=(0.9,) * 25)
    end()
    left = GuardSettings().crouch.rest_stiffness
    until(lambda: max(lola.maps[-1]["Stiffness"]) == pytest.approx(left), "the stiffness to be gone")
    assert lola.maps[-1]["Position"][10] > 1.0  # the knee: it crouched first


def test_a_connection_that_ends_is_a_new_boot(bridged: Any, lola: FakeLola, endpoint: str) -> None:
    link, end = bridged()
    boot = link.wait_robot(timeout=TIMEOUT).boot
    with GuardClient("nao", endpoint) as guard:
        guard.arm("test")
    link.acquire()
    lola.drop()
    until(lambda: link.lease == 0, "the robot to be gone")
    info = link.wait_robot(timeout=TIMEOUT)
    assert info.boot != boot
    with GuardClient("nao", endpoint) as guard:
        assert not guard.status().armed  # who unplugs a robot does not expect it to move on its return
    assert newest(link).seq < 1000
    assert end().connections == 2


UNREADABLE = {
    "nan": {"Sonar": [float("nan")] * 2},
    "short": {"Position": [0.0] * 24},
    "missing": {"FSR": None},
}


@pytest.mark.parametrize("kind", UNREADABLE)
def test_stop_and_arm_work_while_a_sensor_cannot_be_read(
    bridged: Any, lola: FakeLola, endpoint: str, kind: str
) -> None:
    lola.values |= {"Position": [0.0] * 25, "Angles": [0.0, 0.0]}
    link, _ = bridged()
    with GuardClient("nao", endpoint) as guard:
        guard.arm("test")
        link.acquire()
        before = newest(link)
        answer(link, lambda: len(lola.maps) > 2, position=(0.0,) * 25, stiffness=(0.9,) * 25)
        broken = lola.values | UNREADABLE[kind]
        lola.values = {key: value for key, value in broken.items() if value is not None}
        codes: list[str] = []
        until(lambda: codes.extend(n.code for n in link.notices()) or "sensor-unreadable" in codes, "a notice")
        frame = newest(link)
        assert (frame.sonar, frame.position, frame.fsr) == (before.sonar, before.position, before.fsr)
        guard.stop("limp", "test")
        until(lambda: max(lola.maps[-1]["Stiffness"]) <= 0.0, "the joints to be released")
        assert not guard.status().armed
        assert guard.arm("test").armed


def test_a_silent_controller_s_robot_is_brought_down_while_a_sensor_cannot_be_read(
    bridged: Any, lola: FakeLola, endpoint: str
) -> None:
    lola.values |= {"Position": [0.0] * 25, "Angles": [0.0, 0.0]}
    link, _ = bridged()
    with GuardClient("nao", endpoint) as guard:
        guard.arm("test")
        link.acquire()
        answer(link, lambda: len(lola.maps) > 2, position=(0.0,) * 25, stiffness=(0.9,) * 25)
        lola.values["Angles"] = [float("nan")] * 2
        until(lambda: guard.status().state == "rest", "the robot to rest")
    rest = GuardSettings().crouch.rest_stiffness + 1e-6
    until(lambda: max(lola.maps[-1]["Stiffness"]) <= rest, "LoLA to hear of it")
    assert lola.maps[-1]["Position"][10] > 1.0  # the knee: it crouched first


def test_only_waiting_counts_as_silence_and_not_a_pause_of_the_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At each look at the clock an hour has passed."""
    path, clock = str(tmp_path / "robocup"), iter(range(0, 1 << 30, 3600))
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(path)
        listener.listen()
        with LolaDevice(parse_address(path), silence=1.0) as device, listener.accept()[0] as peer:
            monkeypatch.setattr("bridge.adapters.lola.bridge.time.monotonic", lambda: next(clock))
            for _ in range(2):
                assert [device.packets(0.25) for _ in range(4)] == [None] * 4
                peer.sendall(msgpack.packb(PACKET, use_single_float=True))
                assert device.packets(0.25) is not None
            with pytest.raises(LinkError, match="has been silent for 1 s"):
                for _ in range(5):
                    device.packets(0.25)


def test_another_body_than_a_v6_has_to_be_named(lola: FakeLola, tmp_path: Path, endpoint: str) -> None:
    lola.values["RobotConfig"] = ["P0000073A03S83I00011", "7.0.0", "P0000074A03S84F00006", "7.0.0"]
    settings = BridgeSettings(robot="nao", software="test", listen=endpoint)
    bridge = LolaBridge(Address(path=str(tmp_path / "robocup")), settings, threading.Event())
    with pytest.raises(ConfigurationError, match=r"version 7\.0\.0.*--robot"):
        bridge.run()


def pythons() -> dict[str, str]:
    """Interpreters that a V6 may have: this one, and a Python 2.7 if there is one."""
    found = {"3": sys.executable}
    places = [shutil.which("python2.7"), *map(str, Path.home().glob(".pyenv/versions/2.7*/bin/python2.7"))]
    for place in filter(None, places):
        if subprocess.run([place, "-c", ""], capture_output=True, check=False).returncode == 0:
            found["2.7"] = place
    return found


PYTHONS = pythons()


@contextlib.contextmanager
def relaying(
    listen: str, path: Path, python: str = sys.executable
) -> Iterator[tuple[int, subprocess.Popen[str]]]:
    """The relay as on a robot, where a plain Python without any package runs the one file; port and process."""
    flags = ["-I", "-S"] if python == sys.executable else ["-E", "-s", "-S"]
    command = [python, *flags, str(RELAY), "--listen", listen, "--socket", str(path)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as relay:
        try:
            assert relay.stderr is not None
            yield int(relay.stderr.readline().rpartition(":")[2]), relay
        finally:
            relay.kill()


def test_the_relay_takes_nothing_from_a_web_browser(tmp_path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as lola:
        lola.bind(str(tmp_path / "lola"))
        lola.listen()
        lola.settimeout(TIMEOUT)
        with (
            relaying("127.0.0.1:0", tmp_path / "lola") as (port, _),
            socket.create_connection(("127.0.0.1", port), TIMEOUT) as browser,
        ):
            browser.sendall(b"POST / HTTP/1.1\r\n\r\n\x81\xa8Position\x90")
            with lola.accept()[0] as robot:
                robot.settimeout(TIMEOUT)
                assert robot.recv(100) == b""


def test_through_the_relay_it_is_the_same(bridged: Any, lola: FakeLola, tmp_path: Path) -> None:
    with relaying("127.0.0.1:0", tmp_path / "robocup") as (port, _):
        link, _ = bridged(address=f"127.0.0.1:{port}")
        assert newest(link).position == pytest.approx(PACKET["Position"])


STIFFNESS = [0.75, -1.0, *[0.5] * 23]
COMMAND = msgpack.packb(
    {"Position": [0.25] * 25, "Stiffness": STIFFNESS, "Sonar": [True, False]}, use_single_float=True
)


def until_reported(client: socket.socket, stiffness: list[float]) -> None:
    """Wait until the relay has passed on a packet with this stiffness, from which it begins a ramp."""
    wanted, read = msgpack.packb(stiffness, use_single_float=True), bytearray()
    until(lambda: read.extend(client.recv(65536)) or wanted in read, "the stiffness in the packets", pause=0.0)


@pytest.mark.parametrize("python", PYTHONS.values(), ids=PYTHONS)
@pytest.mark.parametrize("end", ["closes", "dies in a map", "hangs", "relay ends"])
def test_the_relay_rests_the_joints_of_a_client_that_is_gone(
    lola: FakeLola, tmp_path: Path, python: str, end: str
) -> None:
    lola.echo = True
    with relaying("127.0.0.1:0", tmp_path / "robocup", python) as (port, relay):
        with socket.create_connection(("127.0.0.1", port), TIMEOUT) as client:
            client.sendall(COMMAND)
            until(lambda: lola.maps, "the command")
            assert list(lola.maps[0]) == ["Position", "Stiffness", "Sonar"]
            until_reported(client, STIFFNESS)
            assert len(lola.maps) == 1
            if end == "dies in a map":
                client.sendall(COMMAND[:100])
            if end == "hangs":  # its connection stays
                until(lambda: len(lola.maps) > 1, "the ramp")
            elif end == "relay ends":
                relay.terminate()
                until(lambda: relay.poll() is not None, "the relay's end")
        until(lambda: lola.maps[-1]["Stiffness"][0] == 0.0, "the joints to be released")
    ramp = [given["Stiffness"] for given in lola.maps[1:]]
    assert all(list(given) == ["Stiffness"] for given in lola.maps[1:])
    assert ramp[-1] == [0.0, -1.0, *[0.0] * 23]  # a free joint stays free
    assert 50 < len(ramp) < 200  # gently: some 2 s
    steps = [before[0] - after[0] for before, after in itertools.pairwise([[0.75], *ramp])]
    assert all(0.0 <= step < 0.02 for step in steps)


@pytest.mark.parametrize("python", PYTHONS.values(), ids=PYTHONS)
def test_the_relay_crouches_first_with_a_robot_that_stands(lola: FakeLola, tmp_path: Path, python: str) -> None:
    lola.values |= {"Position": [0.0] * 25, "Angles": [0.0, 0.1], "FSR": [0.65] * 8}
    lola.echo = True
    with relaying("127.0.0.1:0", tmp_path / "robocup", python) as (port, _):
        with socket.create_connection(("127.0.0.1", port), TIMEOUT) as client:
            client.sendall(msgpack.packb({"Stiffness": [0.8] * 25}, use_single_float=True))
            until_reported(client, [0.8] * 25)
        until(lambda: "Stiffness" in lola.maps[-1] and lola.maps[-1]["Stiffness"][0] == 0.0, "the release")
    poses = [given["Position"] for given in lola.maps[1:] if "Position" in given]
    legs = range(7, 18)
    assert [poses[-1][i] for i in legs] == pytest.approx([POSTURES["Crouch"][i] for i in legs], abs=0.01)
    fastest = max(abs(b - a) for old, new in itertools.pairwise(poses) for a, b in zip(old, new, strict=True))
    assert fastest / 0.012 < 1.5  # rad/s
    left = GuardSettings().crouch.rest_stiffness
    assert lola.maps[-1]["Stiffness"] == pytest.approx([left if i in legs else 0.0 for i in range(25)])


def test_the_relay_leaves_alone_what_its_client_has_not_commanded(lola: FakeLola, tmp_path: Path) -> None:
    with relaying("127.0.0.1:0", tmp_path / "robocup") as (port, _):
        with socket.create_connection(("127.0.0.1", port), TIMEOUT) as client:
            client.settimeout(TIMEOUT)
            assert client.recv(896)
        with socket.create_connection(("127.0.0.1", port), TIMEOUT) as client:  # the first one's end is over
            client.settimeout(TIMEOUT)
            assert client.recv(896)
            assert lola.maps == []


def test_a_bridge_that_is_killed_leaves_a_robot_at_rest(
    lola: FakeLola, tmp_path: Path, endpoint: str, start: Callable[..., Any]
) -> None:
    """Before: it is not disconnected while its controller is silent and its guard holds the joints."""
    lola.values |= {"Position": [0.0] * 25, "Angles": [0.0, 0.0]}
    lola.echo = True
    with relaying("127.0.0.1:0", tmp_path / "robocup") as (port, _):
        bridge = start("bridge", "lola", "--socket", f"127.0.0.1:{port}", "--listen", endpoint)
        with contextlib.ExitStack() as stack:
            link = stack.enter_context(ControllerLink("nao", endpoint, "tester"))
            link.wait_robot(timeout=TIMEOUT)
            guard = stack.enter_context(GuardClient("nao", endpoint))
            guard.arm("test")
            link.acquire()
            answer(link, lambda: len(lola.maps) > 2, position=(0.0,) * 25, stiffness=(0.75,) * 25)
            link.release()
            held = len(lola.maps)
            until(lambda: len(lola.maps) > held + 200, "2.4 s of holding")
            assert all(given["Stiffness"] == [0.75] * 25 for given in lola.maps[held : held + 200])
            bridge.kill()
            rest = GuardSettings().crouch.rest_stiffness + 1e-6
            until(lambda: max(lola.maps[-1].get("Stiffness", [1.0])) <= rest, "the joints to be released")
