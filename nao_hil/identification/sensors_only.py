"""Comparisons without commands: a recording of sensors alone against the emulated robot."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import msgspec
import numpy as np
from scipy.ndimage import uniform_filter1d

from bridge.body.quantities import GRAVITY
from bridge.types import Array
from emulator.sensors.fusion import FusedAngle, fuse
from emulator.sensors.parameters import FusedAngleParameters
from nao_hil.identification.clock import follow_lag
from nao_hil.identification.readings import Signals
from nao_hil.identification.recorded import RecordedSignals
from nao_hil.runs.run import Table

_WINDOW: Final = 0.5
"""Time over which a torso is quiet, s."""
_QUIET: Final = {"gyroscope": 0.02, "accelerometer": 0.3}
"""Largest standard deviation in it of each axis, rad/s and m/s^2: some times the noise of a real robot."""
_STILL: Final = (2.0, 20.0)
"""Shortest and longest stretch at rest, s."""


class FusedAngleComparison(msgspec.Struct, frozen=True, kw_only=True):
    """Fused roll and pitch as recorded, and by the emulated filter from the recorded sensors."""

    difference: tuple[float, float]
    """RMS, means taken out, rad."""
    recorded_rms: tuple[float, float]
    """About the mean, rad."""
    recorded_step: tuple[float, float]
    """Largest change from one sample to the next, rad."""
    emulated_step: tuple[float, float]


def follow_angles(recorded: RecordedSignals) -> RecordedSignals:
    """The same with its angles as commands, earlier by the lag with which a robot follows."""
    signals = recorded.signals
    lead = round(follow_lag(recorded.body) / signals.cycle)
    ahead = np.concatenate([signals.position[lead:], np.repeat(signals.position[-1:], lead, axis=0)])
    return replace(recorded, signals=replace(signals, command=ahead[: len(signals.time)]))


def at_rest(signals: Signals) -> slice | None:
    """The longest stretch, 20 s at most, in which the torso does not move; None: none, or unknown."""
    size = max(round(_WINDOW / signals.cycle), 2)
    known = [
        (name, axis)
        for name in _QUIET
        for axis in range(3)
        if np.isfinite(getattr(signals, name)[:, axis]).all()
    ]
    if not known or len(signals.time) < size:
        return None
    quiet = np.ones(len(signals.time) - size + 1, dtype=bool)
    for name, axis in known:
        quiet &= _deviation(getattr(signals, name)[:, axis], size) < _QUIET[name]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], quiet, [False]])))
    if not len(edges):
        return None
    begin, end = max(zip(edges[::2], edges[1::2], strict=True), key=lambda stretch: stretch[1] - stretch[0])
    rows = min(int(end - begin) + size - 1, round(_STILL[1] / signals.cycle))
    return slice(int(begin), int(begin) + rows) if rows * signals.cycle >= _STILL[0] else None


def compare_fused_angle(sensors: Table, parameters: FusedAngleParameters) -> FusedAngleComparison | None:
    """Feed the emulated filter with the recorded gyroscope and accelerometer.

    Args:
        sensors: Measurements at their own times.
        parameters: Of the filter.

    Returns:
        None where one of these sensors, or the fused angle, was not recorded.
    """
    empty = np.empty((0, 3))
    angle = sensors.get("angle", empty[:, :2])
    acceleration, rate = (sensors.get(name, empty) for name in ("accelerometer", "gyroscope"))
    if not len(angle) or not len(acceleration) or not len(rate):
        return None
    rate = np.where(np.isfinite(rate).any(axis=0), rate, 0.0)  # some gyroscopes have no z
    rows = np.isfinite(np.hstack([angle, acceleration, rate])).all(axis=1)
    if rows.sum() < 2:
        return None
    angle, emulated = angle[rows], _fused(sensors["time"][rows], acceleration[rows], rate[rows], parameters)
    difference = angle - emulated
    return FusedAngleComparison(
        difference=_pair(difference.std(axis=0)),
        recorded_rms=_pair(angle.std(axis=0)),
        recorded_step=_pair(np.abs(np.diff(angle, axis=0)).max(axis=0)),
        emulated_step=_pair(np.abs(np.diff(emulated, axis=0)).max(axis=0)),
    )


def _fused(time: Array, acceleration: Array, rate: Array, parameters: FusedAngleParameters) -> Array:
    """Roll and pitch of the emulated filter at each sample, (n, 2), rad."""
    samples = [tuple(row) for row in acceleration.tolist()], [tuple(row) for row in rate.tolist()]
    unit = FusedAngle(GRAVITY, samples[0][0], parameters)
    angles = [unit.angle]
    for dt, seen, turned in zip(np.diff(time).tolist(), samples[0][1:], samples[1][1:], strict=True):
        fuse(unit.state, seen, turned, dt, *unit.constants)
        angles.append(unit.angle)
    return np.array(angles)


def _deviation(values: Array, size: int) -> Array:
    """Standard deviation in each whole window."""
    values = values - values.mean()
    mean, square = (uniform_filter1d(each, size, origin=-(size // 2)) for each in (values, np.square(values)))
    whole = len(values) - size + 1
    return np.asarray(np.sqrt(np.maximum(square - np.square(mean), 0.0))[:whole])


def _pair(values: Array) -> tuple[float, float]:
    return float(values[0]), float(values[1])
