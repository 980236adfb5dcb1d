"""How the arms hang in a walk."""

from __future__ import annotations

from typing import Final

ARMS: Final = {
    "LShoulderPitch": 1.5,
    "LShoulderRoll": 0.15,
    "LElbowYaw": -1.2,
    "LElbowRoll": -0.4,
    "RShoulderPitch": 1.5,
    "RShoulderRoll": -0.15,
    "RElbowYaw": 1.2,
    "RElbowRoll": 0.4,
}
"""Arms hanging at the sides, elbows a little bent, clear of the legs; rad."""
