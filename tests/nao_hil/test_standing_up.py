"""A robot that lies or sits stands up, and carries out its order."""

from __future__ import annotations

import pytest

from bridge.motion import MotionPlayer, load_motion
from nao_hil.runs.build import build_robot
from nao_hil.runs.config import RunConfig, run_config
from nao_hil.runs.in_process import walk_in_process
from nao_hil.runs.motion import play


@pytest.mark.parametrize(("robot", "start"), [("nao-v6", "lie-back"), ("nao-v3", "lie-front")])
def test_onto_its_feet_and_on(robot: str, start: str) -> None:
    summary = walk_in_process(
        run_config(
            None, robot=robot, engine="mujoco", gait="dynamic", start=start, steps=4, seed=21, recover=True
        )
    )
    # it lay from the start: that is no fall; it stands at the end, and has walked what was asked for
    assert (summary.falls, summary.recoveries, summary.steps) == (0, 1, 4)
    assert summary.stands
    assert summary.displacement[0] > 0.1
    assert abs(summary.displacement[2]) < 0.5  # rad; what it turned while it got up is no turn of its walk
    assert summary.speed > 0.0


def test_without_recovery_it_stays_where_it_is() -> None:
    summary = walk_in_process(
        run_config(None, robot="nao-v6", engine="mujoco", gait="dynamic", start="lie-back", steps=4, seed=21)
    )
    assert (summary.recoveries, summary.steps, summary.stands) == (0, 0, False)


@pytest.mark.parametrize(("robot", "motion"), [("nao-v3", "stand-up-v3"), ("nao-v6", "stand-up")])
def test_a_robot_that_begins_sitting_stands_up(robot: str, motion: str) -> None:
    with build_robot(RunConfig(robot=robot, engine="mujoco", start="sit", seed=1)) as body:
        result = play(body, motion, MotionPlayer(load_motion(motion), body.body))
    assert result.stands and result.began == result.ended == "upright"
