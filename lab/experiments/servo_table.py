"""The table of the leg drives: what the bench measures, beside what the data sheet says.

Yardstick of the step response: the second-order model that a team identified on its V6, T = 0.019 s, D = 1.5,
drawn from the moment the motion begins. It is no target.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Final

import msgspec
import numpy as np

from bridge.datasheet import Body, load_body
from bridge.datasheet.quantities import joint_no_load_speed, joint_nominal_torque, joint_stall_torque
from emulator.wear import WearProfile, load_wear
from lab.experiments import servo_bench
from lab.experiments.context import Context
from lab.experiments.page import Claim, Outcome, Page, Picture
from lab.experiments.servo_bench import LEGS, Vector, part
from lab.experiments.servo_figures import plot_heat, plot_loops, plot_speeds, plot_steps, plot_stiffness

STEP: Final = math.radians(10.0)
"""Of the step response, rad; half of it for HipYawPitch, whose hips turn together."""
LOOP_REACH: Final = math.radians(4.0)
LOOP_SPEED: Final = math.radians(1.0)
"""rad/s: slow beside delay and loop, so that the loop's width is play."""
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
    play: float
    """Width of the loop of joint over motor angle, rad."""
    play_configured: float
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


class ServoTable(msgspec.Struct, frozen=True, kw_only=True):
    """All leg motors of a body."""

    name: str = "servo-table"
    passed: bool
    """Speeds within 5 %, motion after 36 ms to 4 cycles, play within 10 %, half the torque at half stiffness,
    no torque at 0, where hips and knees fall; what a profile leaves ideal (no play, no delay) is not asked
    for."""
    body: str
    wear: str
    rows: tuple[ServoRow, ...]


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


def measure(body: Body, wear: WearProfile, out: Path | None = None) -> tuple[ServoRow, ...]:
    """All leg motors on the bench, with figures in `out`."""
    speeds = {joint: servo_bench.run_through(body, wear, joint) for joint in LEGS}
    steps = {joint: servo_bench.step_response(body, wear, joint, _step_of(joint)) for joint in LEGS}
    loop = servo_bench.slow_reversal(body, wear, LOOP_REACH, LOOP_SPEED)
    slack = part(loop, 2) - part(loop, 1)
    (full, current), (half, _), (none, _) = (servo_bench.clamped(body, wear, s) for s in (1.0, 0.5, 0.0))
    fall = servo_bench.fall_limp(body, wear)
    heat = servo_bench.overload(body, wear, HEAT_TIME)
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
                play=float(np.ptp(slack[:, i])),
                play_configured=wear.servo.play.of(joint),
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
        and (worn.delay == 0.0 or 0.0359 < row.request_to_motion < 4.01 * cycle)
        and abs(row.play - row.play_configured)
        <= 0.1 * row.play_configured + 1e-3 * (row.play_configured == 0.0)
        and abs(row.stall_torque / row.stall_torque_sheet - 1.0) < 0.03
        and abs(row.stall_torque_half / row.stall_torque - 0.5) < 0.01
        and row.limp_torque < 0.1 * row.stall_torque
        and (row.limp_fall > LEAST_FALL or "Ankle" in row.joint)
    )


def run(body: str = "nao-v3", wear: str = "nominal", out: Path | None = None) -> ServoTable:
    """The table of a body in a state of wear.

    Args:
        body: Data sheet by name or path.
        wear: Wear profile by name or path.
        out: Folder for `servo-table.json` and the figures; None: nothing is written.
    """
    sheet, profile = load_body(body), load_wear(wear)
    rows = measure(sheet, profile, out)
    table = ServoTable(
        passed=all(passes(row, profile, sheet.cycle) for row in rows), body=body, wear=wear, rows=rows
    )
    if out is not None:
        (out / "servo-table.json").write_bytes(msgspec.json.format(msgspec.json.encode(table)))
    return table


def text(table: ServoTable) -> str:
    """The table for people, angles in degrees."""
    lines = [
        f"{'joint':14} {'deg/s':>13} {'motion':>7} {'lag':>6} {'play deg':>11} {'stall N m':>12} "
        f"{'half':>5} {'limp':>5} {'falls':>6} {'stall A':>7} {'warm after s':>12} {'end C':>6} {'stiff':>6}"
    ]
    for r in table.rows:
        speed, sheet, play, set_play, fall = np.degrees(
            [r.no_load_speed, r.no_load_speed_sheet, r.play, r.play_configured, r.limp_fall]
        )
        lines.append(
            f"{r.joint:14} {speed:6.1f}/{sheet:6.1f} {1e3 * r.request_to_motion:4.0f} ms {1e3 * r.lag:3.0f} ms "
            f"{play:5.2f}/{set_play:5.2f} {r.stall_torque:6.2f}/{r.stall_torque_sheet:5.2f} "
            f"{r.stall_torque_half / r.stall_torque:5.2f} {r.limp_torque:5.2f} {fall:5.1f}d "
            f"{r.stall_current:7.2f} {r.warm_after:5.1f}/{r.warm_after_closed_form:5.1f} "
            f"{r.temperature_end:7.1f} {r.stiffness_end:6.2f}"
        )
    return "\n".join(
        [*lines, f"passed: {table.passed}; pairs are measured / data sheet, profile or closed form"]
    )


def experiment(context: Context) -> Outcome:
    """The table as a page of the report."""
    table = run(context.robot, context.wear, context.out)
    profile, cycle = load_wear(context.wear), load_body(context.robot).cycle
    claims = tuple(
        Claim(
            f"{row.joint} is as data sheet and profile say",
            f"{math.degrees(row.no_load_speed):.0f} deg/s (sheet {math.degrees(row.no_load_speed_sheet):.0f}), "
            f"motion after {1e3 * row.request_to_motion:.0f} ms, play {math.degrees(row.play):.2f} deg "
            f"(profile {math.degrees(row.play_configured):.2f}), stall {row.stall_torque:.1f} N m",
            passes(row, profile, cycle),
        )
        for row in table.rows
    )
    figures = (
        ("servo-speed.png", "From stop to stop"),
        ("servo-step.png", "Step responses"),
        ("servo-loop.png", "Play"),
        ("servo-heat.png", "Heat and derating"),
        ("servo-stiffness.png", "Stiffness"),
    )
    page = Page(
        name="servo-table",
        title="The drives of the legs",
        source="Data sheets and published measurements; no part of the thesis.",
        setup=(
            ("robot", f"{context.robot}, {context.wear} drives and sensors"),
            ("bench", "torso nailed down"),
        ),
        claims=claims,
        pictures=tuple(Picture(context.out / file, title, "") for file, title in figures),
    )
    return Outcome(table, page)


def main() -> None:
    """The nominal V3; table and figures in the folder `servo-table`."""
    print(text(run(out=Path("servo-table"))))


if __name__ == "__main__":
    main()
