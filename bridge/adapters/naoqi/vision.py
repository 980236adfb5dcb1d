"""ALFaceDetection, ALLandMarkDetection and ALRedBallDetection: they see the things around the robot."""

from __future__ import annotations

import time
from typing import Any, Final

from bridge.adapters.naoqi.arguments import flag, number, text
from bridge.adapters.naoqi.events import Events
from bridge.adapters.naoqi.extractor import VisionExtractor
from bridge.adapters.naoqi.frames import RobotFrames, inverse, position6
from bridge.adapters.naoqi.methods import Table
from bridge.adapters.naoqi.stage import Sighting, Stage
from bridge.messages.world import ThingKind as Kind

CAMERAS: Final = ("CameraTop", "CameraBottom")
PERIOD: Final = 100
"""ms between two results, for a subscriber that gives no period (assumed)."""


class Detection:
    """One service that detects things of one kind; not thread-safe, the caller locks.

    Args:
        service: its name.
        kind: of the things.
        event: that it raises.
        stage: has the things.
        frames: of the robot.
        events: to be raised.
    """

    def __init__(
        self, service: str, kind: Kind, event: str, stage: Stage, frames: RobotFrames, events: Events
    ) -> None:
        self._service, self._kind, self._event = service, kind, event
        self._stage, self._frames, self._events = stage, frames, events
        self._extractor = VisionExtractor(service, events, [event], PERIOD)
        events.declare(event, service, [])
        self._seen = False
        self._due = 0

    @property
    def _camera(self) -> int:
        return self._extractor.camera

    def update(self, now: int) -> None:
        """One cycle, at `now` of the robot's clock, ms; raises the event at the period that was asked for."""
        if not self._extractor.processing or now < self._due:
            return
        self._due = now + max(10, self._extractor.period)
        sightings = list(self._stage.seen(self._kind, self._camera))
        if sightings:
            self._events.raise_event(self._event, self._value(sightings))
        elif self._seen:
            self._events.raise_event(self._event, [])  # once, when the last one is gone
        self._seen = bool(sightings)

    def _value(self, sightings: list[Sighting]) -> list[Any]:
        seconds, part = divmod(time.time(), 1.0)
        links = sightings[0].links
        camera = self._frames.in_torso(CAMERAS[self._camera], links)
        poses = [position6(inverse(self._frames.space(space, links, True)) @ camera) for space in (0, 2)]
        return [[int(seconds), int(1e6 * part)], *self._found(sightings), *poses, self._camera_name()]

    def _camera_name(self) -> Any:
        return self._camera

    def _found(self, sightings: list[Sighting]) -> list[Any]:
        one = sightings[0]
        return [[one.alpha, one.beta, 0.5 * one.size, 0.5 * one.size]]  # a ball's sizes are its radii

    def methods(self) -> Table:
        """Methods of the service."""
        return self._extractor.methods()


class LandMarks(Detection):
    """`ALLandMarkDetection`."""

    def _camera_name(self) -> Any:
        return CAMERAS[self._camera]

    def _found(self, sightings: list[Sighting]) -> list[Any]:
        return [[[[1, s.alpha, s.beta, s.size, s.size, 0.0], [int(s.name)]] for s in sightings]]


class Faces(Detection):
    """`ALFaceDetection`: knows the faces that were learnt."""

    def __init__(self, stage: Stage, frames: RobotFrames, events: Events) -> None:
        super().__init__("ALFaceDetection", "face", "FaceDetected", stage, frames, events)
        self._known: dict[str, str] = {}
        """Name of a thing -> what the robot calls it."""
        self._recognizes, self._tracks, self._threshold = True, False, 0.4
        self._before: list[str] = []

    def _found(self, sightings: list[Sighting]) -> list[Any]:
        labels = [self._known.get(s.name, "") if self._recognizes else "" for s in sightings]
        faces = [self._face(i, s, label) for i, (s, label) in enumerate(zip(sightings, labels, strict=True))]
        new = [label for label in labels if label and label not in self._before]
        self._before = labels
        return [[*faces, [2, new] if len(new) == 1 else [3, new] if new else []]]

    def _face(self, number_: int, sighting: Sighting, label: str) -> list[Any]:
        middle = [sighting.alpha, sighting.beta]
        points = [middle * 7, middle * 7, [0.0, 0.0], [0.0, 0.0], middle * 3, middle * 8]
        shape = [0, sighting.alpha, sighting.beta, sighting.size, sighting.size]
        return [shape, [number_ + 1, 1.0 if label else 0.0, label, *points]]

    def _learn(self, name: Any) -> bool:
        """Learn the one face that is seen; false when it is none or several."""
        label = text(name, "ALFaceDetection.learnFace: name")
        faces = list(self._stage.seen("face", self._camera))
        if len(faces) != 1:
            return False
        self._known[faces[0].name] = label
        return True

    def _forget(self, name: Any) -> bool:
        label = text(name, "ALFaceDetection.forgetPerson: name")
        gone = [thing for thing, known in self._known.items() if known == label]
        for thing in gone:
            del self._known[thing]
        return bool(gone)

    def _clear(self) -> bool:
        self._known.clear()
        return True

    def _recognize(self, enabled: Any) -> None:
        self._recognizes = flag(enabled, "ALFaceDetection.setRecognitionEnabled: enabled")

    def _track(self, enabled: Any) -> None:
        self._tracks = flag(enabled, "ALFaceDetection.setTrackingEnabled: enabled")

    def _set_threshold(self, value: Any) -> None:
        self._threshold = number(value, "ALFaceDetection: threshold", 0.0, 1.0)

    def methods(self) -> Table:
        """Methods of the service."""
        return super().methods() | {
            "learnFace": self._learn,
            "reLearnFace": self._learn,
            "forgetPerson": self._forget,
            "clearDatabase": self._clear,
            "getLearnedFacesList": lambda: sorted(set(self._known.values())),
            "setRecognitionEnabled": self._recognize,
            "enableRecognition": self._recognize,
            "isRecognitionEnabled": lambda: self._recognizes,
            "setTrackingEnabled": self._track,
            "enableTracking": self._track,
            "isTrackingEnabled": lambda: self._tracks,
            "setRecognitionConfidenceThreshold": self._set_threshold,
            "getRecognitionConfidenceThreshold": lambda: self._threshold,
        }
