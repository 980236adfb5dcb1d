"""R7: the centre of mass of the dynamically stable gait (thesis 3.3.2, figures 3.6, 3.7), planned and walked.

The values that the thesis' parameters mean were recomputed from its equations; they are read here from the
planned trajectory itself, by finite differences, not from the closed forms that made it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import msgspec
import numpy as np

from bridge.body import Body, load_body
from bridge.types import SIDES
from nao_hil.analysis.report.page import Claim, Outcome, Picture, ReportPage
from nao_hil.experiments import axes
from nao_hil.experiments.arms import Arm, arm, arms_table, falls_finding
from nao_hil.experiments.context import Context
from nao_hil.experiments.geometry import soles_in_world
from nao_hil.experiments.setup import setup_rows
from nao_hil.experiments.static_walk import plan
from nao_hil.runs.track import Array, Track
from nao_hil.runs.walk import WalkOutcome
from walker.gaits import Plan, gait_parameters, make_gait

TOLERANCE: Final = 0.01
"""Share by which a design value may differ."""
DT: Final = 2e-4
"""s; sampling of the plan from which the values are read."""
EXPECTED: Final = {
    "t_a": 0.22173,
    "V_ya": 0.26254,
    "V_h": 0.29178,
    "V_11": 0.12997,
    "T_DSP": 0.03885,
    "S_b": 0.01134,
    "S_d": 0.04,
    "step_length": 0.09134,
    "step_time": 0.48231,
    "speed": 0.189,
}
"""What e_s1 = 0.03, e_su = 0.0051, S_a0 = 0.04, z = 0.23 and d_0 = 0.05 m mean, SI units."""


@dataclass(frozen=True)
class DynamicWalkSetup:
    """The experiment's numbers."""

    duration: float = 12.0
    """s"""
    runs: int = 5
    """Most seeds that are used: the plan is the same for all."""


class DynamicWalkResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came out."""

    name: str = "dynamic-walk"
    passed: bool
    planned: dict[str, float]
    """The values of `EXPECTED`, read from the plan."""
    mean_speed: float
    """Of the plan from its start over the time that figure 3.6 shows (4 s), m/s; the thesis reads 0.15."""
    walked: Arm
    sway_rms: float
    """Root mean square difference of the true from the planned centre of mass along y without drift, m."""
    drift: float
    """Median of the drift to the side over the way ahead."""


def read_plan(references: Sequence[Plan], dt: float) -> dict[str, float]:
    """The values of `EXPECTED` from a steady part of a plan.

    Args:
        references: The plan, sampled every `dt` s, walking for three steps or more.
        dt: s
    """
    phase = np.array([r.phase for r in references])
    com = np.array([r.com for r in references])
    velocity = np.gradient(com, dt, axis=0)
    double = np.isin(phase, ("DSL", "DSR"))
    begins = np.flatnonzero(double[1:] & ~double[:-1]) + 1
    ends = np.flatnonzero(~double[1:] & double[:-1]) + 1
    # from the third touch-down to the fourth: one whole step, well behind the start
    first, second = int(begins[2]), int(begins[3])
    lift = int(ends[ends > first][0])
    single = slice(lift, second)
    turn = lift + int(np.argmin(velocity[single, 0]))
    inside = slice(first + 2, lift - 2)
    duration = (second - first) * dt
    length = float(com[second, 0] - com[first, 0])
    return {
        "t_a": (second - turn) * dt,
        "V_ya": float(np.abs(velocity[inside, 1]).mean()),
        "V_h": float(velocity[inside, 0].mean()),
        "V_11": float(velocity[turn, 0]),
        "T_DSP": (lift - first) * dt,
        "S_b": float(velocity[inside, 0].mean()) * (lift - first) * dt,
        "S_d": float(com[turn, 0] - com[lift, 0]),
        "step_length": length,
        "step_time": duration,
        "speed": length / duration,
    }


def experiment(context: Context, setup: DynamicWalkSetup | None = None) -> Outcome:
    """Figures 3.6 and 3.7 planned and walked, and the design values."""
    setup = setup or DynamicWalkSetup()
    context = context.first(setup.runs)
    body = load_body(context.robot)
    (results,) = context.run(context.walks("dynamic-walk", "dynamic", setup.duration))
    parameters = gait_parameters("dynamic", context.config("dynamic", 0, {}).parameters)
    references = plan(make_gait("dynamic", parameters, body), 5.0, DT)
    values = read_plan(references, DT)
    speed = references[round(4.0 / DT)].com[0] / 4.0
    walked = arm(results)
    claims = (
        *(
            Claim(f"{name} = {expected:g} (within 1 %)", f"{values[name]:.5f}", _near(values[name], expected))
            for name, expected in EXPECTED.items()
        ),
        Claim("The robot walks it, with its controllers", walked.words(), walked.survived == walked.n),
    )
    sways = [_sway(result.track, body) for result in results]
    result = DynamicWalkResult(
        passed=all(claim.holds for claim in claims),
        planned=values,
        mean_speed=speed,
        walked=walked,
        sway_rms=float(np.sqrt(np.mean([rms**2 for rms, _ in sways]))),
        drift=float(np.median([drift for _, drift in sways])),
    )
    note = f"Seed {results[0].seed}; planned blue, walked red."
    page = ReportPage(
        name="dynamic-walk",
        title="R7: the dynamically stable gait",
        source=(
            "Thesis 3.3.2, figures 3.6 and 3.7: e_s1 = 0.03, e_su = 0.0051, S_a0 = 0.04, z = 0.23 m; a mean "
            "speed of 0.15 m/s, start-up included."
        ),
        setup=setup_rows(
            context, [("gait", "dynamic, with its own controllers"), ("length", f"{setup.duration:g} s")]
        ),
        claims=claims,
        pictures=(
            Picture(
                _plot_time(context.out / "dynamic-walk-3.6.png", results[0], body),
                "Figure 3.6: centre of mass over time, planned and walked",
                note,
            ),
            Picture(
                _plot_path(context.out / "dynamic-walk-3.7.png", results[0], body),
                "Figure 3.7: path of the centre of mass, planned and walked",
                note,
            ),
        ),
        tables=(arms_table({"with its controllers": walked}),),
        findings=tuple(
            text
            for text in (
                f"The plan makes {speed:.3f} m/s over its first 4 s, the start included (the thesis reads "
                f"0.15), and {values['speed']:.3f} m/s then; the robot walks {walked.speed:.3f} m/s "
                "(median).",
                f"To the side the true centre of mass is {1e3 * result.sway_rms:.0f} mm (rms) from the plan "
                f"once the drift of the heading is taken out, which is {100.0 * result.drift:+.0f} % of the "
                "way (median).",
                falls_finding("The walk", results, body),
            )
            if text
        ),
    )
    return Outcome(result, page)


def _near(value: float, expected: float) -> bool:
    return abs(value / expected - 1.0) <= TOLERANCE


def _com_walked(track: Track, body: Body) -> Array:
    """True centre of mass in the walk frame, whose origin is midway between the ankles at the start, m."""
    first = Track(track.rows[:1])
    soles = [soles_in_world(body, side, first)[0, :2, 3] for side in SIDES]
    (xl, yl), (xr, yr) = soles
    yaw = math.atan2(-(xl - xr), yl - yr)
    off = track["com"][:, :2] - np.mean(soles, axis=0)
    c, s = math.cos(yaw), math.sin(yaw)
    return np.column_stack([c * off[:, 0] + s * off[:, 1], c * off[:, 1] - s * off[:, 0]])


def _sway(track: Track, body: Body) -> tuple[float, float]:
    """Rms difference along y from the plan without its linear trend, m, and that trend over the way ahead."""
    off = _com_walked(track, body)[:, 1] - track["plan_com"][:, 1]
    rate, start = np.polyfit(track["time"], off, 1)
    ahead = np.polyfit(track["time"], track["plan_com"][:, 0], 1)[0]
    return float(np.std(off - rate * track["time"] - start)), float(rate / ahead)


def _plot_time(path: Path, result: WalkOutcome, body: Body) -> Path:
    figure = axes.new_figure(9.0, 6.5)
    track = result.track
    walked = _com_walked(track, body)
    for i, (panel, name) in enumerate(zip(figure.subplots(2, 1, sharex=True), "xy", strict=True)):
        panel.plot(track["time"], track["plan_com"][:, i], axes.BLUE, label="planned")
        panel.plot(track["time"], walked[:, i], axes.RED, linewidth=0.9, label="walked")
        axes.finish(panel, "t / s", f"{name}_W^CoG / m")
    return axes.save(figure, path)


def _plot_path(path: Path, result: WalkOutcome, body: Body) -> Path:
    figure = axes.new_figure(9.0, 4.0)
    panel = figure.subplots()
    track = result.track
    walked = _com_walked(track, body)
    panel.plot(track["plan_com"][:, 0], track["plan_com"][:, 1], axes.BLUE, label="planned")
    panel.plot(walked[:, 0], walked[:, 1], axes.RED, linewidth=0.9, label="walked")
    axes.finish(panel, "x_W^CoG / m", "y_W^CoG / m")
    return axes.save(figure, path)
