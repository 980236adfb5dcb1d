"""What an admittance does over the phases of the walk: hold, release, comply.

The thesis lets the admittance act on the swing leg only and leaves open what becomes of its offset. Here:

- *hold* (stance): the offset with which the foot came down is kept, so that the robot stands on the ground it
  found.
- *release* (swing, first half): the offset returns to zero in the shape in which the foot is lifted (the cubic
  with zero end slopes), so that a foot on an obstacle lower than the lift never presses on it while it rises.
  The residual load of a foot that is just leaving the ground has no effect.
- *comply* (swing, second half): the equations of 4.1 run on the measured forces.
"""

from __future__ import annotations

from typing import Final

APEX: Final = 0.5
"""Fraction of the single support at which the swing foot is highest and release turns into comply."""


def kept(progress: float) -> float:
    """Fraction of a held offset that is left at `progress` (0..1) of the swing."""
    return 1.0 - _smooth(progress / APEX)


def lowered(progress: float) -> float:
    """Fraction of its depth below the ground that the target has at `progress` (0..1) of the swing."""
    return _smooth((progress - APEX) / (1.0 - APEX))


def clip(value: float, lower: float, upper: float) -> float:
    """`value`, or the nearer of two bounds."""
    return max(lower, min(value, upper))


def _smooth(s: float) -> float:
    s = clip(s, 0.0, 1.0)
    return s * s * (3.0 - 2.0 * s)
