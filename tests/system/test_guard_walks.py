"""The guard does not touch a walk: every command of the gaits goes out as it came in."""

from __future__ import annotations

import pytest

from bridge.body import load_body
from bridge.guard import Guard
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from nao_hil.runs.build import controller_maker
from nao_hil.runs.config import RunConfig
from tests.loops import repeat_while


@pytest.mark.parametrize(("gait", "steps"), [("static", 2), ("dynamic", 6)])
def test_every_command_of_a_walk_passes_unchanged(gait: str, steps: int) -> None:
    body = load_body("nao-v3")
    guard = Guard(body)
    controller = controller_maker(RunConfig(gait=gait, steps=steps))(body, body.cycle)
    with EmulatedRobot(body, seed=0, engine="mujoco", wear=load_wear("nominal")) as robot:
        for _ in repeat_while(lambda: not controller.done):
            command = guard.check(controller.tick(robot.frame), robot.frame.seq)
            given = guard.cycle(robot.frame, command)
            assert given == command, robot.frame.seq
            robot.advance(given)
        assert controller.telemetry.step == steps
    assert [notice.code for notice in guard.take_notices()] == ["guard-active"]
