"""The guard's published state; detection of a fall; heat and charge."""

from __future__ import annotations

from typing import Final

from bridge.body import Body
from bridge.body.fall import tilt
from bridge.body.joints import INDEX, JOINTS
from bridge.body.quantities import absent_joints
from bridge.guard.config import BatterySettings, FallSettings, TemperatureSettings
from bridge.messages import Notice, SensorFrame
from bridge.messages.guard import GuardStatus, Reason, State
from bridge.stance import StanceSettings, stands

_REASON_TEXTS: Final[dict[Reason, str]] = {
    "": "",
    "silence": " because its controller is silent",
    "stop": " after an emergency stop",
    "fall": " because it falls",
    "temperature": " because a motor is too hot",
    "battery": " because the battery is nearly empty",
    "sensors": " because a sensor cannot be read",
}
_STATE_TEXTS: Final[dict[State, str]] = {
    "idle": "The joints are left alone until the first command",
    "approach": "The robot moves slowly to the pose of the first command",
    "active": "Commands are in force",
    "hold": "The joints hold",
    "crouch": "The robot crouches",
    "sit": "The robot sits down",
    "rest": "The robot rests, its joints released",
    "fallen": "The robot is limp",
}


class FallMonitor:
    """Reports a fall once, after some cycles of too much tilt that follow an upright stand.

    A robot that sits or gets up leans as far without a fall; while getting up it may be upright for a moment,
    with a sole below its hip.

    Args:
        body: data sheet.
        settings: the bounds.
        stance: bounds of a stand.
    """

    def __init__(self, body: Body, settings: FallSettings, stance: StanceSettings) -> None:
        self._body, self._s, self._stance = body, settings, stance
        self._tilted = self._stood = 0
        self._may_fall = False

    def update(self, frame: SensorFrame) -> bool:
        """One cycle; True in the one in which a fall is detected."""
        angle = tilt(frame.angle)
        if not self._may_fall:
            upright = angle < self._s.upright and stands(self._body, frame, self._stance)
            self._stood = self._stood + 1 if upright else 0
            self._may_fall = self._stood >= self._s.stood_cycles
        self._tilted = self._tilted + 1 if angle > self._s.angle else 0
        falls = self._s.enabled and self._may_fall and self._tilted >= self._s.cycles
        self._may_fall = self._may_fall and not falls
        return falls


class SupplyMonitor:
    """Temperature and charge, each with bounds for warning, limit and return.

    Args:
        body: data sheet; joints it lacks have no temperature.
        temperature: bounds of the hottest motor.
        battery: bounds of the charge.
    """

    def __init__(self, body: Body, temperature: TemperatureSettings, battery: BatterySettings) -> None:
        absent = absent_joints(body)
        self._slots = [INDEX[joint] for joint in JOINTS if joint not in absent]
        self._heat, self._charge = temperature, battery
        self._hot = self._empty = False
        self._warned_heat = self._warned_charge = False

    @property
    def fault(self) -> Reason:
        """The quantity that passed its limit and has not returned; empty: none."""
        return "temperature" if self._hot else "battery" if self._empty else ""

    def update(self, frame: SensorFrame) -> list[str]:
        """One cycle; the warnings of this cycle, one sentence each."""
        warnings = []
        slot = max(self._slots, key=frame.temperature.__getitem__)
        heat, charge = frame.temperature[slot], frame.battery[0]
        if heat >= self._heat.warn and not self._warned_heat:
            warnings.append(
                f"{JOINTS[slot]} is at {heat:.0f} degrees Celsius; at {self._heat.limit:g} the robot goes down."
            )
        self._warned_heat = heat >= self._heat.warn or (self._warned_heat and heat >= self._heat.resume)
        self._hot = heat >= self._heat.limit or (self._hot and heat >= self._heat.resume)
        if charge <= self._charge.warn and not self._warned_charge:
            warnings.append(f"The battery is at {charge:.0%}; at {self._charge.limit:.0%} the robot goes down.")
        self._warned_charge = charge <= self._charge.warn
        self._empty = charge <= self._charge.limit or (self._empty and charge <= self._charge.resume)
        return warnings


class StatusLog:
    """The status, and a notice for each change until it is taken.

    Args:
        armed: whether commands are taken.
        dry_run: for the status.
    """

    def __init__(self, *, armed: bool, dry_run: bool) -> None:
        self._dry_run = dry_run
        self._notices: list[Notice] = []
        self.armed = armed
        """Commands are taken."""
        self.reset()

    def reset(self) -> None:
        """Enter the state `idle` at `seq` 0."""
        self.status = self._status(0, "idle", "", "")
        """Answer to the query `guard`."""

    def enter(self, seq: int, state: State, reason: Reason, event: str = "", code: str = "") -> None:
        """Change the state.

        Args:
            seq: first sensor frame of the state.
            state: the new one.
            reason: for which the guard controls the joints; empty: it does not.
            event: first sentence of the text.
            code: of the notice; empty: `guard-` and the state.
        """
        self.status = self._status(seq, state, reason, event)
        self.add_notice(seq, code or f"guard-{state}", self.status.text, "info" if reason == "" else "warning")

    def add_notice(self, seq: int, code: str, text: str, level: str = "warning") -> None:
        """Add a notice; the arguments are its fields."""
        self._notices.append(Notice(seq=seq, level=level, code=code, text=text))

    def take_notices(self) -> list[Notice]:
        """The notices since the last call."""
        notices, self._notices = self._notices, []
        return notices

    def _status(self, seq: int, state: State, reason: Reason, event: str) -> GuardStatus:
        sentence = _STATE_TEXTS[state] + _REASON_TEXTS[reason]
        sentence += "." if self.armed else "; it is not armed and takes no command before `nao-hil arm`."
        return GuardStatus(
            seq=seq,
            state=state,
            reason=reason,
            armed=self.armed,
            dry_run=self._dry_run,
            text=f"{event} {sentence}" if event else sentence,
        )
