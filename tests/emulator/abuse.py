"""Abuse of the emulated robot: it must stay a physical body.

Random commands inside and outside the limits, random stiffness, pushes, falls, lying about, put back on its
feet by hand. In between the drives are cut, and the robot must not gain mechanical energy from nowhere.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from bridge.body import Body
from bridge.body.joints import JOINTS, N_JOINTS
from bridge.messages import ActuatorFrame, SensorFrame
from bridge.messages.faults import PowerLoss
from bridge.messages.world import EndFault, Push, StandUp, StartFault
from emulator.queries import carry_out
from emulator.robot import EmulatedRobot
from emulator.wear import WearProfile
from tests.engines import energy as energy_of

ROUND: Final = 8.0
"""s from one stand to the next: commands for 5 s, limp for 3 s."""
COMMANDED: Final = 5.0
"""s"""
BEYOND: Final = 1.5
"""Commands are drawn from the joints' ranges widened by this factor about their middle."""
LARGEST_PUSH: Final = 3.0
"""N s"""
LARGEST_RISE: Final = 0.05
"""Energy that a limp robot may seem to gain, J: its weight raised by about 1 mm, as the contact solver does
when it pushes overlapping bodies apart."""
LARGEST_EXCESS: Final = 1.0
"""Degrees a joint may be beyond its stop."""


class AbuseRun:
    """One robot under random commands, pushes and falls."""

    def __init__(self, robot: EmulatedRobot, random: np.random.Generator) -> None:
        self._robot, self._random = robot, random
        names = robot.multibody.joints
        sheets = [robot.body.joints[name] for name in names]
        self._lower = np.array([sheet.lower for sheet in sheets])
        self._upper = np.array([sheet.upper for sheet in sheets])
        slots = {name: robot.body.joints[name] for name in JOINTS if name in robot.body.joints}
        self._range = np.array([(s.lower, s.upper) if (s := slots.get(n)) else (0.0, 1.0) for n in JOINTS])
        self._excess, self._excess_joint, self._rise, self._farthest = 0.0, "", 0.0, 0.0
        self._finite, self._falls = True, 0

    def run(self, seconds: float) -> dict[str, Any]:
        """Abuse it for so much robot time, s; the robot is put back on its feet after each round."""
        robot = self._robot
        while robot.time < seconds:
            fell = self._commanded(min(COMMANDED, seconds))
            fell = self._limp(ROUND - COMMANDED) or fell
            self._falls += fell
            carry_out(robot, StandUp())
        return {
            "seconds": robot.time,
            "falls": self._falls,
            "finite": self._finite,
            "stop_excess_deg": math.degrees(self._excess),
            "stop_excess_joint": self._excess_joint,
            "energy_rise_j": self._rise,  # of a limp robot without pushes, over its least energy so far
            "farthest_m": self._farthest,  # torso from the floor's origin
        }

    def _commanded(self, seconds: float) -> bool:
        """Random commands and pushes; True when the robot fell."""
        robot, random = self._robot, self._random
        end, change, push, fell = robot.time + seconds, 0.0, robot.time + random.uniform(0.0, 2.0), False
        command: ActuatorFrame | None = None
        while robot.time < end:
            if robot.time >= change:
                command, change = self._command(), robot.time + random.uniform(0.02, 0.8)
            if robot.time >= push:
                target = str(random.choice(["Torso", *robot.multibody.joints]))
                x, y, z = random.normal(0.0, LARGEST_PUSH / 3.0, 3).tolist()
                carry_out(robot, Push(target=target, impulse=(x, y, z), duration=random.uniform(0.005, 0.3)))
                push = robot.time + random.exponential(2.0)
            fell = self._cycle(command) or fell
        return fell

    def _command(self) -> ActuatorFrame:
        """Targets inside and outside the ranges; stiffness full, none, negative, or in between."""
        random = self._random
        middle, half = self._range.mean(axis=1), 0.5 * (self._range[:, 1] - self._range[:, 0])
        position = middle + random.uniform(-BEYOND, BEYOND, N_JOINTS) * half
        choice = random.integers(0, 4, N_JOINTS)
        stiffness = np.choose(choice, [1.0, 0.0, -1.0, random.uniform(0.0, 1.0, N_JOINTS)])
        return ActuatorFrame(
            reply_to=self._robot.seq, position=tuple(position.tolist()), stiffness=tuple(stiffness.tolist())
        )

    def _limp(self, seconds: float) -> bool:
        """Cut the power, wait for pushes to end, and watch the energy; True when the robot fell."""
        robot = self._robot
        carry_out(robot, StartFault(fault=PowerLoss()))
        end, fell = robot.time + seconds, False
        quiet = robot.time + 0.5
        least = math.inf
        while robot.time < end:
            fell = self._cycle(None) or fell
            if robot.time > quiet:
                energy = energy_of(robot.engine, robot.multibody)
                least = min(least, energy)
                self._rise = max(self._rise, energy - least)
        carry_out(robot, EndFault())
        return fell

    def _cycle(self, command: ActuatorFrame | None) -> bool:
        robot = self._robot
        frame = robot.advance(command)
        robot.take_notices()
        truth = robot.truth()
        self._finite = self._finite and _finite(frame) and all(map(math.isfinite, truth.joints))
        position = robot.multibody.position
        excess = np.maximum(position - self._upper, self._lower - position)
        worst = int(excess.argmax())
        if excess[worst] > self._excess:
            self._excess, self._excess_joint = float(excess[worst]), robot.multibody.joints[worst]
        self._farthest = max(self._farthest, math.dist(truth.torso_position, (0.0, 0.0, 0.0)))
        return truth.fell


def _finite(frame: SensorFrame) -> bool:
    """Every number in a frame."""
    fields = (getattr(frame, name) for name in frame.__struct_fields__)
    values = (v for field in fields for v in (field if isinstance(field, tuple) else (field,)))
    return all(math.isfinite(value) for value in values)


def run(seconds: float, *, seed: int, body: Body, wear: WearProfile, engine: str = "auto") -> dict[str, Any]:
    """Abuse a robot and measure it.

    Args:
        seconds: Robot time.
        seed: Of the abuse and of the robot.
        body: Data sheet.
        wear: State of its drives.
        engine: Name of the physics engine.
    """
    with EmulatedRobot(body, seed=seed, wear=wear, engine=engine) as robot:
        return AbuseRun(robot, np.random.default_rng(seed)).run(seconds)
