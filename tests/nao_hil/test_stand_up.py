"""Standing up from the start pose `sit`, by the body's own motion, judged by the ground truth."""

from __future__ import annotations

import pytest

from bridge.motion import MotionPlayer, load_motion
from nao_hil.runs.build import build_robot
from nao_hil.runs.config import RunConfig
from nao_hil.runs.motion import play


@pytest.mark.parametrize(("robot", "motion"), [("nao-v3", "stand-up-v3"), ("nao-v6", "stand-up")])
def test_a_robot_that_begins_sitting_stands_up(robot: str, motion: str) -> None:
    with build_robot(RunConfig(robot=robot, engine="mujoco", start="sit", seed=1)) as body:
        result = play(body, motion, MotionPlayer(load_motion(motion), body.body))
    assert result.stands and result.began == result.ended == "upright"
