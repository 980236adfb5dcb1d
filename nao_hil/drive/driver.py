"""From keys and a stick to what the robot is to do: no terminal, no link, no clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, get_args

from bridge.messages.walk import TorsoName, WalkCommand, WalkStatus
from bridge.types import Vec3

NOTCHES: Final = 5
"""Key presses from rest to a gait's own velocity."""
SIDEWAYS: Final = 0.02
"""m/s per key press; for gaits that can."""
TURN: Final = 0.1
"""rad/s per key press; for gaits that can."""
DEAD: Final = 0.15
"""Share of the stick's way that counts as rest."""
HOLD: Final = 3.0
"""s; the robot stops by itself this long after the driver's last word."""

HELP: Final = {
    "w, up": "faster",
    "s, down": "slower",
    "a, d / left, right": "turn left, right",
    "q, e": "left, right sideways",
    "space, x": "stop",
    "g": "next gait",
    "t": "next torso control",
    "m": "admittance on, off",
    "Q, Esc": "stop and leave",
}
"""Keys -> what they do."""

STOPS: Final = (" ", "x")
"""Keys that stop."""
_SEQUENCES: Final = {b"\x1b[A": "w", b"\x1b[B": "s", b"\x1b[C": "d", b"\x1b[D": "a"}
"""Arrows, as terminals send them (also with O instead of the bracket)."""
_TORSOS: Final[tuple[TorsoName, ...]] = get_args(TorsoName)


def keys_of(data: bytes) -> list[str]:
    """Keys in what a terminal sent; an escape alone is `Esc`, other sequences are passed over."""
    keys: list[str] = []
    while data:
        head = data[:3].replace(b"\x1bO", b"\x1b[")
        if head in _SEQUENCES:
            keys.append(_SEQUENCES[head])
            data = data[3:]
        elif data.startswith((b"\x1b[", b"\x1bO")):
            data = data[2:].lstrip(b"0123456789;")[1:]
        else:
            keys.append("Esc" if data[:1] == b"\x1b" else data[:1].decode("latin-1"))
            data = data[1:]
    return keys


def notch_of(deflection: float) -> int:
    """Notches that a stick stands for, pushed forwards by -1..1."""
    size = abs(deflection)
    if size < DEAD:
        return 0
    notches = round(NOTCHES * (min(size, 1.0) - DEAD) / (1.0 - DEAD))
    return notches if deflection > 0.0 else -notches


@dataclass(frozen=True)
class Wheel:
    """What the driver wants now."""

    gait: str
    torso: str
    admittance: bool
    forward: float = 0
    """Notches; whole ones by keys."""
    sideways: float = 0
    turn: float = 0
    leave: bool = False


@dataclass(frozen=True)
class Driver:
    """Turns keys into wheels, and wheels into commands.

    Args:
        speeds: own velocity of each gait that there is, m/s.
    """

    speeds: Mapping[str, float]

    def at_rest(self, status: WalkStatus) -> Wheel:
        """The wheel of somebody who takes over from a walker's status."""
        return Wheel(status.gait, status.torso, status.admittance)

    def under_way(self, status: WalkStatus) -> Wheel:
        """The wheel of somebody who takes over a walk: the notch next to its speed."""
        notch = self.speeds.get(status.gait, 0.0) / NOTCHES
        forward = round(status.velocity[0] / notch) if notch > 0.0 else 1
        if not any(status.velocity[1:]):
            forward = max(1, forward)
        sideways, turn = round(status.velocity[1] / SIDEWAYS), round(status.velocity[2] / TURN)
        return replace(self.at_rest(status), forward=forward, sideways=sideways, turn=turn)

    def press(self, wheel: Wheel, key: str) -> Wheel:
        """The wheel after a key; keys without a meaning leave it as it is."""
        if key in ("w", "s"):
            return replace(wheel, forward=wheel.forward + (1 if key == "w" else -1))
        if key in ("a", "d"):
            return replace(wheel, turn=wheel.turn + (1 if key == "a" else -1))
        if key in ("q", "e"):
            return replace(wheel, sideways=wheel.sideways + (1 if key == "q" else -1))
        if key in STOPS:
            return replace(wheel, forward=0, sideways=0, turn=0)
        if key == "g":
            slow = min(max(wheel.forward, 0), 1)
            return replace(wheel, gait=_next(sorted(self.speeds), wheel.gait), forward=slow, sideways=0, turn=0)
        if key == "t":
            return replace(wheel, torso=_next(_TORSOS, wheel.torso))
        if key == "m":
            return replace(wheel, admittance=not wheel.admittance)
        if key in ("Q", "Esc"):
            return replace(wheel, forward=0, sideways=0, turn=0, leave=True)
        return wheel

    def stick(self, wheel: Wheel, deflection: float) -> Wheel:
        """The wheel after the stick was moved, forwards by -1..1."""
        return replace(wheel, forward=notch_of(deflection))

    def steer(self, wheel: Wheel, velocity: Vec3) -> Wheel:
        """The wheel that asks for a velocity, m/s, m/s, rad/s."""
        x, y, turn = velocity
        notch = self.speeds[wheel.gait] / NOTCHES
        return replace(wheel, forward=x / notch, sideways=y / SIDEWAYS, turn=turn / TURN)

    def velocity(self, wheel: Wheel) -> Vec3:
        """m/s, m/s, rad/s."""
        notch = self.speeds.get(wheel.gait, 0.0) / NOTCHES
        return wheel.forward * notch, wheel.sideways * SIDEWAYS, wheel.turn * TURN

    def command(self, before: Wheel, wheel: Wheel, key: str = "") -> WalkCommand | None:
        """What to tell the walker after a key; None: nothing.

        A stop is always told: somebody else may have made the robot walk.
        """
        if wheel.leave or key in STOPS:
            return WalkCommand(op="stop")
        if wheel == before:
            return None
        changes = {
            name: getattr(wheel, name)
            for name in ("gait", "torso", "admittance")
            if getattr(wheel, name) != getattr(before, name)
        }
        velocity = self.velocity(wheel)
        if any(velocity):
            return WalkCommand(op="walk", velocity=velocity, hold=HOLD, **changes)
        if changes:
            return WalkCommand(op="set", **changes)
        return WalkCommand(op="stop")

    def again(self, wheel: Wheel) -> WalkCommand | None:
        """A sign of life of the driver; None at rest, where none is needed."""
        velocity = self.velocity(wheel)
        return WalkCommand(op="walk", velocity=velocity, hold=HOLD) if any(velocity) else None


def _next(names: Sequence[str], name: str) -> str:
    return names[(names.index(name) + 1) % len(names)] if name in names else names[0]
