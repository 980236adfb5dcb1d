"""Head and arms while the walker has the robot: the walk leaves them to the program.

The head is the program's always, an arm by `setMoveArmsEnabled`; a motion of the program has precedence over
the walk's arms (vendor's sample motion_walk.py: "arms motion from user have always the priority").
"""

from __future__ import annotations

from typing import Any, Final

from bridge.adapters.naoqi.core.joints import CHAINS, Joints, slot
from bridge.adapters.naoqi.declared import Answers, flag, offers
from bridge.errors import NaoqiRefused
from bridge.messages.walk import UpperBody
from bridge.validation import unknown_name

_SIDES: Final = ("LArm", "RArm")


class UpperBodyShare:
    """Not thread-safe, the caller locks.

    Args:
        joints: of the robot.
    """

    def __init__(self, joints: Joints) -> None:
        self._joints = joints
        self._swings = dict.fromkeys(_SIDES, True)
        """Whether the walk moves an arm."""
        self._upper = joints.names.resolve(["Head", *_SIDES])
        self.taken: set[str] = set()
        """Joints that are not the walker's while it has the robot."""

    def begin(self) -> None:
        """The walker gets the robot."""
        kept = ["Head", *(side for side in _SIDES if not self._swings[side])]
        moving = (joint for joint in self._upper if self._joints.waits(joint))
        self.taken = {*self._joints.names.resolve(kept), *moving}

    def within(self, names: Any) -> tuple[str, ...] | None:
        """Joints that a call names, if all of them are of the head and the arms; else None."""
        try:
            joints = self._joints.names.resolve(names)
        except NaoqiRefused:
            return None
        return joints if set(joints) <= set(self._upper) else None

    def order(self, *, walks: bool) -> UpperBody:
        """Order to the walker in this cycle.

        Args:
            walks: the robot walks: arms are the walk's again once no motion of the program moves them.
        """
        if walks:
            for side in _SIDES:
                if self._swings[side]:
                    self.taken -= {j for j in CHAINS[side] if j in self.taken and not self._joints.waits(j)}
        sent = self._joints.answer()
        slots = {joint: slot(joint) for joint in self._upper if joint in self.taken}
        return UpperBody(
            joints=tuple(slots),
            position=tuple(sent.position[i] for i in slots.values()),
            stiffness=tuple(sent.stiffness[i] for i in slots.values()),
        )

    @offers("ALMotion.setMoveArmsEnabled", "ALMotion.setWalkArmsEnabled")
    def _set_move_arms_enabled(self, left: Any, right: Any) -> Any:
        for side, value in zip(_SIDES, (left, right), strict=True):
            self._swings[side] = flag(value, f"ALMotion.setMoveArmsEnabled: {side}")
            if not self._swings[side]:
                self.taken |= set(self._joints.names.resolve(side))

    @offers("ALMotion.getMoveArmsEnabled")
    def _get_move_arms_enabled(self, arm: Any = "Arms") -> Any:
        if arm == "Arms":
            return all(self._swings.values())
        if arm not in _SIDES:
            raise NaoqiRefused(f"ALMotion.getMoveArmsEnabled: {unknown_name('chain', str(arm), _SIDES)}.")
        return self._swings[arm]

    answers = Answers({"ALMotion.getWalkArmsEnabled": lambda self: [self._swings[side] for side in _SIDES]})
