"""A program that is started again and again must not lower the robot, whose joints sag under load."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nao_hil
from bridge.body import load_body
from bridge.body.joints import LEG_SLOTS
from bridge.body.postures import POSTURES
from bridge.guard import Guard
from bridge.link.client import GuardClient
from bridge.messages import ActuatorFrame
from bridge.recording.playback import read_recording
from emulator.robot import EmulatedRobot
from tests.loops import until

STARTS = 10
LEGS = [slot for slots in LEG_SLOTS.values() for slot in slots]
TEAM_PAGE = Path(__file__).parents[2] / "docs" / "team.md"


def sag(position: Any) -> float:
    """Greatest angle of a leg joint off the stand, rad; the sixth start with measured angles ends in a fall."""
    return float(np.abs(np.subtract(position, POSTURES["StandInit"])[LEGS]).max())


@pytest.mark.parametrize("stiffness", [0.6, 1.0])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_robot_stands_after_ten_starts_that_command_the_stand(seed: int, stiffness: float) -> None:
    """`Info.stand`, as in docs/protocol.md."""
    body = load_body("nao-v6")
    robot, guard = EmulatedRobot(body, seed=seed, engine="mujoco"), Guard(body)
    for start in range(STARTS):
        for _ in range(100):
            wanted = ActuatorFrame(
                reply_to=robot.frame.seq,
                position=POSTURES["StandInit"],
                stiffness=(stiffness,) * 25,
                lease=start + 1,
            )
            robot.advance(guard.cycle(robot.frame, guard.check(wanted, robot.frame.seq), supervised=True))
        guard.released(robot.frame.seq)
        for _ in range(20):
            robot.advance(guard.cycle(robot.frame, None))
    assert not robot.truth().fell
    assert sag(robot.frame.position) < 0.15


@pytest.mark.parametrize("stiffness", [0.6])
def test_a_robot_stands_after_ten_starts_that_hold_it_where_it_is(
    start: Callable[..., Any], endpoint: str, stiffness: float
) -> None:
    """`first_target` of a connection, for programs that take the robot as it is, as the page's sliders do."""
    start("emulate", "--robot", "nao-v6", "--engine", "mujoco", "--mode", "lockstep", "--listen", endpoint)
    targets = []
    for _ in range(STARTS):
        with nao_hil.connect(endpoint, timeout=60.0) as robot:
            targets.append(robot.first_target)
            for _ in range(60):
                robot.step(robot.first_target, stiffness)
            assert sag(robot.frame.position) < 0.15
    assert targets[1:] == [targets[1]] * (STARTS - 1)


@pytest.mark.parametrize("stiffness", [1.0])
def test_a_robot_stands_after_ten_runs_of_the_team_page_s_client(
    start: Callable[..., Any], endpoint: str, tmp_path: Path, stiffness: float
) -> None:
    """Between two of them the guard crouches, because the client leaves the robot stiff.

    Each begins at rest: the guard's own motion is faster than the clock in lockstep, and the first angles that
    a client reads meanwhile are old when its first command comes.
    """
    found = re.search(r'title="client.py"\n(.*?)```', TEAM_PAGE.read_text(), re.DOTALL)
    assert found
    (tmp_path / "client.py").write_text(found[1].replace("[0.6]", f"[{stiffness}]"))
    robot = ("--robot", "nao-v6", "--engine", "mujoco", "--mode", "lockstep")
    emulator = start("emulate", *robot, "--out", str(tmp_path / "v6"), "--listen", endpoint)
    start("serve", "lola", "--socket", str(tmp_path / "lola.socket"), "--connect", endpoint)
    until((tmp_path / "lola.socket").exists, "LoLA's socket")
    guard = GuardClient("nao", endpoint)
    for number in range(STARTS):
        done = subprocess.run(
            [sys.executable, tmp_path / "client.py"], cwd=tmp_path, capture_output=True, text=True, check=True
        )
        left, right = map(float, re.findall(r"(\d+\.\d) kg", done.stdout))
        assert left + right == pytest.approx(5.5, abs=1.5), number
        until(lambda: guard.status().state == "rest", "the crouch")
    guard.close()
    emulator.interrupt()
    truths = [r.message for r in read_recording(tmp_path / "v6" / "frames.mcap") if r.topic == "world/truth"]
    assert truths and not any(truth.fell for truth in truths)
