"""ALAutonomousLife and ALBasicAwareness: settings that are remembered, and a head that follows a face.

A person is a face of the emulated world, or one of `NaoHil.show`. Source: vendor's pages.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from bridge.adapters.naoqi.arguments import flag, text
from bridge.adapters.naoqi.core.cartesian import look_angles
from bridge.adapters.naoqi.core.frames import RobotFrames, inverse
from bridge.adapters.naoqi.core.joint_motion import JointMotion
from bridge.adapters.naoqi.core.memory import Events, Memory
from bridge.adapters.naoqi.interaction.detection import Stage
from bridge.adapters.naoqi.interaction.tracker import PERIOD, SPEED, point_of
from bridge.adapters.naoqi.methods import Table
from bridge.body.cameras import LINK as CAMERA_LINK
from bridge.body.cameras import cameras
from bridge.errors import NaoqiRefused
from bridge.messages.world import THING_SIZES
from bridge.validation import unknown_name

_STATE: Final = "AutonomousLife/State"
STATES: Final = ("solitary", "interactive", "safeguard", "disabled")
ABILITIES: Final = (
    *("AutonomousBlinking", "BackgroundMovement", "BasicAwareness"),
    *("ListeningMovement", "SpeakingMovement"),
)
"""Autonomous abilities (confirmed: vendor's page)."""


class AutonomousLife:
    """Methods of `ALAutonomousLife`; the caller locks.

    Args:
        events: its state is one.
    """

    def __init__(self, events: Events) -> None:
        self._events, self._state = events, "disabled"
        events.declare(_STATE, "ALAutonomousLife", self._state)
        self._enabled = dict.fromkeys(ABILITIES, False)

    def _set_state(self, state: Any) -> None:
        wanted = text(state, "ALAutonomousLife.setState: state")
        if wanted not in STATES:
            raise NaoqiRefused(f"ALAutonomousLife.setState: {unknown_name('state', wanted, STATES)}.")
        if wanted == "solitary" and self._state == "interactive":
            raise NaoqiRefused("ALAutonomousLife.setState: interactive ends by itself, and not by setState.")
        self._state = wanted
        self._events.raise_event(_STATE, wanted)

    def _ability(self, name: Any) -> str:
        ability = text(name, "ALAutonomousLife: ability")
        if ability not in ABILITIES:
            raise NaoqiRefused(f"ALAutonomousLife: {unknown_name('ability', ability, ABILITIES)}.")
        return ability

    def _set_ability(self, name: Any, enabled: Any) -> None:
        names = ABILITIES if name == "All" else (self._ability(name),)
        on = flag(enabled, "ALAutonomousLife.setAutonomousAbilityEnabled: enabled")
        self._enabled.update(dict.fromkeys(names, on))

    def _status(self) -> list[dict[str, Any]]:
        return [{"name": name, "enabled": on, "running": False} for name, on in self._enabled.items()]

    def _no_activity(self, name: Any, *_: Any) -> None:
        raise NaoqiRefused(
            f"ALAutonomousLife: there is no activity {text(name, 'ALAutonomousLife: activity')!r:.60}; none is "
            "installed on an emulated robot."
        )

    def methods(self) -> Table:
        """Methods of the service."""
        return {
            "getState": lambda: self._state,
            "setState": self._set_state,
            "focusedActivity": lambda: "",
            "switchFocus": self._no_activity,
            "stopFocus": lambda: None,
            "stopAll": lambda: None,
            "getActivityNature": self._no_activity,
            "getFocusContext": self._no_activity,
            "getFocusHistory": lambda _depth=None: [],
            "getStateHistory": lambda _depth=None: [],
            "getAutonomousAbilityEnabled": lambda name: self._enabled[self._ability(name)],
            "setAutonomousAbilityEnabled": self._set_ability,
            "getAutonomousAbilitiesStatus": self._status,
            "isMonitoringLaunchpadConditions": lambda: False,
        }


ENGAGEMENT_MODES: Final = ("Unengaged", "FullyEngaged", "SemiEngaged")
TRACKING_MODES: Final = ("Head", "BodyRotation", "WholeBody", "MoveContextually")
STIMULI: Final = ("Sound", "Movement", "NavigationMotion", "People", "Touch", "TabletTouch")
"""Of `ALBasicAwareness` (confirmed: vendor's page)."""
NOBODY: Final = -1
"""In place of a person's number (confirmed: vendor's page)."""
LOST: Final = 3000
"""ms without a sight of somebody after which the robot has lost them (assumed)."""
_PERSON: Final = "PeoplePerception/Person/"
_SPACES: Final = {0: "PositionInTorsoFrame", 1: "PositionInWorldFrame", 2: "PositionInRobotFrame"}


class Awareness:
    """Methods of `ALBasicAwareness`; not thread-safe, the caller locks.

    Args:
        stage: has the faces to be seen.
        frames: of the robot.
        motion: turns its head.
        events: told who is tracked.
        memory: gets where people are.
    """

    def __init__(
        self, stage: Stage, frames: RobotFrames, motion: JointMotion, events: Events, memory: Memory
    ) -> None:
        self._stage, self._frames, self._motion = stage, frames, motion
        self._events, self._memory = events, memory
        self._cameras = [camera.name for camera in cameras(frames.body)]
        self._people: dict[str, int] = {}
        """Name of a face -> the number that the robot gave it."""
        self._tracked, self._due, self._seen = NOBODY, 0, 0
        self._enabled = self._paused = False
        self._engagement, self._tracking = ENGAGEMENT_MODES[0], TRACKING_MODES[0]
        self._stimuli = dict.fromkeys(STIMULI, True)

    def _enable(self, enabled: Any) -> None:
        self._enabled = flag(enabled, "ALBasicAwareness.setEnabled: enabled")

    def _pause(self, paused: bool) -> None:
        self._paused = paused

    def _set_engagement(self, mode: Any) -> None:
        self._engagement = _one_of(mode, ENGAGEMENT_MODES, "engagement mode")

    def _set_tracking(self, mode: Any) -> None:
        self._tracking = _one_of(mode, TRACKING_MODES, "tracking mode")

    def _set_stimulus(self, stimulus: Any, enabled: Any) -> None:
        name = _one_of(stimulus, STIMULI, "stimulus")
        self._stimuli[name] = flag(enabled, "ALBasicAwareness.setStimulusDetectionEnabled: enabled")

    def update(self, now: int) -> None:
        """One cycle, at `now` of the robot's clock, ms."""
        if now < self._due:
            return
        self._due = now + PERIOD
        running = self._enabled and not self._paused and self._stimuli["People"]
        places = self._look_around() if running else {}
        if self._tracked in places:
            self._seen = now
        elif self._tracked != NOBODY and (not running or now - self._seen > LOST):
            lost, self._tracked = self._tracked, NOBODY
            self._events.raise_event("ALBasicAwareness/HumanTracked", NOBODY)
            for event in ("ALBasicAwareness/HumanLost", "ALBasicAwareness/PeopleLeft"):
                self._events.raise_event(event, lost)
        if self._tracked == NOBODY and places:
            self._tracked, self._seen = next(iter(places)), now
            self._events.raise_event("ALBasicAwareness/StimulusDetected", "People")
            self._events.raise_event("ALBasicAwareness/HumanTracked", self._tracked)
        if self._tracked in places and self._motion.available(["Head"]):
            camera = self._frames.effectors[self._cameras[0]].fixed
            angles = look_angles(places[self._tracked], self._frames.body.lengths.NeckOffsetZ, camera)
            self._motion.set_angles(["HeadYaw", "HeadPitch"], list(angles), SPEED)

    def _look_around(self) -> dict[int, list[float]]:
        """Number -> place in the Torso frame, m, of the people that are seen, the largest face first."""
        links = self._frames.measured_links()
        spaces = {key: self._frames.space(i, links, True) for i, key in _SPACES.items()}
        places: dict[int, list[float]] = {}
        for i, camera in enumerate(self._cameras):
            for sighting in self._stage.seen("face", i):
                number = self._people.setdefault(sighting.name, len(self._people) + 1)
                point = self._frames.in_torso(camera, sighting.links) @ point_of(sighting, THING_SIZES["face"])
                places.setdefault(number, point[:3].tolist())
                for key, space in spaces.items():
                    self._memory.put(f"{_PERSON}{number}/{key}", (inverse(space) @ point)[:3].tolist())
                distance = float(np.linalg.norm((inverse(links[CAMERA_LINK]) @ point)[:3]))
                self._memory.put(f"{_PERSON}{number}/Distance", distance)
        self._memory.put("PeoplePerception/PeopleList", sorted(places))
        return places

    def methods(self) -> Table:
        """Methods of the service."""
        return {
            "setEnabled": self._enable,
            "isEnabled": lambda: self._enabled,
            "isRunning": lambda: self._enabled and not self._paused,
            "startAwareness": lambda: self._enable(True),
            "stopAwareness": lambda: self._enable(False),
            "isAwarenessRunning": lambda: self._enabled and not self._paused,
            "pauseAwareness": lambda: self._pause(True),
            "resumeAwareness": lambda: self._pause(False),
            "isAwarenessPaused": lambda: self._paused,
            "getEngagementMode": lambda: self._engagement,
            "setEngagementMode": self._set_engagement,
            "getTrackingMode": lambda: self._tracking,
            "setTrackingMode": self._set_tracking,
            "isStimulusDetectionEnabled": lambda stimulus: self._stimuli[
                _one_of(stimulus, STIMULI, "stimulus")
            ],
            "setStimulusDetectionEnabled": self._set_stimulus,
        }


def _one_of(name: Any, known: Sequence[str], what: str) -> str:
    chosen = text(name, f"ALBasicAwareness: {what}")
    if chosen not in known:
        raise NaoqiRefused(f"ALBasicAwareness: {unknown_name(what, chosen, known)}.")
    return chosen
