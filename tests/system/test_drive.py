"""`nao-hil drive` in a terminal of its own, against a walker that writes down what it is told."""

from __future__ import annotations

import itertools
import json
import os
import pty
import subprocess
import sys
import termios
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from bridge.errors import WalkRefused
from bridge.link import keys
from bridge.link.query import serve_query
from bridge.link.session import open_robot
from bridge.messages import decode_command, encode
from bridge.messages.walk import WALK_COMMAND, WalkCommand
from tests.frames import walk_status
from tests.loops import TIMEOUT, until

REST = walk_status(text="The robot is in state `stand`.", torso="robust")


class Walker:
    """Refuses to turn, and does whatever else it is told."""

    def __init__(self) -> None:
        self.told: list[WalkCommand] = []
        self.looks = 0

    def answer(self, payload: bytes) -> bytes:
        command: WalkCommand = decode_command(payload, WalkCommand, "Walk command")
        if command.op == "status":
            self.looks += 1
            return encode(REST)
        self.told.append(command)
        if command.velocity is not None and command.velocity[2]:
            raise WalkRefused("The static gait walks straight ahead.")
        return encode(msgspec.structs.replace(REST, text="Done.", velocity=command.velocity or (0.0, 0.0, 0.0)))

    @property
    def walks(self) -> list[float]:
        """Velocity forwards of each order to walk straight on, but for those that change something else."""
        ahead = [c.velocity[0] for c in self.told if c.op == "walk" and c.velocity and not c.velocity[2]]
        return [velocity for velocity, _ in itertools.groupby(ahead)]


@pytest.fixture
def walker(endpoint: str) -> Iterator[Walker]:
    walker = Walker()
    session = open_robot(endpoint)
    queryable = serve_query(
        session, keys.key("driven", WALK_COMMAND), lambda payload, _: walker.answer(payload)
    )
    yield walker
    queryable.undeclare()
    session.close()


def test_keys_in_a_terminal_walk_the_robot(walker: Walker, endpoint: str, tmp_path: Path) -> None:
    terminal, inside = pty.openpty()
    before = termios.tcgetattr(inside)
    arguments = ["drive", "--name", "driven", "--connect", endpoint, "--json"]
    with (tmp_path / "out").open("w") as out, (tmp_path / "err").open("w") as err:
        process = subprocess.Popen(
            [sys.executable, "-m", "nao_hil.cli", *arguments], stdin=inside, stdout=out, stderr=err
        )
    try:
        until(lambda: walker.looks > 1 or process.poll() is not None, "the driver")
        os.write(terminal, b"w\x1b[A")
        until(lambda: len(walker.walks) == 2, "two steps of the velocity")
        os.write(terminal, b"a")
        until(lambda: any(c.velocity and c.velocity[2] for c in walker.told), "a turn")
        os.write(terminal, b"w")
        until(lambda: len(walker.walks) == 3, "another velocity")
        os.write(terminal, b"m")
        until(lambda: any(c.admittance is False for c in walker.told), "a switch")
        os.write(terminal, b"Q")
        assert process.wait(TIMEOUT) == 0
    finally:
        process.kill()
        process.wait()
    notch = 0.06 / 3.5 / 5  # a fifth of the static gait's own velocity
    # faster, faster, the turn that is refused, faster again without it; then the switch at that velocity
    assert walker.walks == pytest.approx([notch, 2 * notch, 3 * notch], abs=1e-6)
    assert walker.told[-1].op == "stop"
    assert all(command.hold == 3.0 for command in walker.told if command.op == "walk")
    result = json.loads((tmp_path / "out").read_text())
    assert result["refused"] == 1
    assert (result["config"]["name"], result["config"]["connect"]) == ("driven", endpoint)
    assert (result["config"]["gait"], result["config"]["torso"]) == (REST.gait, REST.torso)
    assert termios.tcgetattr(inside) == before
    os.close(terminal)
    os.close(inside)
