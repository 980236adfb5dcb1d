"""Physics before the command: where the drives delay requests by a cycle, the frames cannot tell."""

from __future__ import annotations

import math

import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.postures import POSTURES
from bridge.messages import ActuatorFrame, SensorFrame
from bridge.messages.faults import CommandLost, DcmPause, JointWeak
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear

V6 = load_body("nao-v6")
STAND = POSTURES["StandInit"]


def squat(frame: SensorFrame) -> ActuatorFrame | None:
    """Knees and hands in motion; now and then no answer."""
    if frame.seq % 7 == 3:
        return None
    bend = 0.2 * (1.0 - math.cos(2.0 * frame.time))
    position = list(STAND)
    for side in "LR":
        position[INDEX[f"{side}HipPitch"]] -= bend
        position[INDEX[f"{side}KneePitch"]] += 2.0 * bend
        position[INDEX[f"{side}AnklePitch"]] -= bend
        position[INDEX[f"{side}Hand"]] = 0.5 + 0.5 * math.sin(frame.time)
    stiffness = 0.9 if frame.seq < 60 else 0.6
    return ActuatorFrame(reply_to=frame.seq, position=tuple(position), stiffness=(stiffness,) * 25)


def frames(wear: str, *, ahead: bool) -> list[SensorFrame]:
    with EmulatedRobot(V6, seed=4, engine="mujoco", wear=load_wear(wear)) as robot:
        robot.faults.start(CommandLost(probability=0.2), robot.time, 0.0)
        seen = [robot.frame]
        for cycle in range(150):
            if cycle == 50:
                robot.faults.start(DcmPause(), robot.time, 0.1)
            if cycle == 90:
                robot.faults.start(JointWeak(joint="LKneePitch", fraction=0.5), robot.time, 0.3)
            if ahead:
                robot.run_ahead()
            seen.append(robot.advance(squat(robot.frame), expected=True))
        return seen


@pytest.mark.parametrize("wear", ["ideal", "nominal", "worn"])
def test_the_same_frames_with_the_physics_before_or_after_the_command(wear: str) -> None:
    assert frames(wear, ahead=True) == frames(wear, ahead=False)


@pytest.mark.parametrize(("wear", "moves"), [("nominal", True), ("ideal", False)])
def test_the_world_moves_before_the_command_only_where_that_cannot_act_yet(wear: str, moves: bool) -> None:
    with EmulatedRobot(V6, seed=4, engine="mujoco", wear=load_wear(wear)) as robot:
        for _ in range(20):
            robot.advance(squat(robot.frame))
        before = robot.engine.robot.position.copy()
        robot.run_ahead()
        assert bool((robot.engine.robot.position != before).any()) is moves
        assert robot.frame.seq == robot.seq == 20
