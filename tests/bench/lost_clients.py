"""LoLA clients killed at random moments of standing and walking: does the robot crouch, does it fall?"""

from __future__ import annotations

import math
import random
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Final

from bridge.adapters.lola.codec import SENSORS, MapStream
from bridge.adapters.lola.packets import actuator_map, sensor_frame
from bridge.body import load_body
from bridge.body.fall import FALLEN_TILT
from bridge.errors import LinkError
from bridge.link import ControllerLink, keys
from bridge.link.client import GuardClient, WorldClient
from bridge.link.session import open_client, subscribe
from bridge.messages import TruthFrame, decode
from bridge.messages.world import Reset
from nao_hil.runs.build import controller_maker
from nao_hil.runs.config import run_config
from nao_hil.runs.supervisor import Child
from tests.bench.pictures import TIMEOUT
from tests.ports import free_endpoint

CLIENTS: Final = 20
"""Of each kind."""
SPEED: Final = (0.15, 0.0, 0.0)
"""m/s and rad/s"""
KILL_TIMES: Final = (3.0, 8.0)
"""s from the client's first packet in which it is killed; it walks from 1.5 s on."""
DOWN_TIMEOUT: Final = 20.0
"""s until the robot must be down."""
_ROOT: Final = Path(__file__).parents[2]


def measure(clients: int = CLIENTS) -> dict[str, Any]:
    """A nominal V6 on MuJoCo, in real time; the walking clients use `omni`.

    Returns:
        For `standing` and `walking`: number of clients, robots that sat down (guard in `rest`) and
        robots that fell (torso over 45 degrees).

    Raises:
        LinkError: a process failed.
    """
    draw, endpoint = random.Random(0), free_endpoint()
    with tempfile.TemporaryDirectory() as name:
        path = str(Path(name) / "robocup")
        emulate = ["emulate", "--robot", "nao-v6", "--engine", "mujoco", "--listen", endpoint, "--out", name]
        robot = Child("robot", emulate, Path(name))
        server = Child("serve", ["serve", "lola", "--socket", path, "--connect", endpoint], Path(name))
        try:
            with ControllerLink("nao", endpoint, "bench") as link:
                link.wait_robot(timeout=TIMEOUT)
            return {
                kind: _row([_lose(endpoint, path, draw, walks=kind == "walking") for _ in range(clients)])
                for kind in ("standing", "walking")
            }
        finally:
            server.end(5.0)
            robot.end(5.0)


def _row(found: list[tuple[bool, bool]]) -> dict[str, int]:
    return {"clients": len(found), "down": sum(d for d, _ in found), "fell": sum(f for _, f in found)}


def _lose(endpoint: str, path: str, draw: random.Random, *, walks: bool) -> tuple[bool, bool]:
    """Start a client on a standing robot and kill it; whether the robot ends at rest, and whether it falls."""
    with WorldClient("nao", endpoint) as world:
        world.send(Reset(), TIMEOUT)
    tilts: list[float] = []
    session = open_client(endpoint)
    key = keys.topic_key("nao", TruthFrame)
    subscriber = subscribe(session, key, lambda data: tilts.append(_upright(data)))
    code = f"from tests.bench.lost_clients import client; client({path!r}, {walks})"
    with subprocess.Popen([sys.executable, "-c", code], cwd=_ROOT, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(draw.uniform(*KILL_TIMES))
        if process.poll() is not None:
            raise LinkError("the client ended by itself.")
        process.kill()
    with GuardClient("nao", endpoint) as guard:
        deadline = time.monotonic() + DOWN_TIMEOUT
        while (state := guard.status().state) != "rest" and time.monotonic() < deadline:
            time.sleep(0.1)
    subscriber.undeclare()
    session.close()
    return state == "rest", min(tilts) < math.cos(FALLEN_TILT)


def _upright(data: bytes) -> float:
    """Cosine of the torso's lean."""
    x, y, _, _ = decode(data, TruthFrame).torso_orientation
    return 1.0 - 2.0 * (x * x + y * y)


def client(path: str, walks: bool) -> None:
    """The client, a process of its own: prints a line at its first packet, then stands or walks until killed.

    Args:
        path: of LoLA's socket.
        walks: whether it walks.
    """
    settings = run_config(None, robot="nao-v6", gait="omni", velocity=SPEED, steps=0, recover=False)
    controller = controller_maker(settings)(load_body("nao-v6"), 0.012)
    stream, peer, seq = MapStream(SENSORS), socket.socket(socket.AF_UNIX), 0
    peer.connect(path)
    stand: tuple[float, ...] | None = None
    while True:
        for packet in stream.feed(peer.recv(4096))[-1:]:
            frame = sensor_frame(packet, seq=seq)
            if not seq:
                print("begins", flush=True)
            seq += 1
            stand = stand or frame.position
            command = controller.tick(frame) if walks else None
            peer.sendall(actuator_map(command.position if command else stand, (1.0,) * 25))
