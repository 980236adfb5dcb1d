"""Faults of joints: jammed, weak, hot, with more backlash, and all of them without power."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from bridge.body.joints import INDEX_WITH_MIRROR, JOINTS
from bridge.messages.faults import JointBacklash, JointFault, JointHot, JointLimp, JointStuck, JointWeak
from emulator.engine.base import Multibody
from emulator.servo.servo import Servo

JAM_TORQUE: Final = 100.0
"""Torque that a jammed gear withstands, N m: far above any motor's stall torque."""


class JointFaults:
    """Puts faults into the drives of one robot.

    Args:
        robot: Whose joints.
        servo: Their drives.
    """

    def __init__(self, robot: Multibody, servo: Servo) -> None:
        self._robot, self._servo = robot, servo
        self._sound = (servo.strength.copy(), servo.backlash.copy())
        self._hot: list[tuple[list[int], float]] = []

    def has(self, joint: str) -> bool:
        """The body has this joint, with a motor of its own in the model."""
        return bool(self._numbers(joint))

    def _numbers(self, joint: str) -> list[int]:
        """Places of the mechanical joints that a frame's joint means: HipYawPitch is two."""
        return [i for i, name in enumerate(self._robot.joints) if JOINTS[INDEX_WITH_MIRROR[name]] == joint]

    def apply(self, faults: Iterable[JointFault], powered: bool) -> None:
        """Put exactly these faults in force; to be called when they change.

        Args:
            faults: Of joints.
            powered: The motors have power.
        """
        servo = self._servo
        strength, backlash = (values.copy() for values in self._sound)
        jammed: list[str] = []
        self._hot = []
        for fault in faults:
            numbers = self._numbers(fault.joint)
            if isinstance(fault, JointWeak):
                strength[numbers] *= fault.fraction
            elif isinstance(fault, JointLimp):
                strength[numbers] = 0.0
            elif isinstance(fault, JointBacklash):
                backlash[numbers] += fault.backlash
            elif isinstance(fault, JointHot):
                self._hot.append((numbers, fault.temperature))
            elif isinstance(fault, JointStuck):
                jammed += [self._robot.joints[i] for i in numbers]
        servo.strength[:] = strength if powered else np.zeros_like(strength)
        servo.backlash[:] = backlash
        self._robot.lock(jammed, JAM_TORQUE)
        servo.apply_power()

    def hold_heat(self) -> None:
        """Once per cycle: hold hot motors at their temperature."""
        if self._hot:
            servo = self._servo
            for numbers, temperature in self._hot:
                servo.heat.temperature[numbers] = temperature
            servo.apply_power()
