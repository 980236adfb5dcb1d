"""Colours, sizes and points of the pictures, live and exported."""

from __future__ import annotations

from typing import Final, NamedTuple

from nao_hil.view.looks import Colour

PLANNED: Final[Colour] = (51, 154, 240)
MEASURED: Final[Colour] = (255, 146, 43)
TRUE: Final[Colour] = (64, 192, 87)
CAPTURE: Final[Colour] = (204, 93, 232)
COM: Final[Colour] = (250, 82, 82)
SAFE: Final[Colour] = (32, 201, 151)
LOST: Final[Colour] = (250, 82, 82)
PUSH: Final[Colour] = (252, 196, 25)
OBSTACLE: Final[Colour] = (212, 163, 92)
GROUND: Final[Colour] = (104, 92, 72)
CELLS: Final[tuple[Colour, Colour]] = ((214, 218, 224), (62, 66, 74))
SECTIONS: Final[tuple[Colour, Colour]] = ((176, 182, 190), (92, 98, 108))
"""Lines of the floor on a light and on a dark page."""
PRINTS: Final[dict[str, Colour]] = {"planned": PLANNED, "made": (173, 181, 189)}
"""Colours of the footprints."""

NEWTON: Final = 0.006
"""Height of a load's bar, m/N: 150 mm for a full cell."""
BARS_OVER: Final = 0.02
"""Height over the sole at which the bars begin, m."""
OVER: Final = 0.002
"""Height of what is drawn on the floor over it, m."""
ROOT: Final = "/world"
"""Frame that all is drawn in: to follow the robot it moves the other way, so that the camera is free."""


class Point(NamedTuple):
    """A point of the balance: its name on the page, and its colour."""

    name: str
    label: str
    colour: Colour
    radius: float
    meaning: str
    """For somebody who sees it for the first time."""


POINTS: Final = (
    Point(
        "zmp_plan", "ZMP planned", PLANNED, 0.008, "where the ground is meant to push back (zero moment point)"
    ),
    Point("zmp_fsr", "ZMP by the FSR", MEASURED, 0.008, "where the foot sensors feel it"),
    Point("zmp_true", "ZMP true", TRUE, 0.008, "where it does; at the edge of the feet the robot tips"),
    Point("com", "centre of mass", COM, 0.012, "of the whole robot"),
    Point("com_ground", "its projection", COM, 0.006, "on the ground"),
    Point(
        "capture",
        "capture point",
        CAPTURE,
        0.009,
        "where a foot would have to be for the robot to come to rest",
    ),
)
