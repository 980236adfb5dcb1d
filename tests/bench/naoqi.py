"""NAOqi: cost of a call to a served robot against a bare qi call, and of the way through both ends.

The calls are made from a process of their own, in alternating blocks, to `nao-hil serve naoqi` and to a bare qi
service that answers at once. The hops are measured with this process being the robot and the controller at both
ends of emulator's link - serve - bridge - controller, so that one clock times both ways.
"""

from __future__ import annotations

import contextlib
import json
import secrets
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import msgspec

from bridge.body.joints import INDEX
from bridge.errors import LinkError
from bridge.link import ControllerLink, RobotLink
from bridge.link.client import GuardClient
from bridge.messages import ActuatorFrame, Info, SensorFrame
from bridge.realtime import ROBOT_PRIORITY, quiet_process
from nao_hil.runs.supervisor import Child
from tests.frames import standing_frame
from tests.ports import free_endpoint

_CYCLE: Final = 0.01
_BLOCKS: Final = 4
_CALLS: Final = 200
_READINGS: Final = 20
"""Of joint states, in a block."""
_STATES: Final = ("Velocity", "Torque")
_CYCLES: Final = 800
_LOOK_AHEADS: Final = (0.0, 10.0, 20.0)
"""ms"""
_HEAD: Final = INDEX["HeadYaw"]
_TIMEOUT: Final = 60.0
_ROOT: Final = Path(__file__).parents[2]


def measure() -> dict[str, Any]:
    """`calls`: microseconds; `hops`: ms, by look-ahead."""
    with _served() as (robot, url, folder):
        return {
            "calls": _calls(url),
            "hops": {f"look-ahead {ahead:g} ms": _hops(robot, url, ahead, folder) for ahead in _LOOK_AHEADS},
        }


class _Robot:
    """Follows each command at once; records the times of frames sent and commands received."""

    def __init__(self, endpoint: str) -> None:
        self.endpoint = endpoint
        self.sent: dict[int, float] = {}
        self.got: list[tuple[float, float]] = []
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        info = Info(
            robot="nao",
            body="nao-v5",
            side="emulator",
            mode="real-time",
            cycle=_CYCLE,
            absent=(),
            boot=secrets.randbits(31),
            software="bench",
        )
        frame = msgspec.structs.replace(standing_frame(0), stiffness=(1.0,) * 25)
        with RobotLink(info, self.endpoint) as link:
            deadline = time.monotonic()
            while not self._stop.is_set():
                self.sent[frame.seq] = time.monotonic()
                # A frame is known again at the other end by its distance.
                link.publish(msgspec.structs.replace(frame, sonar=(float(frame.seq), 0.0)))
                deadline += _CYCLE
                while (left := deadline - time.monotonic()) > 0.0:
                    command = link.wait_command(left)
                    if command is not None:
                        self.got.append((time.monotonic(), command.position[_HEAD]))
                        frame = msgspec.structs.replace(frame, position=command.position)
                seq = frame.seq + 1
                frame = msgspec.structs.replace(frame, seq=seq, time=seq * _CYCLE)

    def close(self) -> None:
        self._stop.set()
        self._thread.join()


@contextlib.contextmanager
def _served() -> Iterator[tuple[_Robot, str, Path]]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        robot = _Robot(free_endpoint())
        url = "tcp://" + free_endpoint().removeprefix("tcp/")
        server = Child("serve", ["serve", "naoqi", "--listen", url, "--connect", robot.endpoint], folder)
        try:
            _wait_for("is served at", folder / "serve.log")
            yield robot, url, folder
        finally:
            server.end(5.0)
            robot.close()


def _wait_for(text: str, log: Path) -> None:
    deadline = time.monotonic() + _TIMEOUT
    while text not in " ".join(log.read_text().split()):
        if time.monotonic() > deadline:
            raise LinkError(f"{log.name} did not say {text!r} within {_TIMEOUT:g} s: {log.read_text()[-300:]}")
        time.sleep(0.05)


def _calls(url: str) -> dict[str, Any]:
    bare = "tcp://" + free_endpoint().removeprefix("tcp/")
    code = f"from tests.bench.naoqi import bare_service; bare_service({bare!r})"
    with subprocess.Popen(
        [sys.executable, "-c", code], cwd=_ROOT, stdout=subprocess.PIPE, text=True
    ) as service:
        try:
            assert service.stdout is not None
            while service.stdout.readline().strip() != "ready":
                pass
            code = f"from tests.bench.naoqi import caller; caller({url!r}, {bare!r})"
            out = subprocess.run(
                [sys.executable, "-c", code], cwd=_ROOT, stdout=subprocess.PIPE, text=True, check=True
            ).stdout
        finally:
            service.kill()
    result: dict[str, Any] = json.loads(out.splitlines()[-1])
    return result


def bare_service(url: str) -> None:
    """The floor: the same methods, answered by qi's own process with constants."""
    import qi

    class Bare:
        def ping(self) -> bool:
            return True

        def getTime(self, _offset: int) -> int:
            return 1

        def getListData(self, keys: list[str]) -> list[float]:
            return [0.5] * len(keys)

        def setAlias(self, _command: list[Any]) -> None:
            return None

    session = qi.Session()
    session.listenStandalone(url)
    session.registerService("Bare", Bare())
    print("ready", flush=True)
    while True:
        time.sleep(1.0)


def caller(served: str, bare: str) -> None:
    """Times both in alternating blocks; one JSON object on the last line."""
    import qi

    sessions = [qi.Session(), qi.Session()]
    for session, url in zip(sessions, (served, bare), strict=True):
        session.connect(url)
    dcm, memory, motion = (sessions[0].service(name) for name in ("DCM", "ALMemory", "ALMotion"))
    floor = sessions[1].service("Bare")
    names = [f"{joint}/Position/Actuator/Value" for joint in INDEX]
    dcm.createAlias(["Bench", names])
    keys = [f"Device/SubDeviceList/{joint}/{end}/Sensor/Value" for joint in INDEX for end in _ENDS]
    states = [f"Motion/{of}/Sensor/{joint}" for joint in motion.getBodyNames("Body") for of in _STATES]

    def read_states() -> None:
        """Joint states as a ROS driver reads them that waits for each call: angles, then each key."""
        motion.getAngles("Body", True)
        for key in states:
            memory.getData(key)

    def read_nothing() -> None:
        for _ in range(len(states) + 1):
            floor.ping()

    command = ["Bench", "ClearAll", "time-separate", 0, [dcm.getTime(0)], [[0.0]] * len(names)]
    calls = {
        "ping": (dcm.ping, floor.ping, ()),
        "getTime": (dcm.getTime, floor.getTime, (0,)),
        "setAlias, 25 joints": (dcm.setAlias, floor.setAlias, (command,)),
        f"getListData, {len(keys)} keys": (memory.getListData, floor.getListData, (keys,)),
        f"joint states, {len(states) + 1} calls": (read_states, read_nothing, ()),
    }
    result = {}
    for name, (ours, theirs, arguments) in calls.items():
        times: tuple[list[float], list[float]] = ([], [])
        for _ in range(_BLOCKS):
            for method, taken in zip((ours, theirs), times, strict=True):
                for _ in range(_CALLS if not name.startswith("joint") else _READINGS):
                    began = time.perf_counter()
                    method(*arguments)
                    taken.append(1e6 * (time.perf_counter() - began))
        result[name] = {"served": _quantiles(times[0]), "bare": _quantiles(times[1])}
    print(json.dumps(result), flush=True)


_ENDS: Final = ("Position", "ElectricCurrent", "Temperature")


def _quantiles(values: list[float]) -> dict[str, float]:
    ordered = sorted(values)
    return {"p50": statistics.median(ordered), "p99": ordered[int(0.99 * (len(ordered) - 1))]}


def _hops(robot: _Robot, url: str, look_ahead: float, folder: Path) -> dict[str, Any]:
    """From the robot's frame to the controller, and from its command back to the robot."""
    far = free_endpoint()
    options = ["--url", url, "--listen", far, "--look-ahead", f"{look_ahead:g}"]
    bridge = Child("bridge", ["bridge", "naoqi", *options, "--json"], folder)
    try:
        _wait_for("not armed", folder / "bridge.log")
        with GuardClient("nao", far) as guard:
            guard.arm("bench")
        with ControllerLink("nao", far, "bench") as link:
            link.wait_robot(timeout=_TIMEOUT)
            link.acquire()
            quiet_process(ROBOT_PRIORITY)
            up, commands = _control(robot, link)
            link.release()
    finally:
        bridged = bridge.end(20.0).result
    down = _arrivals(robot, commands)
    left_out = bridged["left_out"] / max(1, bridged["frames"]) if bridged else None
    return {"frame_ms": _quantiles(up), "command_ms": _quantiles(down), "cycles_left_out": left_out}


def _control(robot: _Robot, link: ControllerLink) -> tuple[list[float], list[tuple[float, float]]]:
    """Answer every frame with HeadYaw a little further; ages of frames (ms), times and values of commands."""
    up: list[float] = []
    commands: list[tuple[float, float]] = []
    first: SensorFrame | None = None
    robot.got.clear()
    while len(up) < _CYCLES:
        frame = link.latest(1.0)
        now = time.monotonic()
        if frame is None:
            raise LinkError("The bridged robot fell silent.")
        first = first or frame
        up.append(1e3 * (now - robot.sent[round(frame.sonar[0])]))
        position = list(first.position)
        position[_HEAD] += 0.001 * len(up)
        link.send(ActuatorFrame(reply_to=frame.seq, position=tuple(position), stiffness=(1.0,) * 25))
        commands.append((now, position[_HEAD]))
    return up, commands


def _arrivals(robot: _Robot, commands: list[tuple[float, float]]) -> list[float]:
    """Time from a command to the first one at the robot that is as far, ms."""
    ages, at = [], 0
    got = list(robot.got)
    for sent, value in commands[50:]:
        while at < len(got) and (got[at][0] < sent or got[at][1] < value - 2e-4):
            at += 1
        if at < len(got):
            ages.append(1e3 * (got[at][0] - sent))
    return ages
