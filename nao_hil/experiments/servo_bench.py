"""The test bench of the drives: torso nailed to the world, legs free; speed, delay, backlash, torque.

Every measurement is one of the real bench's: it reads encoders, currents, temperatures, the motors' own
angles and the torque of a clamp; gravity is switched off where it would hide the drive.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX, INDEX_WITH_MIRROR, LEG_JOINTS
from bridge.body.postures import POSTURES
from bridge.messages import ActuatorFrame
from bridge.types import Array, Closing
from emulator.poses import quaternion
from emulator.robot import EmulatedRobot
from emulator.wear import WearProfile

LEGS: Final = tuple(name for name in (*LEG_JOINTS["L"], *LEG_JOINTS["R"]) if name in INDEX)
"""The eleven motors of both legs."""
ZERO: Final = POSTURES["StandZero"]
SETTLE: Final = 0.3
"""Rest before each measurement, s."""
SPREAD: Final = 0.7
"""Roll of a hip that lets the other roll through its range, rad."""
FAR: Final = 0.3
"""Position error at which every drive gives full voltage, rad."""
CLAMP: Final = 1000.0
"""Largest torque of the clamp, N m."""
STEP: Final = math.radians(10.0)
"""Height of the step response, rad; half of it for HipYawPitch, whose hips turn together."""
LOOP_AMPLITUDE: Final = math.radians(4.0)
"""Amplitude of the loop of slow reversals, rad."""
LOOP_SPEED: Final = math.radians(1.0)
"""rad/s: slow against delay and loop, so that the loop's width is backlash."""
CRUISE: Final = (0.4, 0.8)
"""Part of the way in which a joint has reached its speed and does not brake yet."""


class Bench(Closing):
    """One robot on the bench.

    Args:
        body: Data sheet.
        wear: State of the drives.
        engine: Name of the physics engine.
        posture: 25 angles, rad.
        gravity: m/s^2.
        orientation: Of the torso, as Euler angles about x, y and z, rad.
    """

    def __init__(
        self,
        body: Body,
        wear: WearProfile,
        engine: str,
        posture: tuple[float, ...] = ZERO,
        gravity: float = 0.0,
        orientation: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        self.body, self.posture = body, posture
        self.robot = EmulatedRobot(
            body,
            seed=0,
            posture=posture,
            wear=wear,
            engine=engine,
            settle=0.0,
            lift=1.0,
            held=True,
            orientation=quaternion(*orientation),
        )
        # the robot's own settings keep gravity: its inertial unit would not start without
        physics = self.robot.engine
        physics.surround(physics.surroundings._replace(gravity=(0.0, 0.0, -gravity)))
        self._cycle = 0
        self.play(lambda _: {}, SETTLE)

    def close(self) -> None:
        """Free the physics engine."""
        self.robot.close()

    def play(
        self, requests: Callable[[float], dict[str, float]], duration: float, stiffness: float = 1.0
    ) -> Array:
        """Let requests follow a rule in time.

        Args:
            requests: Joint requests at a time, rad; joints left out keep the posture's.
            duration: s.
            stiffness: Of all joints.

        Returns:
            Time, and the leg joints' encoder angles, true angles, motor angles, currents, temperatures and
            stiffnesses, in the order of `LEGS`: shape (cycles, 1 + 6 x 11).
        """
        rows = []
        for _ in range(round(duration / self.body.cycle)):
            angles = list(self.posture)
            for name, angle in requests(self._cycle * self.body.cycle).items():
                angles[INDEX[name]] = angle
            command = ActuatorFrame(
                reply_to=self._cycle, position=tuple(angles), stiffness=(stiffness,) * len(angles)
            )
            frame = self.robot.advance(command)
            self._cycle += 1
            motors = self._mechanical(self.robot.servo.motor_angle)
            slots = [INDEX[name] for name in LEGS]
            columns = (
                frame.position,
                self.robot.truth().joints,
                frame.current,
                frame.temperature,
                frame.stiffness,
            )
            read, true, current, temperature, force = ([column[i] for i in slots] for column in columns)
            rows.append([self._cycle * self.body.cycle, *read, *true, *motors, *current, *temperature, *force])
        return np.array(rows)

    def _mechanical(self, values: Array) -> list[float]:
        joints = self.robot.multibody.joints
        return [float(values[joints.index(name)]) for name in LEGS]

    def clamp(self, free: str | None = None) -> None:
        """Clamp all joints where they are, but one."""
        robot = self.robot.multibody
        robot.lock([name for name in robot.joints if not _moves_with(name, free)], CLAMP)

    def clamp_torque(self) -> Array:
        """Torque that the clamp holds against each leg motor, N m, absolute; both hips' halves are added."""
        robot = self.robot.multibody
        torque = dict(zip(robot.joints, np.abs(robot.lock_torque).tolist(), strict=True))
        torque["LHipYawPitch"] += torque["RHipYawPitch"]
        return np.array([torque[name] for name in LEGS])


def _moves_with(name: str, motor: str | None) -> bool:
    return motor is not None and INDEX_WITH_MIRROR[name] == INDEX[motor]


def part(track: Array, column: int) -> Array:
    """One of the groups of a track: 0 encoders, 1 true, 2 motors, 3 currents, 4 temperatures, 5 stiffnesses."""
    size = len(LEGS)
    return np.asarray(track[:, 1 + column * size : 1 + (column + 1) * size])


def run_through(body: Body, wear: WearProfile, engine: str, joint: str) -> Array:
    """One joint from stop to stop, the others clamped, without gravity; the track of `Bench.play`.

    Both legs are spread: a hip that rolls inward would bring its leg against the other.
    """
    sheet = body.joints[joint]
    posture = list(ZERO)
    posture[INDEX["LHipRoll"]], posture[INDEX["RHipRoll"]] = SPREAD, -SPREAD
    posture[INDEX[joint]] = sheet.lower
    with Bench(body, wear, engine, tuple(posture)) as bench:
        bench.clamp(joint)
        return bench.play(lambda _: {joint: sheet.upper}, 1.0)


def step_response(body: Body, wear: WearProfile, engine: str, joint: str, step: float) -> Array:
    """One joint of a free leg is asked to turn by a step, with gravity; the track of `Bench.play`."""
    posture = POSTURES["StandInit"]
    with Bench(body, wear, engine, posture, 9.81) as bench:
        return bench.play(lambda _: {joint: posture[INDEX[joint]] + step}, 0.5)


def slow_reversal(body: Body, wear: WearProfile, engine: str, reach: float, speed: float) -> Array:
    """All leg joints slowly to and fro by a reach, once and a half; the last whole period, without gravity."""
    posture = POSTURES["StandInit"]
    period = 4.0 * reach / speed

    def triangle(time: float) -> dict[str, float]:
        phase = (time / period + 0.25) % 1.0
        way = reach * (4.0 * abs(phase - 0.5) - 1.0)
        return {name: posture[INDEX[name]] - way for name in LEGS}

    with Bench(body, wear, engine, posture) as bench:
        bench.play(triangle, 0.5 * period)
        return bench.play(triangle, period)


def clamped(body: Body, wear: WearProfile, engine: str, stiffness: float) -> tuple[Array, Array]:
    """Torque (N m) and current (A) of the leg motors with their joints clamped and a request far away."""
    with Bench(body, wear, engine) as bench:
        bench.clamp()
        track = bench.play(lambda _: {name: far(body, name) for name in LEGS}, 0.2, stiffness)
        return bench.clamp_torque(), part(track, 3)[-1]


def far(body: Body, joint: str) -> float:
    """A request of full voltage, near enough to leave the coupled AnkleRoll its range."""
    sheet = body.joints[joint]
    return FAR if sheet.upper > FAR else -FAR


def cruise_speed(time: Array, angle: Array) -> float:
    """Mean speed over the part of a way in which a joint neither starts nor brakes, rad/s."""
    share = (angle - angle[0]) / (angle.max() - angle[0])
    first, last = (int(np.argmax(share >= level)) for level in CRUISE)
    return float((angle[last] - angle[first]) / (time[last] - time[first]))


def step_of(joint: str) -> float:
    """Step of the request for a joint, rad."""
    return -0.5 * STEP if joint.endswith("HipYawPitch") else STEP


def motion_times(body: Body, track: Array, column: int, step: float) -> tuple[float, float]:
    """Times from request to motion and from there to 63 % of the step, s, of a motor's step response."""
    read, time = part(track, 0)[:, column], track[:, 0]
    start = time[0] - body.cycle
    counts = 2.0 * math.pi / body.encoder_steps
    way = (read - read[0]) * math.copysign(1.0, step)
    # one count may be the encoder on the edge between two
    begin = float(time[int(np.argmax(way > 1.5 * counts))])
    # the joint settles a little off the request: the share is of where it ends
    reached = float(time[int(np.argmax(way >= 0.632 * way[-1]))])
    return float(begin - start), reached - begin


class Drive(msgspec.Struct, frozen=True, kw_only=True):
    """Measurements of one leg motor."""

    joint: str
    no_load_speed: float
    """Speed without load, rad/s."""
    request_to_motion: float
    """From the boundary that takes a request to the first frame whose encoder has moved by two counts, s."""
    lag: float
    """From there to 63 % of the step, s; 0.054 by the second-order model that a team identified on its V6."""
    backlash: float
    """Width of the loop of joint over motor angle, rad."""
    stall_torque: float
    """Held by a clamp at full stiffness, N m."""
    stall_current: float
    """Current at standstill, A."""


def measure_drives(body: Body, wear: WearProfile, engine: str) -> list[Drive]:
    """All leg motors on the bench."""
    loop = slow_reversal(body, wear, engine, LOOP_AMPLITUDE, LOOP_SPEED)
    slack, (torque, current) = part(loop, 2) - part(loop, 1), clamped(body, wear, engine, 1.0)
    drives = []
    for i, joint in enumerate(LEGS):
        way = run_through(body, wear, engine, joint)
        motion, lag = motion_times(
            body, step_response(body, wear, engine, joint, step_of(joint)), i, step_of(joint)
        )
        drives.append(
            Drive(
                joint=joint,
                no_load_speed=cruise_speed(way[:, 0], part(way, 1)[:, i]),
                request_to_motion=motion,
                lag=lag,
                backlash=float(np.ptp(slack[:, i])),
                stall_torque=float(torque[i]),
                stall_current=float(current[i]),
            )
        )
    return drives
