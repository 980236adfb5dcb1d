"""Key-frame motions through LoLA by a client of its own, judged by the ground truth."""

from __future__ import annotations

import contextlib
import math
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bridge.link.client import WorldClient
from bridge.messages import TruthFrame
from bridge.messages.world import LayDown, StartName
from bridge.motion import load_motion
from nao_hil.runs.monitor import Monitor
from tests.loops import TIMEOUT, until
from tests.processes import REPOSITORY, module_of

WEIGHT = 53.0
"""N, of a V6 (data sheet: 5.4 kg)."""


LIMP = 60
"""Cycles."""


def client() -> Any:
    """The example: a socket, msgpack and key frames."""
    return module_of(REPOSITORY / "examples" / "lola_motion.py")


def tilt(truth: TruthFrame) -> float:
    """Of the torso, degrees: the z axis of the world against its own."""
    x, y, _, _ = truth.torso_orientation
    return math.degrees(math.acos(1.0 - 2.0 * (x * x + y * y)))


def stands(truth: TruthFrame) -> bool:
    return not truth.fell and tilt(truth) < 10.0 and on_feet(truth) > 0.9


def on_feet(truth: TruthFrame) -> float:
    """Share of the weight."""
    return (truth.left.force[2] + truth.right.force[2]) / WEIGHT


def test_the_motions_of_a_day_through_lola(start: Callable[..., Any], endpoint: str, tmp_path: Path) -> None:
    """Up from back, front and side, down to the seat, up from it, and a crouch; one robot, in lockstep."""
    pytest.importorskip("mujoco")
    path = str(tmp_path / "robocup")
    emulate = ["emulate", "--engine", "mujoco", "--robot", "nao-v6", "--wear", "nominal", "--mode", "lockstep"]
    start(*emulate, "--start", "lie-back", "--seed", "1", "--listen", endpoint, "--out", str(tmp_path / "run"))
    start("serve", "lola", "--socket", path, "--connect", endpoint)
    until(lambda: Path(path).exists(), "the socket")
    example = client()
    with contextlib.ExitStack() as stack:
        monitor = stack.enter_context(Monitor("nao", endpoint))
        until(monitor.connect, "the robot")
        world = stack.enter_context(WorldClient("nao", endpoint))
        lola = stack.enter_context(socket.socket(socket.AF_UNIX))
        lola.settimeout(TIMEOUT)
        lola.connect(path)

        packet = example.exchange(lola, {})

        def after(*names: str, comes: Callable[[TruthFrame], bool]) -> None:
            """Play motions; then the robot waits for an answer, and its newest truth is under way."""
            nonlocal packet
            for name in names:
                packet = example.play(lola, load_motion(name), packet)
            until(lambda: monitor.truth is not None and comes(monitor.truth), f"the end of {names[-1]}")

        def lie(pose: StartName) -> None:
            """Somebody lays the robot down, and the client lets go of it."""
            nonlocal packet
            world.send(LayDown(pose=pose))
            for _ in range(LIMP):
                packet = example.exchange(lola, {"Stiffness": [0.0] * 25})

        after("get-up-back", comes=stands)
        after("sit-down", comes=lambda truth: tilt(truth) < 25.0 and on_feet(truth) < 0.3)
        after("stand-up", comes=stands)
        after("crouch", comes=stands)
        lie("lie-front")
        after("get-up-front", comes=stands)
        lie("lie-side")
        after("roll-from-side", "get-up-back", comes=stands)
