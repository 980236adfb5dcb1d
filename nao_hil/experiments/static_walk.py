"""R7: the trajectories of the statically stable gait (thesis 3.3.1, figure 3.4), planned and walked.

No controllers: what is walked is the plan of chapter 3, and what differs from it is the robot.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from bridge.body import Body, load_body
from bridge.types import SIDES, Side
from nao_hil.analysis.report.page import Claim, Outcome, Picture, ReportPage
from nao_hil.experiments import axes
from nao_hil.experiments.arms import Arm, arm, arms_table, falls_finding
from nao_hil.experiments.context import Context
from nao_hil.experiments.geometry import ankle_in_hip, soles_in_world
from nao_hil.experiments.setup import setup_rows
from nao_hil.runs.track import Array, Track
from nao_hil.runs.walk import WalkOutcome
from walker.gaits import Gait, Plan, dry_walk, gait_parameters, make_gait
from walker.switches import NAMED

TOLERANCE = 0.01
"""Share by which a design value may differ from the thesis'."""


@dataclass(frozen=True)
class StaticWalkSetup:
    """The experiment's numbers."""

    duration: float = 21.0
    """s: three double steps."""
    runs: int = 5
    """Most seeds that are used: the plan is the same for all."""
    T_DSP: float = 2.0
    T_SSP: float = 1.5
    l_lift: float = 0.035
    l_GH: float = 0.170


class StaticWalkResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came out."""

    name: str = "static-walk"
    passed: bool
    T_DSP: float
    """s, like the others as read from the planned trajectories."""
    T_SSP: float
    l_lift: float
    l_GH: float
    walked: Arm
    feet_rms: float
    """Root mean square distance of the ankles, in their hips' frames, from where they are requested, m."""
    lift_measured: float
    """Median largest lift of a swing, m."""


def plan(gait: Gait[Any], seconds: float, dt: float = 0.01) -> list[Plan]:
    """Plans of a walk without a robot.

    Args:
        gait: to walk by.
        seconds: of the walk.
        dt: time between two plans, s.
    """
    walk = itertools.islice(dry_walk(gait, dt), round(seconds / dt))
    return [plan for plan, _ in walk]


def design_values(references: Sequence[Plan], body: Body, dt: float = 0.01) -> dict[str, float]:
    """T_DSP, T_SSP (s), l_lift and l_GH (m) as a reader of figure 3.4 finds them."""
    phases = [r.phase for r in references]
    lengths: dict[str, list[int]] = {"DSP": [], "SSP": []}
    begin = 0
    for k in range(1, len(phases)):
        if phases[k] != phases[k - 1]:
            lengths["DSP" if phases[begin] in ("DSL", "DSR") else "SSP"].append(k - begin)
            begin = k
    # the first phase begins within its first cycle
    return {
        "T_DSP": dt * float(np.median(lengths["DSP"][1:])),
        "T_SSP": dt * float(np.median(lengths["SSP"])),
        "l_lift": max(r.right.z for r in references),
        "l_GH": references[0].hip_height - body.lengths.FootHeight,
    }


def experiment(context: Context, setup: StaticWalkSetup | None = None) -> Outcome:
    """Figure 3.4 planned and measured, and the design values."""
    setup = setup or StaticWalkSetup()
    context = context.first(setup.runs)
    body = load_body(context.robot)
    bare = msgspec.to_builtins(NAMED["none"])
    (results,) = context.run(context.walks("static-walk", "static", setup.duration, bare))
    changes = context.config("static", 0, bare)
    gait = make_gait("static", gait_parameters("static", changes.parameters), body)
    values = design_values(plan(gait, setup.duration), body)
    walked = arm(results)
    claims = (
        *(
            Claim(
                f"{name} = {getattr(setup, name):g} {'s' if name.startswith('T') else 'm'} (within 1 %)",
                f"{values[name]:.4g}",
                abs(values[name] / getattr(setup, name) - 1.0) <= TOLERANCE,
            )
            for name in values
        ),
        Claim("The robot walks it on flat ground", walked.words(), walked.survived == walked.n),
    )
    errors = [_foot_error(result.track, body) for result in results]
    lifts = [lift for result in results for lift in _lifts(result.track, body)]
    result = StaticWalkResult(
        passed=all(claim.holds for claim in claims),
        T_DSP=values["T_DSP"],
        T_SSP=values["T_SSP"],
        l_lift=values["l_lift"],
        l_GH=values["l_GH"],
        walked=walked,
        feet_rms=float(np.sqrt(np.mean(np.square(errors)))),
        lift_measured=float(np.median(lifts)) if lifts else math.nan,
    )
    page = ReportPage(
        name="static-walk",
        title="R7: the statically stable gait",
        source="Thesis 3.3.1, figure 3.4: T_DSP 2 s, T_SSP 1.5 s, l_lift 35 mm, l_GH 170 mm.",
        setup=setup_rows(context, [("gait", "static, no controllers"), ("length", f"{setup.duration:g} s")]),
        claims=claims,
        pictures=(
            Picture(
                _plot(context.out / "static-walk-3.4.png", results[0], body, values["l_GH"]),
                "Figure 3.4: trajectories of the feet, planned and walked",
                f"Seed {results[0].seed}; ankles in the frames of their hips, left solid, right dash-dotted; "
                "phases: 0 DSL, 30 SSL, 60 DSR, 90 SSR.",
            ),
        ),
        tables=(arms_table({"no controllers": walked}),),
        findings=tuple(
            text
            for text in (
                f"Ankles are {1e3 * result.feet_rms:.1f} mm (rms) from where they are planned against their "
                f"hips; a swing lifts the sole by {1e3 * result.lift_measured:.0f} mm over where it stood "
                "(median).",
                falls_finding("The walk", results, body),
            )
            if text
        ),
    )
    return Outcome(result, page)


def _foot_error(track: Track, body: Body) -> float:
    """Root mean square distance of measured from requested ankles, both feet, m."""
    off = [
        ankle_in_hip(body, side, track["joints"]) - ankle_in_hip(body, side, track["request"]) for side in SIDES
    ]
    return float(np.sqrt(np.mean([np.sum(d * d, axis=1) for d in off]))) if len(track) else math.nan


def _lifts(track: Track, body: Body) -> list[float]:
    """Largest rise of the true swing sole over where it stood, in each single support, m."""
    lifts = []
    edges = np.flatnonzero(np.diff(track["phase"])) + 1
    for begin, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        part = Track(track.rows[begin:end])
        for side, phase in zip(SIDES, ("SSR", "SSL"), strict=True):
            if part.during(phase)[0]:
                height = soles_in_world(body, side, part)[:, 2, 3]
                lifts.append(float(height.max() - height[0]))
    return lifts


def _plot(path: Path, result: WalkOutcome, body: Body, height: float) -> Path:
    figure = axes.new_figure(9.0, 7.0)
    track = result.track
    planned = [_planned(track, body, side, height) for side in SIDES]
    walked = [ankle_in_hip(body, side, track["joints"]) for side in SIDES]
    panels = figure.subplots(2, 1, sharex=True)
    for panel, (left, right), title in zip(panels, (planned, walked), ("planned", "walked"), strict=True):
        axes.feet(panel, track["time"], left, right)
        axes.phase_line(panel, track, 30.0)
        axes.finish(panel, "t / s", "p_i,0^i,8 / mm", title)
    return axes.save(figure, path)


def _planned(track: Track, body: Body, side: Side, height: float) -> Array:
    """Ankle in its hip's frame as the thesis plans it, the centre of mass fixed in an upright torso, m.

    Args:
        track: Of the walk.
        body: Data sheet.
        side: Foot.
        height: l_GH, m.
    """
    foot, com = track["plan_left" if side == "L" else "plan_right"], track["plan_com"]
    hip = body.lengths.HipOffsetY if side == "L" else -body.lengths.HipOffsetY
    ahead = foot[:, 0] - com[:, 0]
    return np.column_stack([ahead - ahead[0], foot[:, 1] - com[:, 1] - hip, foot[:, 2] - height])
