"""What the guard says of itself: one sentence for each state and reason."""

from __future__ import annotations

from typing import Final

from bridge.guard.messages import Reason, State

_BECAUSE: Final[dict[Reason, str]] = {
    "": "",
    "silence": " because its controller says nothing",
    "stop": " after an emergency stop",
    "fall": " because it falls",
    "temperature": " because a motor is too hot",
    "battery": " because the battery is nearly empty",
}
_STATES: Final[dict[State, str]] = {
    "idle": "The joints are left alone until the first command",
    "approach": "The robot goes slowly to where the first command wants it",
    "active": "Commands are in force",
    "hold": "The joints hold",
    "crouch": "The robot crouches",
    "rest": "The robot rests, its joints let go",
    "fallen": "The robot is limp",
}


def sentence(state: State, reason: Reason, armed: bool) -> str:
    """One sentence on a state, why it is so, and what would end it."""
    text = _STATES[state] + _BECAUSE[reason]
    return f"{text}." if armed else f"{text}; it is not armed and takes no command before `nao-hil arm`."
