"""What a controller sees of each fault; one test per row of the table in docs/scenarios.md."""

import math
import statistics
from collections.abc import Iterator

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.postures import POSTURES
from bridge.body.quantities import joint_stall_torque
from bridge.errors import FrameError
from bridge.messages import ActuatorFrame
from bridge.messages.faults import (
    CommandDuplicated,
    CommandLate,
    CommandLost,
    CommandReordered,
    DcmPause,
    Fault,
    HalError,
    JointHot,
    JointStuck,
    JointWeak,
    PowerLoss,
    SensorDead,
    SensorNoisy,
    SensorOffset,
    SensorStuck,
)
from emulator.robot import EmulatedRobot
from emulator.scenarios.events import FaultEvent
from emulator.scenarios.model import Scenario
from tests.servos import torques

BODY = load_body("nao-v3")
START = POSTURES["StandInit"]
ELBOW = INDEX["LElbowRoll"]
KNEE = INDEX["LKneePitch"]


@pytest.fixture
def robot() -> Iterator[EmulatedRobot]:
    with EmulatedRobot(BODY, seed=0, engine="mujoco") as standing:
        yield standing


@pytest.fixture
def held() -> Iterator[EmulatedRobot]:
    with EmulatedRobot(BODY, seed=0, engine="mujoco", held=True, lift=0.5, settle=0.2) as hanging:
        yield hanging


def begin(robot: EmulatedRobot, fault: Fault, duration: float = 0.0) -> None:
    robot.faults.start(fault, robot.time, duration)


def command(reply_to: int, stiffness: float = 1.0, **offsets: float) -> ActuatorFrame:
    position = list(START)
    for joint, offset in offsets.items():
        position[INDEX[joint]] += offset
    return ActuatorFrame(reply_to=reply_to, position=tuple(position), stiffness=(stiffness,) * 25)


def answered(robot: EmulatedRobot, n: int) -> list[int]:
    """The `command` field of n frames, each of which is answered at once."""
    return [robot.advance(command(robot.frame.seq), expected=True).command for _ in range(n)]


# ---- commands


def test_lost_commands_are_missed_and_the_last_one_stays_in_force(robot: EmulatedRobot) -> None:
    assert answered(robot, 5) == [0, 1, 2, 3, 4]
    begin(robot, CommandLost())
    assert answered(robot, 5) == [4] * 5
    assert robot.frame.missed == 5
    robot.faults.end("command-lost")
    assert answered(robot, 2) == [10, 11]


def test_late_commands_are_in_force_that_many_cycles_later(robot: EmulatedRobot) -> None:
    begin(robot, CommandLate(cycles=3))
    assert answered(robot, 7) == [-1, -1, -1, 0, 1, 2, 3]
    assert robot.frame.missed == 7


def test_duplicated_commands_come_back_over_newer_ones(robot: EmulatedRobot) -> None:
    begin(robot, CommandDuplicated(cycles=2))
    assert answered(robot, 6) == [0, 1, 0, 1, 2, 3]


def test_reordered_commands_are_overtaken(robot: EmulatedRobot) -> None:
    answered(robot, 1)
    begin(robot, CommandReordered())
    answered(robot, 1)
    robot.faults.end()
    # 1 was held back; 2 overtakes it in the next cycle, in which 1 then arrives last
    assert answered(robot, 3) == [1, 3, 4]


# ---- sensors


def test_a_stuck_sensor_repeats_what_it_read_when_the_fault_began(robot: EmulatedRobot) -> None:
    begin(robot, SensorStuck(sensor="position.LElbowRoll"))
    first = robot.advance(command(0, LElbowRoll=-0.5)).position[ELBOW]
    for _ in range(40):
        frame = robot.advance(None)
        assert frame.position[ELBOW] == first
    assert robot.truth().joints[ELBOW] < START[ELBOW] - 0.4
    robot.faults.end()
    assert robot.advance(None).position[ELBOW] < START[ELBOW] - 0.4


def test_a_dead_sensor_reads_nothing_and_its_neighbours_all(robot: EmulatedRobot) -> None:
    before = robot.advance(None).fsr
    begin(robot, SensorDead(sensor="fsr.LFL"))
    after = robot.advance(None).fsr
    assert before[0] > 1.0
    assert after[0] == 0.0
    np.testing.assert_allclose(after[1:], before[1:], rtol=0.02)


def test_a_noisy_sensor_has_the_asked_deviation_about_the_truth(robot: EmulatedRobot) -> None:
    robot.advance(None)
    mean = robot.frame.accelerometer[2]
    begin(robot, SensorNoisy(sensor="accelerometer.z", deviation=0.5))
    values = [robot.advance(None).accelerometer[2] for _ in range(400)]
    assert statistics.fmean(values) == pytest.approx(mean, abs=4.0 * 0.5 / math.sqrt(400))
    assert statistics.stdev(values) == pytest.approx(0.5, rel=4.0 / math.sqrt(800))


def test_an_offset_sensor_reads_too_much(robot: EmulatedRobot) -> None:
    for _ in range(100):
        before = robot.advance(None).gyroscope
    begin(robot, SensorOffset(sensor="gyroscope.y", offset=0.05))
    after = robot.advance(None).gyroscope
    np.testing.assert_allclose(np.subtract(after, before), (0.0, 0.05, 0.0), atol=1e-3)


# ---- joints


def test_a_stuck_joint_stays_and_tells_so(held: EmulatedRobot) -> None:
    begin(held, JointStuck(joint="LElbowRoll"))
    for _ in range(100):
        held.advance(command(0, LElbowRoll=-0.6, RElbowRoll=0.6))
    assert held.frame.position[ELBOW] == pytest.approx(START[ELBOW], abs=0.01)
    # stall torque 14.3 mN m over 24 V per 10700 rpm, or 59.5 mN m over 21.6 V per 8000 rpm: far above holding
    assert held.frame.current[ELBOW] > 10.0 * held.frame.current[INDEX["RElbowRoll"]]
    assert held.frame.position[INDEX["RElbowRoll"]] == pytest.approx(START[INDEX["RElbowRoll"]] + 0.6, abs=0.1)
    held.faults.end()
    for _ in range(100):
        held.advance(None)
    assert held.frame.position[ELBOW] == pytest.approx(START[ELBOW] - 0.6, abs=0.1)


def test_a_weak_joint_gives_its_share_of_the_stall_torque(held: EmulatedRobot) -> None:
    """Driven against a far target, the drive's torque at rest is its limit."""
    servo = held.servo
    joint = held.multibody.joints.index("LKneePitch")
    stall = joint_stall_torque(BODY, "LKneePitch")

    def largest() -> float:
        position = held.multibody.position.copy()
        held.advance(command(0, LKneePitch=1.0))
        return max(abs(float(torques(servo, position, 0.0 * position)[joint])) for _ in range(20))

    begin(held, JointStuck(joint="LKneePitch"))
    sound = largest()
    begin(held, JointWeak(joint="LKneePitch", fraction=0.25))
    weak = largest()
    assert sound == pytest.approx(stall, rel=1e-6)
    assert weak == pytest.approx(0.25 * stall, rel=1e-6)


def test_a_hot_joint_reports_its_heat_and_loses_stiffness(held: EmulatedRobot) -> None:
    begin(held, JointHot(joint="LKneePitch", temperature=95.0))
    for _ in range(5):
        held.advance(None)
    assert held.frame.temperature[KNEE] == pytest.approx(95.0, abs=1.0)
    assert 0.0 < held.frame.stiffness[KNEE] < 0.7
    assert held.frame.stiffness[INDEX["RKneePitch"]] == 1.0
    begin(held, JointHot(joint="LKneePitch", temperature=100.0))
    for _ in range(5):
        held.advance(None)
    assert held.frame.stiffness[KNEE] == 0.0


def test_without_power_the_robot_is_limp_and_says_so(robot: EmulatedRobot) -> None:
    begin(robot, PowerLoss())
    for _ in range(150):
        frame = robot.advance(command(robot.frame.seq))
    assert set(frame.stiffness) == {0.0}
    assert set(frame.current) == {0.0}
    assert frame.battery[0] == 0.0
    assert robot.truth().torso_position[2] < 0.25
    robot.faults.end()
    assert robot.advance(command(robot.frame.seq)).stiffness[KNEE] == 1.0


def test_after_an_error_of_hal_all_joints_are_limp_and_the_frames_go_on(robot: EmulatedRobot) -> None:
    begin(robot, HalError())
    before = robot.frame
    for _ in range(150):
        frame = robot.advance(command(robot.frame.seq))
    assert set(frame.stiffness) == set(frame.current) == {0.0}
    assert frame.battery[0] > 0.0 and frame.seq == before.seq + 150
    assert robot.truth().torso_position[2] < 0.25


# ---- the DCM


def test_a_pause_of_the_dcm_is_a_gap_in_the_frames_while_the_world_goes_on(robot: EmulatedRobot) -> None:
    answered(robot, 3)
    begin(robot, DcmPause(), duration=0.1)
    frame = robot.advance(command(3, LElbowRoll=-0.3), expected=True)
    # Boundaries 3 to 12 fall into the pause: no frame, and no command is taken before its end.
    assert frame.seq == 14
    assert frame.time == pytest.approx(0.14)
    assert frame.command == 3
    assert robot.truth().joints[ELBOW] > START[ELBOW] - 0.1
    assert answered(robot, 2) == [14, 15]


# ---- windows and words


def test_a_planned_fault_begins_and_ends_in_time_and_is_told() -> None:
    planned = FaultEvent(time=0.1, duration=0.05, fault=SensorDead(sensor="sonar"))
    with EmulatedRobot(BODY, seed=0, engine="mujoco", scenario=Scenario(faults=(planned,))) as robot:
        frames = [robot.advance(None) for _ in range(30)]
        # in force in the cycles that begin at 0.10 ... 0.14 s, and therefore in the frames that end them
        assert [frame.seq for frame in frames if frame.sonar == (0.0, 0.0)] == [11, 12, 13, 14, 15]
        notices = robot.take_notices()
        assert [(notice.seq, notice.code) for notice in notices] == [(10, "fault"), (15, "fault")]
        assert "sensor-dead:sonar" in notices[0].text


def test_an_end_of_a_fault_that_is_not_there_names_those_that_are(robot: EmulatedRobot) -> None:
    begin(robot, SensorDead(sensor="fsr"))
    with pytest.raises(FrameError, match="sensor-dead:fsr"):
        robot.faults.end("sensor-dead")
