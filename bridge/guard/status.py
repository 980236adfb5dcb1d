"""The guard's state as others see it: the reply of the query `guard`, and the notices of its changes."""

from __future__ import annotations

from typing import Final

from bridge.messages import Notice
from bridge.messages.guard import GuardStatus, Reason, State

_REASONS: Final[dict[Reason, str]] = {
    "": "",
    "silence": " because its controller is silent",
    "stop": " after an emergency stop",
    "fall": " because it falls",
    "temperature": " because a motor is too hot",
    "battery": " because the battery is nearly empty",
}
_STATES: Final[dict[State, str]] = {
    "idle": "The joints are left alone until the first command",
    "approach": "The robot moves slowly to the pose of the first command",
    "active": "Commands are in force",
    "hold": "The joints hold",
    "crouch": "The robot crouches",
    "sit": "The robot sits down",
    "rest": "The robot rests, its joints released",
    "fallen": "The robot is limp",
}


class StatusLog:
    """Keeps the status, and a notice for each change until it is taken.

    Args:
        armed: whether commands are taken.
        dry_run: said in the status.
    """

    def __init__(self, *, armed: bool, dry_run: bool) -> None:
        self._dry_run = dry_run
        self._notices: list[Notice] = []
        self.armed = armed
        """Commands are taken."""
        self.reset()

    def reset(self) -> None:
        """The robot began anew: state `idle` at `seq` 0."""
        self.status = self._status(0, "idle", "", "")
        """As `guard` answers it."""

    def enter(self, seq: int, state: State, reason: Reason, event: str = "") -> None:
        """A change of state.

        Args:
            seq: sensor frame since which it is so.
            state: the new one.
            reason: why the guard took over; empty: it did not.
            event: one sentence that comes first.
        """
        self.status = self._status(seq, state, reason, event)
        self.say(seq, f"guard-{state}", self.status.text, "info" if reason == "" else "warning")

    def say(self, seq: int, code: str, text: str, level: str = "warning") -> None:
        """Add a notice; the arguments are its fields."""
        self._notices.append(Notice(seq=seq, level=level, code=code, text=text))

    def take_notices(self) -> list[Notice]:
        """The notices since the last call."""
        notices, self._notices = self._notices, []
        return notices

    def _status(self, seq: int, state: State, reason: Reason, event: str) -> GuardStatus:
        sentence = _STATES[state] + _REASONS[reason]
        sentence += "." if self.armed else "; it is not armed and takes no command before `nao-hil arm`."
        return GuardStatus(
            seq=seq,
            state=state,
            reason=reason,
            armed=self.armed,
            dry_run=self._dry_run,
            text=f"{event} {sentence}" if event else sentence,
        )
