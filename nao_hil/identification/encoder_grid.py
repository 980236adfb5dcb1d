"""Whether recorded angles are an encoder's: on a grid of its steps, with a shift."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.joints import JOINTS
from bridge.body.quantities import HANDS
from bridge.types import Array

_VALUES: Final = 8
"""Different angles that a joint needs: eight random ones seem to be on a grid once in a thousand."""
_ON_GRID: Final = 0.95
"""Least length of the mean of unit vectors that make one turn a step: the angles then scatter by 0.05 steps at
most, as those rounded to four decimals do."""


class JointGrid(msgspec.Struct, frozen=True, kw_only=True):
    """Angles of one joint."""

    on_grid: bool
    shift: float
    """Of the grid from zero, by half a step at most, rad; meaningless off the grid."""


class EncoderGrid(msgspec.Struct, frozen=True, kw_only=True):
    """Angles of all joints that moved."""

    step: float
    """rad"""
    joints: dict[str, JointGrid]

    @property
    def sentence(self) -> str:
        """The result in words."""
        if not self.joints:
            return "No joint moves enough to tell whether its angles are the encoder's."
        on = {name: joint for name, joint in self.joints.items() if joint.on_grid}
        grid = f"the encoders' grid of {self.step:.3e} rad"
        if not on:
            return f"No joint's angles are on {grid}: they are filtered, interpolated or not measured."
        shifts = [abs(joint.shift) for joint in on.values()]
        off = [name for name in self.joints if name not in on]
        return (
            f"Angles of {len(on)} of {len(self.joints)} joints are on {grid}, shifted by "
            f"{np.median(shifts):.1e} rad in the median ({min(shifts):.1e} to {max(shifts):.1e})"
            f"{'; not those of ' + ', '.join(off) if off else ''}."
        )


def encoder_grid(body: Body, measured: Mapping[str, Array]) -> EncoderGrid:
    """Test each joint that has taken enough angles.

    Args:
        body: Gives the encoders' step.
        measured: Measured signals; `position` is read, (n, 25), as recorded, rad.
    """
    step = 2.0 * np.pi / body.encoder_steps
    position = measured.get("position", np.empty((0, len(JOINTS))))
    joints = {}
    for number, name in enumerate(JOINTS):
        values = np.unique(position[np.isfinite(position[:, number]), number])
        if name not in HANDS and len(np.unique(np.rint(values / (0.5 * step)))) >= _VALUES:
            mean = np.exp(2j * np.pi * values / step).mean()
            shift = float(np.angle(mean) / (2.0 * np.pi) * step)
            joints[name] = JointGrid(on_grid=bool(abs(mean) >= _ON_GRID), shift=shift)
    return EncoderGrid(step=step, joints=joints)
