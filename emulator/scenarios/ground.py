"""The ground of a scenario: floor, start, boxes, tiles, heightfield; and the base of all its tables."""

from __future__ import annotations

from typing import Annotated, Final, Literal, get_args

import msgspec

from bridge.body.postures import POSTURES
from bridge.messages.world import Friction, SolidShape, StartName, ThingKind, solid_fault
from bridge.types import Bounded, Vec2
from bridge.validation import unknown_name

Positive = Annotated[float, msgspec.Meta(gt=0.0, le=1000.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0, le=1e6)]
Slope = Annotated[float, msgspec.Meta(ge=-34.0, le=34.0)]
Degrees = Annotated[float, msgspec.Meta(ge=-360.0, le=360.0)]
Seed = Annotated[int, msgspec.Meta(ge=0)]
Plane = tuple[Positive, Positive]
Size = tuple[Positive, Positive, Positive]


class ScenarioTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True):
    """Base: frozen, a misspelt key is an error, and a default is not written."""


START_NAMES: Final[tuple[str, ...]] = get_args(StartName)
"""Names of the start poses; their meaning: `emulator.start.START_POSES`."""
MAX_TILES: Final = 10_000
MAX_POINTS: Final = 250_000
"""Most points of a heightfield."""


class ScenarioFloor(ScenarioTable, frozen=True, kw_only=True):
    """The floor; Ry(pitch) Rx(roll) about the origin."""

    surface: Literal["wood", "carpet", "turf"] = "wood"
    """Friction and softness under the soles (assumed: `emulator.world.world`)."""
    friction: Friction | None = None
    """Coulomb coefficient against soles; none: the surface's, 0.8 on wood."""
    stiffness: Annotated[float, msgspec.Meta(ge=1e5, le=1e9)] | None = None
    """Pressure of sole and floor per depth, N/m^3; none: the surface's, 6e7 on wood."""
    roll: Slope = 0.0
    """Degrees; positive raises the left."""
    pitch: Slope = 0.0
    """Degrees; positive lowers the front: downhill."""


class Start(ScenarioTable, frozen=True, kw_only=True):
    """Start of the robot."""

    pose: StartName = "stand"
    """`stand`: in `posture`, its soles parallel to the floor; or sitting, lying, hanging, see
    `emulator.start.START_POSES`."""
    posture: str = "StandInit"
    x: Bounded = 0.0
    y: Bounded = 0.0
    yaw: Degrees = 0.0

    def __post_init__(self) -> None:
        """Raises ValueError for an unknown posture."""
        if self.posture not in POSTURES:
            raise ValueError(unknown_name("posture", self.posture, POSTURES))


class PlacedBox(ScenarioTable, frozen=True, kw_only=True):
    """A plate, a step, a wall; or a box that can be pushed about; or a ball or a pole."""

    name: Annotated[str, msgspec.Meta(pattern=r"^[A-Za-z0-9_-]{1,64}$")]
    shape: SolidShape = "box"
    size: Size
    """Size of a ball three times its diameter."""
    at: Vec2
    """Middle of its bottom."""
    yaw: Degrees = 0.0
    height: float | None = None
    """Height of its bottom over the floor; none: it rests on the ground under it."""
    mass: NotNegative = 0.0
    """0: fixed on the floor."""
    friction: Friction | None = None

    def __post_init__(self) -> None:
        """Raises ValueError for a size or a mass that the shape cannot have."""
        if fault := solid_fault(self.shape, self.size, self.mass):
            raise ValueError(fault.rstrip("."))

    """Against the soles; none: as the floor."""


class PlacedThing(ScenarioTable, frozen=True, kw_only=True):
    """A red ball, a landmark or a face, for the cameras."""

    name: Annotated[str, msgspec.Meta(pattern=r"^[A-Za-z0-9_-]{1,64}$")]
    """Name: a landmark's number, a face's person."""
    kind: ThingKind
    at: Vec2
    """Its middle."""
    height: float | None = None
    """Height of its middle over the floor; none: a ball rests there, the others are at eye level."""
    yaw: Degrees = 180.0
    """Heading to which a landmark or a face shows its front; 180: towards where the robot starts."""
    size: Positive | None = None
    """Diameter; none: the kind's."""

    def __post_init__(self) -> None:
        """Raises ValueError for a landmark without a number."""
        if self.kind == "landmark" and not self.name.isdecimal():
            raise ValueError(f"a landmark's name is its number, not {self.name!r}")


class Tiles(ScenarioTable, frozen=True, kw_only=True):
    """Square tiles of random height."""

    area: Plane
    """Along x and y."""
    height: Positive
    """Height of the highest."""
    edge: Positive = 0.1
    centre: Vec2 = (0.0, 0.0)
    free: NotNegative = 0.25
    """Radius about the origin that has no tiles."""
    seed: Seed | None = None
    """None: the tiles follow the seed of the run."""

    def __post_init__(self) -> None:
        """Raises ValueError for more tiles than an engine can hold."""
        count = self.area[0] / self.edge * self.area[1] / self.edge
        if count > MAX_TILES:
            raise ValueError(f"{count:.0f} tiles; at most {MAX_TILES}: a smaller area, or longer edges")


class Heightfield(ScenarioTable, frozen=True, kw_only=True):
    """A grid of heights: given, from a CSV file, or random."""

    spacing: Positive = 0.05
    centre: Vec2 = (0.0, 0.0)
    heights: tuple[tuple[NotNegative, ...], ...] = ()
    """Rows from right to left (y), each from back to front (x)."""
    file: str = ""
    """CSV of the same, in the scenario's folder."""
    area: Plane = (2.0, 1.0)
    """Area of a random one, along x and y."""
    roughness: NotNegative = 0.0
    """Greatest height of a random one."""
    seed: Seed | None = None
    """None: a random one follows the seed of the run."""

    def __post_init__(self) -> None:
        """Raises ValueError unless there is one source of heights, and a grid."""
        if (bool(self.heights) + bool(self.file) + (self.roughness > 0.0)) != 1:
            raise ValueError("give one of `heights`, `file` and `roughness`")
        if self.heights and (len(self.heights) < 2 or len({len(row) for row in self.heights}) != 1):
            raise ValueError("`heights` needs two or more rows of one length")
        if (points := sum(map(len, self.heights))) > MAX_POINTS:
            raise ValueError(f"`heights` has {points} points; at most {MAX_POINTS} are allowed")
        if self.heights and len(self.heights[0]) < 2:
            raise ValueError("each row of `heights` needs two or more points")
        count = self.area[0] / self.spacing * self.area[1] / self.spacing
        if self.roughness > 0.0 and count > MAX_POINTS:
            raise ValueError(f"{count:.0f} points; at most {MAX_POINTS}: a smaller area, or a wider spacing")
