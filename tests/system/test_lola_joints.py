"""The joint test as RoboCup teams run it, through LoLA's packets, against the emulated V6 in nominal wear.

The robot hangs. Each leg joint is driven through its range by ramps of 1 s, or as long as 2 rad/s take, at
stiffness 0.6. What is measured is held against what was asked for three packets (36 ms) before, the published
delay from request to measured motion (B-Human's `motionDelay`), by which teams shift the two.
"""

from __future__ import annotations

import math

import msgpack
import pytest

from bridge.adapters.lola.client import Setpoints
from bridge.adapters.lola.codec import ACTUATORS, CYCLE, MapStream
from bridge.adapters.lola.packets import Identity, actuator_map, sensor_packet
from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.postures import POSTURES
from bridge.body.quantities import coupled_limits, limits
from bridge.messages import ActuatorFrame
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear

V6 = load_body("nao-v6")
DELAY = 3
FASTEST = 2.0
LEFT_LEG = ("LHipYawPitch", "LHipRoll", "LHipPitch", "LKneePitch", "LAnklePitch", "LAnkleRoll")


class Hanging:
    """A robot seen through packets alone."""

    def __init__(self, robot: EmulatedRobot) -> None:
        self._robot, self._stream = robot, MapStream(ACTUATORS)
        self._setpoints = Setpoints(robot.frame.stiffness)

    def measured(self) -> list[float]:
        packet = sensor_packet(self._robot.frame, Identity())
        position: list[float] = msgpack.unpackb(packet)["Position"]
        return position

    def ask(self, position: list[float]) -> None:
        for values in self._stream.feed(actuator_map(position, [0.6] * 25)):
            self._setpoints.update(values)
        wanted = self._setpoints
        frame = ActuatorFrame(
            reply_to=self._robot.frame.seq,
            position=wanted.position(self._robot.frame.position),
            stiffness=wanted.stiffness,
        )
        self._robot.advance(frame)


@pytest.mark.parametrize("joint", LEFT_LEG)
def test_a_leg_joint_follows_a_ramp_through_its_range(joint: str) -> None:
    slot = INDEX[joint]
    posture = list(POSTURES["StandInit"])
    posture[INDEX["RHipRoll"]] = -0.7  # the other leg out of the way
    wear = load_wear("nominal")
    with EmulatedRobot(V6, seed=1, posture=tuple(posture), wear=wear, held=True, lift=0.3) as robot:
        hanging = Hanging(robot)
        asked = hanging.measured()
        lower, upper = limits(V6, joint)
        if joint == "LAnkleRoll":
            lower, upper = coupled_limits(V6, joint, asked[INDEX["LAnklePitch"]])
        history, worst, reached = [asked[slot]] * (DELAY + 1), 0.0, []
        for goal in (lower, upper):
            start = asked[slot]
            cycles = math.ceil(max(1.0, abs(goal - start) / FASTEST) / CYCLE)
            for cycle in range(1, cycles + 20):
                asked[slot] = start + (goal - start) * min(1.0, cycle / cycles)
                hanging.ask(asked)
                history.append(asked[slot])
                measured = hanging.measured()[slot]
                worst = max(worst, abs(measured - history[-1 - DELAY]))
            reached.append(measured)
    assert math.degrees(worst) < 5.0
    assert reached == pytest.approx([lower, upper], abs=math.radians(5.0))
