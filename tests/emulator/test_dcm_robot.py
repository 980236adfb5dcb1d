"""The DCM in the emulated robot: what is sent moves the joints, through the same buffers as frames."""

from __future__ import annotations

import math

import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.postures import POSTURES
from bridge.dcm.requests import alias_request, set_alias_request, set_request
from bridge.messages import ActuatorFrame
from bridge.messages.faults import DcmPause
from emulator.robot import EmulatedRobot

START = POSTURES["Stand"]
ELBOW = "LElbowYaw"
SLOT = INDEX[ELBOW]
COMMAND = f"{ELBOW}/Position/Actuator/Value"


def held_robot(body: str = "nao-v3") -> EmulatedRobot:
    return EmulatedRobot(
        load_body(body), seed=0, engine="mujoco", posture="Stand", held=True, lift=0.3, settle=0.1
    )


def frame(robot: EmulatedRobot, angle: float) -> ActuatorFrame:
    position = tuple(angle if i == SLOT else value for i, value in enumerate(START))
    return ActuatorFrame(reply_to=robot.frame.seq, position=position, stiffness=(1.0,) * 25)


def test_a_timed_ramp_moves_the_joint_as_frames_along_the_same_line_do() -> None:
    with held_robot() as by_frames, held_robot() as by_ramp:
        by_ramp.dcm.set(set_request([COMMAND, "ClearAll", [[0.0, 0], [-1.0, 400]]]))
        for k in range(60):
            by_frames.advance(frame(by_frames, -min(k / 40, 1.0)))
            by_ramp.advance(None)
            # One count of the motor board's integer is 0.1 mrad, one of the encoder 1.5 mrad.
            assert by_ramp.frame.position[SLOT] == pytest.approx(by_frames.frame.position[SLOT], abs=2e-3)
        assert by_ramp.frame.position[SLOT] == pytest.approx(-1.0, abs=0.05)


def test_an_alias_command_and_a_frame_of_the_same_values_give_the_same_robot() -> None:
    """Bit for bit, standing on its feet: the frame is ClearAll at the time of now."""
    with (
        EmulatedRobot(load_body("nao-v3"), seed=0, engine="mujoco") as by_frames,
        EmulatedRobot(load_body("nao-v3"), seed=0, engine="mujoco") as by_alias,
    ):
        joints = [actuator.name for actuator in by_alias.dcm.table if "/Position/" in actuator.name]
        stiff = [name.replace("Position", "Hardness") for name in joints]
        by_alias.dcm.create_alias(alias_request(["all", joints + stiff]))
        for k in range(50):
            angle = START[SLOT] + 0.2 * math.sin(0.2 * k)
            command = frame(by_frames, angle)
            by_frames.advance(command)
            values = [command.position[INDEX[name.split("/")[0]]] for name in joints] + [1.0] * len(stiff)
            by_alias.dcm.set_alias(set_alias_request(["all", by_alias.dcm.clock.shown(), values]))
            by_alias.advance(None)
            assert by_alias.truth() == by_frames.truth()
            assert by_alias.frame.position == by_frames.frame.position


def test_without_stiffness_the_actuator_reads_the_measured_angle() -> None:
    with held_robot() as robot:
        robot.dcm.set(set_request([COMMAND, "ClearAll", [[-1.5, 0]]]))
        robot.dcm.set(set_request([f"{ELBOW}/Hardness/Actuator/Value", "ClearAll", [[0.0, 0]]]))
        for _ in range(30):
            robot.advance(None)
        assert robot.frame.stiffness[SLOT] == 0.0
        assert robot.dcm.read([COMMAND], robot.frame.position) == [robot.frame.position[SLOT]]
        assert robot.frame.position[SLOT] > -1.0


def test_hands_follow_timed_commands() -> None:
    with held_robot("nao-v6") as robot:
        robot.dcm.set(set_request(["LHand/Position/Actuator/Value", "ClearAll", [[1.0, 0]]]))
        for _ in range(100):
            robot.advance(None)
        assert robot.frame.position[INDEX["LHand"]] == 1.0


@pytest.mark.parametrize("body", ["nao-v3", "nao-v6"])
def test_the_clock_counts_the_cycles_of_the_body(body: str) -> None:
    with held_robot(body) as robot:
        for _ in range(25):
            robot.advance(None)
        assert robot.dcm.clock.shown() == round(1000.0 * robot.frame.time)


def test_the_clock_keeps_to_the_time_of_the_robot_over_a_pause_of_the_dcm() -> None:
    with held_robot() as robot:
        robot.faults.start(DcmPause(), robot.time, 0.1)
        for _ in range(5):
            robot.advance(None)
        assert robot.frame.seq > 10
        assert robot.dcm.clock.shown() == round(1000.0 * robot.frame.time)


def test_a_reset_begins_with_empty_buffers_and_no_aliases() -> None:
    with held_robot() as robot:
        robot.dcm.create_alias(alias_request(["mine", [COMMAND]]))
        robot.dcm.set(set_request(["mine", "ClearAll", [[-1.0, 500]]]))
        robot.advance(None)
        robot.reset()
        assert robot.dcm.waiting(COMMAND) == ()
        assert robot.dcm.clock.shown() == 0
        first = robot.frame.position
        for _ in range(60):
            robot.advance(None)
        assert robot.frame.position[SLOT] == pytest.approx(first[SLOT], abs=2e-3)
