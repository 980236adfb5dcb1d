"""ALAutonomousLife on a robot without a life of its own: what is set is remembered."""

from __future__ import annotations

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
