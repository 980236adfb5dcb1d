"""Signals of a recording: at times of their own, and on a grid of one row per cycle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bridge.body import Body
from bridge.body.joints import JOINTS
from bridge.body.quantities import GRAVITY, total_mass
from bridge.messages.columns import COLUMNS
from bridge.messages.frames import ELEMENTS, ActuatorFrame, SensorFrame
from bridge.types import Array
from nao_hil.runs.run import Run, Table

NAMES: Final = {
    "command": JOINTS,
    **{
        name: ELEMENTS[name] for name in ("stiffness", "position", "accelerometer", "gyroscope", "angle", "fsr")
    },
}
"""Columns of each signal by their names."""
COMMANDS: Final = ("command", "stiffness")
"""Signals that are asked for; the others are measured."""


@dataclass(frozen=True)
class Signals:
    """Commands and measurements, row k at the boundary of cycle k; NaN where nothing is known.

    Joints are in the order of `nao_hil.JOINTS`; units are SI and radians.
    """

    time: Array
    """s, (n,), evenly spaced from 0."""
    command: Array
    """Angles asked for in the cycle that begins at the row, (n, 25)."""
    stiffness: Array
    """Asked for in the same cycle, (n, 25)."""
    position: Array
    """Measured joint angles, (n, 25)."""
    accelerometer: Array
    """(n, 3)"""
    gyroscope: Array
    """(n, 3)"""
    angle: Array
    """Fused roll and pitch of the torso, (n, 2)."""
    fsr: Array
    """Force cells, left foot first, (n, 8), N."""
    measured: NDArray[np.bool_]
    """Rows with a measurement, (n,); the measurements of the others are interpolated."""

    @property
    def cycle(self) -> float:
        """Time from one row to the next, s."""
        return float(self.time[1] - self.time[0])

    def part(self, rows: slice) -> Signals:
        """Some of the rows; their time begins at 0."""
        values: dict[str, Any] = {field.name: getattr(self, field.name)[rows] for field in fields(self)}
        values["time"] = values["time"] - values["time"][0]
        return Signals(**values)


_GAP: Final = 1.0
"""Shortest time without a sample that is reported, s."""
_JITTER: Final = 0.2
"""Fraction of the usual interval by which samples of an even recording may be early or late."""


class LoggedRun(Run):
    """A run of which `sensors` and `actuators` are known, at times of their own; NaN where a row lacks a value.

    Args:
        time: Of the measurements, s, (n,), rising.
        measured: Measured signals of `NAMES` that the file has, (n, width) each.
        command_time: Of the commands, s, (m,), rising.
        commands: `command` and `stiffness`, (m, 25) each; none: the file has no commands.
        own_clock: The commands' clock has an unknown offset to that of the measurements.
        notes: Sentences about the conversion.
        config: As of `Run`.
    """

    def __init__(
        self,
        time: Array,
        measured: Mapping[str, Array],
        command_time: Array,
        commands: Mapping[str, Array],
        own_clock: bool = False,
        notes: tuple[str, ...] = (),
        config: dict[str, Any] | None = None,
    ) -> None:
        asked = {"position" if name == "command" else name: values for name, values in commands.items()}
        tables = {
            "sensors": Table({**measured, "time": time}, COLUMNS[SensorFrame]),
            "actuators": Table({**asked, "time": command_time if asked else time[:0]}, COLUMNS[ActuatorFrame]),
        }
        super().__init__(config=lambda: config or {}, tables=tables)
        self.own_clock, self.notes = own_clock, notes


def on_grid(run: Run, cycle: float, offset: float = 0.0) -> Signals:
    """Signals on an even grid that begins at the first measurement.

    Commands keep their value until the next. Joint angles are interpolated. So are the other sensors, but the
    rows next to a sample have its value: interpolation would lower their noise.

    Args:
        run: Its `sensors` and `actuators`, at times of their own.
        cycle: Distance of the grid's rows, s.
        offset: Added to the times of the commands, s.
    """
    sensors, actuators = run["sensors"], run["actuators"]
    begin = sensors["time"][0]
    source = sensors["time"] - begin
    grid = np.arange(round(source[-1] / cycle) + 1) * cycle
    nearest = np.minimum(np.rint(source / cycle).astype(int), len(grid) - 1)
    measured = np.zeros(len(grid), dtype=bool)
    measured[nearest] = True
    values: dict[str, Any] = {"time": grid, "measured": measured}
    for name, labels in NAMES.items():
        empty = np.full((len(grid), len(labels)), np.nan)
        if name in COMMANDS:
            asked = actuators.get("position" if name == "command" else name)
            until = begin + grid + 0.5 * cycle
            values[name] = empty if asked is None else _held(actuators["time"] + offset, asked, until)
        elif (rows := sensors.get(name)) is None:
            values[name] = empty
        else:
            values[name] = np.stack([_interpolated(grid, source, column) for column in rows.T], axis=1)
            if name != "position":
                known = np.isfinite(rows)
                for column in range(len(labels)):
                    values[name][nearest[known[:, column]], column] = rows[known[:, column], column]
    return Signals(**values)


def timing_notes(time: Array, cycle: float) -> tuple[str, ...]:
    """Sentences about uneven samples and gaps; none for samples of every cycle.

    Args:
        time: Of the samples, s, (n,).
        cycle: Of the robot, s.
    """
    intervals = np.diff(time)
    usual = float(np.median(intervals))
    notes = []
    if usual > 1.5 * cycle or np.mean(np.abs(intervals - usual) > _JITTER * usual) > 0.01:
        notes.append(
            f"There are {len(time)} samples, {1e3 * usual:.0f} ms apart in the median and "
            f"{1e3 * intervals.max():.0f} ms at most; the cycle is {1e3 * cycle:g} ms. Values between them are "
            "interpolated and do not count."
        )
    if intervals.max() > _GAP:
        at = int(intervals.argmax())
        begin = time[at] - time[0]
        number = int((intervals > _GAP).sum())
        notes.append(
            f"Gaps of more than {_GAP:g} s: {number}, the longest from {begin:.2f} s to "
            f"{begin + intervals[at]:.2f} s."
        )
    return tuple(notes)


def specific_force(accelerometer: Array, angle: Array | None) -> tuple[Array, tuple[str, ...]]:
    """The accelerometer as specific force, of one that may show gravity instead or count in g.

    Args:
        accelerometer: (n, 3), m/s^2 or g.
        angle: Fused roll and pitch, (n, 2), rad; None: not known, the torso is upright.

    Returns:
        (n, 3), m/s^2, and sentences about the changes.
    """
    notes = []
    if 0.5 < np.nanmedian(np.linalg.norm(accelerometer, axis=1)) < 2.0:
        accelerometer = accelerometer * GRAVITY
        notes.append("The accelerometer is in g; it was multiplied by 9.81 m/s^2.")
    roll, pitch = (0.0, 0.0) if angle is None else np.nan_to_num(np.nanmedian(angle, axis=0))
    up = np.array([-np.sin(pitch), np.cos(pitch) * np.sin(roll), np.cos(pitch) * np.cos(roll)])
    if np.nanmedian(accelerometer, axis=0) @ up < 0.0:
        accelerometer = -accelerometer
        notes.append("The accelerometer shows gravity; it was negated into specific force.")
    return accelerometer, tuple(notes)


def _held(time: Array, asked: Array, until: Array) -> Array:
    """The last value at each of the times, (rows, width); NaN before the first."""
    before = np.searchsorted(time, until) - 1
    rows = np.where(np.isfinite(asked), np.arange(len(asked))[:, None], -1)
    rows = np.maximum.accumulate(rows, axis=0)[np.maximum(before, 0)]
    resampled = np.where(rows >= 0, np.take_along_axis(asked, np.maximum(rows, 0), axis=0), np.nan)
    resampled[before < 0] = np.nan
    return np.asarray(resampled)


def _interpolated(grid: Array, source: Array, column: Array) -> Array:
    known = np.isfinite(column)
    if not known.any():
        return np.full(len(grid), np.nan)
    return np.asarray(np.interp(grid, source[known], column[known]))


_UNLOADED: Final = 0.3
"""Fraction of the weight below which the feet carry nothing."""
_WATCHED: Final = 1.0
"""Time at the beginning that is looked at, s."""


def hangs(body: Body, signals: Signals) -> bool | None:
    """The feet carry next to nothing at the beginning; None: their forces are not recorded."""
    fsr = signals.fsr[: round(_WATCHED / signals.cycle)]
    if not np.isfinite(fsr).all():
        return None
    return float(fsr.sum(axis=1).mean()) < _UNLOADED * GRAVITY * total_mass(body)
