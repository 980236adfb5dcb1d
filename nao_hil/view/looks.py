"""What a NAO looks like on the page: rounded primitive shapes, sized from the data sheet.

Looks only: what may touch the world has shapes of its own in the emulator. The sole is the published outline.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial import ConvexHull

from bridge.body import TORSO, Body
from bridge.body.sole import sole_hull
from bridge.messages.world_state import Terrain
from bridge.types import Side

Floats = npt.NDArray[np.float64]
Faces = npt.NDArray[np.int64]
Colour = tuple[int, int, int]
Ball = tuple[float, float, float, float]
"""Centre and radius, m."""

WHITE: Final[Colour] = (236, 238, 242)
GREY: Final[Colour] = (104, 110, 120)
BLUE: Final[Colour] = (47, 110, 200)
DARK: Final[Colour] = (44, 47, 54)
LIGHT: Final[Colour] = (90, 200, 250)

_POINTS: Final = 160
"""On each ball; enough to look round."""
_SQUARE: Final = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
_SIDES_AND_TOP: Final = np.array(
    [[4, 5, 6], [4, 6, 7]]
    + [[[a, b, b + 4], [a, b + 4, a + 4]][k] for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)) for k in (0, 1)]
)
"""Faces of a tile whose lower corners are 0 to 3 and upper ones 4 to 7, outward."""
_SHELL: Final = 0.012
"""Thickness of the sole's plate, m."""


class ColouredMesh(NamedTuple):
    """One coloured piece of a link, in the link's frame."""

    vertices: Floats
    """(n, 3), m."""
    faces: Faces
    """(m, 3), outward."""
    colour: Colour


def _sphere() -> Floats:
    """Points spread evenly over the unit sphere (golden spiral), shape (n, 3)."""
    i = np.arange(_POINTS) + 0.5
    z = 1.0 - 2.0 * i / _POINTS
    around = np.pi * (1.0 + np.sqrt(5.0)) * i
    radius = np.sqrt(1.0 - z * z)
    return np.column_stack([radius * np.cos(around), radius * np.sin(around), z])


_SPHERE: Final = _sphere()


def _hull(points: Floats, colour: Colour) -> ColouredMesh:
    """Convex hull with its faces turned outward."""
    hull = ConvexHull(points)
    used, faces = np.unique(hull.simplices, return_inverse=True)
    vertices, faces = points[used], faces.reshape(-1, 3)
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return ColouredMesh(vertices, faces, colour)


def _blob(balls: Sequence[Ball], colour: Colour, grow: float) -> ColouredMesh:
    """Convex hull of balls."""
    return _hull(np.vstack([np.array(b[:3]) + (b[3] + grow) * _SPHERE for b in balls]), colour)


def _balls(body: Body) -> dict[str, list[tuple[list[Ball], Colour]]]:
    """Pieces of the links but the feet, by the name of the joint that moves them."""
    d = body.lengths
    hip, shoulder, top = d.HipOffsetZ, d.ShoulderOffsetY, d.ShoulderOffsetZ
    chest: list[Ball] = [(0.0, s * (shoulder - 0.045), top - 0.01, 0.034) for s in (1.0, -1.0)]
    chest += [(0.022, s * 0.026, 0.06, 0.042) for s in (1.0, -1.0)]
    chest += [(-0.02, s * 0.03, 0.06, 0.042) for s in (1.0, -1.0)]
    chest += [(0.0, s * 0.012, -0.012, 0.044) for s in (1.0, -1.0)]
    pelvis: list[Ball] = [(0.0, s * 0.036, 0.028 - hip, 0.034) for s in (1.0, -1.0)]
    pelvis += [(0.0, s * 0.01, 0.045 - hip, 0.042) for s in (1.0, -1.0)]
    head: list[Ball] = [(0.004, 0.0, 0.062, 0.056), (0.02, 0.0, 0.045, 0.042)]
    head += [(0.0, s * 0.046, 0.056, 0.026) for s in (1.0, -1.0)]
    pieces: dict[str, list[tuple[list[Ball], Colour]]] = {
        TORSO: [(chest, WHITE), (pelvis, GREY), ([(0.062, 0.0, 0.058, 0.012)], LIGHT)],
        "HeadYaw": [([(0.0, 0.0, -0.02, 0.022), (0.0, 0.0, 0.005, 0.022)], GREY)],
        "HeadPitch": [
            (head, WHITE),
            *[([(0.052, s * 0.025, 0.066, 0.0125)], LIGHT) for s in (1.0, -1.0)],
            ([(0.055, 0.0, 0.032, 0.009)], DARK),
        ],
    }
    hand = d.LowerArmLength + d.HandOffsetX
    for side in ("L", "R"):
        s = 1.0 if side == "L" else -1.0
        pieces |= {
            f"{side}ShoulderPitch": [([(0.0, 0.0, 0.0, 0.032)], GREY)],
            f"{side}ShoulderRoll": [
                ([(0.01, s * 0.004, 0.0, 0.029), (d.UpperArmLength, s * 0.01, 0.0, 0.023)], WHITE)
            ],
            f"{side}ElbowRoll": [
                ([(0.0, 0.0, 0.0, 0.022), (0.04, 0.0, 0.0, 0.027), (hand - 0.035, 0.0, 0.0, 0.023)], BLUE),
                ([(hand - 0.012, 0.0, 0.0, 0.021), (hand + 0.004, 0.0, -0.008, 0.016)], GREY),
            ],
            f"{side}HipRoll": [([(0.0, 0.0, 0.0, 0.033)], GREY)],
            f"{side}HipPitch": [
                (
                    [
                        (0.004, 0.0, -0.022, 0.036),
                        (0.008, 0.0, -0.55 * d.ThighLength, 0.038),
                        (0.002, 0.0, 0.012 - d.ThighLength, 0.029),
                    ],
                    WHITE,
                )
            ],
            f"{side}KneePitch": [
                ([(0.004, 0.0, 0.0, 0.031)], GREY),
                (
                    [
                        (0.010, 0.0, -0.025, 0.031),
                        (0.008, 0.0, -0.5 * d.TibiaLength, 0.036),
                        (0.0, 0.0, 0.02 - d.TibiaLength, 0.027),
                    ],
                    BLUE,
                ),
            ],
            f"{side}AnklePitch": [([(0.0, 0.0, 0.0, 0.026)], GREY)],
        }
    return pieces


def _foot(body: Body, side: Side, grow: float) -> list[ColouredMesh]:
    """The sole's plate with the published outline, and a shell over it."""
    outline, low = sole_hull(body, side), -body.lengths.FootHeight
    middle = outline.mean(axis=0)
    plate = np.vstack(
        [np.column_stack([outline, np.full(len(outline), z)]) for z in (low - grow, low + _SHELL + grow)]
    )
    rim = middle + 0.94 * (outline - middle)
    shell = np.vstack(
        [
            np.column_stack([rim, np.full(len(rim), low + _SHELL)]),
            np.column_stack([middle + 0.8 * (outline - middle), np.full(len(rim), low + 0.022)]),
            np.array([0.0, 0.0, -0.012]) + (0.026 + grow) * _SPHERE,
        ]
    )
    return [_hull(plate, DARK), _hull(shell, WHITE)]


def terrain_meshes(terrain: Terrain) -> list[tuple[Floats, Faces]]:
    """Vertices (n, 3), m, floor frame, and faces (m, 3) of all tiles in one mesh, and of the heights."""
    meshes = []
    if terrain.tiles:
        corners = np.array([(x, y, z) for z in (0.0, 1.0) for x, y in _SQUARE])
        scale = np.array([(tile.edge, tile.edge, tile.height) for tile in terrain.tiles])
        at = np.array([(*tile.at, 0.0) for tile in terrain.tiles])
        vertices = (corners[None] * scale[:, None] + at[:, None]).reshape(-1, 3)
        faces = (_SIDES_AND_TOP[None] + len(corners) * np.arange(len(at))[:, None, None]).reshape(-1, 3)
        meshes.append((vertices, faces))
    if terrain.grid is not None:
        z = np.array(terrain.grid.heights)
        rows, columns = z.shape
        x = terrain.grid.centre[0] + terrain.grid.spacing * (np.arange(columns) - 0.5 * (columns - 1))
        y = terrain.grid.centre[1] + terrain.grid.spacing * (np.arange(rows) - 0.5 * (rows - 1))
        vertices = np.stack([*np.meshgrid(x, y), z], axis=-1).reshape(-1, 3)
        first = (columns * np.arange(rows - 1)[:, None] + np.arange(columns - 1)).ravel()
        lower = np.column_stack([first, first + 1, first + columns])
        upper = np.column_stack([first + 1, first + columns + 1, first + columns])
        meshes.append((vertices, np.vstack([lower, upper])))
    return meshes


def link_parts(body: Body, grow: float = 0.0) -> dict[str, list[ColouredMesh]]:
    """The pieces of each link that has any, by the name of the joint that moves it.

    Args:
        body: The data sheet.
        grow: Added to all radii, m: a ghost that is drawn over the robot must be a little larger.
    """
    parts = {
        name: [_blob(balls, colour, grow) for balls, colour in pieces] for name, pieces in _balls(body).items()
    }
    sides: tuple[Side, Side] = ("L", "R")
    for side in sides:
        parts[f"{side}AnkleRoll"] = _foot(body, side, grow)
    return parts
