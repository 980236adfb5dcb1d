"""Lines and poses in viser's conventions."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from bridge.types import Array, Quaternion
from nao_hil.view.looks import Colour


def add_lines(scene: Any, name: str, n: int, colour: Colour, width: float, *, each: bool = False) -> Any:
    """Lines of one colour; `each`: a colour for each point, which later ones of the same shape replace."""
    points = np.zeros((n, 2, 3), dtype=np.float32)
    colours = line_colour(colour)
    if each:
        colours = np.tile(colours, (n, 2, 1))
    return scene.add_line_segments(name, points, colours, thickness=width, thickness_units="screen")


def line_colour(colour: Colour) -> Any:
    """The colour to give to a line that is to look like this: lines are drawn without the screen's gamma."""
    return np.array([round(255.0 * (c / 255.0) ** 2.2) for c in colour], dtype=np.uint8)


def closed(corners: Array) -> Any:
    """The edges of a polygon, shape (n, 2, 3), of its corners (n, 3)."""
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1).astype(np.float32)


def quaternions(R: Array) -> Array:
    """Unit quaternions (w, x, y, z) of rotation matrices, shape (n, 4) of (n, 3, 3)."""
    xyzw = Rotation.from_matrix(R).as_quat()
    wxyz: Array = xyzw[:, [3, 0, 1, 2]]
    return wxyz


def wxyz(quaternion: Quaternion) -> tuple[float, float, float, float]:
    """A quaternion (x, y, z, w) in viser's order."""
    x, y, z, w = quaternion
    return w, x, y, z


def show(handle: Any, visible: bool) -> None:
    """Show or hide; a word to the browser only where that changes."""
    if handle.visible != visible:
        handle.visible = visible
