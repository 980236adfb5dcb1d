"""The path of a foot through the air, heel and toe included ((1) to (6)), and over the edges of known ground.

Departure from the source: between its knots a spline through (2), (3) neither keeps the edge of the sole in its
place nor out of the ground. Here the ankle follows from the pitch while the sole rolls over its toe or heel,
and the spline of the swing takes over with position, velocity and acceleration. The formulas (2), (3) are this
rolling at the knots. Ground that slopes is the same rolling about the sloped sole.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from bridge.body import Body
from bridge.body.sole import sole_hull
from bridge.types import Array
from walker.functions import MotionState
from walker.gaits.huang.parameters import HuangParameters, refuse
from walker.gaits.huang.spline import Cubic, clamped, even, joined


@dataclass(frozen=True)
class FootShape:
    """A foot seen from the side."""

    l_an: float
    """Height of the ankle over the sole, m."""
    l_af: float
    """Ankle to toe, m."""
    l_ab: float
    """Ankle to heel, m."""

    @classmethod
    def of(cls, body: Body) -> FootShape:
        """From the data sheet's sole."""
        along = sole_hull(body, "L")[:, 0]
        return cls(body.lengths.FootHeight, float(along.max()), float(-along.min()))


class Placement(NamedTuple):
    """Pose of a flat foot."""

    x: float
    """Below the ankle along the sole's normal, on the ground, m."""
    z: float = 0.0
    """Height of the ground there, m."""
    pitch: float = 0.0
    """Slope of the ground, rad, positive: downhill."""


class FootPose(NamedTuple):
    """Ankle and pitch of a foot: floats, or arrays of one shape."""

    x: Array
    z: Array
    pitch: Array


class Rolling(NamedTuple):
    """A sole that turns about its toe or heel, resting on the ground: the ankle about the pivot."""

    pivot: tuple[float, float]
    arm: tuple[float, float]
    """Pivot to ankle in the foot's own axes, m."""

    @classmethod
    def over(cls, shape: FootShape, place: Placement, *, toe: bool) -> Rolling:
        """Over the toe or the heel of a foot that is flat at a place."""
        forward = shape.l_af if toe else -shape.l_ab
        s, c = math.sin(place.pitch), math.cos(place.pitch)
        return cls((place.x + c * forward, place.z - s * forward), (-forward, shape.l_an))

    def ankle(self, pitch: MotionState) -> tuple[MotionState, MotionState]:
        """Motion of the ankle, x and z, for a motion of the pitch."""
        s, c = math.sin(pitch.position), math.cos(pitch.position)
        a, b = self.arm
        x, z = c * a + s * b, c * b - s * a
        w, dw = pitch.velocity, pitch.acceleration
        return (
            MotionState(self.pivot[0] + x, z * w, z * dw - x * w * w),
            MotionState(self.pivot[1] + z, -x * w, -x * dw - z * w * w),
        )

    def places(self, pitch: Array) -> tuple[Array, Array]:
        """Place of the ankle, x and z, for many pitches."""
        a, b = self.arm
        s, c = np.sin(pitch), np.cos(pitch)
        return self.pivot[0] + c * a + s * b, self.pivot[1] + c * b - s * a


class Apex(NamedTuple):
    """The highest point of a swing."""

    time: float
    """From the beginning of the foot's cycle, s."""
    way: float
    """Fraction of the path."""
    height: float
    """Height of the ankle above the higher of both ends, m."""


class FootPath:
    """From one placement of a foot to the next; time counts from the beginning of its cycle.

    Args:
        p: of the gait.
        shape: of the foot.
        start: placement before.
        end: placement after.
        fraction: of a whole step's roll that this one has; the first and the last step have half.
        apex: highest point, where it is not as the parameters have it.
    """

    def __init__(
        self,
        p: HuangParameters,
        shape: FootShape,
        start: Placement,
        end: Placement,
        fraction: float = 1.0,
        apex: Apex | None = None,
    ) -> None:
        self.start, self.end, self._shape = start, end, shape
        self.lift, self.land, self.settled = p.T_d, p.T_c, p.T_c + p.T_d
        roll = min(fraction, 1.0)
        self.pitch: Cubic = clamped(
            (0.0, self.lift, self.land, self.settled),
            (start.pitch, start.pitch + roll * p.q_b, end.pitch - roll * p.q_f, end.pitch),
        )
        self._toe = Rolling.over(shape, start, toe=True)
        self._heel = Rolling.over(shape, end, toe=False)
        off, on = self._toe.ankle(self.pitch.at(self.lift)), self._heel.ankle(self.pitch.at(self.land))
        apex = apex or Apex(p.T_m, (p.L_ao or p.D_s) / (2.0 * p.D_s), p.H_ao)
        times = (self.lift, apex.time, self.land)
        self.x = joined(times, off[0], start.x + apex.way * (end.x - start.x), on[0])
        self.z = joined(times, off[1], max(start.z, end.z) + apex.height, on[1])
        self._check_roll(p)

    def sample(self, times: Array) -> FootPose:
        """Ankle and pitch at many times, s; before and after the path the foot rests."""
        t = np.clip(np.asarray(times, dtype=np.float64), 0.0, self.settled)
        pitch = self.pitch.sample(t)[0]
        toe, heel = self._toe.places(pitch), self._heel.places(pitch)
        rolls, lands = t <= self.lift, t >= self.land
        x = np.where(rolls, toe[0], np.where(lands, heel[0], self.x.sample(t)[0]))
        z = np.where(rolls, toe[1], np.where(lands, heel[1], self.z.sample(t)[0]))
        return FootPose(x, z, pitch)

    def motion(self, time: float) -> tuple[MotionState, MotionState, MotionState]:
        """Ankle x, ankle z and pitch at a time, s, with their derivatives."""
        t = min(max(time, 0.0), self.settled)
        pitch = self.pitch.at(t)
        if not 0.0 < time < self.settled:
            pitch = MotionState(pitch.position, 0.0, 0.0)
        if t <= self.lift:
            return (*self._toe.ankle(pitch), pitch)
        if t >= self.land:
            return (*self._heel.ankle(pitch), pitch)
        return self.x.at(t), self.z.at(t), pitch

    def sole(self, times: Array, outline: Array) -> Array:
        """Places of points of the sole at many times: x and z, shape (2, times, points), m.

        Args:
            times: s.
            outline: x of the sole's points in the foot, m.
        """
        pose = self.sample(times)
        s, c = np.sin(pose.pitch)[:, None], np.cos(pose.pitch)[:, None]
        x = pose.x[:, None] + c * outline - s * self._shape.l_an
        z = pose.z[:, None] - s * outline - c * self._shape.l_an
        return np.stack((x, z))

    def _check_roll(self, p: HuangParameters) -> None:
        """The pitch turns one way only while an edge rests: else the other edge would cut into the ground."""
        for name, begin, end, sign, flat in (
            ("q_b", 0.0, self.lift, 1.0, self.start.pitch),
            ("q_f", self.land, self.settled, -1.0, self.end.pitch),
        ):
            turn = sign * (self.pitch.sample(even(begin, end, 41))[0] - flat)
            if turn.min() < -1e-9:
                refuse(
                    f"with {name} = {getattr(p, name)} rad and T_d = {p.T_d} s the foot rocks back by "
                    f"{math.degrees(-turn.min()):.2f} deg while it rolls; make {name} larger or T_d shorter"
                )


_APEX_SHIFTS: Final = (
    (0.0, 0.0),
    (-0.1, -0.1),
    (0.1, 0.1),
    (-0.1, -0.25),
    (0.1, 0.25),
    (-0.15, -0.35),
    (0.15, 0.35),
)
"""Shifts of the apex in time and way, fractions of the swing: early up a step, late and far down one."""
_APEX_RAISES: Final = (0.0, 0.004, 0.008, 0.012)
"""Raises of the apex that are tried, m."""
_SAMPLES: Final = 60
_TOLERANCE: Final = 1e-9
"""m; rounding of a sole that rolls on the ground."""


class ClearPaths:
    """Makes the paths of the feet over known ground.

    Args:
        p: of the gait, its ground included.
        body: data sheet.
    """

    def __init__(self, p: HuangParameters, body: Body) -> None:
        self._p, self._shape = p, FootShape.of(body)
        sole = sole_hull(body, "L")
        self._along = sole[:, 0]
        self._half_width = max(abs(y) for _, y in body.foot.sole)

    def path(self, start: Placement, end: Placement, y: float) -> FootPath:
        """The path from one placement to the next: by the parameters, or the first variation that clears edges.

        Args:
            start: placement before.
            end: placement after.
            y: of the ankle, m.

        Raises:
            ConfigurationError: none of those tried stays off the ground.
        """
        p = self._p
        fraction = min((end.x - start.x) / (2.0 * p.D_s), 1.0)
        path = FootPath(p, self._shape, start, end, fraction)
        if not any(start.x - 0.2 < edge < end.x + 0.2 for edge in p.ground.edges()):
            return path
        deepest = self._depth(path, y)
        swing, way = p.T_c - p.T_d, (p.L_ao or p.D_s) / (2.0 * p.D_s)
        for rise in _APEX_RAISES:
            for time, ahead in _APEX_SHIFTS:
                if deepest <= _TOLERANCE:
                    return path
                apex = Apex(p.T_m + time * swing, way + ahead, p.H_ao + rise)
                path = FootPath(p, self._shape, start, end, fraction, apex)
                deepest = self._depth(path, y)
        if deepest > _TOLERANCE:
            refuse(
                f"the foot that swings from x = {start.x:.3f} m to {end.x:.3f} m goes {1e3 * deepest:.1f} mm "
                "into the known ground; raise H_ao"
            )
        return path

    def _depth(self, path: FootPath, y: float) -> float:
        """Largest depth of a path below the ground, m."""
        ground = self._p.ground
        sides = (y - self._half_width, y, y + self._half_width)
        x, z = path.sole(even(0.0, path.settled, _SAMPLES), self._along)
        places = zip(x.ravel().tolist(), z.ravel().tolist(), strict=True)
        return float(max(ground.at(place, sides) - height for place, height in places))
