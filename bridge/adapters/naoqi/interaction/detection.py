"""ALFaceDetection, ALLandMarkDetection and ALRedBallDetection, by the geometry of things in view."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Annotated, Any, Final, cast

from bridge.adapters.naoqi.core.cameras import CAMERAS
from bridge.adapters.naoqi.core.frames import position6
from bridge.adapters.naoqi.core.memory import stamp
from bridge.adapters.naoqi.core.motion_tasks import MotionTask
from bridge.adapters.naoqi.core.sensing import VisionExtractor
from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import OneOf, Range, Setting, Vector, offers, text
from bridge.body.cameras import cameras
from bridge.body.kinematics import inverse
from bridge.errors import NaoqiRefused
from bridge.messages.world import THING_SIZES
from bridge.messages.world import ThingKind as Kind
from bridge.types import Array, Vec3

MAX_DISTANCE: Final = 3.0
"""Range of the detection, m (assumed: 2 to 3 m in the vendor's pages)."""
MAX_THINGS: Final = 100


@dataclass(frozen=True)
class ShownThing:
    """A visible thing."""

    kind: Kind
    name: str
    place: Vec3
    """In the world's space, m."""
    size: float
    """Diameter, m."""


@dataclass(frozen=True)
class Sighting:
    """A thing in a camera's picture."""

    name: str
    alpha: float
    """To the left of the picture's middle, rad."""
    beta: float
    """Below the picture's middle, rad."""
    size: float
    """Its angular size, rad."""
    links: Mapping[str, Array]
    """Links in the Torso frame, with the head's angles at the time of the picture, each (4, 4), m."""


ThingName = Annotated[str, OneOf("kind", THING_SIZES)]
Place = Annotated[list[float], Vector("x, y, z", -1e3, 1e3, "m")]


class Scene(Service):
    """Things around the robot.

    Args:
        hear: utterance -> recognized words.
    """

    def __init__(self, robot: ServedRobot, hear: Callable[[str], list[str]]) -> None:
        super().__init__(robot)
        self._hear = hear
        self._cameras = cameras(robot.body)
        self._things: dict[tuple[str, str], ShownThing] = {}

    def sightings(self, kind: Kind, camera: int) -> Iterator[Sighting]:
        """Things of a kind in the field of view of camera 0 (top) or 1 (bottom), the largest first."""
        across, down = self._cameras[camera].field
        found = []
        for found_kind, name, place, diameter, links in self._nearby(camera):
            x, y, z = place
            distance = math.sqrt(x * x + y * y + z * z)
            if found_kind != kind or x <= 0.0 or distance > MAX_DISTANCE:
                continue
            alpha, beta = math.atan2(y, x), -math.atan2(z, x)
            if abs(alpha) <= 0.5 * across and abs(beta) <= 0.5 * down:
                size = 2.0 * math.asin(min(1.0, 0.5 * diameter / distance))
                found.append(Sighting(name, alpha, beta, size, links))
        yield from sorted(found, key=lambda sighting: -sighting.size)

    def _nearby(self, camera: int) -> Iterator[tuple[str, str, Sequence[float], float, Mapping[str, Array]]]:
        """Kind, name, place in the camera's frame (m), diameter (m) and the robot's links of each thing."""
        for seen_by, kind, name, place, diameter, head in self._robot.feed.sights():
            if seen_by == camera:
                yield kind, name, place, diameter, self._frames.measured_links(head)
        if self._things:
            links = self._frames.measured_links()
            in_torso = self._frames.in_torso(self._cameras[camera].name, links)
            to_camera = inverse(in_torso) @ self._frames.space(1, links, True)
            for thing in self._things.values():
                x, y, z, _ = (float(part) for part in to_camera @ (*thing.place, 1.0))
                yield thing.kind, thing.name, (x, y, z), thing.size, links

    @offers("NaoHil.show")
    def show(
        self, kind: ThingName, name: Any, place: Place, size: Annotated[float, Range(0.001, 10.0)] | None = None
    ) -> None:
        """Put a thing into the world, or move it.

        Args:
            kind: `face`, `landmark` or `ball`.
            name: of the face; the number of the landmark.
            place: in the world's space, `[x, y, z]`, m.
            size: diameter, m.
        """
        key = kind, label = kind, _name(kind, name)
        x, y, z = place
        wide = THING_SIZES[kind] if size is None else size
        if key not in self._things and len(self._things) >= MAX_THINGS:
            raise NaoqiRefused(f"NaoHil.show: {MAX_THINGS} things are shown already; hide some.")
        self._things[key] = ShownThing(cast(Kind, kind), label, (x, y, z), wide)

    @offers("NaoHil.hide")
    def _hide(self, kind: ThingName, name: Any) -> None:
        self._things.pop((kind, _name(kind, name)), None)

    @offers("NaoHil.hear")
    def _hear_words(self, words: str) -> Any:
        return self._hear(words)

    _shown = offers("NaoHil.things")(
        lambda self: [[t.kind, t.name, list(t.place), t.size] for t in self._things.values()]
    )


def _name(kind: Any, name: Any) -> str:
    which = str(name) if isinstance(name, int) and not isinstance(name, bool) else text(name, "NaoHil: name")
    if kind == "landmark" and not which.isdecimal():
        raise NaoqiRefused(f"NaoHil: the landmark {which!r:.40} has no number.")
    return which


PERIOD: Final = 100
"""Default between two results, ms (assumed)."""


LEARN_TIME: Final = 5000
"""ms for which a face to be learnt is looked for (assumed)."""


class Detection(VisionExtractor):
    """One service that detects things of one kind."""

    kind: Kind

    def __init__(self, robot: ServedRobot, scene: Scene) -> None:
        super().__init__(robot)
        self._scene = scene
        self._seen = False
        self._due = 0

    def update(self, now: int) -> None:
        """Raise the event at the subscribers' period, in the cycle at `now` of the robot's clock, ms."""
        if not self.processing or now < self._due:
            return
        self._due = now + max(10, self.period)
        sightings = list(self._scene.sightings(self.kind, self.camera))
        if sightings:
            self._events.raise_event(self.raised[0], self._value(sightings))
        elif self._seen:
            self._events.raise_event(self.raised[0], [])  # once, after the last one
        self._seen = bool(sightings)

    def _value(self, sightings: list[Sighting]) -> list[Any]:
        links = sightings[0].links
        camera = self._frames.in_torso(CAMERAS[self.camera], links)
        poses = [position6(inverse(self._frames.space(space, links, True)) @ camera) for space in (0, 2)]
        return [stamp(), *self._found(sightings), *poses, self._camera_name()]

    def _camera_name(self) -> Any:
        return self.camera

    def _found(self, sightings: list[Sighting]) -> list[Any]:
        one = sightings[0]
        return [[one.alpha, one.beta, 0.5 * one.size, 0.5 * one.size]]  # a ball's sizes are its radii


class Balls(Detection):
    """`ALRedBallDetection`."""

    service, kind = "ALRedBallDetection", "ball"


class LandMarks(Detection):
    """`ALLandMarkDetection`."""

    service, kind = "ALLandMarkDetection", "landmark"

    def _camera_name(self) -> Any:
        return CAMERAS[self.camera]

    def _found(self, sightings: list[Sighting]) -> list[Any]:
        return [[[[1, s.alpha, s.beta, s.size, s.size, 0.0], [int(s.name)]] for s in sightings]]


class Faces(Detection):
    """`ALFaceDetection`, with names for learnt faces."""

    service, kind = "ALFaceDetection", "face"
    recognizes = Setting(
        "ALFaceDetection.RecognitionEnabled", True, bool, reader="is", also="enableRecognition"
    )
    tracks = Setting(
        "ALFaceDetection.TrackingEnabled", False, bool, inert=True, reader="is", also="enableTracking"
    )
    threshold = Setting(
        "ALFaceDetection.RecognitionConfidenceThreshold", 0.4, Annotated[float, Range(0.0, 1.0)], inert=True
    )

    def __init__(self, robot: ServedRobot, scene: Scene) -> None:
        super().__init__(robot, scene)
        self._known: dict[str, str] = {}
        """Name of a thing -> its name in events."""
        self._before: list[str] = []

    def _found(self, sightings: list[Sighting]) -> list[Any]:
        labels = [self._known.get(s.name, "") if self.recognizes else "" for s in sightings]
        faces = [self._face(i, s, label) for i, (s, label) in enumerate(zip(sightings, labels, strict=True))]
        new = [label for label in labels if label and label not in self._before]
        self._before = labels
        return [[*faces, [2, new] if len(new) == 1 else [3, new] if new else []]]

    def _face(self, number_: int, sighting: Sighting, label: str) -> list[Any]:
        middle = [sighting.alpha, sighting.beta]
        points = [middle * 7, middle * 7, [0.0, 0.0], [0.0, 0.0], middle * 3, middle * 8]
        shape = [0, sighting.alpha, sighting.beta, sighting.size, sighting.size]
        return [shape, [number_ + 1, 1.0 if label else 0.0, label, *points]]

    @offers("ALFaceDetection.learnFace", "ALFaceDetection.reLearnFace")
    def _learn(self, name: str) -> Future[bool]:
        """Learn the one visible face; false: there are none or several for `LEARN_TIME`."""

        def task() -> MotionTask:
            """Wait until one face is seen alone."""
            end = self._now() + LEARN_TIME
            while len(faces := list(self._scene.sightings("face", self.camera))) != 1:
                if self._now() >= end:
                    return False
                yield self._now() + PERIOD
            self._known[faces[0].name] = name
            return True

        return self._others.begin(task())

    @offers("ALFaceDetection.forgetPerson")
    def _forget(self, name: str) -> bool:
        gone = [thing for thing, known in self._known.items() if known == name]
        for thing in gone:
            del self._known[thing]
        return bool(gone)

    @offers("ALFaceDetection.clearDatabase")
    def _clear(self) -> bool:
        self._known.clear()
        return True

    _get_learned_faces_list = offers("ALFaceDetection.getLearnedFacesList")(
        lambda self: sorted(set(self._known.values()))
    )
