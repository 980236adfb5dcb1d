"""A scenario: the robot's start, the ground, and the events.

Lengths in m, masses in kg, times in s from the first frame. Angles are typed by a person: degrees. Positions
are in the floor frame: origin where the robot starts by default, x in its heading, z along the floor's normal.
"""

from __future__ import annotations

import math
from typing import Annotated, Final

import msgspec

from bridge.body.joints import INDEX_WITH_MIRROR
from bridge.messages.world import min_tilt_duration
from bridge.validation import unknown_name
from emulator.scenarios.events import FaultEvent, FrictionEvent, PendulumEvent, PlateEvent, PushEvent, TiltEvent
from emulator.scenarios.ground import Heightfield, PlacedBox, PlacedThing, ScenarioFloor, Start, Tiles
from emulator.scenarios.table import ScenarioTable

MAX_BOXES: Final = 1000
MAX_THINGS: Final = 100


class Scenario(ScenarioTable, frozen=True, kw_only=True):
    """All there is to a world."""

    title: Annotated[str, msgspec.Meta(max_length=200)] = ""
    """One line for people."""
    floor: ScenarioFloor = ScenarioFloor()
    start: Start = Start()
    charger: bool = False
    """The robot is on its charger's cable: its battery does not run down."""
    boxes: Annotated[tuple[PlacedBox, ...], msgspec.Meta(max_length=MAX_BOXES)] = ()
    things: Annotated[tuple[PlacedThing, ...], msgspec.Meta(max_length=MAX_THINGS)] = ()
    tiles: Tiles | None = None
    heightfield: Heightfield | None = None
    pushes: tuple[PushEvent, ...] = ()
    plates: tuple[PlateEvent, ...] = ()
    tilts: tuple[TiltEvent, ...] = ()
    frictions: tuple[FrictionEvent, ...] = ()
    pendulums: tuple[PendulumEvent, ...] = ()
    faults: tuple[FaultEvent, ...] = ()

    def __post_init__(self) -> None:
        """Raises ValueError for events that could never happen, so that no run passes without its disturbance.

        These are two boxes or things of one name, a push of an unknown target, and a floor that turns too fast.
        """
        names = [*(box.name for box in self.boxes), *(thing.name for thing in self.things)]
        if len(set(names)) != len(names):
            raise ValueError(f"two boxes or things have the same name; there are {', '.join(names)}")
        movable = {box.name for box in self.boxes if box.mass > 0.0}
        targets = {"Torso", *INDEX_WITH_MIRROR, *movable} - {"LHand", "RHand"}
        for push in self.pushes:
            if push.target not in targets:
                raise ValueError(f"pushes: {unknown_name('target', push.target, targets)}")
        at, until = (self.floor.roll, self.floor.pitch), 0.0
        for tilt in sorted(self.tilts, key=lambda event: event.time):
            turn = math.radians(max(abs(tilt.roll - at[0]), abs(tilt.pitch - at[1])))
            shortest = min_tilt_duration(turn)
            # one that cuts another short begins somewhere on its way, and is judged there and then
            if tilt.time >= until and tilt.duration < shortest:
                raise ValueError(
                    f"tilts: the turn at {tilt.time:g} s needs a duration of {shortest:.3g} s or more"
                )
            at, until = (tilt.roll, tilt.pitch), tilt.time + tilt.duration
