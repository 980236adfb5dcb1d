"""ALMotion's fall manager: a robot that falls ends its motions and goes limp, unless it is switched off."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from bridge.adapters.naoqi.arguments import flag
from bridge.adapters.naoqi.joint_motion import JointMotion
from bridge.adapters.naoqi.joints import Joints
from bridge.guard.config import FallSettings
from bridge.guard.fall import FallMonitor
from bridge.messages import SensorFrame
from bridge.stance import STANCE

STIFFNESS: Final = FallSettings().stiffness
"""Of all joints in a fall (assumed: the vendor's page says only that the stiffness is reduced)."""


class FallManager:
    """Watches each frame; not thread-safe, the caller locks.

    Args:
        joints: of the robot.
        motion: whose motions end in a fall.
    """

    def __init__(self, joints: Joints, motion: JointMotion) -> None:
        self._joints, self._motion = joints, motion
        self._monitor = FallMonitor(joints.body, FallSettings(), STANCE)
        self.enabled = True

    def update(self, frame: SensorFrame, *, leaning: bool) -> bool:
        """One cycle; whether the robot goes limp in it.

        Args:
            frame: newest.
            leaning: a motion to a posture wants the torso to lean; that is no fall.
        """
        if not self._monitor.update(frame) or leaning or not self.enabled:
            return False
        self._motion.end_all()
        for joint in self._joints.names.all:
            if self._joints.stiffness(joint) > STIFFNESS:
                self._joints.put_stiffness(joint, [(0.0, STIFFNESS)])
        return True

    def methods(self) -> dict[str, Callable[..., Any]]:
        """Methods of `ALMotion`."""

        def put(enabled: Any) -> None:
            self.enabled = flag(enabled, "ALMotion.setFallManagerEnabled: enabled")

        return {"setFallManagerEnabled": put, "getFallManagerEnabled": lambda: self.enabled}
