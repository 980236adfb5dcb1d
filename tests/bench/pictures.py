"""Cost of pictures and of a ROS driver's load for the cycle of a robot that walks for a NAOqi program."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from bridge.errors import LinkError
from bridge.link import ControllerLink
from bridge.messages import SensorFrame
from emulator.engine.catalogue import ENGINES
from nao_hil.runs.supervisor import Child
from tests.ports import free_endpoint

TIMEOUT: Final = 120.0
"""s for each process to start."""
START_TIME: Final = 3.0
"""s until the robot walks, and the first picture is there."""
RATE: Final = 10
"""Pictures a second, of 320 x 240 pixels, RGB."""
STATES: Final = 50
"""Readings of all joint states a second, as a ROS driver does it: angles, then velocity and torque by joint."""
CASES: Final[dict[str, tuple[str, ...]]] = {
    "without": (),
    "pictures": ("pictures",),
    "driver": ("pictures", "states", "events"),
}
"""Programs that run while one walks the robot."""
_ROOT: Final = Path(__file__).parents[2]


def measure(seconds: float = 15.0, rounds: int = 4) -> dict[str, Any]:
    """A V5 walks by `moveToward` on each engine, in turn with each of `CASES`.

    Returns:
        Load of the machine at the beginning and the end; of each engine and case: cycles, cycles missed, of all
        rounds and of the worst; results per second of each program, the fewest.

    Raises:
        LinkError: one of the processes failed, or the robot fell.
    """
    results: dict[str, Any] = {"seconds": seconds, "rounds": rounds, "load": os.getloadavg()[0]}
    for engine in filter(find_spec, ENGINES):
        walks: dict[str, list[dict[str, float]]] = {case: [] for case in CASES}
        for _ in range(rounds):
            for case, programs in CASES.items():
                walks[case].append(_walk(engine, seconds, programs))
        results[engine] = {case: _together(each) for case, each in walks.items()}
    return results | {"load at the end": os.getloadavg()[0]}


def _walk(engine: str, seconds: float, programs: tuple[str, ...]) -> dict[str, float]:
    endpoint, url = free_endpoint(), "tcp://" + free_endpoint().removeprefix("tcp/")
    emulate = ["emulate", "--robot", "nao-v5", "--engine", engine, "--listen", endpoint]
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as clients:
        robot = Child("robot", [*emulate, "--out", name], Path(name))
        server = Child("serve", ["serve", "naoqi", "--listen", url, "--connect", endpoint], Path(name))

        def start(program: str) -> subprocess.Popen[str]:
            """A program, once its time has begun."""
            code = f"from tests.bench.pictures import program; program({program!r}, {url!r}, {seconds})"
            command = [sys.executable, "-c", code]
            client = clients.enter_context(
                subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=_ROOT)
            )
            clients.callback(client.kill)
            _next_number(client)
            return client

        try:
            with ControllerLink("nao", endpoint, "bench") as link:
                await_server(server)
                link.wait_robot(timeout=TIMEOUT)
                walker = start("walk")
                readers = {program: start(program) for program in programs}
                first = _frame(link)
                if not readers:
                    time.sleep(seconds)
                counts = {program: _next_number(reader) / seconds for program, reader in readers.items()}
                last = _frame(link)
                if walker.poll() is not None:
                    raise LinkError("the robot does not walk any more.")
        finally:
            server.end(5.0)
            outcome = robot.end(5.0)
    if outcome.code:
        raise LinkError(f"the robot's process failed: {outcome.error}")
    return {"cycles": last.seq - first.seq, "missed": last.missed - first.missed} | counts


def program(name: str, url: str, seconds: float) -> None:
    """A NAOqi program, a process of its own: prints 0 when its time begins, then its number of results.

    Args:
        name: `walk`, or one of `CASES`.
        url: of the server.
        seconds: its time.
    """
    import qi

    session = qi.Session()
    session.connect(url)
    motion, memory = session.service("ALMotion"), session.service("ALMemory")
    if name == "walk":
        motion.wakeUp()
        motion.moveToward(1.0, 0.0, 0.0)
        time.sleep(START_TIME)
        print("0", flush=True)
        while motion.moveIsActive():
            time.sleep(0.5)
        os._exit(1)
    work = {"pictures": _pictures, "states": _states, "events": _events}[name](session, motion, memory)
    period = 1.0 / (RATE if name == "pictures" else STATES)
    work()
    print("0", flush=True)
    begin, count, turn = time.monotonic(), 0, 0
    while (now := time.monotonic()) < begin + seconds:
        count += work()
        turn = max(turn + 1, int((now - begin) / period))
        time.sleep(max(0.0, begin + turn * period - time.monotonic()))
    print(count, flush=True)
    os._exit(0)


def _pictures(session: Any, _motion: Any, _memory: Any) -> Callable[[], int]:
    """Takes one picture."""
    video = session.service("ALVideoDevice")
    handle = video.subscribeCamera("bench", 1, 1, 11, RATE)
    return lambda: int(len(video.getImageRemote(handle)[6]) == 320 * 240 * 3)


def _states(_session: Any, motion: Any, memory: Any) -> Callable[[], int]:
    """Reads all joint states as a driver does."""
    joints = [joint for joint in motion.getBodyNames("Body") if not joint.endswith("Hand")]

    def read() -> int:
        """One cycle of a driver; 1, for the count of readings."""
        torso = motion.getPosition("Torso", 1, True, _async=True)
        motion.getAngles("Body", True)
        torso.value()
        keys = [f"Motion/{of}/Sensor/{joint}" for joint in joints for of in ("Velocity", "Torque")]
        for value in [memory.getData(key, _async=True) for key in keys]:
            value.value()
        return 1

    return read


def _events(_session: Any, _motion: Any, memory: Any) -> Callable[[], int]:
    """Subscribes to a button, and reads inertial unit and feet."""
    subscriber = memory.subscriber("FrontTactilTouched")
    subscriber.signal.connect(lambda _: None)
    part = "Device/SubDeviceList/"
    keys = [f"{part}InertialSensor/Gyroscope{axis}/Sensor/Value" for axis in "XYZ"]
    keys += [f"{part}{s}Foot/FSR/{at}/Sensor/Value" for s in "LR" for at in ("FrontLeft", "RearRight")]

    def read() -> int:
        return int(len(memory.getListData(keys)) == len(keys) and subscriber is not None)

    return read


def _next_number(client: subprocess.Popen[str]) -> int:
    """The next number that a program prints, past the output of qi."""
    assert client.stdout is not None
    for line in client.stdout:
        if line.strip().isdecimal():
            return int(line)
    raise LinkError("a program failed.")


def _frame(link: ControllerLink) -> SensorFrame:
    """The robot's newest frame."""
    link.latest(0.0)
    frame = link.latest(1.0)
    if frame is None:
        raise LinkError("the robot fell silent.")
    return frame


def await_server(server: Child) -> None:
    """Wait until a server of NAOqi is there; a LinkError if it is not."""
    deadline = time.monotonic() + TIMEOUT
    while "is served at" not in " ".join(server.stderr.split()):
        if not server.running or time.monotonic() > deadline:
            raise LinkError(f"the server did not start: {server.end(1.0).error}")
        time.sleep(0.1)


def _together(walks: list[dict[str, float]]) -> dict[str, float]:
    sums = {name: sum(walk[name] for walk in walks) for name in ("cycles", "missed")}
    return sums | {
        "missed, worst": max(walk["missed"] for walk in walks),
        **{name: min(walk[name] for walk in walks) for name in walks[0] if name not in sums},
    }
