"""Faults of joints: jammed, weak, hot, with more play, and all of them without power."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from bridge.faults import JointFault, JointHot, JointPlay, JointStuck, JointWeak
from bridge.joints import INDEX_WITH_MIRROR, JOINTS
from emulator.mechanics import Mechanics


class JointFaults:
    """Puts faults into the drives of one robot.

    Args:
        mechanics: The robot.
    """

    def __init__(self, mechanics: Mechanics) -> None:
        self._mechanics = mechanics
        servo = mechanics.servo
        self._sound = (servo.strength.copy(), servo.play.copy())
        self._hot: list[tuple[list[int], float]] = []

    def has(self, joint: str) -> bool:
        """The body has this joint, with a motor of its own in the model."""
        return bool(self._numbers(joint))

    def _numbers(self, joint: str) -> list[int]:
        """Places of the mechanical joints that a frame's joint means: HipYawPitch is two."""
        names = self._mechanics.model.joints
        return [i for i, name in enumerate(names) if JOINTS[INDEX_WITH_MIRROR[name]] == joint]

    def apply(self, faults: Iterable[JointFault], powered: bool) -> None:
        """Put exactly these faults in force; to be called when they change."""
        servo = self._mechanics.servo
        strength, play = (values.copy() for values in self._sound)
        jammed: list[int] = []
        self._hot = []
        for fault in faults:
            numbers = self._numbers(fault.joint)
            if isinstance(fault, JointWeak):
                strength[numbers] *= fault.share
            elif isinstance(fault, JointPlay):
                play[numbers] += fault.play
            elif isinstance(fault, JointHot):
                self._hot.append((numbers, fault.temperature))
            elif isinstance(fault, JointStuck):
                jammed += numbers
        servo.strength[:] = strength if powered else np.zeros_like(strength)
        servo.play[:] = play
        self._mechanics.jam(frozenset(jammed))
        servo.apply_power()

    def hold_heat(self) -> None:
        """Once per cycle: hold hot motors at their temperature."""
        if self._hot:
            servo = self._mechanics.servo
            for numbers, temperature in self._hot:
                servo.heat.temperature[numbers] = temperature
            servo.apply_power()
