"""LoLA: the beat of a served socket, the time for an answer, and the cost of each hop between both ends.

The client is a raw socket. Beat and time for an answer are measured with an emulated V6 in real time, against
a bare loop that sends as many bytes over a unix socket, and one that sends nothing. The hops are measured one
by one, this process being the robot and the controller at both ends of each, so that one clock times both ways;
their floor is a unix socket's bare echo.
"""

from __future__ import annotations

import contextlib
import itertools
import secrets
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

import msgspec

from bridge.adapters.lola.address import Address, connect
from bridge.adapters.lola.codec import CYCLE, SENSOR_BYTES
from bridge.adapters.lola.packets import Identity, actuator_map, sensor_packet
from bridge.body.postures import POSTURES
from bridge.errors import LinkError
from bridge.link import ControllerLink, RobotLink
from bridge.link.client import GuardClient
from bridge.messages import ActuatorFrame, Info
from bridge.realtime import CONTROLLER_PRIORITY, ROBOT_PRIORITY, quiet_process
from emulator.engine.catalogue import ENGINES
from emulator.timing import CycleTimer
from nao_hil.runs.supervisor import Child
from tests.bare_loop import BareLoop
from tests.frames import standing_frame
from tests.ports import free_endpoint

_WARM_UP: Final = 100
_TRIPS: Final = 500
_TIMEOUT: Final = 60.0
_ANSWERS: Final = 600
"""Packets that are answered after a sleep."""
_COMMAND: Final = actuator_map((0.0,) * 25, (0.0,) * 25)
_STAND: Final = actuator_map(POSTURES["StandInit"], (1.0,) * 25)


def measure(seconds: float = 60.0) -> dict[str, Any]:
    """`beat`, `window` and `hops`."""
    return {"beat": beat(seconds), "window": window(), "hops": hops()}


def beat(seconds: float) -> dict[str, Any]:
    """Gaps between packets, ms, as a client sees them that reads 896 bytes per cycle."""
    with tempfile.TemporaryDirectory() as name:
        folder, endpoint = Path(name), free_endpoint()
        path = str(folder / "robocup")
        robot = Child("robot", ["emulate", "--robot", "nao-v6", "--listen", endpoint, "--out", name], folder)
        server = Child("serve", ["serve", "lola", "--socket", path, "--connect", endpoint], folder)
        try:
            served = _gaps(path, seconds)
        finally:
            server.end(5.0)
            robot.end(5.0)
        code = f"from tests.bench.lola import bare_loop; bare_loop({path!r}, {seconds!r})"
        root = Path(__file__).parents[2]
        with subprocess.Popen([sys.executable, "-c", code], cwd=root) as bare:
            floor = _gaps(path, seconds)
            bare.terminate()
    return {"seconds": seconds, "served_ms": served, "bare_loop_ms": floor}


def window(sleeps: Sequence[float] = (0.007, 0.008, 0.009)) -> dict[str, Any]:
    """Late answers of 600, by engine and by the client's sleep between packet and answer.

    Args:
        sleeps: s.

    Returns:
        Also of a bare loop's cycles meanwhile the fractions that began over 0.5 ms and over 1 ms late.
    """
    late: dict[str, Any] = {}
    with BareLoop() as bare:
        for engine in ENGINES:
            if find_spec(engine) is not None:
                late[engine] = {f"{1e3 * sleep:g} ms": _late_answers(engine, sleep) for sleep in sleeps}
    shares = {f"over {limit:g} ms": float((bare.lateness > 1e-3 * limit).mean()) for limit in (0.5, 1.0)}
    return {"answers": _ANSWERS, "late": late, "bare_loop": shares}


def _late_answers(engine: str, sleep: float) -> int:
    with tempfile.TemporaryDirectory() as name:
        folder, endpoint = Path(name), free_endpoint()
        path = str(folder / "robocup")
        body = ["--robot", "nao-v6", "--engine", engine]
        robot = Child("robot", ["emulate", *body, "--listen", endpoint, "--out", name, "--json"], folder)
        server = Child("serve", ["serve", "lola", "--socket", path, "--connect", endpoint], folder)
        try:
            with _connected(path) as peer:
                quiet_process(ROBOT_PRIORITY)
                for number in range(_WARM_UP + _ANSWERS):
                    _read(peer)
                    time.sleep(sleep if number >= _WARM_UP else 0.0)
                    peer.sendall(_STAND)
        finally:
            outcome = robot.end(5.0)
            server.end(5.0)
    if outcome.result is None:
        raise LinkError(f"the robot's process failed: {outcome.error}")
    missed: int = outcome.result["cycles_missed"]
    return missed


def bare_loop(path: str, seconds: float) -> None:
    """Send packets to one client every 12 ms and do nothing else."""
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(path)
        listener.listen()
        peer = listener.accept()[0]
        timer = CycleTimer(CYCLE)
        quiet_process(CONTROLLER_PRIORITY)
        with peer, contextlib.suppress(OSError):
            for _ in range(round(seconds / CYCLE) + 2 * _WARM_UP):
                timer.wait()
                peer.sendall(bytes(SENSOR_BYTES))


def _gaps(path: str, seconds: float) -> dict[str, float]:
    """In a thread of real-time priority where that is permitted, as a robot's own controller has."""
    times: list[float] = []
    with _connected(path) as peer:
        quiet_process(ROBOT_PRIORITY)
        for _ in range(_WARM_UP + round(seconds / CYCLE)):
            _read(peer)
            times.append(time.perf_counter())
    times = times[_WARM_UP:]
    gaps = sorted(1e3 * (b - a) for a, b in itertools.pairwise(times))
    return {
        "p50": statistics.median(gaps),
        "p99.9": gaps[int(0.999 * (len(gaps) - 1))],
        "max": gaps[-1],
        "min": gaps[0],
    }


@contextlib.contextmanager
def _connected(path: str) -> Iterator[socket.socket]:
    deadline = time.monotonic() + _TIMEOUT
    while True:
        try:
            peer = connect(Address(path=path), 1.0)
            break
        except OSError:
            if time.monotonic() > deadline:
                raise LinkError(f"Nobody listened at {path} for {_TIMEOUT:g} s.") from None
            time.sleep(0.05)
    with peer:
        peer.settimeout(_TIMEOUT)
        yield peer


def _read(peer: socket.socket, size: int = SENSOR_BYTES) -> bytes:
    data = b""
    while len(data) < size:
        piece = peer.recv(size - len(data))
        if not piece:
            raise LinkError("The other end of the socket closed it.")
        data += piece
    return data


def hops() -> dict[str, Any]:
    """Each hop's time, ms: `sensors` towards the controller, `commands` towards the robot."""
    quiet_process(ROBOT_PRIORITY)  # which the children inherit, as they would ask for it in real time
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        return {"serve": _serve_hop(folder), "bridge": _bridge_hop(folder), "echo": _echo(folder)}


def _serve_hop(folder: Path) -> dict[str, Any]:
    endpoint, path = free_endpoint(), str(folder / "served")
    server = Child("serve", ["serve", "lola", "--socket", path, "--connect", endpoint], folder)
    try:
        with RobotLink(_info("lockstep"), endpoint) as link, _connected(path) as peer:
            link.publish(_frame(0))
            repeat = threading.Event()
            threading.Thread(target=_repeat, args=(link, repeat), daemon=True).start()
            _read(peer)  # once the server has found the robot and its frame
            repeat.set()
            peer.sendall(_COMMAND)
            while link.wait_command(_TIMEOUT) is None:
                pass  # the granted lease wakes it once
            seqs = iter(range(1, 1 << 30))

            def there() -> None:
                link.publish(_frame(next(seqs)))
                _read(peer)

            def back() -> None:
                peer.sendall(_COMMAND)
                if link.wait_command(_TIMEOUT) is None:
                    raise LinkError("the served LoLA passed no command on")

            return _timed(there, back)
    finally:
        server.end(5.0)


def _repeat(link: RobotLink, ended: threading.Event) -> None:
    while not ended.wait(0.1):
        link.publish(_frame(0))


def _bridge_hop(folder: Path) -> dict[str, Any]:
    endpoint, path = free_endpoint(), str(folder / "bridged")
    packet = sensor_packet(standing_frame(0), Identity())
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(path)
        listener.listen()
        options = ["--listen", endpoint, "--mode", "lockstep"]
        bridge = Child("bridge", ["bridge", "lola", "--socket", path, *options], folder)
        try:
            with listener.accept()[0] as peer, ControllerLink("nao", endpoint, "bench") as link:
                peer.sendall(packet)
                link.wait_robot(timeout=_TIMEOUT)
                with GuardClient("nao", endpoint) as guard:
                    guard.arm("bench")
                link.acquire()
                seq = _next(link)

                def there() -> None:
                    nonlocal seq
                    peer.sendall(packet)
                    while (newer := _next(link)) <= seq:
                        pass  # a repetition
                    seq = newer

                def back() -> None:
                    zeros = (0.0,) * 25
                    link.send(ActuatorFrame(reply_to=seq, position=zeros, stiffness=zeros))
                    _read(peer, len(_COMMAND))

                back()
                return _timed(there, back)
        finally:
            bridge.end(5.0)


def _next(link: ControllerLink) -> int:
    frame = link.next(_TIMEOUT)
    if frame is None:
        raise LinkError("the bridged LoLA passed no frame on")
    return frame.seq


def _echo(folder: Path) -> dict[str, Any]:
    """Both ways between two processes over a unix socket, with nothing done in between."""
    path = str(folder / "echo")
    code = f"from tests.bench.lola import echo; echo({path!r})"
    with subprocess.Popen([sys.executable, "-c", code], cwd=Path(__file__).parents[2]) as process:
        with _connected(path) as peer:

            def both() -> None:
                peer.sendall(bytes(SENSOR_BYTES))
                _read(peer, len(_COMMAND))

            times = [trip_time(both) for _ in range(_TRIPS)]
        process.terminate()
    return {"both": _ms(times)}


def echo(path: str) -> None:
    """Answer each packet with a command's length."""
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(path)
        listener.listen()
        with listener.accept()[0] as peer, contextlib.suppress(LinkError):
            while True:
                _read(peer)
                peer.sendall(_COMMAND)


def _info(mode: str) -> Info:
    return Info(
        robot="nao",
        body="nao-v6",
        side="emulator",
        mode=mode,
        cycle=CYCLE,
        absent=(),
        boot=secrets.randbits(31),
        software="bench",
    )


def _frame(seq: int) -> Any:
    return msgspec.structs.replace(standing_frame(seq), time=seq * CYCLE)


def _timed(there: Callable[[], None], back: Callable[[], None]) -> dict[str, Any]:
    sensors, commands = [], []
    for turn in range(_WARM_UP + _TRIPS):
        a, b = trip_time(there), trip_time(back)
        if turn >= _WARM_UP:
            sensors.append(a)
            commands.append(b)
    return {"sensors": _ms(sensors), "commands": _ms(commands)}


def _ms(times: list[float]) -> dict[str, float]:
    ordered = sorted(times)
    return {"p50": 1e3 * statistics.median(ordered), "p99": 1e3 * ordered[int(0.99 * (len(ordered) - 1))]}


def trip_time(trip: Callable[[], None]) -> float:
    """Duration of one round trip, s."""
    began = time.perf_counter()
    trip()
    return time.perf_counter() - began
