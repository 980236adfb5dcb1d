"""Shapes of a picture: intersection of a ray with each, and its colour there.

A ray is a point of the camera's plane at depth 1, so that the parameter of a hit is its depth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from bridge.types import Array

Colour = tuple[float, float, float]
"""Red, green and blue, 0 to 1."""
NEAR: Final = 0.01
"""Depth from which something is seen, m."""
_PARALLEL: Final = 1e-12
_SPOT: Final = 0.93
"""Cosine of the angle from the middle of a ball's spot to its edge."""


class Bounded(Protocol):
    """Something with a place."""

    @property
    def hull(self) -> Array:
        """Points (n, 3) whose convex hull, widened by `radius`, it is in, world frame, m."""
        ...

    @property
    def radius(self) -> float:
        """See `hull`, m."""
        ...


class Solid(Bounded, Protocol):
    """A visible shape."""

    def intersect(self, eye: Array, rays: Array) -> Array:
        """Depth of each ray's first intersection, infinite where there is none.

        Args:
            eye: origin of the rays, world frame, (3,), m.
            rays: (..., 3), world frame, to depth 1.
        """
        ...

    def colours_and_normals(self, points: Array) -> tuple[Array, Array]:
        """Colours (n, 3) and outward normals (n, 3) at points of the surface (n, 3), world frame."""
        ...


@dataclass(frozen=True)
class Ball:
    """A ball of one colour, or with dark spots."""

    centre: Array
    radius: float
    """Its radius, m."""
    colour: Colour
    spotted: Array | None = None
    """Its axes, ball to world, (3, 3): a spot is around each end of each; None: no spots."""

    @property
    def hull(self) -> Array:
        """See `Bounded`."""
        return self.centre[None]

    def intersect(self, eye: Array, rays: Array) -> Array:
        """See `Solid`."""
        return _first_root(rays, eye - self.centre, self.radius)

    def colours_and_normals(self, points: Array) -> tuple[Array, Array]:
        """See `Solid`."""
        colours, normals = _plain(self.colour, points), (points - self.centre) / self.radius
        if self.spotted is not None:
            spots = np.abs(normals @ self.spotted).max(axis=1) > _SPOT
            colours = np.where(spots[:, None], 0.1, colours)
        return colours, normals


@dataclass(frozen=True)
class Cylinder:
    """All points within `radius` of an axis, between two flat ends."""

    centre: Array
    """Middle of the axis."""
    half: Array
    """From the middle to the upper end."""
    radius: float
    """Its radius, m."""
    colour: Colour

    @property
    def hull(self) -> Array:
        """See `Bounded`."""
        return np.stack((self.centre - self.half, self.centre + self.half))

    def intersect(self, eye: Array, rays: Array) -> Array:
        """See `Solid`."""
        length = float(np.linalg.norm(self.half))
        axis, from_centre = self.half / length, eye - self.centre
        height, climb = from_centre @ axis, rays @ axis
        across, beside = rays - climb[..., None] * axis, from_centre - height * axis
        depth = _first_root(across, beside, self.radius)
        with np.errstate(invalid="ignore"):  # a ray that misses the round side has no place along it
            depth = np.where(np.abs(height + depth * climb) <= length, depth, np.inf)
        climb = np.where(np.abs(climb) < _PARALLEL, _PARALLEL, climb)
        end = (-np.sign(climb) * length - height) / climb  # where the ray enters through a flat end
        apart = beside + end[..., None] * across
        inside = (np.einsum("...i,...i->...", apart, apart) <= self.radius**2) & (end > NEAR)
        nearest: Array = np.minimum(depth, np.where(inside, end, np.inf))
        return nearest

    def colours_and_normals(self, points: Array) -> tuple[Array, Array]:
        """See `Solid`."""
        length = float(np.linalg.norm(self.half))
        axis = self.half / length
        along = (points - self.centre) @ axis
        round_side = (points - self.centre - along[:, None] * axis) / self.radius
        flat = np.abs(along) > length * (1.0 - 1e-6)
        return _plain(self.colour, points), np.where(flat[:, None], np.sign(along)[:, None] * axis, round_side)


@dataclass(frozen=True)
class Convex:
    """A body between planes: a box, a prism."""

    hull: Array
    """Its corners."""
    normals: Array
    """Outward, (k, 3), world frame."""
    offsets: Array
    """Distance of each plane from the world's origin along its normal, (k,), m."""
    colour: Colour
    radius: float = 0.0

    def intersect(self, eye: Array, rays: Array) -> Array:
        """See `Solid`."""
        enter, leave = np.full(rays.shape[:-1], -np.inf), np.full(rays.shape[:-1], np.inf)
        for normal, offset in zip(self.normals, self.offsets, strict=True):
            slope, gap = rays @ normal, float(offset - normal @ eye)
            slope = np.where(np.abs(slope) < _PARALLEL, _PARALLEL, slope)
            depth = gap / slope
            enter = np.where(slope < 0.0, np.maximum(enter, depth), enter)
            leave = np.where(slope > 0.0, np.minimum(leave, depth), leave)
        return np.where((enter <= leave) & (enter > NEAR), enter, np.inf)

    def colours_and_normals(self, points: Array) -> tuple[Array, Array]:
        """See `Solid`."""
        nearest = np.argmin(np.abs(points @ self.normals.T - self.offsets), axis=1)
        return _plain(self.colour, points), self.normals[nearest]


class Paint(Protocol):
    """Pattern of a disc."""

    def __call__(self, right: Array, up: Array) -> Array:
        """Colours (n, 3) at places of the disc (n,), in radii, as one sees it from its front."""
        ...


@dataclass(frozen=True)
class Disc:
    """A disc with a picture on its front, white behind."""

    centre: Array
    radius: float
    """Its radius, m."""
    facing: Array
    """Unit vector out of its front, world frame."""
    paint: Paint

    @property
    def hull(self) -> Array:
        """See `Bounded`."""
        return self.centre[None]

    def intersect(self, eye: Array, rays: Array) -> Array:
        """See `Solid`."""
        slope = rays @ self.facing
        slope = np.where(np.abs(slope) < _PARALLEL, _PARALLEL, slope)
        depth = float((self.centre - eye) @ self.facing) / slope
        apart = eye + depth[..., None] * rays - self.centre
        inside = np.einsum("...i,...i->...", apart, apart) <= self.radius**2
        return np.where(inside & (depth > NEAR), depth, np.inf)

    def colours_and_normals(self, points: Array) -> tuple[Array, Array]:
        """See `Solid`."""
        right = np.array([-self.facing[1], self.facing[0], 0.0])
        right /= max(float(np.linalg.norm(right)), 1e-9)
        up = np.cross(self.facing, right)
        apart = (points - self.centre) / self.radius
        return self.paint(apart @ right, apart @ up), np.broadcast_to(self.facing, points.shape)


def window(solid: Bounded, eye: Array, R: Array, slopes: Array) -> tuple[float, float, float, float] | None:
    """Bounds of a solid in the camera's plane at depth 1: left, right, up and down; None: outside the picture.

    Args:
        solid: the visible one.
        eye: the camera, world frame, m.
        R: camera to world.
        slopes: largest of the picture to the left and upward, (2,).
    """
    points, r = (solid.hull - eye) @ R, solid.radius
    x, sides = points[:, 0], points[:, 1:]
    reach = np.sqrt(1.0 + slopes * slopes) * r
    if (x + r).max() <= NEAR:
        return None
    for beyond in (sides - x[:, None] * slopes, -sides - x[:, None] * slopes):
        if (beyond > reach).all(axis=0).any():
            return None
    if (x - r).min() <= NEAR:
        return slopes[0], -slopes[0], slopes[1], -slopes[1]
    nearest, farthest = (x - r)[:, None], (x + r)[:, None]
    high = np.maximum((sides + r) / nearest, (sides + r) / farthest).max(axis=0)
    low = np.minimum((sides - r) / nearest, (sides - r) / farthest).min(axis=0)
    return float(high[0]), float(low[0]), float(high[1]), float(low[1])


def _first_root(rays: Array, eye: Array, radius: float) -> Array:
    """Depth at which rays from `eye` enter the sphere of `radius` about the origin; infinite for a miss."""
    a = np.einsum("...i,...i->...", rays, rays)
    half_b, c = rays @ eye, float(eye @ eye) - radius * radius
    under = half_b * half_b - a * c
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = (-half_b - np.sqrt(np.maximum(under, 0.0))) / a
        return np.where((under >= 0.0) & (depth > NEAR), depth, np.inf)


def _plain(colour: Colour, points: Array) -> Array:
    return np.broadcast_to(np.array(colour), points.shape)


def landmark(number: int) -> Paint:
    """A black disc with a white rim and white sectors, whose widths follow from the number.

    The vendor's marks have sectors as well; which number has which is not published, so these are our own
    (assumed): programs that decode marks themselves do not know them.
    """
    widths = [(number >> (2 * i)) % 4 + 1 for i in range(4)]
    edges = np.cumsum([w + 2 for w in widths]) * (2.0 * math.pi / (sum(widths) + 8))

    def paint(right: Array, up: Array) -> Array:
        """White ring and sectors on black, at points of the mark."""
        around = np.arctan2(up, right) % (2.0 * math.pi)
        sector = np.searchsorted(edges, around)
        begin = np.concatenate(([0.0], edges))[np.minimum(sector, 3)]
        share = np.array(widths)[np.minimum(sector, 3)] * (2.0 * math.pi / (sum(widths) + 8))
        out = np.hypot(right, up)
        white = (out > 0.93) | ((around - begin < share) & (out > 0.25) & (out < 0.8))
        return np.where(white[:, None], 0.95, 0.05) * np.ones(3)

    return paint


def face(right: Array, up: Array) -> Array:
    """A face: skin, two eyes, a mouth; the same for everybody."""
    colours = np.tile(np.array([0.87, 0.68, 0.55]), (len(right), 1))
    eyes = np.hypot(np.abs(right) - 0.35, up - 0.25) < 0.12
    mouth = (np.abs(np.hypot(right, up + 0.1) - 0.4) < 0.05) & (up < -0.25)
    colours[eyes], colours[mouth], colours[up > 0.65] = (0.12, 0.1, 0.1), (0.65, 0.2, 0.2), (0.25, 0.16, 0.1)
    return colours
