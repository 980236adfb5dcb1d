"""The test bench of the drives: torso nailed to the world, legs free; speed, delay, backlash, torque, heat.

Every measurement is one of the real bench's: it reads encoders, currents, temperatures, the motors' own
angles and the torque of a clamp; gravity is switched off where it would hide the drive.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final, NamedTuple

import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX, INDEX_WITH_MIRROR, LEG_JOINTS
from bridge.body.postures import POSTURES
from bridge.body.quantities import joint_no_load_speed, joint_nominal_torque, joint_stall_torque
from bridge.messages import ActuatorFrame
from bridge.types import Array
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
"""Of the step response, rad; half of it for HipYawPitch, whose hips turn together."""
LOOP_AMPLITUDE: Final = math.radians(4.0)
"""Of the loop of slow reversals, rad."""
LOOP_SPEED: Final = math.radians(1.0)
"""rad/s: slow against delay and loop, so that the loop's width is backlash."""
LEAST_FALL: Final = math.radians(15.0)
"""Of hips and knees without stiffness; an ankle has too light a foot for the friction of its gear."""
HEAT_TIME: Final = 60.0
"""s"""
CRUISE: Final = (0.4, 0.8)
"""Part of the way in which a joint has reached its speed and does not brake yet."""


class Bench:
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

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *_: object) -> None:
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
        track = bench.play(lambda _: {name: _far(body, name) for name in LEGS}, 0.2, stiffness)
        return bench.clamp_torque(), part(track, 3)[-1]


def _far(body: Body, joint: str) -> float:
    """A request of full voltage, near enough to leave the coupled AnkleRoll its range."""
    sheet = body.joints[joint]
    return FAR if sheet.upper > FAR else -FAR


def overload(body: Body, wear: WearProfile, engine: str, duration: float) -> Array:
    """All leg motors stalled at full stiffness; the track of `Bench.play`."""
    with Bench(body, wear, engine) as bench:
        bench.clamp()
        return bench.play(lambda _: {name: _far(body, name) for name in LEGS}, duration)


def fall_limp(body: Body, wear: WearProfile, engine: str) -> Array:
    """How far each leg joint moves by the leg's weight in 2 s without stiffness, rad, the larger of two poses.

    The torso lies on its back with raised legs, and on its side.
    """
    raised = list(POSTURES["StandInit"])
    raised[INDEX["LHipRoll"]], raised[INDEX["RHipRoll"]] = 0.3, -0.3
    moved = []
    for orientation in ((0.0, -0.5 * math.pi, 0.0), (0.5 * math.pi, 0.0, 0.0)):
        with Bench(body, wear, engine, tuple(raised), 9.81, orientation) as bench:
            angles = part(bench.play(lambda _: {}, 2.0, stiffness=0.0), 1)
            moved.append(np.abs(angles - angles[0]).max(axis=0))
    return np.asarray(np.max(moved, axis=0))


class ServoRow(msgspec.Struct, frozen=True, kw_only=True):
    """One leg motor."""

    joint: str
    no_load_speed: float
    """Measured, rad/s."""
    no_load_speed_sheet: float
    request_to_motion: float
    """From the boundary that takes a request to the first frame whose encoder has moved by two counts, s."""
    lag: float
    """From there to 63 % of the step, s (the yardstick: 0.054)."""
    backlash: float
    """Width of the loop of joint over motor angle, rad."""
    backlash_configured: float
    stall_torque: float
    """Held by a clamp at stiffness 1, N m."""
    stall_torque_sheet: float
    stall_torque_half: float
    """At stiffness 0.5, N m."""
    limp_torque: float
    """At stiffness 0, N m."""
    limp_fall: float
    """Moved by the leg's own weight without stiffness, rad."""
    stall_current: float
    """A"""
    warm_after: float
    """Stalled at full stiffness: until the protection begins to act, s; negative: not within 60 s."""
    warm_after_closed_form: float
    temperature_end: float
    """After 60 s, degrees Celsius."""
    stiffness_end: float
    """Left by then."""


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


def _warm_after(body: Body, wear: WearProfile, joint: str) -> float:
    """Closed form of the time to the first threshold at stall, s; infinite without heating."""
    heating = wear.servo.heating
    rise = heating.rise * (joint_stall_torque(body, joint) / joint_nominal_torque(body, joint)) ** 2
    share = (heating.warm - heating.room) / rise if rise > 0.0 else 1.0
    return -heating.time_constant * math.log(1.0 - share) if share < 1.0 else math.inf


class BenchTracks(NamedTuple):
    """Measurements of all leg motors."""

    speeds: dict[str, Array]
    """From stop to stop, by joint; tracks of `Bench.play`."""
    steps: dict[str, Array]
    """Step responses, likewise."""
    loop: Array
    """Slow reversal, likewise of all joints."""
    torque: dict[float, Array]
    """Of clamped motors by stiffness, N m."""
    current: Array
    """At full stiffness, A."""
    fall: Array
    """Without stiffness, rad."""
    heat: Array
    """Stalled at full stiffness; track of `Bench.play`."""


def bench_tracks(body: Body, wear: WearProfile, engine: str) -> BenchTracks:
    """All leg motors on the bench."""
    clamps = {stiffness: clamped(body, wear, engine, stiffness) for stiffness in (1.0, 0.5, 0.0)}
    return BenchTracks(
        speeds={joint: run_through(body, wear, engine, joint) for joint in LEGS},
        steps={joint: step_response(body, wear, engine, joint, step_of(joint)) for joint in LEGS},
        loop=slow_reversal(body, wear, engine, LOOP_AMPLITUDE, LOOP_SPEED),
        torque={stiffness: torque for stiffness, (torque, _) in clamps.items()},
        current=clamps[1.0][1],
        fall=fall_limp(body, wear, engine),
        heat=overload(body, wear, engine, HEAT_TIME),
    )


def measure(body: Body, wear: WearProfile, tracks: BenchTracks) -> list[ServoRow]:
    """The table of all leg motors."""
    slack, heat = part(tracks.loop, 2) - part(tracks.loop, 1), tracks.heat
    rows = []
    for i, joint in enumerate(LEGS):
        motion, lag = motion_times(body, tracks.steps[joint], i, step_of(joint))
        hot = part(heat, 4)[:, i] > wear.servo.heating.warm
        way = tracks.speeds[joint]
        rows.append(
            ServoRow(
                joint=joint,
                no_load_speed=cruise_speed(way[:, 0], part(way, 1)[:, i]),
                no_load_speed_sheet=joint_no_load_speed(body, joint),
                request_to_motion=motion,
                lag=lag,
                backlash=float(np.ptp(slack[:, i])),
                backlash_configured=wear.servo.backlash.of(joint),
                stall_torque=float(tracks.torque[1.0][i]),
                stall_torque_sheet=joint_stall_torque(body, joint),
                stall_torque_half=float(tracks.torque[0.5][i]),
                limp_torque=float(tracks.torque[0.0][i]),
                limp_fall=float(tracks.fall[i]),
                stall_current=float(tracks.current[i]),
                warm_after=float(heat[int(np.argmax(hot)), 0] - heat[0, 0]) if bool(hot.any()) else -1.0,
                warm_after_closed_form=min(_warm_after(body, wear, joint), 1e9),
                temperature_end=float(part(heat, 4)[-1, i]),
                stiffness_end=float(part(heat, 5)[-1, i]),
            )
        )
    return rows


def passes(row: ServoRow, wear: WearProfile, cycle: float) -> bool:
    """One motor is as it should be.

    Speed within 5 %, motion after 36 ms to 4 cycles, backlash within 10 %, half the torque at half stiffness,
    no torque at 0, where hips and knees fall; backlash and delay only where the profile has them.
    """
    worn = wear.servo
    return (
        abs(row.no_load_speed / row.no_load_speed_sheet - 1.0) < 0.05
        and worn.delay < row.request_to_motion < worn.delay + 2.01 * cycle
        and abs(row.backlash - row.backlash_configured)
        <= 0.1 * row.backlash_configured + 1e-3 * (row.backlash_configured == 0.0)
        and abs(row.stall_torque / row.stall_torque_sheet - 1.0) < 0.03
        and abs(row.stall_torque_half / row.stall_torque - 0.5) < 0.01
        and row.limp_torque < 0.1 * row.stall_torque
        and (row.limp_fall > LEAST_FALL or "Ankle" in row.joint)
    )
