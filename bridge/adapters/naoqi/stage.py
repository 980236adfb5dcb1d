"""What is around a served robot: things that somebody shows it, and words that somebody says to it.

The service `NaoHil` takes both: words, as the emulated robot has no microphones, and things for a robot whose
world is not emulated. What a camera sees of these follows from where they are, and from where the robot and its
head are by its sensors. Things of an emulated world are seen by the cameras (`eyes`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, cast

from bridge.adapters.naoqi.arguments import number, text
from bridge.adapters.naoqi.eyes import Eyes
from bridge.adapters.naoqi.frames import RobotFrames, inverse
from bridge.adapters.naoqi.methods import Table
from bridge.body import Body
from bridge.body.cameras import cameras
from bridge.errors import NaoqiRefused
from bridge.messages.world import THING_SIZES
from bridge.messages.world import ThingKind as Kind
from bridge.types import Array, Vec3
from bridge.validation import unknown_name

RANGE: Final = 3.0
"""m within which a thing is detected (assumed: 2 to 3 m in the vendor's pages)."""
MAX_THINGS: Final = 100


@dataclass(frozen=True)
class ShownThing:
    """Something that can be seen."""

    kind: Kind
    name: str
    place: Vec3
    """In the world's space, m."""
    size: float
    """Diameter, m."""


@dataclass(frozen=True)
class Sighting:
    """A thing as a camera sees it."""

    name: str
    alpha: float
    """To the left of the picture's middle, rad."""
    beta: float
    """Below the picture's middle, rad."""
    size: float
    """Angle that it fills, rad."""
    links: Mapping[str, Array]
    """Links in the Torso frame, with the head as it was when the camera saw this, each (4, 4), m."""


class Stage:
    """Things around the robot; not thread-safe, the caller locks.

    Args:
        body: of the robot.
        frames: of the robot.
        eyes: that see things of its world.
        hear: gets what is said to the robot; returns the words that it recognized.
    """

    def __init__(self, body: Body, frames: RobotFrames, eyes: Eyes, hear: Callable[[str], list[str]]) -> None:
        self._frames, self._eyes, self._hear = frames, eyes, hear
        self._cameras = cameras(body)
        self._things: dict[tuple[str, str], ShownThing] = {}

    def seen(self, kind: Kind, camera: int) -> Iterator[Sighting]:
        """Things of a kind in the field of view of camera 0 (top) or 1 (bottom), the largest first."""
        across, down = self._cameras[camera].field
        found = []
        for what, name, place, diameter, links in self._around(camera):
            x, y, z = place
            distance = math.sqrt(x * x + y * y + z * z)
            if what != kind or x <= 0.0 or distance > RANGE:
                continue
            alpha, beta = math.atan2(y, x), -math.atan2(z, x)
            if abs(alpha) <= 0.5 * across and abs(beta) <= 0.5 * down:
                size = 2.0 * math.asin(min(1.0, 0.5 * diameter / distance))
                found.append(Sighting(name, alpha, beta, size, links))
        yield from sorted(found, key=lambda sighting: -sighting.size)

    def _around(self, camera: int) -> Iterator[tuple[str, str, Sequence[float], float, Mapping[str, Array]]]:
        """Kind, name, place in the camera's frame (m), diameter (m) and the robot's links, of all things."""
        for seen_by, kind, name, place, diameter, head in self._eyes.sights():
            if seen_by == camera:
                yield kind, name, place, diameter, self._frames.measured_links(head)
        if self._things:
            links = self._frames.measured_links()
            in_torso = self._frames.in_torso(self._cameras[camera].name, links)
            to_camera = inverse(in_torso) @ self._frames.space(1, links, True)
            for thing in self._things.values():
                x, y, z, _ = (float(part) for part in to_camera @ (*thing.place, 1.0))
                yield thing.kind, thing.name, (x, y, z), thing.size, links

    def show(self, kind: Any, name: Any, place: Any, size: Any = None) -> None:
        """Put a thing into the world, or move it.

        Args:
            kind: `face`, `landmark` or `ball`.
            name: of the face; the number of the landmark.
            place: in the world's space, `[x, y, z]`, m.
            size: diameter, m.
        """
        what, which = _kind(kind), _name(kind, name)
        if not isinstance(place, list) or len(place) != 3:
            raise NaoqiRefused(f"NaoHil.show: {place!r:.60} was given; [x, y, z] in m is expected.")
        x, y, z = (number(item, "NaoHil.show: place", -1e3, 1e3) for item in place)
        wide = THING_SIZES[what] if size is None else number(size, "NaoHil.show: size", 0.001, 10.0)
        if (what, which) not in self._things and len(self._things) >= MAX_THINGS:
            raise NaoqiRefused(f"NaoHil.show: {MAX_THINGS} things are shown already; hide some.")
        self._things[what, which] = ShownThing(cast(Kind, what), which, (x, y, z), wide)

    def _hide(self, kind: Any, name: Any) -> None:
        self._things.pop((_kind(kind), _name(kind, name)), None)

    def methods(self) -> Table:
        """Methods of the service `NaoHil`."""
        return {
            "show": self.show,
            "hide": self._hide,
            "things": lambda: [[t.kind, t.name, list(t.place), t.size] for t in self._things.values()],
            "hear": lambda words: self._hear(text(words, "NaoHil.hear: words")),
        }


def _kind(kind: Any) -> str:
    what = text(kind, "NaoHil: kind")
    if what not in THING_SIZES:
        raise NaoqiRefused(f"NaoHil: {unknown_name('kind', what, THING_SIZES)}.")
    return what


def _name(kind: Any, name: Any) -> str:
    which = str(name) if isinstance(name, int) and not isinstance(name, bool) else text(name, "NaoHil: name")
    if kind == "landmark" and not which.isdecimal():
        raise NaoqiRefused(f"NaoHil: the landmark {which!r:.40} has no number.")
    return which
