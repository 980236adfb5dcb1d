"""Arguments of any kind, for calls and messages."""

from __future__ import annotations

import random
from typing import Any

ATOMS: list[Any] = [
    *(None, True, False, 0, 1, -1, 2, 63, 100, 2**31, 2**63, 0.0, 0.5, -0.5, 1.0, 1e9, -1e300),
    *(float("nan"), float("inf"), "", "Body", "Head", "HeadYaw", "LArm", "Torso", "Legs", "LLeg", "CameraTop"),
    *("FaceLeds", "English", "speed", "Face", "me", "TouchChanged", "ClearAll", "time-mixed", "\0", "x" * 300),
    *(b"bytes", {}, {"a": 1}, [], [0.1] * 6, [1.0, 0.0, 0.0] * 4, ["HeadYaw", "HeadPitch"], [[0.1], [0.2]]),
]


def some(draw: random.Random, depth: int = 2) -> Any:
    """One argument."""
    if depth and draw.random() < 0.25:
        return [some(draw, depth - 1) for _ in range(draw.randrange(4))]
    return draw.choice(ATOMS)
