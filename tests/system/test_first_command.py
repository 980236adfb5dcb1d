"""A program that is started again and again must not lower the robot, whose joints sag under load."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import nao_hil
from bridge.body import load_body
from bridge.body.joints import LEG_SLOTS
from bridge.body.postures import POSTURES
from bridge.guard import Guard
from bridge.messages import ActuatorFrame
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from tests.system.lola_robot import LolaSocket

STARTS = 7
RUNS = 4
"""Each begins in the same crouch, so that no sag adds up."""
LEGS = [slot for slots in LEG_SLOTS.values() for slot in slots]
TEAM_PAGE = Path(__file__).parents[2] / "docs" / "team.md"


def sag(position: Any) -> float:
    """Greatest angle of a leg joint off the stand, rad; the sixth start with measured angles ends in a fall."""
    return float(np.abs(np.subtract(position, POSTURES["StandInit"])[LEGS]).max())


@pytest.mark.parametrize(("seed", "stiffness"), [(1, 0.6), (2, 1.0)])
def test_a_robot_stands_after_seven_starts_that_command_the_stand(seed: int, stiffness: float) -> None:
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


def test_a_robot_stands_after_seven_starts_that_hold_it_where_it_is(
    start: Callable[..., Any], endpoint: str
) -> None:
    """`first_target` of a connection, for programs that take the robot as it is, as the page's sliders do."""
    start("emulate", "--robot", "nao-v6", "--engine", "mujoco", "--mode", "lockstep", "--listen", endpoint)
    targets = []
    for _ in range(STARTS):
        with nao_hil.connect(endpoint, timeout=60.0) as robot:
            targets.append(robot.first_target)
            for _ in range(60):
                robot.step(robot.first_target, 0.6)
            assert sag(robot.frame.position) < 0.15
    assert targets[1:] == [targets[1]] * (STARTS - 1)


def test_a_robot_stands_after_four_runs_of_the_team_page_s_client(capsys: pytest.CaptureFixture[str]) -> None:
    """Between two of them the guard crouches, because the client leaves the robot stiff.

    The page's own test runs the client against processes.
    """
    found = re.search(r'title="client.py"\nimport socket\n(.*?)```', TEAM_PAGE.read_text(), re.DOTALL)
    assert found
    client = compile(found[1].replace("[0.6]", "[1.0]"), "client.py", "exec")
    with EmulatedRobot(load_body("nao-v6"), seed=0, engine="mujoco", wear=load_wear("nominal")) as robot:
        lola = LolaSocket(robot)
        for number in range(RUNS):
            exec(client, {"socket": SimpleNamespace(AF_UNIX=0, socket=lambda _family: lola)})
            left, right = map(float, re.findall(r"(\d+\.\d) kg", capsys.readouterr().out))
            assert left + right == pytest.approx(5.5, abs=1.5), number
            lola.abandon()
            assert not robot.truth().fell
