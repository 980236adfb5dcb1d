"""The drives of the legs on the bench against data sheet, profile and closed forms."""

from __future__ import annotations

import math
from typing import Any, Final

import msgspec
import numpy as np
from matplotlib.figure import Figure

from bridge.body import Body
from bridge.body.joints import INDEX
from bridge.body.postures import POSTURES
from bridge.body.quantities import joint_no_load_speed, joint_nominal_torque, joint_stall_torque
from bridge.types import Array
from emulator.wear import WearProfile, load_wear
from nao_hil.analysis.report.render import Claim
from nao_hil.experiments.context import Context
from nao_hil.experiments.experiment import Drawing, Experiment, Measured
from nao_hil.experiments.servo_bench import (
    LEGS,
    Bench,
    Drive,
    clamped,
    far,
    measure_drives,
    part,
    step_of,
    step_response,
)

LEAST_FALL: Final = math.radians(15.0)
"""Of hips and knees without stiffness; an ankle has too light a foot for the friction of its gear."""
HEAT_TIME: Final = 60.0
"""s"""


def overload(body: Body, wear: WearProfile, engine: str, duration: float) -> Array:
    """All leg motors stalled at full stiffness; the track of `Bench.play`."""
    with Bench(body, wear, engine) as bench:
        bench.clamp()
        return bench.play(lambda _: {name: far(body, name) for name in LEGS}, duration)


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


class ServoRow(Drive, frozen=True, kw_only=True):
    """Measurements of one leg motor beside their sources."""

    no_load_speed_sheet: float
    backlash_configured: float
    stall_torque_sheet: float
    stall_torque_half: float
    """At stiffness 0.5, N m."""
    limp_torque: float
    """At stiffness 0, N m."""
    limp_fall: float
    """Moved by the leg's own weight without stiffness, rad."""
    warm_after: float
    """Stalled at full stiffness: until the protection begins to act, s; negative: not within 60 s."""
    warm_after_closed_form: float
    temperature_end: float
    """After 60 s, degrees Celsius."""
    stiffness_end: float
    """Left by then."""


def _warm_after(body: Body, wear: WearProfile, joint: str) -> float:
    """Closed form of the time to the first threshold at stall, s; infinite without heating."""
    heating = wear.servo.heating
    rise = heating.rise * (joint_stall_torque(body, joint) / joint_nominal_torque(body, joint)) ** 2
    share = (heating.warm - heating.room) / rise if rise > 0.0 else 1.0
    return -heating.time_constant * math.log(1.0 - share) if share < 1.0 else math.inf


def servo_rows(body: Body, wear: WearProfile, engine: str) -> list[ServoRow]:
    """The table of all leg motors."""
    half, limp = (clamped(body, wear, engine, stiffness)[0] for stiffness in (0.5, 0.0))
    fall, heat = fall_limp(body, wear, engine), overload(body, wear, engine, HEAT_TIME)
    rows = []
    for i, drive in enumerate(measure_drives(body, wear, engine)):
        hot = part(heat, 4)[:, i] > wear.servo.heating.warm
        rows.append(
            ServoRow(
                **msgspec.structs.asdict(drive),
                no_load_speed_sheet=joint_no_load_speed(body, drive.joint),
                backlash_configured=wear.servo.backlash.of(drive.joint),
                stall_torque_sheet=joint_stall_torque(body, drive.joint),
                stall_torque_half=float(half[i]),
                limp_torque=float(limp[i]),
                limp_fall=float(fall[i]),
                warm_after=float(heat[int(np.argmax(hot)), 0] - heat[0, 0]) if bool(hot.any()) else -1.0,
                warm_after_closed_form=min(_warm_after(body, wear, drive.joint), 1e9),
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


def _claims(measured: Measured[list[ServoRow]]) -> list[Claim]:
    wear = load_wear(measured.context.wear, measured.body)
    return [
        Claim(
            f"{row.joint} is as data sheet and profile say",
            f"{math.degrees(row.no_load_speed):.0f} deg/s (sheet "
            f"{math.degrees(row.no_load_speed_sheet):.0f}), motion after {1e3 * row.request_to_motion:.0f} "
            f"ms, backlash {math.degrees(row.backlash):.2f} deg (profile "
            f"{math.degrees(row.backlash_configured):.2f}), stall {row.stall_torque:.1f} N m",
            passes(row, wear, measured.body.cycle),
        )
        for row in measured.results
    ]


def _measure(context: Context) -> list[ServoRow]:
    return servo_rows(context.body, load_wear(context.wear, context.body), context.engine)


def _quantities(measured: Measured[list[ServoRow]]) -> dict[str, Any]:
    return {"body": measured.context.robot, "wear": measured.context.wear, "rows": measured.results}


def _draw_steps(figure: Figure, measured: Measured[list[ServoRow]]) -> None:
    """Step responses of a free leg; dashed: the model of a team's V6, 3 cycles after the request."""
    body, wear = measured.body, load_wear(measured.context.wear, measured.body)
    slow, fast = np.roots((0.019**2, 2.0 * 1.5 * 0.019, 1.0))
    fine = np.arange(0.0, 0.4, 1e-3)
    model = 1.0 - (fast * np.exp(slow * fine) - slow * np.exp(fast * fine)) / (fast - slow)
    for i, panel in enumerate(figure.subplots(2, 3).ravel().tolist()):  # the right leg's are alike
        track = step_response(body, wear, measured.context.engine, LEGS[i], step_of(LEGS[i]))
        read = part(track, 0)[:, i]
        panel.plot(
            1e3 * (track[:, 0] - track[0, 0] + body.cycle),
            (read - read[0]) / step_of(LEGS[i]),
            ".-",
            markersize=3,
        )
        panel.plot(1e3 * (fine + 0.030), model, "k--", linewidth=1.0)
        panel.axvspan(36.0, 40.0, alpha=0.2, color="tab:green")
        panel.set(xlabel="time after the request / ms", xlim=(0.0, 400.0), title=LEGS[i])
        panel.grid(alpha=0.3)


SERVO_TABLE: Final = Experiment(
    title="The drives of the legs",
    source="Data sheets and published measurements; no part of the thesis.",
    setup=(("bench", "torso nailed down"),),
    measure=_measure,
    quantities=_quantities,
    claims=_claims,
    pictures=(
        Drawing("servo-step.png", _draw_steps, "Step responses", "Green: the published delay.", (11.0, 6.5)),
    ),
)
