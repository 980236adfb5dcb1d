"""State of the robot in words, from its own report and its sensors."""

from __future__ import annotations

from typing import Any, Final

from bridge.messages.guard import GuardStatus
from bridge.messages.walk import WalkStatus, WalkTelemetry
from bridge.messages.world_state import WorldReply
from bridge.motion.player import lying
from nao_hil.runs.monitor import walk_in_force
from nao_hil.runs.run import Cycle

SILENCE_TIMEOUT: Final = 1.0
"""s without a frame after which the robot counts as silent."""
LYING: Final = {"upright": "", "back": "lies on its back", "front": "lies on its front"}
GUARD: Final = {
    "idle": "free, joints left alone",
    "approach": "moves slowly to its first pose",
    "hold": "holds its pose: its controller is silent",
    "crouch": "crouching",
    "sit": "sitting down",
    "rest": "limp",
    "fallen": "limp",
}
"""State of the guard -> words."""
WALK: Final = {
    "approach": "moves to its first pose",
    "stand": "stands",
    "walk": "walks",
    "stopping": "closes its feet",
    "fallen": "has fallen",
    "motion": "plays a motion",
    "rest": "rests",
}
"""State of the walker -> words."""
ALARMS: Final = ("crouch", "rest", "fallen")
"""States of the guard that are shown in red."""


def describe(
    cycle: Cycle | None,
    guard: GuardStatus | None,
    status: WalkStatus | None,
    world: WorldReply | None,
    silent: float,
) -> dict[str, Any]:
    """The state as the page shows it.

    Args:
        cycle: The newest; None: no frame yet.
        guard: The robot's newest report of itself; None: none yet.
        status: The walker's; None: no walker answers.
        world: Of an emulator; None: not known, or a real robot.
        silent: Time since the last frame, s.

    Returns:
        words, alarm (bool), walks (bool: a walker is in force), walking (bool), velocity in force
        (m/s, m/s, rad/s), gait, armed (None: not reported yet), paused, held by, cycles missed.
    """
    paused = world is not None and world.paused
    walk = walk_in_force(guard, cycle.walk, cycle.sensors) if cycle is not None else None
    state: dict[str, Any] = {
        "words": _words(cycle, guard, walk, silent, paused),
        "alarm": guard is not None and guard.state in ALARMS,
        "walks": walk is not None,
        "walking": walk is not None and walk.state == "walk",
        "velocity": list(status.velocity) if walk and status else [0.0, 0.0, 0.0],
        "gait": status.gait if status else "",
        "armed": guard.armed if guard else None,
        "paused": paused,
        "holder": guard.holder if guard else "",
        "missed": cycle.sensors.missed if cycle else 0,
    }
    return state


def _words(
    cycle: Cycle | None, guard: GuardStatus | None, walk: WalkTelemetry | None, silent: float, paused: bool
) -> str:
    if cycle is None:
        return "waits for the robot"
    if silent > SILENCE_TIMEOUT:
        return "paused" if paused else f"no word from the robot for {silent:.0f} s"
    posture = LYING.get(lying(cycle.sensors.angle), "lies on its side")
    if walk is not None:
        words = "gets up" if walk.state == "motion" and posture else WALK.get(walk.state, walk.state)
    elif guard is None:
        words = "state not reported yet"
    elif guard.state == "active" or (guard.state == "idle" and guard.holder):
        words = f"held by {guard.holder or 'another controller'}"
    else:
        words = GUARD[guard.state]
        if guard.reason == "stop":
            words += ", emergency stop"
    return ", ".join(word for word in (words, posture, "paused" if paused else "") if word)
