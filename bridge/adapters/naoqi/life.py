"""ALAutonomousLife and ALBasicAwareness on a robot without a life of its own: what is set is remembered."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from bridge.adapters.naoqi.arguments import flag, text
from bridge.adapters.naoqi.events import Events
from bridge.adapters.naoqi.methods import Table
from bridge.errors import NaoqiRefused
from bridge.validation import unknown_name

_STATE: Final = "AutonomousLife/State"
STATES: Final = ("solitary", "interactive", "safeguard", "disabled")
ABILITIES: Final = (
    *("AutonomousBlinking", "BackgroundMovement", "BasicAwareness"),
    *("ListeningMovement", "SpeakingMovement"),
)
"""Autonomous abilities (confirmed: vendor's page)."""
ENGAGEMENT_MODES: Final = ("Unengaged", "FullyEngaged", "SemiEngaged")
TRACKING_MODES: Final = ("Head", "BodyRotation", "WholeBody", "MoveContextually")
STIMULI: Final = ("Sound", "Movement", "NavigationMotion", "People", "Touch", "TabletTouch")
"""Of `ALBasicAwareness` (confirmed: vendor's page)."""


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


class Awareness:
    """Methods of `ALBasicAwareness`: they remember what was set, and nobody is perceived; the caller locks."""

    def __init__(self) -> None:
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
