"""Any to any: emulator - serve lola - bridge lola - walker, processes that know each other by address only."""

from __future__ import annotations

import math
import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bridge.link import ControllerLink
from bridge.link.client import GuardClient
from tests.loops import TIMEOUT, until


@pytest.fixture
def begin(
    start: Callable[..., Any], endpoint: str, far: str, tmp_path: Path
) -> Callable[[str], dict[str, Any]]:
    """Starts the loop in a mode up to the bridge, armed: the processes by name."""
    return lambda mode: _begin(mode, start, endpoint, far, tmp_path)


@pytest.fixture
def loop(begin: Callable[[str], dict[str, Any]]) -> dict[str, Any]:
    """The loop in lockstep."""
    return begin("lockstep")


def _begin(mode: str, start: Callable[..., Any], endpoint: str, far: str, tmp_path: Path) -> dict[str, Any]:
    path = str(tmp_path / "robocup")
    robot = start(
        *("emulate", "--robot", "nao-v6", "--mode", mode, "--listen", endpoint, "--json"),
        *(("--engine", "mujoco") if mode == "lockstep" else ()),
        *("--out", str(tmp_path / "run")),
    )
    server = start("serve", "lola", "--socket", path, "--connect", endpoint, "--json")
    bridge = start("bridge", "lola", "--socket", path, "--listen", far, "--mode", mode, "--json")
    until(lambda: "not armed" in " ".join(bridge.stderr.split()), "the bridge to find its robot")
    arm = start("arm", "--yes", "--connect", far)
    assert arm.wait() == 0
    return {"robot": robot, "server": server, "bridge": bridge}


def test_the_walker_walks_through_the_loop(loop: dict[str, Any], start: Callable[..., Any], far: str) -> None:
    velocity = ("--velocity", "0.12", "0.03", "0.3")
    walker = start("walk", *velocity, "--steps", "8", "--connect", far, "--json")
    assert walker.wait() == 0
    assert walker.result["done"] and walker.result["steps"] == 8
    loop["bridge"].interrupt()
    bridged = loop["bridge"].result
    # packets before the first map, and the last one, have no answer
    assert bridged["packets"] >= bridged["commands"] > walker.result["ticks"]  # it crouched in the end
    loop["server"].interrupt()
    assert loop["server"].result["dropped_bytes"] == 0
    loop["robot"].interrupt()
    result = loop["robot"].result
    # Two seconds, less the way from rest and back. The cycles before the walk differ by a few, and with them
    # the walk: the bound is about half of the least of a dozen.
    assert math.hypot(*result["displacement"][:2]) > 0.08
    assert result["cycles_missed"] == 0 and result["commands_refused"] == 0


def test_a_walker_that_is_killed_leaves_the_robot_to_the_bridge_s_guard(
    loop: dict[str, Any], start: Callable[..., Any], far: str
) -> None:
    walker = start("walk", "--gait", "dynamic", "--steps", "0", "--connect", far)
    until(lambda: "Commands are in force" in " ".join(loop["server"].stderr.split()), "the walk")
    os.kill(walker.process.pid, signal.SIGKILL)
    with GuardClient("nao", far) as guard:

        def down() -> bool:
            """In lockstep the descent may be over before anybody looks."""
            return guard.status().state in ("crouch", "rest")

        until(down, "the guard to crouch by itself, in lockstep too")
        assert guard.status().reason == "silence"
    with ControllerLink("nao", far, "next") as link:
        link.wait_robot(timeout=TIMEOUT)
        link.acquire()
        frame = link.next(TIMEOUT)
        assert frame is not None
