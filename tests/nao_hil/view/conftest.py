"""Robots, commands and orders that the tests of the page share."""

from __future__ import annotations

import json
import threading
from collections import deque
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest

from bridge.body import load_body
from bridge.errors import LinkError
from bridge.link.robots import LinkRobot
from bridge.messages.guard import GuardStatus
from bridge.messages.walk import WalkCommand, WalkStatus
from bridge.messages.world_state import WorldReply
from emulator.robot import EmulatedRobot
from nao_hil.runs.run import Cycle, CycleBuilder
from nao_hil.view.follow import LinkFollower
from nao_hil.view.orders import (
    ABSENCE_TIMEOUT,
    Driving,
    Orders,
    answered,
)
from tests.frames import walk_status

BODY = load_body("nao-v3")
REPLY = WorldReply(
    text="Done.", seq=0, time=0.0, paused=False, floor=(0.0, 0.0), friction=0.8, objects=(), faults=()
)
STATUS = walk_status(text="It walks.", state="walk", velocity=(0.05, 0.0, 0.0))


@pytest.fixture(scope="module")
def standing() -> list[Cycle]:
    """Two seconds of a robot that stands."""
    builder, kept = CycleBuilder(), []
    with EmulatedRobot(BODY, seed=0, engine="mujoco") as robot:
        for _ in range(200):
            robot.advance(None)
            for message in (robot.frame, robot.truth()):
                if (cycle := builder.add(message)) is not None:
                    kept.append(cycle)
    return kept


class FakeCommands:
    """Takes commands and keeps them."""

    def __init__(self) -> None:
        self.sent: list[Any] = []
        self.there = True
        self.state = "stand"
        self.report = STATUS

    def world(self, command: Any) -> WorldReply:
        self.sent.append(command)
        return REPLY

    def walk(self, command: WalkCommand) -> WalkStatus:
        self.sent.append(command)
        return msgspec.structs.replace(self.report, state=self.state)

    send = walk

    def status(self) -> WalkStatus:
        return msgspec.structs.replace(self.report, state=self.state)

    def walker(self) -> FakeCommands:
        return self

    def stop(self) -> GuardStatus:
        if not self.there:
            raise LinkError("No robot `nao` at tcp/127.0.0.1:7447 answered `stop`.")
        return GuardStatus(seq=1, state="crouch", reason="stop", armed=False, text="It goes down.")


@pytest.fixture
def commands() -> FakeCommands:
    return FakeCommands()


@pytest.fixture
def lookers() -> list[str]:
    """Who looks at the page."""
    return ["somebody"]


@pytest.fixture
def driving(commands: FakeCommands, lookers: list[str]) -> Driving:
    return Driving(lambda: commands, lambda: 0.0 if lookers else ABSENCE_TIMEOUT)  # type: ignore[arg-type, return-value]


@pytest.fixture
def order(commands: FakeCommands, driving: Driving, tmp_path: Path) -> Callable[..., tuple[str, bool]]:
    config = tmp_path / "config.toml"
    config.write_text('robot = "nao-v3"\n')
    orders = Orders(commands, driving, None, BODY, lambda: config)  # type: ignore[arg-type]
    return lambda doing, **fields: answered(json.dumps({"do": doing, **fields}), orders.execute)  # type: ignore[arg-type]


@pytest.fixture
def link(commands: FakeCommands) -> tuple[LinkFollower, FakeCommands]:
    """A link with the chosen robot `red`, and `blue`; the commands that reach `blue`."""
    server, others = SimpleNamespace(absence=0.0), FakeCommands()
    follower = LinkFollower(server, "red", "tcp/127.0.0.1:1", threading.Event())  # type: ignore[arg-type]
    for name, taken in (("red", commands), ("blue", others)):
        driving = Driving(lambda taken=taken: taken, lambda: 0.0)  # type: ignore[misc, return-value]
        follower.follower(name)._orders = Orders(taken, driving, None, BODY, None)  # type: ignore[arg-type]
        follower.robots.found[name] = LinkRobot(BODY, deque())
    return follower, others
