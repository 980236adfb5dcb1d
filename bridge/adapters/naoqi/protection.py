"""ALMotion's conditions of a walk, stiff legs and ground under the feet; `setMotionConfig` switches them."""

from __future__ import annotations

from typing import Any, Final

from bridge.adapters.naoqi.arguments import flag, pairs, text
from bridge.adapters.naoqi.joints import Joints
from bridge.adapters.naoqi.names import CHAINS
from bridge.adapters.naoqi.robot_events import CONTACT
from bridge.errors import NaoqiRefused
from bridge.validation import unknown_name

STIFF: Final = 0.6
"""Stiffness of the legs that a walk needs more of (confirmed: vendor's page)."""
FEET: Final = "ENABLE_FOOT_CONTACT_PROTECTION"
STIFFNESS: Final = "ENABLE_STIFFNESS_PROTECTION"
BEGINNING: Final = frozenset(
    {
        *("move", "moveTo", "moveToward", "walkTo", "setWalkTargetVelocity", "setFootSteps"),
        *("setFootStepsWithSpeed", "navigateTo", "moveStraightTo"),
    }
)
"""Methods that begin a walk."""


def stays_stiff(stiffnesses: Any) -> bool:
    """Whether legs of these stiffnesses can walk."""
    values = stiffnesses if isinstance(stiffnesses, list) else [stiffnesses]
    return all(isinstance(value, int | float) and value > STIFF for value in values)


class WalkProtection:
    """Not thread-safe, the caller locks.

    Args:
        joints: of the robot.
    """

    def __init__(self, joints: Joints) -> None:
        self._joints = joints
        self._enabled = {FEET: True, STIFFNESS: True}

    def configure(self, config: Any) -> None:
        """Switch conditions on or off: `[[name, True or False], ...]`.

        Raises:
            NaoqiRefused: not such a list, or an unknown name; nothing is changed then.
        """
        wanted = {}
        for name, value in pairs(config, "ALMotion.setMotionConfig"):
            if text(name, "ALMotion.setMotionConfig: name") not in self._enabled:
                raise NaoqiRefused(f"ALMotion.setMotionConfig: {unknown_name('name', name, self._enabled)}.")
            wanted[name] = flag(value, f"ALMotion.setMotionConfig: {name}")
        self._enabled |= wanted

    def require(self, method: str) -> None:
        """See that a walk may begin.

        Args:
            method: that begins it, with its service.

        Raises:
            NaoqiRefused: a condition that is on does not hold; names it.
        """
        frame = self._joints.frame
        if self._enabled[FEET] and sum(frame.fsr) <= CONTACT:
            raise NaoqiRefused(
                f"{method}: no foot touches the ground; put the robot on its feet, or switch {FEET} "
                "off with setMotionConfig."
            )
        soft = [j for leg in ("LLeg", "RLeg") for j in CHAINS[leg] if self._joints.stiffness(j) <= STIFF]
        if self._enabled[STIFFNESS] and soft:
            raise NaoqiRefused(
                f"{method}: the stiffness of {soft[0]} is not above {STIFF:g}; call wakeUp or "
                f"setStiffnesses first, or switch {STIFFNESS} off with setMotionConfig."
            )
