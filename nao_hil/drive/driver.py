"""From keys and a stick to commands: no terminal, no link, no clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, get_args

from bridge.messages.walk import TorsoName, WalkCommand, WalkStatus
from bridge.types import Vec3

SPEED_STEPS: Final = 5
"""Key presses from rest to a gait's own velocity."""
SIDEWAYS_STEP: Final = 0.02
"""m/s per key press; for gaits that can."""
TURN_STEP: Final = 0.1
"""rad/s per key press; for gaits that can."""
DEAD_ZONE: Final = 0.15
"""Share of the stick's way that counts as rest."""
LEARNED_SPEED: Final = 0.1
"""m/s taken for the own speed of a learned gait, whose sheet is on the walker's machine."""
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
"""Keys -> actions."""

STOPS: Final = (" ", "x")
"""Keys that stop."""
_SEQUENCES: Final = {b"\x1b[A": "w", b"\x1b[B": "s", b"\x1b[C": "d", b"\x1b[D": "a"}
"""Arrows, as terminals send them (also with O instead of the bracket)."""
_TORSOS: Final[tuple[TorsoName, ...]] = get_args(TorsoName)


def keys_of(data: bytes) -> list[str]:
    """Keys in a terminal's input; an escape alone is `Esc`, other sequences are passed over."""
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


def speed_steps(deflection: float) -> int:
    """Steps of speed for a stick pushed forwards by -1..1."""
    size = abs(deflection)
    if size < DEAD_ZONE:
        return 0
    steps = round(SPEED_STEPS * (min(size, 1.0) - DEAD_ZONE) / (1.0 - DEAD_ZONE))
    return steps if deflection > 0.0 else -steps


@dataclass(frozen=True)
class DriveTarget:
    """Command in force."""

    gait: str
    torso: str
    admittance: bool
    forward: float = 0
    """Steps of speed; whole ones by keys."""
    sideways: float = 0
    turn: float = 0
    leave: bool = False


@dataclass(frozen=True)
class Driver:
    """Turns keys into targets, and targets into commands.

    Args:
        speeds: own velocity of each gait that there is, m/s.
    """

    speeds: Mapping[str, float]

    def at_rest(self, status: WalkStatus) -> DriveTarget:
        """The target at takeover of a resting walker, from its status."""
        return DriveTarget(status.gait, status.torso, status.admittance)

    def under_way(self, status: WalkStatus) -> DriveTarget:
        """The target at takeover of a walk: the step of speed next to its speed."""
        forward = round(status.velocity[0] / self._step(status.gait))
        if not any(status.velocity[1:]):
            forward = max(1, forward)
        sideways, turn = round(status.velocity[1] / SIDEWAYS_STEP), round(status.velocity[2] / TURN_STEP)
        return replace(self.at_rest(status), forward=forward, sideways=sideways, turn=turn)

    def press(self, target: DriveTarget, key: str) -> DriveTarget:
        """The target after a key; keys without a meaning leave it as it is."""
        if key in ("w", "s"):
            return replace(target, forward=target.forward + (1 if key == "w" else -1))
        if key in ("a", "d"):
            return replace(target, turn=target.turn + (1 if key == "a" else -1))
        if key in ("q", "e"):
            return replace(target, sideways=target.sideways + (1 if key == "q" else -1))
        if key in STOPS:
            return replace(target, forward=0, sideways=0, turn=0)
        if key == "g":
            slow = min(max(target.forward, 0), 1)
            return replace(
                target, gait=_next(sorted(self.speeds), target.gait), forward=slow, sideways=0, turn=0
            )
        if key == "t":
            return replace(target, torso=_next(_TORSOS, target.torso))
        if key == "m":
            return replace(target, admittance=not target.admittance)
        if key in ("Q", "Esc"):
            return replace(target, forward=0, sideways=0, turn=0, leave=True)
        return target

    def stick(self, target: DriveTarget, deflection: float) -> DriveTarget:
        """The target after a motion of the stick, forwards by -1..1."""
        return replace(target, forward=speed_steps(deflection))

    def steer(self, target: DriveTarget, velocity: Vec3) -> DriveTarget:
        """The target with a velocity, m/s, m/s, rad/s."""
        x, y, turn = velocity
        forward = x / self._step(target.gait)
        return replace(target, forward=forward, sideways=y / SIDEWAYS_STEP, turn=turn / TURN_STEP)

    def velocity(self, target: DriveTarget) -> Vec3:
        """Velocity that a target asks for, m/s, m/s, rad/s."""
        step = self._step(target.gait)
        return target.forward * step, target.sideways * SIDEWAYS_STEP, target.turn * TURN_STEP

    def _step(self, gait: str) -> float:
        """Step of speed of a gait, m/s."""
        return self.speeds.get(gait, LEARNED_SPEED) / SPEED_STEPS

    def command(self, before: DriveTarget, target: DriveTarget, key: str = "") -> WalkCommand | None:
        """Command to the walker after a key; None: none.

        A stop is always sent: another driver may have made the robot walk.
        """
        if target.leave or key in STOPS:
            return WalkCommand(op="stop")
        if target == before:
            return None
        changes = {
            name: getattr(target, name)
            for name in ("gait", "torso", "admittance")
            if getattr(target, name) != getattr(before, name)
        }
        velocity = self.velocity(target)
        if any(velocity):
            return WalkCommand(op="walk", velocity=velocity, hold=HOLD, **changes)
        if changes:
            return WalkCommand(op="set", **changes)
        return WalkCommand(op="stop")


def _next(names: Sequence[str], name: str) -> str:
    return names[(names.index(name) + 1) % len(names)] if name in names else names[0]
