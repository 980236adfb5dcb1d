"""The table of the leg drives: what the bench measures, beside what the data sheet says.

Yardstick of the step response: the second-order model that a team identified on its V6, T = 0.019 s, D = 1.5,
drawn from the moment the motion begins. It is no target.
"""

from __future__ import annotations

import math
from pathlib import Path

import msgspec
import numpy as np

from bridge.body import load_body
from emulator.wear import load_wear
from nao_hil.analysis.report.page import Claim, Outcome, Picture, ReportPage
from nao_hil.experiments.context import Context
from nao_hil.experiments.servo_measure import ServoRow, measure, passes
from nao_hil.files import write_bytes


class ServoTable(msgspec.Struct, frozen=True, kw_only=True):
    """All leg motors of a body."""

    name: str = "servo-table"
    passed: bool
    """Speeds within 5 %, motion after 36 ms to 4 cycles, backlash within 10 %, half the torque at half
    stiffness, no torque at 0, where hips and knees fall; what a profile leaves ideal (no backlash, no delay) is
    not asked for."""
    body: str
    wear: str
    rows: tuple[ServoRow, ...]


def run(
    body: str = "nao-v3", wear: str = "nominal", out: Path | None = None, engine: str = "auto"
) -> ServoTable:
    """The table of a body in a state of wear.

    Args:
        body: Data sheet by name or path.
        wear: Wear profile by name or path.
        out: Folder for `servo-table.json` and the figures; None: nothing is written.
        engine: Name of the physics engine.
    """
    sheet = load_body(body)
    profile = load_wear(wear, sheet)
    rows = measure(sheet, profile, engine, out)
    table = ServoTable(
        passed=all(passes(row, profile, sheet.cycle) for row in rows), body=body, wear=wear, rows=rows
    )
    if out is not None:
        write_bytes(out / "servo-table.json", msgspec.json.format(msgspec.json.encode(table)))
    return table


def text(table: ServoTable) -> str:
    """The table for people, angles in degrees."""
    lines = [
        f"{'joint':14} {'deg/s':>13} {'motion':>7} {'lag':>6} {'backlash deg':>12} {'stall N m':>12} "
        f"{'half':>5} {'limp':>5} {'falls':>6} {'stall A':>7} {'warm after s':>12} {'end C':>6} {'stiff':>6}"
    ]
    for r in table.rows:
        speed, sheet, backlash, set_backlash, fall = np.degrees(
            [r.no_load_speed, r.no_load_speed_sheet, r.backlash, r.backlash_configured, r.limp_fall]
        )
        lines.append(
            f"{r.joint:14} {speed:6.1f}/{sheet:6.1f} {1e3 * r.request_to_motion:4.0f} ms {1e3 * r.lag:3.0f} ms "
            f"{backlash:5.2f}/{set_backlash:5.2f} {r.stall_torque:6.2f}/{r.stall_torque_sheet:5.2f} "
            f"{r.stall_torque_half / r.stall_torque:5.2f} {r.limp_torque:5.2f} {fall:5.1f}d "
            f"{r.stall_current:7.2f} {r.warm_after:5.1f}/{r.warm_after_closed_form:5.1f} "
            f"{r.temperature_end:7.1f} {r.stiffness_end:6.2f}"
        )
    return "\n".join(
        [*lines, f"passed: {table.passed}; pairs are measured / data sheet, profile or closed form"]
    )


def experiment(context: Context) -> Outcome:
    """The table as a page of the report."""
    table = run(context.robot, context.wear, context.out, context.engine)
    body = load_body(context.robot)
    profile = load_wear(context.wear, body)
    claims = tuple(
        Claim(
            f"{row.joint} is as data sheet and profile say",
            f"{math.degrees(row.no_load_speed):.0f} deg/s (sheet {math.degrees(row.no_load_speed_sheet):.0f}), "
            f"motion after {1e3 * row.request_to_motion:.0f} ms, backlash {math.degrees(row.backlash):.2f} deg "
            f"(profile {math.degrees(row.backlash_configured):.2f}), stall {row.stall_torque:.1f} N m",
            passes(row, profile, body.cycle),
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
    page = ReportPage(
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
