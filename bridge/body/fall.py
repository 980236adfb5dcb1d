"""When a robot has fallen: its torso leans by more than `FALLEN_TILT`.

Everything that looks back on a robot uses this definition: NAOqi's `robotHasFallen` and a run without a ground
truth by the fused angle, the ground truth by the true one. Four differ, each for a reason:

- The ground truth (`emulator/sampling.py`) also counts a link other than the feet on the ground, and a torso
  that is too low: a robot that kneels has fallen upright.
- The guard (`FallSettings` in `bridge/guard/config.py`) releases the joints before the impact: at a smaller
  tilt, held for some cycles, after an upright stand; one that sits or gets up leans as far.
- The walker (`FallParameters` in `walker/estimation/fall.py`) braces earlier still, by roll or pitch alone,
  names the axis, and knows when a capture step leans on purpose. It also counts a walk without ground under it.
- The side on which a robot lies (`lying` in `bridge/motion/player.py`) chooses its get-up motion.
"""

from __future__ import annotations

import math
from typing import Final

from bridge.types import Vec2

FALLEN_TILT: Final = math.radians(45.0)
"""Tilt of the torso from which a robot counts as fallen, rad."""


def tilt(angle: Vec2) -> float:
    """Angle between the torso and the vertical, rad: cos(tilt) = cos(roll) cos(pitch).

    Args:
        angle: roll and pitch of the torso, rad.
    """
    roll, pitch = angle
    return math.acos(max(-1.0, min(1.0, math.cos(roll) * math.cos(pitch))))


def has_fallen(tilt: float) -> bool:
    """Whether a robot whose torso leans by this much counts as fallen.

    Args:
        tilt: angle between the torso and the vertical, rad.
    """
    return tilt > FALLEN_TILT
