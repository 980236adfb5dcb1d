"""First checks of an actuator frame: finite numbers, stiffnesses, joint ranges."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX, JOINTS, N_JOINTS
from bridge.body.quantities import COUPLED_TO, absent_joints, coupled_limits, limits
from bridge.errors import FrameError
from bridge.messages import ActuatorFrame
from bridge.messages.codec import require_finite
from bridge.types import Array

TOLERANCE: Final = math.radians(0.05)
"""rad beyond a limit that are clipped without a notice: less than its text would show."""


class Ranges:
    """Checks actuator frames for one body.

    Args:
        body: data sheet, whose ranges and coupling tables are enforced.
    """

    def __init__(self, body: Body) -> None:
        self._body = body
        absent = absent_joints(body)
        self._absent = [INDEX[joint] for joint in absent]
        self._lower, self._upper = np.zeros((2, N_JOINTS))
        for joint in JOINTS:
            if joint not in absent:
                self._lower[INDEX[joint]], self._upper[INDEX[joint]] = limits(body, joint)
        self._coupled = {j: (INDEX[j], INDEX[other]) for j, other in COUPLED_TO.items() if j not in absent}
        self.clipped = ""
        """One sentence on what the last `check` had to clip; empty when nothing."""

    def check(self, frame: ActuatorFrame, seq: int) -> ActuatorFrame:
        """The frame with its angles inside their ranges; the slots of absent joints become 0.

        Args:
            frame: as received.
            seq: of the robot's present sensor frame.

        Raises:
            FrameError: an element that is not finite, a stiffness outside -1..1, or an answer to a frame that
                was not sent yet; names the field, the joint and the value.
        """
        require_numbers(frame)
        if frame.reply_to > seq:
            raise FrameError(
                f"ActuatorFrame refused: reply_to is {frame.reply_to}, but the newest sensor frame is {seq}."
            )
        position, self.clipped = self._clip(frame.position)
        return msgspec.structs.replace(frame, position=position)

    def clip(self, wanted: Sequence[float]) -> tuple[float, ...]:
        """The 25 positions inside their ranges that are nearest to the wanted ones, rad."""
        return self._clip(wanted)[0]

    def _clip(self, wanted: Sequence[float]) -> tuple[tuple[float, ...], str]:
        """As `clip`, and one sentence on the first joint that was outside."""
        asked = np.array(wanted)
        asked[self._absent] = 0.0
        position = np.minimum(np.maximum(asked, self._lower), self._upper).tolist()
        # a coupled range follows the clipped angle of the other joint
        for joint, (slot, other) in self._coupled.items():
            lower, upper = coupled_limits(self._body, joint, position[other])
            position[slot] = min(max(position[slot], lower), upper)
        outside = np.flatnonzero(np.abs(asked - position) > TOLERANCE)
        return tuple(position), self._sentence(int(outside[0]), asked, position) if outside.size else ""

    def _sentence(self, slot: int, asked: Array, position: Sequence[float]) -> str:
        """On a joint that was clipped."""
        joint = JOINTS[slot]
        lower, upper = self._lower[slot], self._upper[slot]
        if joint in self._coupled:
            lower, upper = coupled_limits(self._body, joint, position[self._coupled[joint][1]])
        return (
            f"{joint} was asked to {asked[slot]:.3f} rad and clipped to {position[slot]:.3f} rad; its range "
            f"here is {lower:.3f} to {upper:.3f} rad."
        )


def require_numbers(frame: ActuatorFrame) -> None:
    """See that a command's numbers are what they must be on any body.

    Raises:
        FrameError: an element that is not finite, or a stiffness outside -1..1; names the joint and the value.
    """
    require_finite("position", frame.position)
    require_finite("stiffness", frame.stiffness)
    for joint, value in zip(JOINTS, frame.stiffness, strict=True):
        if not -1.0 <= value <= 1.0:
            raise FrameError(
                f"ActuatorFrame refused: stiffness of {joint} is {value}; it must be between -1 and 1."
            )
