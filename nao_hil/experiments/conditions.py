"""Conditions of an experiment summed up: survival, falls, ZMP margin, joints that lag; feet from a track."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bridge.body import Body
from bridge.body.joints import JOINTS, LEG_SLOTS, LEGS
from bridge.body.kinematics import sole_in_torso
from bridge.rotations import matrix, tilt
from bridge.types import SIDES, Array, Side
from nao_hil.analysis.report.render import Claim, ReportTable, table
from nao_hil.analysis.statistics import Paired, Share, paired, percent
from nao_hil.runs.run import Table
from nao_hil.runs.walk import WalkEnd, WalkOutcome


def during(track: Table, *phases: str) -> NDArray[np.bool_]:
    """Mask of the cycles of a walk in some phases, shape (n,)."""
    return np.isin(track["walk/telemetry.phase"], phases)


def soles_in_torso(body: Body, side: Side, joints: Array) -> Array:
    """Poses of a sole (frame 9) in the Torso frame, shape (n, 4, 4), m.

    Args:
        body: Data sheet.
        side: Foot.
        joints: All angles in the order of frames, shape (n, 25), rad.
    """
    angles = joints[:, list(LEG_SLOTS[side])].tolist()
    return np.array([sole_in_torso(body, side, each) for each in angles]).reshape(-1, 4, 4)


def ankle_in_hip(body: Body, side: Side, joints: Array) -> Array:
    """p_(i,0)^(i,8): the ankle in the frame of its hip, torso axes, shape (n, 3), m; arguments as above."""
    soles = soles_in_torso(body, side, joints)
    hip = np.array([0.0, (1.0 if side == "L" else -1.0) * body.lengths.HipOffsetY, -body.lengths.HipOffsetZ])
    return np.asarray(soles[:, :3, 3] + body.lengths.FootHeight * soles[:, :3, 2] - hip)


def soles_in_world(body: Body, side: Side, track: Table) -> Array:
    """Poses of a sole in the world frame, shape (n, 4, 4), m."""
    pose = np.tile(np.eye(4), (track.rows, 1, 1))
    pose[:, :3, :3] = matrix(track["world/truth.torso_orientation"])
    pose[:, :3, 3] = track["world/truth.torso_position"]
    return pose @ soles_in_torso(body, side, track["world/truth.joints"])


def zmp_margin(track: Table, body: Body) -> Array:
    """Distance of the true ZMP from the edge of the stance sole in single support, m, negative outside.

    The sole is taken as its bounding rectangle, as the thesis does (3.1).

    Returns:
        Shape (n,), NaN where there is no single support or no load.
    """
    margin, zmp = np.full(track.rows, np.nan), track["world/truth.zmp"]
    outline = np.array(body.foot.sole)
    low, high = outline.min(axis=0), outline.max(axis=0)
    for side, phase in zip(SIDES, ("SSL", "SSR"), strict=True):
        rows = np.flatnonzero(during(track, phase) & np.isfinite(zmp[:, 0]))
        if not rows.size:
            continue
        soles = soles_in_world(body, side, track.where(rows))
        off = zmp[rows] - soles[:, :2, 3]
        local = np.einsum("nij,ni->nj", soles[:, :2, :2], off)
        if side == "R":
            local[:, 1] *= -1.0
        margin[rows] = np.minimum(local - low, high - local).min(axis=1)
    return margin


MAJORITY: Final = 2.0 / 3.0
"""Lower bound of the share that falls, and of the share that walks on: 18 of 20 reach it, 17 do not."""
BEFORE_FALL: Final = 1.0
"""s before a fall in which the joint that lags most is looked for."""


class Condition(Share, frozen=True, kw_only=True):
    """Runs of one condition."""

    fall_times: tuple[float, ...]
    """s of the walk, ascending."""
    tilt_max_deg: tuple[float, float]
    """Median and largest over the runs of the largest torso tilt before any fall."""
    speed: float
    """Median over the runs, m/s over ground."""

    def fall_words(self) -> str:
        """For claims that they fall; Wilson's interval of the complement is the interval's."""
        low, high = self.interval
        return f"{self.n - self.survived} of {self.n} fall ({percent((1.0 - high, 1.0 - low))})"


def condition(results: Sequence[WalkOutcome], by: float = math.inf) -> Condition:
    """Sum up a condition.

    Args:
        results: Of one condition.
        by: Time until which a run must stand to count as survived, s of the walk.
    """
    alive = [result.end.survived or result.end.time > by for result in results]
    tilts = np.degrees([result.end.tilt_max for result in results])
    return Condition(
        n=len(results),
        survived=sum(alive),
        fall_times=tuple(sorted(result.end.time for result in results if not result.end.survived)),
        tilt_max_deg=(float(np.median(tilts)), float(tilts.max())),
        speed=float(np.median([result.end.speed for result in results])),
    )


@dataclass(frozen=True)
class Comparison:
    """Walks of several conditions with the same seeds."""

    walks: dict[str, list[WalkOutcome]]
    """By the condition's name."""

    @cached_property
    def conditions(self) -> dict[str, Condition]:
        """Each condition summed up."""
        return {name: condition(results) for name, results in self.walks.items()}

    @property
    def pair(self) -> Paired:
        """The first two conditions, seed by seed."""
        first, second, *_ = self.walks.values()
        return pairs(first, second)

    def findings(self, body: Body | None) -> list[str]:
        """Falls of each condition, after the pairs of the first two."""
        texts = [pair_words(self.pair)] if len(self.walks) > 1 else []
        return texts + [falls_finding(name, results, body) for name, results in self.walks.items()]


def falls_claim(text: str, of: Condition, least: float) -> Claim:
    """A claim that a ratio of robots or more falls: the lower bound of the interval decides.

    Args:
        text: The claim.
        of: The condition.
        least: Ratio, 0..1. All of 16 or more seeds must fall for 0.8.
    """
    return Claim(text, of.fall_words(), 1.0 - of.interval[1] >= least)


def pairs(with_: Sequence[WalkOutcome], without: Sequence[WalkOutcome]) -> Paired:
    """The seeds that ran in both conditions, compared."""
    first = {result.seed: result.end.survived for result in with_}
    second = {result.seed: result.end.survived for result in without}
    seeds = [seed for seed in first if seed in second]
    return paired([first[seed] for seed in seeds], [second[seed] for seed in seeds])


def pair_words(pair: Paired) -> str:
    """As text for the report."""
    return (
        f"Same seeds: {pair.both} walk on in both conditions, {pair.only_with} only with, {pair.only_without} "
        f"only without, {pair.neither} in neither: {100 * pair.difference:+.0f} % "
        f"({percent(pair.interval)}), exact McNemar p = {pair.p_value:.2g}."
    )


def conditions_table(conditions: Mapping[str, Condition]) -> ReportTable:
    """Conditions side by side."""
    return table(
        "Conditions",
        conditions.items(),
        {
            "condition": "{0[0]}",
            "survived": "{0[1].survived} of {0[1].n}",
            "95 % interval": lambda item: percent(item[1].interval),
            "falls at, s: first / median / last": lambda item: _times(item[1].fall_times),
            "torso tilt, deg: median / worst": "{0[1].tilt_max_deg[0]:.1f} / {0[1].tilt_max_deg[1]:.1f}",
            "m/s over ground": "{0[1].speed:.3f}",
        },
    )


def before_fall(result: WalkOutcome) -> Table:
    """The walk up to a second before any fall."""
    return result.track.until(result.end.time - (0.0 if result.end.survived else BEFORE_FALL))


def median_over(results: Sequence[WalkOutcome], quantity: Callable[[WalkOutcome], float | None]) -> float:
    """Median of a quantity over the runs that have it; NaN: none has."""
    values = [value for result in results if (value := quantity(result)) is not None]
    return float(np.median(values)) if values else math.nan


def _times(times: Sequence[float]) -> str:
    if not times:
        return "none"
    return f"{times[0]:.1f} / {float(np.median(times)):.1f} / {times[-1]:.1f}"


def falls_finding(name: str, results: Sequence[WalkOutcome], body: Body | None) -> str:
    """Times, directions, phases and joints of the falls of a condition; empty without falls.

    Args:
        name: Of the condition.
        results: Its walks.
        body: For the margin of the ZMP; None: without it.
    """
    fallen = [result for result in results if not result.end.survived]
    if not fallen:
        return ""
    directions = Counter(direction(result.end) for result in fallen)
    to = ", ".join(f"{count} {where}" for where, count in directions.most_common())
    text = (
        f"{name}: {len(fallen)} of {len(results)} fall, at {_times(sorted(r.end.time for r in fallen))} s "
        f"(first / median / last), {to}."
    )
    phases = Counter(_phase_of_fall(result) for result in fallen if result.track.rows)
    if phases:
        text += f" The lean begins in {', '.join(f'{p} ({count})' for p, count in phases.most_common())}."
    lags = [lag for result in fallen if (lag := largest_lag(result)) is not None]
    if lags:
        joint, count = Counter(joint for joint, _ in lags).most_common(1)[0]
        size = float(np.median([math.degrees(angle) for name_, angle in lags if name_ == joint]))
        text += f" In the second before, {joint} is farthest off its request in {count} ({size:.1f} deg)."
    margins = [m for result in results if body is not None and (m := least_margin(result, body)) is not None]
    if margins:
        text += (
            f" Least margin of the ZMP to the edge of the planned stance sole, up to a second before any fall: "
            f"{1e3 * float(np.median(margins)):.0f} mm (median), {1e3 * min(margins):.0f} mm (worst)."
        )
    return text


def direction(end: WalkEnd) -> str:
    """Which way a robot fell, in a word."""
    if abs(end.roll) > abs(end.pitch):
        return "to the right" if end.roll > 0.0 else "to the left"
    return "forward" if end.pitch > 0.0 else "backward"


def _phase_of_fall(result: WalkOutcome) -> str:
    """Phase in which the torso last passed 10 degrees on its way down."""
    track = result.track.until(result.end.time)
    upright = np.flatnonzero(tilt(track["world/truth.torso_orientation"]) < math.radians(10.0))
    row = int(upright[-1]) if upright.size else 0
    return str(track["walk/telemetry.phase"][row])


def largest_lag(result: WalkOutcome) -> tuple[str, float] | None:
    """Leg joint that is farthest off its request in the second before a fall, and by how much, rad."""
    track = result.track.until(result.end.time)
    if not track.rows:
        return None
    rows = track["time"] > result.end.time - BEFORE_FALL
    lag = np.abs(track["actuators.position"] - track["world/truth.joints"])[rows].max(axis=0)
    worst = max(LEGS, key=lambda slot: float(lag[slot]))
    return JOINTS[worst], float(lag[worst])


def least_margin(result: WalkOutcome, body: Body) -> float | None:
    """Least distance of the true ZMP from the stance sole's edge in single support before any fall, m."""
    margins = zmp_margin(before_fall(result), body)
    return float(np.nanmin(margins)) if np.isfinite(margins).any() else None


def growth_per_step(track: Table, values: Array) -> float | None:
    """Slope of a quantity's mean over each step against the number of the step; None before three steps."""
    steps = track["walk/telemetry.step"]
    numbers = np.unique(steps)
    if len(numbers) < 3:
        return None
    means = [values[steps == number].mean() for number in numbers]
    return float(np.polyfit(numbers, means, 1)[0])
