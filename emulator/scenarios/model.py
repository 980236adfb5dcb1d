"""A scenario: where the robot stands, what the ground is like, and what happens when.

Lengths in m, masses in kg, times in s from the first frame. Angles are typed by a person: degrees. Positions
are in the floor frame: origin where the robot starts by default, x in its heading, z along the floor's normal.
"""

from __future__ import annotations

import math
from typing import Annotated

import msgspec

from bridge.config import unknown_name
from bridge.faults import DcmPause, Fault
from bridge.joints import INDEX_WITH_MIRROR
from bridge.messages import Vec2, Vec3
from bridge.world import Foot, least_tilt_time

Positive = Annotated[float, msgspec.Meta(gt=0.0, le=1000.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0, le=1e6)]
Slope = Annotated[float, msgspec.Meta(ge=-34.0, le=34.0)]
Degrees = Annotated[float, msgspec.Meta(ge=-360.0, le=360.0)]
Friction = Annotated[float, msgspec.Meta(ge=0.0, le=10.0)]
Seed = Annotated[int, msgspec.Meta(ge=0)]
Plane = tuple[Positive, Positive]
Size = tuple[Positive, Positive, Positive]


class _Table(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True):
    """Base: frozen, a misspelt key is an error, and what is left at its default is not written."""


class Floor(_Table, frozen=True, kw_only=True):
    """The floor; Ry(pitch) Rx(roll) about the origin."""

    friction: Friction | None = None
    """Coulomb coefficient against soles; none: the emulator's own, 0.8."""
    roll: Slope = 0.0
    """Degrees; positive raises the left."""
    pitch: Slope = 0.0
    """Degrees; positive lowers the front: downhill."""


class Start(_Table, frozen=True, kw_only=True):
    """How the robot begins; its soles are parallel to the floor."""

    posture: str = "StandInit"
    x: float = 0.0
    y: float = 0.0
    yaw: Degrees = 0.0


class PlacedBox(_Table, frozen=True, kw_only=True):
    """A plate, a step, a wall; or a box that can be pushed about."""

    name: Annotated[str, msgspec.Meta(pattern=r"^[A-Za-z0-9_-]{1,64}$")]
    size: Size
    at: Vec2
    """Middle of its bottom."""
    yaw: Degrees = 0.0
    height: float | None = None
    """Of its bottom over the floor; none: it lies on what is there."""
    mass: NotNegative = 0.0
    """0: fixed on the floor."""
    friction: Friction | None = None
    """Against the soles; none: as the floor."""


class Tiles(_Table, frozen=True, kw_only=True):
    """Square tiles of random height."""

    area: Plane
    """Along x and y."""
    height: Positive
    """Of the highest."""
    edge: Positive = 0.1
    centre: Vec2 = (0.0, 0.0)
    free: NotNegative = 0.25
    """Radius about the origin that has no tiles."""
    seed: Seed | None = None
    """None: the tiles follow the seed of the run."""


class Heightfield(_Table, frozen=True, kw_only=True):
    """A grid of heights: given, from a CSV file, or random."""

    spacing: Positive = 0.05
    centre: Vec2 = (0.0, 0.0)
    heights: tuple[tuple[NotNegative, ...], ...] = ()
    """Rows from right to left (y), each from back to front (x)."""
    file: str = ""
    """CSV of the same, beside the scenario."""
    area: Plane = (2.0, 1.0)
    """Of a random one, along x and y."""
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
        if self.heights and len(self.heights[0]) < 2:
            raise ValueError("each row of `heights` needs two or more points")


class _Event(_Table, frozen=True, kw_only=True):
    time: NotNegative
    """Robot time, s."""


class PushEvent(_Event, frozen=True, kw_only=True):
    """A push at a centre of mass, in the torso's heading of that moment."""

    target: str = "Torso"
    """`Torso`, the joint that moves the link, or a movable box."""
    impulse: NotNegative = 0.0
    """N s"""
    direction: Degrees = 0.0
    """In which it pushes: 0 forward, 90 to the left."""
    vector: Vec3 | None = None
    """In place of both: x forward, y left, z up, N s."""
    duration: NotNegative = 0.1

    def __post_init__(self) -> None:
        """Raises ValueError unless it is either a size with a direction or a vector."""
        if (self.impulse > 0.0) == (self.vector is not None):
            raise ValueError("give either `impulse` with `direction`, or `vector`")

    def impulse_vector(self) -> Vec3:
        """Heading frame, N s."""
        if self.vector is not None:
            return self.vector
        angle = math.radians(self.direction)
        return self.impulse * math.cos(angle), self.impulse * math.sin(angle), 0.0


class PlateEvent(_Event, frozen=True, kw_only=True):
    """A plate under a foot, from this time on as soon as the foot is high enough."""

    foot: Foot = "swing"
    size: Size = (0.16, 0.08, 0.01)
    shift: Vec2 = (0.0, 0.0)
    """Along the foot's heading and to its left."""
    name: Annotated[str, msgspec.Meta(pattern=r"^[A-Za-z0-9_-]{1,64}$")] = "plate"


class TiltEvent(_Event, frozen=True, kw_only=True):
    """The floor turns to this tilt about the point under the torso."""

    roll: Slope = 0.0
    pitch: Slope = 0.0
    duration: NotNegative = 1.0


class FrictionEvent(_Event, frozen=True, kw_only=True):
    """The floor's friction changes."""

    friction: Friction


class PendulumEvent(_Event, frozen=True, kw_only=True):
    """A pendulum is let go and strikes the robot."""

    mass: Positive
    """Of the bob."""
    length: Positive = 1.0
    angle: Annotated[float, msgspec.Meta(gt=0.0, le=85.0)]
    """From the vertical at the release, degrees."""
    direction: Degrees = 0.0
    """In which it strikes: 0 from behind, 90 from the right, 180 from the front."""
    height: Positive | None = None
    """Of the strike over the floor; none: the torso's centre of mass."""


class FaultEvent(_Event, frozen=True, kw_only=True):
    """A fault, for a while."""

    duration: NotNegative = 0.0
    """0: to the end."""
    fault: Fault

    def __post_init__(self) -> None:
        """Raises ValueError for a pause of the DCM without an end."""
        if isinstance(self.fault, DcmPause) and self.duration <= 0.0:
            raise ValueError("a pause of the DCM needs a `duration` in s")


class Scenario(_Table, frozen=True, kw_only=True):
    """All there is to a world."""

    title: str = ""
    """One line for people."""
    floor: Floor = Floor()
    start: Start = Start()
    charger: bool = False
    """The robot is on its charger's cable: its battery does not run down."""
    boxes: tuple[PlacedBox, ...] = ()
    tiles: Tiles | None = None
    heightfield: Heightfield | None = None
    pushes: tuple[PushEvent, ...] = ()
    plates: tuple[PlateEvent, ...] = ()
    tilts: tuple[TiltEvent, ...] = ()
    frictions: tuple[FrictionEvent, ...] = ()
    pendulums: tuple[PendulumEvent, ...] = ()
    faults: tuple[FaultEvent, ...] = ()

    def __post_init__(self) -> None:
        """Raises ValueError for what could never happen, so that no run passes because nothing happened to it.

        Two boxes of one name, a push of what no body and no box is, and a floor that turns too fast.
        """
        names = [box.name for box in self.boxes]
        if len(set(names)) != len(names):
            raise ValueError(f"two boxes have the same name; there are {', '.join(names)}")
        movable = {box.name for box in self.boxes if box.mass > 0.0}
        targets = {"Torso", *INDEX_WITH_MIRROR, *movable} - {"LHand", "RHand"}
        for push in self.pushes:
            if push.target not in targets:
                raise ValueError(f"pushes: {unknown_name('target', push.target, targets)}")
        at, until = (self.floor.roll, self.floor.pitch), 0.0
        for tilt in sorted(self.tilts, key=lambda event: event.time):
            turn = math.radians(max(abs(tilt.roll - at[0]), abs(tilt.pitch - at[1])))
            least = least_tilt_time(turn)
            # one that cuts another short begins somewhere on its way, and is judged there and then
            if tilt.time >= until and tilt.duration < least:
                raise ValueError(
                    f"tilts: the turn at {tilt.time:g} s needs a duration of {least:.3g} s or more"
                )
            at, until = (tilt.roll, tilt.pitch), tilt.time + tilt.duration
