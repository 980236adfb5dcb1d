"""The two cameras in the head: their places and their fields of view.

Sources: vendor's pages on the video cameras, NAOqi 1.14 (V3, V4), 2.1 (V4, V5) and 2.8 (V6); the places also in
the vendor's URDFs (confirmed).
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from bridge.body.model import Body
from bridge.types import Vec2, Vec3

CAMERA_LINK: Final = "HeadPitch"
"""Link that carries both."""


class Camera(NamedTuple):
    """One camera: a pinhole without distortion (assumed), whose pixels are square within 0.2 %."""

    name: str
    place: Vec3
    """In the frame of its link, m."""
    pitch: float
    """Pitch of its axis below the link's x axis, rad."""
    field: Vec2
    """Horizontal and vertical field of view, rad."""
    largest: int
    """Columns of its largest picture; each has three rows for four columns."""


def cameras(body: Body) -> tuple[Camera, Camera]:
    """Top and bottom camera of a body."""
    generation = body.base.removeprefix("nao-v")[:1]
    field = {"3": (47.8, 36.8), "6": (56.3, 43.7)}.get(generation, (60.9, 47.6))
    angles = (math.radians(field[0]), math.radians(field[1]))
    if generation == "3":
        return (
            Camera("CameraTop", (0.0539, 0.0, 0.0679), 0.0, angles, 640),
            Camera("CameraBottom", (0.0488, 0.0, 0.02381), 0.6981, angles, 640),
        )
    largest = 2560 if generation == "6" else 1280
    return (
        Camera("CameraTop", (0.05871, 0.0, 0.06364), 0.0209, angles, largest),
        Camera("CameraBottom", (0.05071, 0.0, 0.01774), 0.6929, angles, 1280),
    )
