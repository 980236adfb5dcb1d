"""Cost of the cameras' pictures for the real-time cycle of a robot that walks for a NAOqi program."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from bridge.errors import LinkError
from bridge.link import ControllerLink
from bridge.messages import SensorFrame
from emulator.engine.catalogue import ENGINES
from nao_hil.runs.supervisor import Child, free_endpoint

TIMEOUT: Final = 120.0
"""s for each process to start."""
UNDER_WAY: Final = 3.0
"""s until the robot walks, and the first picture is there."""
RATE: Final = 10
"""Pictures a second, of 320 x 240 pixels, RGB."""
CASES: Final = {"without": False, "pictures": True}
_ROOT: Final = Path(__file__).parents[2]


def measure(seconds: float = 15.0, rounds: int = 4) -> dict[str, Any]:
    """A V5 walks by `moveToward` on each engine, in turn with and without a program that takes pictures.

    Returns:
        Load of the machine at the beginning and the end; of each engine and case: cycles, cycles missed, of all
        rounds and of the worst; pictures per second, the fewest.

    Raises:
        LinkError: one of the processes failed, or the robot fell.
    """
    results: dict[str, Any] = {"seconds": seconds, "rounds": rounds, "load": os.getloadavg()[0]}
    for engine in filter(find_spec, ENGINES):
        walks: dict[str, list[dict[str, float]]] = {case: [] for case in CASES}
        for _ in range(rounds):
            for case, looks in CASES.items():
                walks[case].append(_walk(engine, seconds, looks=looks))
        results[engine] = {case: _together(each) for case, each in walks.items()}
    return results | {"load at the end": os.getloadavg()[0]}


def _walk(engine: str, seconds: float, *, looks: bool) -> dict[str, float]:
    endpoint, url = free_endpoint(), "tcp://" + free_endpoint().removeprefix("tcp/")
    emulate = ["emulate", "--robot", "nao-v5", "--engine", engine, "--listen", endpoint]
    with tempfile.TemporaryDirectory() as name:
        robot = Child("robot", [*emulate, "--out", name], Path(name))
        server = Child("serve", ["serve", "naoqi", "--listen", url, "--connect", endpoint], Path(name))
        try:
            with ControllerLink("nao", endpoint, "bench") as link:
                _await_server(server)
                link.wait_robot(timeout=TIMEOUT)
                code = f"from nao_hil.bench.pictures import program; program({url!r}, {seconds}, {looks})"
                command = [sys.executable, "-c", code]
                with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=_ROOT) as client:
                    assert client.stdout is not None
                    _next_number(client.stdout)  # the time begins
                    first = _frame(link)
                    pictures = _next_number(client.stdout)
                    last = _frame(link)
        finally:
            server.end(5.0)
            outcome = robot.end(5.0)
    if outcome.code:
        raise LinkError(f"the robot's process failed: {outcome.error}")
    return {
        "cycles": last.seq - first.seq,
        "missed": last.missed - first.missed,
        "pictures": pictures / seconds,
    }


def program(url: str, seconds: float, looks: bool) -> None:
    """The NAOqi program, a process of its own: prints 0 when its time begins, then the pictures it took."""
    import qi

    session = qi.Session()
    session.connect(url)
    motion, video = session.service("ALMotion"), session.service("ALVideoDevice")
    handle = video.subscribeCamera("bench", 1, 1, 11, RATE) if looks else None
    motion.wakeUp()
    motion.moveToward(1.0, 0.0, 0.0)
    if handle is not None:
        video.getImageRemote(handle)
    time.sleep(UNDER_WAY)
    print("0", flush=True)
    deadline, pictures = time.monotonic() + seconds, 0
    while time.monotonic() < deadline:
        if handle is None:
            time.sleep(deadline - time.monotonic())
        else:
            pictures += len(video.getImageRemote(handle)[6]) == 320 * 240 * 3
    if not motion.moveIsActive():
        raise LinkError("the robot does not walk any more.")
    print(pictures, flush=True)
    motion.stopMove()
    os._exit(0)


def _next_number(lines: Any) -> int:
    """The next number, past the output of qi."""
    for line in lines:
        if line.strip().isdecimal():
            return int(line)
    raise LinkError("the program that walks the robot failed.")


def _frame(link: ControllerLink) -> SensorFrame:
    """The robot's newest frame."""
    link.latest(0.0)
    frame = link.latest(1.0)
    if frame is None:
        raise LinkError("the robot fell silent.")
    return frame


def _await_server(server: Child) -> None:
    deadline = time.monotonic() + TIMEOUT
    while "is served at" not in " ".join(server.stderr.split()):
        if not server.running or time.monotonic() > deadline:
            raise LinkError(f"the server did not start: {server.end(1.0).error}")
        time.sleep(0.1)


def _together(walks: list[dict[str, float]]) -> dict[str, float]:
    sums = {name: sum(walk[name] for walk in walks) for name in ("cycles", "missed")}
    return sums | {
        "missed, worst": max(walk["missed"] for walk in walks),
        "pictures": min(walk["pictures"] for walk in walks),
    }
