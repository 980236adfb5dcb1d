"""Two robots against two on a small field with a ball: three walkers and a program that knows LoLA alone.

`python -m tests.measure.game --seconds 600` plays it in real time and prints the missed cycles of each robot.
With `--lockstep` it plays the same game twice and compares all frames of each robot.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np

from bridge.body import load_body
from bridge.errors import LinkError, WalkRefused
from bridge.link.client import GuardClient, WalkClient, WorldClient
from bridge.messages.world import LEAGUE_BALL_MASS, Pause, PlaceObject, Step, WorldCommand
from nao_hil.runs.run import load
from nao_hil.runs.supervisor import Child
from tests.ports import free_endpoint
from tests.processes import REPOSITORY

BODY: Final = "nao-v6"
PLACES: Final = {
    "red1": (-1.2, -1.2, 0),
    "red2": (-1.2, 1.2, 0),
    "blue1": (1.2, 1.2, 180),
    "blue2": (1.2, -0.8, 180),
}
"""x and y, m, and heading, degrees, of each robot."""
WALKS: Final = {"red1": (0.15, 0.0, 0.3), "red2": (0.12, 0.0, -0.3), "blue1": (0.15, 0.0, 0.3)}
"""Velocity command of each walker, m/s and rad/s: circles that do not meet; the ball lies on the first."""
START: Final = 100
"""Cycle in which they are told to walk, in lockstep."""
LOLA: Final = "blue2"
BALL: Final = PlaceObject(
    name="ball", shape="ball", size=(0.1, 0.1, 0.1), mass=LEAGUE_BALL_MASS, at=(-0.7, -0.7)
)
GRACE: Final = 60.0
"""s in which processes start or end."""


def play(seconds: float, mode: str, engine: str, folder: Path) -> dict[str, Any]:
    """Play one game.

    Args:
        seconds: Robot time.
        mode: `real-time` or `lockstep`.
        engine: Physics.
        folder: Of recordings and output.

    Returns:
        The summary of each robot, by name.
    """
    endpoint, path = free_endpoint(), folder / "robocup"
    file = folder / "game.toml"
    file.write_text(
        "".join(
            f'[[robots]]\nname = "{name}"\nrobot = "{BODY}"\nseed = {seed}\nat = [{x}, {y}]\nyaw = {yaw}\n'
            for seed, (name, (x, y, yaw)) in enumerate(PLACES.items())
        )
    )
    world = Child(
        "world",
        [
            *("emulate", "--world", str(file), "--scenario", "field-small", "--mode", mode, "--engine", engine),
            *("--listen", endpoint, "--out", str(folder / "run"), "--json"),
        ],
        folder,
    )
    with ExitStack() as opened:
        opened.callback(world.end, GRACE)
        client = opened.enter_context(WorldClient(LOLA, endpoint, GRACE))
        _wait(lambda: _sent(client, BALL))
        if mode == "lockstep":
            client.send(Pause())
        walkers = [
            Child(
                name, ["walk", "--name", name, "--connect", endpoint, "--serve", "--recover", "--json"], folder
            )
            for name in WALKS
        ]
        server = Child(
            "lola", ["serve", "lola", "--name", LOLA, "--socket", str(path), "--connect", endpoint], folder
        )
        for child in (*walkers, server):
            opened.callback(child.end, GRACE)
        _wait(path.exists)
        program = subprocess.Popen(
            [sys.executable, "examples/lola_motion.py", "--socket", str(path)]
            + ["sit-down", "stand-up"] * (1 + int(seconds / 5)),
            cwd=REPOSITORY,
            stdout=subprocess.DEVNULL,
        )
        opened.callback(program.wait)
        opened.callback(program.kill)
        for name in PLACES:
            with GuardClient(name, endpoint) as guard:
                _wait(lambda guard=guard: bool(guard.status().holder))  # type: ignore[misc]
        for (
            name,
            velocity,
        ) in WALKS.items():  # once no process is starting any more, which would starve the others
            with WalkClient(name, endpoint) as walker:
                ready = ("stand",) if mode == "real-time" else ("approach", "stand")
                _wait(lambda walker=walker, ready=ready: _state(walker) in ready)  # type: ignore[misc]
                walker.walk(velocity, at=START if mode == "lockstep" else None)
        if mode == "lockstep":
            client.send(Step(cycles=round(seconds / load_body(BODY).cycle)), timeout=60.0 + 20.0 * seconds)
        else:
            time.sleep(seconds)
        robots: dict[str, Any] = (world.end(GRACE).result or {})["robots"]
    for name, robot in robots.items():
        robot["sensors_sha256"] = _digest(folder / "run" / name, round(seconds / load_body(BODY).cycle))
    return robots


def _digest(run: Path, cycles: int) -> str:
    """SHA-256 over the sensor frames up to a cycle: which answers arrive after it depends on the wall clock."""
    sensors = load(run)["sensors"]
    rows, digest = sensors.where(sensors["seq"] <= cycles), hashlib.sha256()
    for column in sorted(rows):
        digest.update(np.ascontiguousarray(rows[column]).tobytes())
    return digest.hexdigest()


def _sent(client: WorldClient, command: WorldCommand) -> bool:
    with contextlib.suppress(LinkError):
        client.send(command)
        return True
    return False


def _state(walker: WalkClient) -> str:
    """State of a walker; empty: it has answered no frame yet."""
    with contextlib.suppress(WalkRefused):
        return walker.status().state
    return ""


def _wait(condition: Callable[[], bool], seconds: float = GRACE) -> None:
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError("The game did not go on.")
        time.sleep(0.2)


def main() -> None:
    """Play as the command line says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--lockstep", action="store_true", help="twice the same game")
    parser.add_argument("--engine", default="mujoco")
    arguments = parser.parse_args()
    games = []
    for _ in range(2 if arguments.lockstep else 1):
        with TemporaryDirectory() as folder:
            mode = "lockstep" if arguments.lockstep else "real-time"
            games.append(play(arguments.seconds, mode, arguments.engine, Path(folder)))
    keys = ("cycles", "cycles_missed", "falls", "recoveries", "stands", "steps", "way", "sensors_sha256")
    print(json.dumps([{name: {k: robot[k] for k in keys} for name, robot in game.items()} for game in games]))
    if arguments.lockstep:
        alike = all(games[0][name]["sensors_sha256"] == games[1][name]["sensors_sha256"] for name in PLACES)
        print(f"the same twice: {alike}")
        sys.exit(not alike)


if __name__ == "__main__":
    main()
