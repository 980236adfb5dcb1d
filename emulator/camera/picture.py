"""A picture of solids and robots on a floor: a ray through each pixel, and the triangles of the robots.

An engine's own renderer would do, but MuJoCo's needs EGL, PyBullet has no wheels for Python from 3.12 on, and
its TinyRenderer takes 24 ms of processor time for 320 x 240 pixels.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bridge.messages.world_state import Field
from bridge.types import Array, Vec2
from emulator.camera.mesh import Mesh, rasterise
from emulator.camera.shapes import Solid, window

TILE: Final = 0.25
"""Edge of the floor's squares, m."""
_TILES: Final = np.array(((0.42, 0.55, 0.42), (0.50, 0.63, 0.50)))
_CARPET: Final = np.array((0.16, 0.42, 0.20))
_LINE: Final = np.array((0.92, 0.93, 0.92))
_PIXEL: Final = 0.005
"""Edge of the pixels of a painted field, m."""
_WALL: Final = np.array((0.80, 0.82, 0.85))
_FAR: Final = 12.0
"""Depth at which the floor has become the wall's colour, m."""
_LIGHT: Final = np.array((-0.30, 0.25, 0.92))
_AMBIENT: Final = 0.6
_POINT: Final = 1e-4
"""Half the edge of a picture of one point, at depth 1."""


@dataclass(frozen=True)
class View:
    """A camera somewhere: eye (3,), m, and axes R (3, 3), x along its axis, y left, z up, to the world."""

    eye: Array
    R: Array
    field: Vec2
    """Horizontal and vertical field of view, rad."""

    def seen(self, point: Array) -> Array:
        """A point of the world in the camera's frame, (3,), m."""
        place: Array = (point - self.eye) @ self.R
        return place


@dataclass(frozen=True)
class Floor:
    """A plane with squares on it: origin (3,), m, and axes R (3, 3), z out of it, to the world."""

    origin: Array
    R: Array
    field: PaintedField | None = None


class PaintedField:
    """Carpet and lines of a field as a map of the floor.

    Args:
        field: As the world reports it.
    """

    def __init__(self, field: Field) -> None:
        self._half = 0.5 * np.array(field.size)
        shape = np.ceil(np.array(field.size) / _PIXEL).astype(int)
        self._white = np.zeros(shape, dtype=bool)
        for stripe in field.stripes:
            self._paint(np.array(stripe.begin), np.array(stripe.end), 0.5 * stripe.width)

    def _paint(self, begin: Array, end: Array, half: float) -> None:
        length = float(np.linalg.norm(end - begin))
        along = (end - begin) / length
        low, high = np.minimum(begin, end) - 2.0 * half, np.maximum(begin, end) + 2.0 * half
        first = np.maximum(np.floor((low + self._half) / _PIXEL).astype(int), 0)
        last = np.minimum(np.ceil((high + self._half) / _PIXEL).astype(int), self._white.shape)
        x, y = ((np.arange(a, b) + 0.5) * _PIXEL - h for a, b, h in zip(first, last, self._half, strict=True))
        dx, dy = x[:, None] - begin[0], y[None, :] - begin[1]
        way, across = dx * along[0] + dy * along[1], dx * along[1] - dy * along[0]
        inside = (way >= -half) & (way <= length + half) & (np.abs(across) <= half)
        self._white[first[0] : last[0], first[1] : last[1]] |= inside

    def paint(self, x: Array, y: Array, colours: Array) -> None:
        """Change the colours (n, 3) at points of the floor (n,), m, to those of carpet and lines."""
        inside = (np.abs(x) < self._half[0]) & (np.abs(y) < self._half[1])
        rows, columns = ((np.array((x, y))[:, inside] + self._half[:, None]) / _PIXEL).astype(int)
        colours[inside] = np.where(self._white[rows, columns][:, None], _LINE, _CARPET)


def draw(
    view: View, floor: Floor, solids: Sequence[Solid], width: int, height: int, robots: Sequence[Mesh] = ()
) -> NDArray[np.uint8]:
    """The picture, (height, width, 3), RGB.

    Args:
        view: from where.
        floor: under all.
        solids: of the scene.
        width: columns.
        height: rows.
        robots: of the scene.
    """
    slope = np.tan(0.5 * np.array(view.field))
    left = slope[0] * (1.0 - (2.0 * np.arange(width) + 1.0) / width)
    up = slope[1] * (1.0 - (2.0 * np.arange(height) + 1.0) / height)
    plane = np.stack(np.broadcast_arrays(1.0, left[None, :], up[:, None]), axis=-1)
    rays = plane @ view.R.T
    depth = np.full((height, width), np.inf)
    picture = _background(view, floor, rays, depth)
    for solid in solids:
        bounds = window(solid, view.eye, view.R, slope)
        if bounds is None:
            continue
        columns, rows = _pixels(bounds[0], bounds[1], slope[0], width), _pixels(*bounds[2:], slope[1], height)
        part = rays[rows, columns]
        if not part.size:
            continue
        depths = solid.intersect(view.eye, part)
        front = depths < depth[rows, columns]
        if not front.any():
            continue
        depth[rows, columns][front] = depths[front]
        colours, normals = solid.colours_and_normals(view.eye + depths[front][:, None] * part[front])
        picture[rows, columns][front] = _lit(colours, normals)
    for robot in robots:
        if window(robot, view.eye, view.R, slope) is None:
            continue
        found = rasterise(robot, view.eye, view.R, -slope, slope, (height, width))
        front = found.depth < depth[found.rows, found.columns]
        at = found.rows[front], found.columns[front]
        faces = found.faces[front]
        depth[at] = found.depth[front]
        picture[at] = _lit(robot.colours[faces], robot.normals(faces))
    drawn: NDArray[np.uint8] = (255.0 * np.clip(picture, 0.0, 1.0) + 0.5).astype(np.uint8)
    return drawn


def hidden(point: Array, view: View, solids: Sequence[Solid], robots: Sequence[Mesh] = ()) -> bool:
    """Whether one of the solids or robots is between the camera and a point of the world before it."""
    reach, *sides = view.seen(point)
    ray = (point - view.eye) / reach
    if any(float(solid.intersect(view.eye, ray[None])[0]) < reach for solid in solids):
        return True
    middle = np.array(sides) / reach
    edges = view.eye, view.R, middle - _POINT, middle + _POINT
    return any((rasterise(robot, *edges, (1, 1)).depth < reach).any() for robot in robots)


def _lit(colours: Array, normals: Array) -> Array:
    """Colours (n, 3) of surfaces with outward normals (n, 3), world frame."""
    light = _AMBIENT + (1.0 - _AMBIENT) * np.maximum(normals @ _LIGHT, 0.0)
    lit: Array = colours * light[:, None]
    return lit


def _background(view: View, floor: Floor, rays: Array, depth: Array) -> Array:
    """Wall and floor, with the floor's depth put into `depth`."""
    picture = np.broadcast_to(_WALL, rays.shape).copy()
    fall = rays @ floor.R[:, 2]
    height = float((view.eye - floor.origin) @ floor.R[:, 2])
    below = fall < -1e-6 if height > 0.0 else np.zeros(fall.shape, dtype=bool)
    far = -height / fall[below]
    depth[below] = far
    x, y = (
        (view.eye - floor.origin) @ axis + far * (rays @ axis)[below] for axis in (floor.R[:, 0], floor.R[:, 1])
    )
    squares = (np.floor(x / TILE) + np.floor(y / TILE)).astype(int) % 2
    colours = np.take(_TILES, squares, axis=0)
    if floor.field is not None:
        floor.field.paint(x, y, colours)
    haze = np.minimum(far / _FAR, 1.0)[:, None]
    picture[below] = _WALL * haze + colours * (1.0 - haze)
    return picture


def _pixels(high: float, low: float, slope: float, count: int) -> slice:
    """Columns (or rows) between two places of the camera's plane, left (or upper) one first."""
    first, last = (0.5 * count * (1.0 - side / slope) for side in (high, low))
    return slice(max(0, math.floor(first) - 1), min(count, math.ceil(last) + 1))
