"""Measurement of one drive on the bench: speed, delay, backlash, torque and heat."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Final

import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.quantities import joint_no_load_speed, joint_nominal_torque, joint_stall_torque
from emulator.wear import WearProfile
from nao_hil.experiments import servo_bench
from nao_hil.experiments.servo_bench import LEGS, Vector, part
from nao_hil.experiments.servo_figures import plot_heat, plot_loops, plot_speeds, plot_steps, plot_stiffness

STEP: Final = math.radians(10.0)
"""Of the step response, rad; half of it for HipYawPitch, whose hips turn together."""
LOOP_AMPLITUDE: Final = math.radians(4.0)
"""Of the loop of slow reversals, rad."""
LOOP_SPEED: Final = math.radians(1.0)
"""rad/s: slow beside delay and loop, so that the loop's width is backlash."""
LEAST_FALL: Final = math.radians(15.0)
"""Of hips and knees without stiffness; an ankle has too light a foot for the friction of its gear."""
HEAT_TIME: Final = 60.0
"""s"""
CRUISE: Final = (0.4, 0.8)
"""Part of the way in which a joint has reached its speed and does not brake yet."""


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


def cruise_speed(time: Vector, angle: Vector) -> float:
    """Mean speed over the part of a way in which a joint neither starts nor brakes, rad/s."""
    share = (angle - angle[0]) / (angle.max() - angle[0])
    first, last = (int(np.argmax(share >= level)) for level in CRUISE)
    return float((angle[last] - angle[first]) / (time[last] - time[first]))


def _step_of(joint: str) -> float:
    return -0.5 * STEP if joint.endswith("HipYawPitch") else STEP


def motion_times(body: Body, track: Vector, column: int, step: float) -> tuple[float, float]:
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


def measure(body: Body, wear: WearProfile, engine: str, out: Path | None = None) -> tuple[ServoRow, ...]:
    """All leg motors on the bench, with figures in `out`."""
    speeds = {joint: servo_bench.run_through(body, wear, engine, joint) for joint in LEGS}
    steps = {joint: servo_bench.step_response(body, wear, engine, joint, _step_of(joint)) for joint in LEGS}
    loop = servo_bench.slow_reversal(body, wear, engine, LOOP_AMPLITUDE, LOOP_SPEED)
    slack = part(loop, 2) - part(loop, 1)
    (full, current), (half, _), (none, _) = (
        servo_bench.clamped(body, wear, engine, s) for s in (1.0, 0.5, 0.0)
    )
    fall = servo_bench.fall_limp(body, wear, engine)
    heat = servo_bench.overload(body, wear, engine, HEAT_TIME)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        plot_speeds(out / "servo-speed.png", body, speeds)
        plot_steps(out / "servo-step.png", body, steps, {joint: _step_of(joint) for joint in LEGS})
        plot_loops(out / "servo-loop.png", loop)
        plot_heat(out / "servo-heat.png", wear, heat)
        plot_stiffness(out / "servo-stiffness.png", body, {1.0: full, 0.5: half, 0.0: none}, current, fall)
    rows = []
    for i, joint in enumerate(LEGS):
        motion, lag = motion_times(body, steps[joint], i, _step_of(joint))
        hot = part(heat, 4)[:, i] > wear.servo.heating.warm
        rows.append(
            ServoRow(
                joint=joint,
                no_load_speed=cruise_speed(speeds[joint][:, 0], part(speeds[joint], 1)[:, i]),
                no_load_speed_sheet=joint_no_load_speed(body, joint),
                request_to_motion=motion,
                lag=lag,
                backlash=float(np.ptp(slack[:, i])),
                backlash_configured=wear.servo.backlash.of(joint),
                stall_torque=float(full[i]),
                stall_torque_sheet=joint_stall_torque(body, joint),
                stall_torque_half=float(half[i]),
                limp_torque=float(none[i]),
                limp_fall=float(fall[i]),
                stall_current=float(current[i]),
                warm_after=float(heat[int(np.argmax(hot)), 0] - heat[0, 0]) if bool(hot.any()) else -1.0,
                warm_after_closed_form=min(_warm_after(body, wear, joint), 1e9),
                temperature_end=float(part(heat, 4)[-1, i]),
                stiffness_end=float(part(heat, 5)[-1, i]),
            )
        )
    return tuple(rows)


def passes(row: ServoRow, wear: WearProfile, cycle: float) -> bool:
    """One motor is as it should be."""
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
