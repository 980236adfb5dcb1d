"""ALAutonomousLife and ALBasicAwareness: remembered settings, and a head that follows a face.

A person is a face of the emulated world or of `NaoHil.show`. Source: vendor's pages.
"""

from __future__ import annotations

from typing import Annotated, Any, Final

import numpy as np

from bridge.adapters.naoqi.core.cartesian import look_angles
from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import OneOf, Setting, offers
from bridge.adapters.naoqi.interaction.detection import Scene
from bridge.adapters.naoqi.interaction.tracker import HEAD_SPEED, PERIOD, point_of
from bridge.body.cameras import CAMERA_LINK, cameras
from bridge.body.kinematics import inverse
from bridge.errors import NaoqiRefused
from bridge.messages.world import THING_SIZES

_STATE: Final = "AutonomousLife/State"
STATES: Final = ("solitary", "interactive", "safeguard", "disabled")
ABILITIES: Final = (
    *("AutonomousBlinking", "BackgroundMovement", "BasicAwareness"),
    *("ListeningMovement", "SpeakingMovement"),
)
"""Autonomous abilities (confirmed: vendor's page)."""


class AutonomousLife(Service):
    """Methods of `ALAutonomousLife`."""

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self._state = "disabled"
        self._enabled = dict.fromkeys(ABILITIES, False)

    @offers("ALAutonomousLife.setState")
    def _set_state(self, state: Annotated[str, OneOf("state", STATES)]) -> None:
        if state == "solitary" and self._state == "interactive":
            raise NaoqiRefused("ALAutonomousLife.setState: interactive ends by itself, and not by setState.")
        self._state = state
        self._events.raise_event(_STATE, state)

    @offers("ALAutonomousLife.setAutonomousAbilityEnabled")
    def _set_ability(self, name: Annotated[str, OneOf("ability", ("All", *ABILITIES))], enabled: bool) -> None:
        names = ABILITIES if name == "All" else (name,)
        self._enabled.update(dict.fromkeys(names, enabled))

    @offers("ALAutonomousLife.getAutonomousAbilitiesStatus")
    def _status(self) -> list[dict[str, Any]]:
        return [{"name": name, "enabled": on, "running": False} for name, on in self._enabled.items()]

    @offers(
        "ALAutonomousLife.switchFocus", "ALAutonomousLife.getActivityNature", "ALAutonomousLife.getFocusContext"
    )
    def _no_activity(self, name: str, *_: Any) -> None:
        raise NaoqiRefused(
            f"ALAutonomousLife: there is no activity {name!r:.60}; none is installed on an emulated robot."
        )

    @offers("ALAutonomousLife.getAutonomousAbilityEnabled")
    def _is_enabled(self, name: Annotated[str, OneOf("ability", ABILITIES)]) -> bool:
        return self._enabled[name]

    _get_state = offers("ALAutonomousLife.getState")(lambda self: self._state)


ENGAGEMENT_MODES: Final = ("Unengaged", "FullyEngaged", "SemiEngaged")
TRACKING_MODES: Final = ("Head", "BodyRotation", "WholeBody", "MoveContextually")
STIMULI: Final = ("Sound", "Movement", "NavigationMotion", "People", "Touch", "TabletTouch")
"""Kinds of stimuli of `ALBasicAwareness` (confirmed: vendor's page)."""
NO_PERSON: Final = -1
"""In place of a person's number (confirmed: vendor's page)."""
LOST_TIME: Final = 3000
"""ms without a sight of a person after which the person is lost (assumed)."""
_PERSON: Final = "PeoplePerception/Person/"
_SPACES: Final = {0: "PositionInTorsoFrame", 1: "PositionInWorldFrame", 2: "PositionInRobotFrame"}


Stimulus = Annotated[str, OneOf("stimulus", STIMULI)]


class Awareness(Service):
    """Methods of `ALBasicAwareness`."""

    engagement = Setting(
        "ALBasicAwareness.EngagementMode",
        ENGAGEMENT_MODES[0],
        Annotated[str, OneOf("engagement mode", ENGAGEMENT_MODES)],
        inert=True,
    )
    tracking = Setting(
        "ALBasicAwareness.TrackingMode",
        TRACKING_MODES[0],
        Annotated[str, OneOf("tracking mode", TRACKING_MODES)],
    )

    def __init__(self, robot: ServedRobot, scene: Scene) -> None:
        super().__init__(robot)
        self._scene = scene
        self._cameras = [camera.name for camera in cameras(robot.body)]
        self._people: dict[str, int] = {}
        """Name of a face -> number of the person."""
        self._tracked, self._due, self._seen = NO_PERSON, 0, 0
        self._enabled = self._paused = False
        self._stimuli = dict.fromkeys(STIMULI, True)

    @offers("ALBasicAwareness.setEnabled")
    def _enable(self, enabled: bool) -> None:
        self._enabled = enabled

    def _pause(self, paused: bool) -> None:
        self._paused = paused

    @offers("ALBasicAwareness.setStimulusDetectionEnabled")
    def _set_stimulus(self, stimulus: Stimulus, enabled: bool) -> None:
        self._stimuli[stimulus] = enabled

    def update(self, now: int) -> None:
        """Look for people and follow one, in the cycle at `now` of the robot's clock, ms."""
        if now < self._due:
            return
        self._due = now + PERIOD
        running = self._enabled and not self._paused and self._stimuli["People"]
        places = self._visible_people() if running else {}
        if self._tracked in places:
            self._seen = now
        elif self._tracked != NO_PERSON and (not running or now - self._seen > LOST_TIME):
            lost, self._tracked = self._tracked, NO_PERSON
            self._events.raise_event("ALBasicAwareness/HumanTracked", NO_PERSON)
            for event in ("ALBasicAwareness/HumanLost", "ALBasicAwareness/PeopleLeft"):
                self._events.raise_event(event, lost)
        if self._tracked == NO_PERSON and places:
            self._tracked, self._seen = next(iter(places)), now
            self._events.raise_event("ALBasicAwareness/StimulusDetected", "People")
            self._events.raise_event("ALBasicAwareness/HumanTracked", self._tracked)
        if self._tracked in places and self._motion.available(["Head"]):
            camera = self._frames.effectors[self._cameras[0]].fixed
            angles = look_angles(places[self._tracked], self._frames.body.lengths.NeckOffsetZ, camera)
            self._motion.set_angles(["HeadYaw", "HeadPitch"], list(angles), HEAD_SPEED)

    def _visible_people(self) -> dict[int, list[float]]:
        """Number -> place in the Torso frame, m, of the visible people, the largest face first."""
        links = self._frames.measured_links()
        spaces = {key: self._frames.space(i, links, True) for i, key in _SPACES.items()}
        places: dict[int, list[float]] = {}
        for i, camera in enumerate(self._cameras):
            for sighting in self._scene.sightings("face", i):
                number = self._people.setdefault(sighting.name, len(self._people) + 1)
                point = self._frames.in_torso(camera, sighting.links) @ point_of(sighting, THING_SIZES["face"])
                places.setdefault(number, point[:3].tolist())
                for key, space in spaces.items():
                    self._memory.put(f"{_PERSON}{number}/{key}", (inverse(space) @ point)[:3].tolist())
                distance = float(np.linalg.norm((inverse(links[CAMERA_LINK]) @ point)[:3]))
                self._memory.put(f"{_PERSON}{number}/Distance", distance)
        self._memory.put("PeoplePerception/PeopleList", sorted(places))
        return places

    @offers("ALBasicAwareness.isStimulusDetectionEnabled")
    def _detects(self, stimulus: Stimulus) -> bool:
        return self._stimuli[stimulus]

    _is_enabled = offers("ALBasicAwareness.isEnabled")(lambda self: self._enabled)
    _is_running = offers("ALBasicAwareness.isRunning", "ALBasicAwareness.isAwarenessRunning")(
        lambda self: self._enabled and not self._paused
    )
    _stop_awareness = offers("ALBasicAwareness.stopAwareness")(lambda self: self._enable(False))
    _pause_awareness = offers("ALBasicAwareness.pauseAwareness")(lambda self: self._pause(True))
    _resume_awareness = offers("ALBasicAwareness.resumeAwareness")(lambda self: self._pause(False))
    _is_awareness_paused = offers("ALBasicAwareness.isAwarenessPaused")(lambda self: self._paused)

    _start_awareness = offers("ALBasicAwareness.startAwareness")(lambda self: self._enable(True))
