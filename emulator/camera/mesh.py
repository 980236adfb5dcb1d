"""A robot's shell in a picture, by rasterising its triangles: some 10,000 of them face the camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bridge.types import Array
from emulator.camera.shapes import NEAR

REACH: Final = 0.7
"""No point of a NAO is farther from its Torso frame's origin, m."""
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Mesh:
    """Triangles of one robot."""

    vertices: Array
    """(3, n), world frame, m."""
    faces: Indices
    """Three vertices of each, outward, (3, m)."""
    colours: Array
    """Colour of each face, (m, 3)."""
    hull: Array
    """The Torso frame's origin, (1, 3), world frame, m; see `emulator.camera.shapes.Bounded`."""
    radius: float = REACH

    def normals(self, faces: Indices) -> Array:
        """Outward unit normals of some faces (k,), world frame, (k, 3)."""
        a, b, c = (self.vertices[:, corner[faces]].T for corner in self.faces)
        normal = np.cross(b - a, c - a)
        unit: Array = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-12)[:, None]
        return unit


class Fragments(NamedTuple):
    """Pixels that triangles cover, the farthest first: of a pixel with several the nearest is the last."""

    rows: Indices
    columns: Indices
    depth: Array
    """Along the camera's axis, m."""
    faces: Indices


def rasterise(mesh: Mesh, eye: Array, R: Array, low: Array, high: Array, shape: tuple[int, int]) -> Fragments:
    """Pixels whose middles are inside triangles that face the camera.

    Args:
        mesh: Of a robot.
        eye: The camera, world frame, m.
        R: Camera to world.
        low: Right and lower edge of the picture in the camera's plane at depth 1, (2,).
        high: Left and upper edge, (2,).
        shape: Rows and columns.
    """
    depth, left, up = R.T @ (mesh.vertices - eye[:, None])
    rows, columns = shape
    with np.errstate(divide="ignore", invalid="ignore"):  # beside the camera, and not drawn
        # in pixels, from the middle of the upper left one to the right and down
        x = (high[0] - left / depth) * (columns / (high[0] - low[0])) - 0.5
        y = (high[1] - up / depth) * (rows / (high[1] - low[1])) - 0.5
        faces: Indices = np.arange(mesh.faces.shape[1])
        if depth.min() <= NEAR:
            faces = np.flatnonzero((depth > NEAR)[mesh.faces].all(axis=0))
        corners = mesh.faces[:, faces]
        xs, ys = [x[c] for c in corners], [y[c] for c in corners]
        area = _area(xs, ys)
    first = [np.maximum(np.ceil(np.minimum(np.minimum(*v[:2]), v[2])), 0.0) for v in (xs, ys)]
    last = [
        np.minimum(np.floor(np.maximum(np.maximum(*v[:2]), v[2])), n - 1)
        for v, n in ((xs, columns), (ys, rows))
    ]
    chosen = np.flatnonzero((area > 0.0) & (last[0] >= first[0]) & (last[1] >= first[1]))
    # every pixel of the rectangle around each triangle
    x0, y0, wide = (v[chosen].astype(int) for v in (*first, last[0] - first[0] + 1.0))
    count = wide * (last[1] - first[1] + 1.0)[chosen].astype(int)
    of = np.repeat(np.arange(len(chosen)), count)
    down, right = np.divmod(np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count), wide[of])
    px, py = x0[of] + right, y0[of] + down
    triangle = chosen[of]
    xs, ys = [v[triangle] for v in xs], [v[triangle] for v in ys]
    weights = [_area([px, xs[a], xs[b]], [py, ys[a], ys[b]]) for a, b in ((1, 2), (2, 0), (0, 1))]
    inside = np.flatnonzero((weights[0] >= 0.0) & (weights[1] >= 0.0) & (weights[2] >= 0.0))
    triangle = triangle[inside]
    # 1 / depth is linear in the picture
    nearness = (
        sum(w[inside] / depth[c[triangle]] for w, c in zip(weights, corners, strict=True)) / area[triangle]
    )
    order = np.argsort(nearness)
    chosen = inside[order]
    return Fragments(py[chosen], px[chosen], 1.0 / nearness[order], faces[triangle[order]])


def _area(x: list[Array], y: list[Array]) -> Array:
    """Twice the areas of triangles in the picture, positive where a face is seen from outside."""
    area: Array = (x[2] - x[0]) * (y[1] - y[0]) - (x[1] - x[0]) * (y[2] - y[0])
    return area
