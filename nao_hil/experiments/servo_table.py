"""The table of the leg drives: measured values and those of the data sheet.

Yardstick of the step response: the second-order model that a team identified on its V6, T = 0.019 s, D = 1.5,
drawn from the moment the motion begins. It is no target.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from bridge.body import Body, load_body
from bridge.body.quantities import joint_no_load_speed, joint_stall_torque
from bridge.types import Array
from emulator.wear import WearProfile, load_wear
from nao_hil.analysis.report.render import Claim, Outcome, Picture
from nao_hil.experiments import axes
from nao_hil.experiments.context import Context
from nao_hil.experiments.servo_bench import LEGS, bench_tracks, measure, part, passes, step_of
from nao_hil.files import save_figure

SHOWN: Final = tuple(joint for joint in LEGS if joint.startswith("L"))
"""The right leg's are alike."""
PUBLISHED_RESPONSE: Final = (0.019, 1.5)
"""T (s) and D of the second-order response identified by a team on its V6."""


def _panels(title: str) -> tuple[Figure, list[Any]]:
    figure = axes.new_figure(11.0, 6.5)
    figure.suptitle(title)
    panels = figure.subplots(2, 3).ravel().tolist()
    for panel, joint in zip(panels, SHOWN, strict=True):
        panel.set_title(joint)
        panel.grid(alpha=0.3)
    return figure, panels


def published_response(time: Array) -> Array:
    """Step response 1 / (T^2 s^2 + 2 D T s + 1) with D > 1, time in s."""
    period, damping = PUBLISHED_RESPONSE
    root = math.sqrt(damping**2 - 1.0)
    slow, fast = (damping - root) / period, (damping + root) / period
    t = np.maximum(time, 0.0)
    return np.asarray(1.0 - (fast * np.exp(-slow * t) - slow * np.exp(-fast * t)) / (fast - slow))


def plot_steps(path: Path, body: Body, tracks: Mapping[str, Array], steps: Mapping[str, float]) -> None:
    """Step responses of a free leg over the yardstick, which starts 3 cycles after the request."""
    figure, panels = _panels("Free leg, step of the request (encoder), dashed: PT2 of a V6, T 0.019 s, D 1.5")
    for panel, joint in zip(panels, SHOWN, strict=True):
        track = tracks[joint]
        read = part(track, 0)[:, LEGS.index(joint)]
        time = track[:, 0] - track[0, 0] + body.cycle
        panel.plot(1e3 * time, (read - read[0]) / steps[joint], ".-", markersize=3)
        fine = np.arange(0.0, time[-1], 1e-3)
        panel.plot(1e3 * fine, published_response(fine - 0.030), "k--", linewidth=1.0)
        panel.axvspan(36.0, 40.0, alpha=0.2, color="tab:green", label="published delay")
        panel.set(xlabel="time after the request / ms", xlim=(0.0, 400.0))
    panels[0].legend()
    save_figure(figure, path)


def plot_speeds(path: Path, body: Body, tracks: Mapping[str, Array]) -> None:
    """Speed over time from stop to stop, with the data sheet's no-load speed."""
    figure, panels = _panels("From stop to stop without load, dashed: no-load speed of the data sheet")
    for panel, joint in zip(panels, SHOWN, strict=True):
        track = tracks[joint]
        speed = np.degrees(np.diff(part(track, 1)[:, LEGS.index(joint)]) / body.cycle)
        panel.plot(track[1:, 0] - track[0, 0], speed)
        panel.axhline(math.degrees(joint_no_load_speed(body, joint)), color="k", linestyle="--", linewidth=1.0)
        panel.set(xlabel="time / s", ylabel="deg/s")
    save_figure(figure, path)


def plot_loops(path: Path, track: Array) -> None:
    """Joint over motor angle under slow reversal."""
    figure, panels = _panels("Slow reversal without load: joint over motor, about the operating point")
    for panel, joint in zip(panels, SHOWN, strict=True):
        i = LEGS.index(joint)
        motor, angle = np.degrees(part(track, 2)[:, i]), np.degrees(part(track, 0)[:, i])
        middle = float(np.mean(motor))
        panel.plot(motor - middle, angle - middle, linewidth=0.8)
        width = math.degrees(float(np.ptp(part(track, 2)[:, i] - part(track, 1)[:, i])))
        panel.set(xlabel="motor / deg", ylabel="encoder / deg")
        panel.text(0.05, 0.9, f"width {width:.2f} deg", transform=panel.transAxes)
    save_figure(figure, path)


def plot_heat(path: Path, wear: WearProfile, track: Array) -> None:
    """Temperature, and the stiffness that the protection leaves, stalled at full stiffness."""
    figure, panels = _panels("Stalled at full stiffness: temperature, dashed: stiffness left")
    for panel, joint in zip(panels, SHOWN, strict=True):
        i = LEGS.index(joint)
        time = track[:, 0] - track[0, 0]
        panel.plot(time, part(track, 4)[:, i], color="tab:red")
        for level in (wear.servo.heating.warm, wear.servo.heating.hot, wear.servo.heating.critical):
            panel.axhline(level, color="grey", linewidth=0.6)
        panel.set(xlabel="time / s", ylabel="degrees Celsius")
        twin = panel.twinx()
        twin.plot(time, part(track, 5)[:, i], "--")
        twin.set_ylim(0.0, 1.05)
    save_figure(figure, path)


def plot_stiffness(
    path: Path, body: Body, torques: Mapping[float, Array], current: Array, fallen: Array
) -> None:
    """Torque of clamped motors by stiffness (N m), current at full stiffness (A), fall without any (rad)."""
    figure = axes.new_figure(11.0, 7.5)
    figure.suptitle("Clamped motors with a far request, and a leg without stiffness")
    held, drawn, fall = figure.subplots(3, 1, sharex=True)
    places = np.arange(len(LEGS))
    width = 0.8 / len(torques)
    for k, (stiffness, torque) in enumerate(torques.items()):
        held.bar(places - 0.4 + (k + 0.5) * width, torque, width, label=f"stiffness {stiffness:g}")
    sheet = [joint_stall_torque(body, joint) for joint in LEGS]
    held.plot(places, sheet, "k_", markersize=30, label="data sheet")
    held.set_ylabel("torque / N m")
    held.set_ylim(0.0, 1.35 * max(sheet))
    held.legend(ncols=len(torques) + 1, loc="upper center")
    drawn.bar(places, current)
    drawn.set_ylabel("stall current / A")
    fall.bar(places, np.degrees(fallen))
    fall.set_ylabel("falls in 2 s / deg")
    fall.set_xticks(places, LEGS, rotation=30)
    for panel in (held, drawn, fall):
        panel.grid(alpha=0.3, axis="y")
    save_figure(figure, path)


def experiment(context: Context) -> Outcome:
    """All leg motors of a body in a state of wear."""
    body = load_body(context.robot)
    wear = load_wear(context.wear, body)
    tracks = bench_tracks(body, wear, context.engine)
    rows = measure(body, wear, tracks)
    out = context.out
    plot_speeds(out / "servo-speed.png", body, tracks.speeds)
    plot_steps(out / "servo-step.png", body, tracks.steps, {joint: step_of(joint) for joint in LEGS})
    plot_loops(out / "servo-loop.png", tracks.loop)
    plot_heat(out / "servo-heat.png", wear, tracks.heat)
    plot_stiffness(out / "servo-stiffness.png", body, tracks.torque, tracks.current, tracks.fall)
    titles = {
        "speed": "From stop to stop",
        "step": "Step responses",
        "loop": "Play",
        "heat": "Heat and derating",
        "stiffness": "Stiffness",
    }
    return context.outcome(
        "servo-table",
        "The drives of the legs",
        "Data sheets and published measurements; no part of the thesis.",
        setup=[("bench", "torso nailed down")],
        claims=[
            Claim(
                f"{row.joint} is as data sheet and profile say",
                f"{math.degrees(row.no_load_speed):.0f} deg/s (sheet "
                f"{math.degrees(row.no_load_speed_sheet):.0f}), motion after "
                f"{1e3 * row.request_to_motion:.0f} ms, backlash {math.degrees(row.backlash):.2f} deg (profile "
                f"{math.degrees(row.backlash_configured):.2f}), stall {row.stall_torque:.1f} N m",
                passes(row, wear, body.cycle),
            )
            for row in rows
        ],
        pictures=[Picture(out / f"servo-{name}.png", title, "") for name, title in titles.items()],
        figures={"body": context.robot, "wear": context.wear, "rows": rows},
    )
