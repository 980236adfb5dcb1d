"""Measured velocity, path and odometry of a walk at commanded velocities."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import msgspec
import numpy as np

from bridge import rotations
from bridge.types import Vec2, Vec3
from nao_hil.analysis.statistics import Share, mean_of
from nao_hil.runs.heading_motion import SETTLING
from nao_hil.runs.track import Array, Track
from nao_hil.runs.walk import WalkOutcome

LEAST: Final = 1.0
"""s of walk after the settling without which nothing is measured."""


class MeanInterval(msgspec.Struct, frozen=True, kw_only=True):
    """Mean of some walks with its 95 % interval (Student's t); NaN where there are too few."""

    value: float
    interval: Vec2

    def within(self, low: float, high: float) -> bool:
        """Whether the whole interval lies between `low` and `high`."""
        return self.interval[0] >= low and self.interval[1] <= high

    def words(self, scale: float = 1.0, digits: int = 2) -> str:
        """As text for the report."""
        low, high = (scale * bound for bound in self.interval)
        return f"{scale * self.value:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def mean(values: Sequence[float]) -> MeanInterval:
    """Mean and interval of independent values."""
    found = mean_of(values)
    low, high = found.low, found.high
    return MeanInterval(
        value=math.nan if found.value is None else found.value,
        interval=(-math.inf if low is None else low, math.inf if high is None else high),
    )


class VelocityCell(Share, frozen=True, kw_only=True):
    """Walks at one velocity."""

    command: Vec3
    """m/s, m/s, rad/s"""
    measured: Vec3
    """Medians over the walks, of the torso in its heading from 2 s on, until the end or the fall."""
    ratio: MeanInterval
    """Measured over commanded, on the commanded axis on which it is furthest from 1."""
    coupling: MeanInterval
    """Largest motion on an axis that is not commanded, relative to the command; each as a part of its axis'
    full speed."""


def heading_velocity(track: Track) -> Vec3 | None:
    """Mean velocity of the torso in its own heading after the settling; None: the walk is too short."""
    time, yaw = track["time"], np.unwrap(rotations.yaw(track["orientation"]))
    late = np.flatnonzero(time >= SETTLING)
    if not len(late) or time[-1] - time[late[0]] < LEAST:
        return None
    steps, turn = np.diff(track["torso"][late, :2], axis=0), np.diff(yaw[late])
    middle = yaw[late][:-1] + 0.5 * turn
    c, s = np.cos(middle), np.sin(middle)
    duration = float(time[-1] - time[late[0]])
    x = float(np.sum(c * steps[:, 0] + s * steps[:, 1])) / duration
    y = float(np.sum(c * steps[:, 1] - s * steps[:, 0])) / duration
    return x, y, float(np.sum(turn)) / duration


def cell(command: Vec3, results: Sequence[WalkOutcome], full: Vec3) -> VelocityCell:
    """Sum up the walks at one velocity.

    Args:
        command: m/s, m/s, rad/s.
        results: Of the walks, with their tracks.
        full: Speed that counts as 1 on each axis.
    """
    walked = [r.track.until(r.end.time) for r in results]
    measured = [velocity for track in walked if (velocity := heading_velocity(track)) is not None]
    alive = sum(r.end.survived for r in results)
    named = [axis for axis in range(3) if command[axis]]
    ratios = [mean([velocity[axis] / command[axis] for velocity in measured]) for axis in named]
    size = math.hypot(*(v / f for v, f in zip(command, full, strict=True)))
    others = [
        mean([abs(velocity[axis]) / full[axis] / size for velocity in measured])
        for axis in range(3)
        if axis not in named
    ]
    x, y, turn = np.median(measured, axis=0).tolist() if measured else (math.nan,) * 3
    return VelocityCell(
        command=command,
        n=len(results),
        survived=alive,
        measured=(x, y, turn),
        ratio=max(ratios, key=lambda ratio: abs(ratio.value - 1.0)),
        coupling=max(others, key=lambda coupling: coupling.value, default=mean([0.0, 0.0])),
    )


class Straight(msgspec.Struct, frozen=True, kw_only=True):
    """Walks straight ahead without a heading command; of those that stand."""

    n: int
    survived: int
    heading_deg: MeanInterval
    """Absolute change of the heading."""
    odometry: MeanInterval
    """Error of the odometry's position, as a part of the path."""


def straight(results: Sequence[WalkOutcome]) -> Straight:
    """Sum up the walks straight ahead."""
    stood = [r.track for r in results if r.end.survived]
    return Straight(
        n=len(results),
        survived=len(stood),
        heading_deg=mean([abs(math.degrees(_moved(true_path(track))[2])) for track in stood]),
        odometry=mean([_odometry_error(track) for track in stood]),
    )


def true_path(track: Track) -> Array:
    """x, y and yaw of the torso, shape (cycles, 3), m, rad."""
    return np.column_stack([track["torso"][:, :2], np.unwrap(rotations.yaw(track["orientation"]))])


def _moved(path: Array) -> Vec3:
    """From the first pose to the last, in the frame of the first."""
    (x, y, yaw), (u, v, end) = path[0], path[-1]
    ahead, aside = rotations.planar_local((x, y, yaw), (u, v))
    return float(ahead), float(aside), float(end - yaw)


def _odometry_error(track: Track) -> float:
    """The torso sways over the middle between the feet: both ends are means over a second."""
    true, odometry = (_smooth(path, track["time"]) for path in (true_path(track), track["place"]))
    way = float(np.sum(np.hypot(*np.diff(true[::25, :2], axis=0).T)))
    return math.dist(_moved(true)[:2], _moved(odometry)[:2]) / way


def _smooth(path: Array, time: Array) -> Array:
    """Running mean over a second of a path, shape (cycles, 3)."""
    width = max(1, round(1.0 / float(np.median(np.diff(time)))))
    kernel = np.full(width, 1.0 / width)
    angles = np.unwrap(path[:, 2])
    return np.column_stack([np.convolve(each, kernel, "valid") for each in (path[:, 0], path[:, 1], angles)])
