"""Pictures of a comparison."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from bridge.body.joints import JOINTS
from nao_hil.files import atomic_path
from nao_hil.identification.comparison import JointComparison, SensorComparison
from nao_hil.identification.signals import Signals

SHOWN: Final = 4
"""Joints that are drawn over time."""
_STRETCH: Final = 8.0
"""Time that is drawn, s."""


def plot_ranking(path: Path, joints: Sequence[JointComparison]) -> None:
    """Difference of each joint beside its noise floor."""
    figure = Figure(figsize=(9.0, 0.28 * len(joints) + 1.2), layout="constrained")
    axes = figure.subplots()
    rows = np.arange(len(joints))[::-1]
    axes.barh(rows, np.degrees([joint.difference for joint in joints]), label="recorded less replayed")
    axes.barh(rows, np.degrees([joint.floor for joint in joints]), height=0.4, color="0.3", label="noise floor")
    axes.set_yticks(rows, [joint.joint for joint in joints], fontsize=8)
    axes.set_xlabel("RMS difference of the angle, deg")
    axes.legend()
    axes.grid(axis="x", alpha=0.3)
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=110)


def plot_joints(path: Path, joints: Sequence[JointComparison], recorded: Signals, replayed: Signals) -> None:
    """The joints that differ most, where they do most: over time, and angle less command over command."""
    figure = Figure(figsize=(11.0, 2.6 * len(joints)), layout="constrained")
    for row, joint in zip(figure.subplots(len(joints), 2, squeeze=False), joints, strict=True):
        number = JOINTS.index(joint.joint)
        rows = _worst(recorded.position[:, number] - replayed.position[:, number], recorded.cycle)
        command = np.degrees(recorded.command[:, number])
        row[0].plot(recorded.time[rows], command[rows], "k--", lw=0.8, label="command")
        for name, signals in (("recorded", recorded), ("replayed", replayed)):
            angle = np.degrees(signals.position[:, number])
            row[0].plot(signals.time[rows], angle[rows], lw=1.0, label=name)
            row[1].plot(command, angle - command, ".", ms=1.5, label=name)
        row[0].set(ylabel=f"{joint.joint}, deg", xlabel="time, s")
        row[1].set(ylabel="angle - command, deg", xlabel="command, deg")
        for axes in row:
            axes.grid(alpha=0.3)
        row[0].legend(fontsize=7)
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=110)


def plot_spectra(path: Path, sensors: Sequence[SensorComparison]) -> None:
    """Power spectral densities, a panel per axis or cell."""
    columns = 4 if len(sensors) > 6 else 3
    figure = Figure(figsize=(11.0, 2.4 * -(-len(sensors) // columns)), layout="constrained")
    panels: list[Any] = figure.subplots(-(-len(sensors) // columns), columns, squeeze=False).ravel().tolist()
    for axes, sensor in zip(panels, sensors, strict=False):
        for name in ("recorded", "replayed"):
            density = np.maximum(getattr(sensor, f"{name}_density")[1:], 1e-12)
            axes.loglog(sensor.frequency[1:], density, lw=1.0, label=name)
        axes.minorticks_off()  # they take most of the time
        axes.set_title(sensor.sensor, fontsize=9)
        axes.grid(alpha=0.3)
    for axes in panels[len(sensors) :]:
        axes.set_visible(False)
    panels[0].legend(fontsize=7)
    figure.supxlabel("frequency, Hz", fontsize=9)
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=110)


def _worst(difference: Any, cycle: float) -> slice:
    """The stretch in which the squared difference is largest."""
    length = min(round(_STRETCH / cycle), len(difference))
    sums = np.cumsum(np.append(0.0, np.square(difference)))
    begin = int(np.argmax(sums[length:] - sums[:-length]))
    return slice(begin, begin + length)
