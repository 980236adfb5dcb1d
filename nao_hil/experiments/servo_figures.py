"""Figures of the servo table."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from bridge.body import Body
from bridge.body.quantities import joint_no_load_speed, joint_stall_torque
from emulator.wear import WearProfile
from nao_hil.experiments.servo_bench import LEGS, Vector, part
from nao_hil.files import atomic_path

SHOWN: Final = tuple(joint for joint in LEGS if joint.startswith("L"))
"""The right leg's are alike."""
PUBLISHED_RESPONSE: Final = (0.019, 1.5)
"""T (s) and D of the second-order response identified by a team on its V6."""


def _panels(title: str) -> tuple[Figure, list[Any]]:
    figure = Figure(figsize=(11.0, 6.5), layout="constrained")
    figure.suptitle(title)
    axes = figure.subplots(2, 3).ravel().tolist()
    for panel, joint in zip(axes, SHOWN, strict=True):
        panel.set_title(joint)
        panel.grid(alpha=0.3)
    return figure, axes


def published_response(time: Vector) -> Vector:
    """Step response 1 / (T^2 s^2 + 2 D T s + 1) with D > 1, time in s."""
    period, damping = PUBLISHED_RESPONSE
    root = math.sqrt(damping**2 - 1.0)
    slow, fast = (damping - root) / period, (damping + root) / period
    t = np.maximum(time, 0.0)
    return np.asarray(1.0 - (fast * np.exp(-slow * t) - slow * np.exp(-fast * t)) / (fast - slow))


def plot_steps(path: Path, body: Body, tracks: Mapping[str, Vector], steps: Mapping[str, float]) -> None:
    """Step responses of a free leg over the yardstick, which starts 3 cycles after the request."""
    figure, axes = _panels("Free leg, step of the request (encoder), dashed: PT2 of a V6, T 0.019 s, D 1.5")
    for panel, joint in zip(axes, SHOWN, strict=True):
        track = tracks[joint]
        read = part(track, 0)[:, LEGS.index(joint)]
        time = track[:, 0] - track[0, 0] + body.cycle
        panel.plot(1e3 * time, (read - read[0]) / steps[joint], ".-", markersize=3)
        fine = np.arange(0.0, time[-1], 1e-3)
        panel.plot(1e3 * fine, published_response(fine - 0.030), "k--", linewidth=1.0)
        panel.axvspan(36.0, 40.0, alpha=0.2, color="tab:green", label="published delay")
        panel.set(xlabel="time after the request / ms", xlim=(0.0, 400.0))
    axes[0].legend()
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=110)


def plot_speeds(path: Path, body: Body, tracks: Mapping[str, Vector]) -> None:
    """Speed over time from stop to stop, with the data sheet's no-load speed."""
    figure, axes = _panels("From stop to stop without load, dashed: no-load speed of the data sheet")
    for panel, joint in zip(axes, SHOWN, strict=True):
        track = tracks[joint]
        speed = np.degrees(np.diff(part(track, 1)[:, LEGS.index(joint)]) / body.cycle)
        panel.plot(track[1:, 0] - track[0, 0], speed)
        panel.axhline(math.degrees(joint_no_load_speed(body, joint)), color="k", linestyle="--", linewidth=1.0)
        panel.set(xlabel="time / s", ylabel="deg/s")
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=110)


def plot_loops(path: Path, track: Vector) -> None:
    """Joint over motor angle under slow reversal."""
    figure, axes = _panels("Slow reversal without load: joint over motor, about the operating point")
    for panel, joint in zip(axes, SHOWN, strict=True):
        i = LEGS.index(joint)
        motor, angle = np.degrees(part(track, 2)[:, i]), np.degrees(part(track, 0)[:, i])
        middle = float(np.mean(motor))
        panel.plot(motor - middle, angle - middle, linewidth=0.8)
        width = math.degrees(float(np.ptp(part(track, 2)[:, i] - part(track, 1)[:, i])))
        panel.set(xlabel="motor / deg", ylabel="encoder / deg")
        panel.text(0.05, 0.9, f"width {width:.2f} deg", transform=panel.transAxes)
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=110)


def plot_heat(path: Path, wear: WearProfile, track: Vector) -> None:
    """Temperature, and the stiffness that the protection leaves, stalled at full stiffness."""
    figure, axes = _panels("Stalled at full stiffness: temperature, dashed: stiffness left")
    for panel, joint in zip(axes, SHOWN, strict=True):
        i = LEGS.index(joint)
        time = track[:, 0] - track[0, 0]
        panel.plot(time, part(track, 4)[:, i], color="tab:red")
        for level in (wear.servo.heating.warm, wear.servo.heating.hot, wear.servo.heating.critical):
            panel.axhline(level, color="grey", linewidth=0.6)
        panel.set(xlabel="time / s", ylabel="degrees Celsius")
        twin = panel.twinx()
        twin.plot(time, part(track, 5)[:, i], "--")
        twin.set_ylim(0.0, 1.05)
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=110)


def plot_stiffness(
    path: Path, body: Body, torques: Mapping[float, Vector], current: Vector, fallen: Vector
) -> None:
    """Torque of clamped motors by stiffness (N m), current at full stiffness (A), fall without any (rad)."""
    figure = Figure(figsize=(11.0, 7.5), layout="constrained")
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
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=110)
