"""Colours, sizes and points of the pictures, live and exported."""

from __future__ import annotations

from typing import Final, NamedTuple

from emulator.shell import Colour

PLANNED: Final[Colour] = (51, 154, 240)
MEASURED: Final[Colour] = (255, 146, 43)
TRUE: Final[Colour] = (64, 192, 87)
CAPTURE: Final[Colour] = (204, 93, 232)
COM: Final[Colour] = (250, 82, 82)
SAFE: Final[Colour] = (32, 201, 151)
LOST: Final[Colour] = (250, 82, 82)
OBSTACLE: Final[Colour] = (212, 163, 92)
GROUND: Final[Colour] = (104, 92, 72)
PRINTS: Final[dict[str, Colour]] = {"planned": PLANNED, "made": (173, 181, 189)}
"""Colours of the footprints."""

NEWTON: Final = 0.006
"""Height of a load's bar, m/N: 150 mm for a full cell."""
BARS_OVER: Final = 0.02
"""Height over the sole at which the bars begin, m."""
OVER: Final = 0.002
"""Height of what is drawn on the floor over it, m."""


class Point(NamedTuple):
    """A point of the balance: its name on the page, and its colour."""

    name: str
    label: str
    colour: Colour
    radius: float
    overlay: str
    """Switch of the page that shows it: `com`, `capture` or `zmp`."""


POINTS: Final = (
    Point("zmp_plan", "ZMP planned", PLANNED, 0.009, "zmp"),
    Point("zmp_fsr", "ZMP by the FSR", MEASURED, 0.009, "zmp"),
    Point("zmp_true", "ZMP true", TRUE, 0.009, "zmp"),
    Point("com", "centre of mass", COM, 0.014, "com"),
    Point("com_ground", "its projection", COM, 0.007, "com"),
    Point("capture", "capture point", CAPTURE, 0.010, "capture"),
)
