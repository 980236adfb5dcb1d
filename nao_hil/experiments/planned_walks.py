"""R7: both gaits of the thesis, planned and walked (3.3, figures 3.4, 3.6, 3.7).

The static gait walks without controllers: differences from its plan are the robot's. Values that the thesis'
parameters of the dynamic gait mean are recomputed from its equations; they are read here from the planned
trajectory itself, by finite differences, not from the closed forms that made it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import msgspec
import numpy as np
from matplotlib.figure import Figure

from bridge.body import Body
from bridge.rotations import R_yaw
from bridge.types import SIDES, Array, Side
from nao_hil.analysis.report.render import Claim
from nao_hil.experiments import axes
from nao_hil.experiments.conditions import (
    Comparison,
    ankle_in_hip,
    during,
    median_over,
    soles_in_world,
)
from nao_hil.experiments.context import Task
from nao_hil.experiments.experiment import Drawing, Measured, comparison
from nao_hil.runs.run import Table
from nao_hil.runs.walk import WalkOutcome
from walker.gaits import Gait, Plan, dry_walk, gait_parameters, make_gait
from walker.switches import NAMED

TOLERANCE: Final = 0.01
"""Share by which a design value may differ from the thesis'."""
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
"""Consequences of e_s1 = 0.03, e_su = 0.0051, S_a0 = 0.04, z = 0.23 and d_0 = 0.05 m, SI units."""


STATIC: Final = 21.0
"""s of the static walk: three double steps."""
DYNAMIC: Final = 12.0
"""s of the dynamic walk."""
RUNS: Final = 5
"""Most seeds that are used: the plan is the same for all."""
ASKED: Final = {"T_DSP": 2.0, "T_SSP": 1.5, "l_lift": 0.035, "l_GH": 0.170}
"""Design values of the static gait (figure 3.4), s and m."""


def plan(gait: Gait[Any], seconds: float, dt: float = 0.01) -> list[Plan]:
    """Plans of a walk without a robot.

    Args:
        gait: to walk by.
        seconds: of the walk.
        dt: time between two plans, s.
    """
    walk = itertools.islice(dry_walk(gait, dt), round(seconds / dt))
    return [plan for plan, _ in walk]


def design_values(references: Sequence[Plan], body: Body) -> dict[str, float]:
    """T_DSP, T_SSP (s), l_lift and l_GH (m) as a reader of figure 3.4 finds them, of a plan each 10 ms."""
    phases = [r.phase for r in references]
    lengths: dict[str, list[int]] = {"DSP": [], "SSP": []}
    begin = 0
    for k in range(1, len(phases)):
        if phases[k] != phases[k - 1]:
            lengths["DSP" if phases[begin] in ("DSL", "DSR") else "SSP"].append(k - begin)
            begin = k
    # the first phase begins within its first cycle
    return {
        "T_DSP": 0.01 * float(np.median(lengths["DSP"][1:])),
        "T_SSP": 0.01 * float(np.median(lengths["SSP"])),
        "l_lift": max(r.right.z for r in references),
        "l_GH": references[0].hip_height - body.lengths.FootHeight,
    }


def _foot_error(track: Table, body: Body) -> float:
    """Root mean square distance of measured from requested ankles, both feet, m."""
    true, asked = track["world/truth.joints"], track["actuators.position"]
    off = [ankle_in_hip(body, side, true) - ankle_in_hip(body, side, asked) for side in SIDES]
    return float(np.sqrt(np.mean([np.sum(d * d, axis=1) for d in off]))) if track.rows else math.nan


def _lifts(track: Table, body: Body) -> list[float]:
    """Largest rise of the true swing sole over where it stood, in each single support, m."""
    lifts = []
    phases = track["walk/telemetry.phase"]
    edges = np.flatnonzero(phases[1:] != phases[:-1]) + 1
    for begin, end in itertools.pairwise(edges.tolist()):
        part = track.where(slice(begin, end))
        for side, phase in zip(SIDES, ("SSR", "SSL"), strict=True):
            if during(part, phase)[0]:
                height = soles_in_world(body, side, part)[:, 2, 3]
                lifts.append(float(height.max() - height[0]))
    return lifts


def _static_quantities(measured: Measured[Comparison]) -> dict[str, Any]:
    body, (walks,) = measured.body, measured.results.walks.values()
    changes = measured.context.config("static")
    gait = make_gait("static", gait_parameters("static", changes.parameters), body)
    lifts = [lift for result in walks for lift in _lifts(result.track, body)]
    return {
        **design_values(plan(gait, STATIC), body),  # s and m, read from the planned trajectories
        # of the ankles from where they are requested, in their hips' frames, m
        "feet_rms": float(np.sqrt(np.mean([_foot_error(result.track, body) ** 2 for result in walks]))),
        "lift_measured": float(np.median(lifts)) if lifts else math.nan,  # of the largest of each swing, m
    }


def _draw_feet(figure: Figure, measured: Measured[Comparison]) -> None:
    body, track = measured.body, _first(measured).track
    planned = [_planned(track, body, side, measured.figures["l_GH"]) for side in SIDES]
    walked = [ankle_in_hip(body, side, track["world/truth.joints"]) for side in SIDES]
    panels = figure.subplots(2, 1, sharex=True)
    for panel, (left, right), title in zip(panels, (planned, walked), ("planned", "walked"), strict=True):
        axes.feet(panel, track["time"], left, right)
        axes.phase_line(panel, track, 30.0)
        axes.finish(panel, "t / s", "p_i,0^i,8 / mm", title)


def _first(measured: Measured[Comparison]) -> WalkOutcome:
    return next(iter(measured.results.walks.values()))[0]


def _planned(track: Table, body: Body, side: Side, height: float) -> Array:
    """Ankle in its hip's frame as the thesis plans it, the centre of mass fixed in an upright torso, m.

    Args:
        track: Of the walk.
        body: Data sheet.
        side: Foot.
        height: l_GH, m.
    """
    foot = track["walk/telemetry.left" if side == "L" else "walk/telemetry.right"]
    com = track["walk/telemetry.com"]
    hip = body.lengths.HipOffsetY if side == "L" else -body.lengths.HipOffsetY
    ahead = foot[:, 0] - com[:, 0]
    return np.column_stack([ahead - ahead[0], foot[:, 1] - com[:, 1] - hip, foot[:, 2] - height])


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


def _dynamic_quantities(measured: Measured[Comparison]) -> dict[str, Any]:
    body, (walks,) = measured.body, measured.results.walks.values()
    parameters = gait_parameters("dynamic", measured.context.config("dynamic").parameters)
    references = plan(make_gait("dynamic", parameters, body), 5.0, DT)
    return {
        "planned": read_plan(references, DT),
        "mean_speed": references[round(4.0 / DT)].com[0] / 4.0,  # over the time that figure 3.6 shows, m/s
        # of the true from the planned centre of mass along y without drift, m
        "sway_rms": float(np.sqrt(np.mean([_sway(result.track, body)[0] ** 2 for result in walks]))),
        "drift": median_over(walks, lambda result: _sway(result.track, body)[1]),  # to the side over the way
    }


def _claims(expected: Mapping[str, float], values: Mapping[str, float], text: str, walked: Any) -> list[Claim]:
    """The design values, and that all walk."""
    return [
        *(
            Claim(
                f"{name} = {value:g} (within {100.0 * TOLERANCE:g} %)",
                f"{values[name]:.5g}",
                abs(values[name] / value - 1.0) <= TOLERANCE,
            )
            for name, value in expected.items()
        ),
        Claim(text, walked.words(), walked.survived == walked.n),
    ]


def _com_walked(track: Table, body: Body) -> Array:
    """True centre of mass in the walk frame, whose origin is midway between the ankles at the start, m."""
    first = track.where(slice(1))
    soles = [soles_in_world(body, side, first)[0, :2, 3] for side in SIDES]
    (xl, yl), (xr, yr) = soles
    yaw = math.atan2(-(xl - xr), yl - yr)
    return np.asarray((track["world/truth.com"][:, :2] - np.mean(soles, axis=0)) @ R_yaw(yaw)[:2, :2])


def _sway(track: Table, body: Body) -> tuple[float, float]:
    """Rms difference along y from the plan without its linear trend, m, and that trend over the way ahead."""
    off = _com_walked(track, body)[:, 1] - track["walk/telemetry.com"][:, 1]
    rate, start = np.polyfit(track["time"], off, 1)
    ahead = np.polyfit(track["time"], track["walk/telemetry.com"][:, 0], 1)[0]
    return float(np.std(off - rate * track["time"] - start)), float(rate / ahead)


def _draw_time(figure: Figure, measured: Measured[Comparison]) -> None:
    track = _first(measured).track
    walked = _com_walked(track, measured.body)
    for i, (panel, name) in enumerate(zip(figure.subplots(2, 1, sharex=True), "xy", strict=True)):
        panel.plot(track["time"], track["walk/telemetry.com"][:, i], axes.BLUE, label="planned")
        panel.plot(track["time"], walked[:, i], axes.RED, linewidth=0.9, label="walked")
        axes.finish(panel, "t / s", f"{name}_W^CoG / m")


def _draw_path(figure: Figure, measured: Measured[Comparison]) -> None:
    track, panel = _first(measured).track, figure.subplots()
    walked = _com_walked(track, measured.body)
    panel.plot(track["walk/telemetry.com"][:, 0], track["walk/telemetry.com"][:, 1], axes.BLUE, label="planned")
    panel.plot(walked[:, 0], walked[:, 1], axes.RED, linewidth=0.9, label="walked")
    axes.finish(panel, "x_W^CoG / m", "y_W^CoG / m")


STATIC_WALK: Final = comparison(
    most_seeds=RUNS,
    title="R7: the statically stable gait",
    source="Thesis 3.3.1, figure 3.4: T_DSP 2 s, T_SSP 1.5 s, l_lift 35 mm, l_GH 170 mm.",
    setup=(("gait", "static, no controllers"), ("length", f"{STATIC:g} s")),
    conditions=lambda context: {
        "no controllers": Task("static", STATIC).walks(
            context, "static-walk", {"controller.switches": msgspec.to_builtins(NAMED["none"])}
        )
    },
    quantities=_static_quantities,
    claims=lambda measured: _claims(
        ASKED, measured.figures, "The robot walks it on flat ground", measured.figures["walked"]
    ),
    pictures=(
        Drawing(
            "static-walk-3.4.png",
            _draw_feet,
            "Figure 3.4: trajectories of the feet, planned and walked",
            "Seed {seed}; ankles in the frames of their hips, left solid, right dash-dotted; phases: 0 DSL, "
            "30 SSL, 60 DSR, 90 SSR.",
            (9.0, 7.0),
        ),
    ),
)
_NOTE: Final = "Seed {seed}; planned blue, walked red."
DYNAMIC_WALK: Final = comparison(
    most_seeds=RUNS,
    title="R7: the dynamically stable gait",
    source="Thesis 3.3.2, figures 3.6 and 3.7: e_s1 = 0.03, e_su = 0.0051, S_a0 = 0.04, z = 0.23 m; a mean "
    "speed of 0.15 m/s, start-up included.",
    setup=(("gait", "dynamic, with its own controllers"), ("length", f"{DYNAMIC:g} s")),
    conditions=lambda context: {
        "with its controllers": Task("dynamic", DYNAMIC).walks(context, "dynamic-walk")
    },
    quantities=_dynamic_quantities,
    claims=lambda measured: _claims(
        EXPECTED,
        measured.figures["planned"],
        "The robot walks it, with its controllers",
        measured.figures["walked"],
    ),
    pictures=(
        Drawing(
            "dynamic-walk-3.6.png",
            _draw_time,
            "Figure 3.6: centre of mass over time, planned and walked",
            _NOTE,
            (9.0, 6.5),
        ),
        Drawing(
            "dynamic-walk-3.7.png",
            _draw_path,
            "Figure 3.7: path of the centre of mass, planned and walked",
            _NOTE,
            (9.0, 4.0),
        ),
    ),
)
