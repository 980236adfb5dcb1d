"""What a client of LoLA wants of the joints, over maps that each name only a part of it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bridge.joints import JOINTS, N_JOINTS
from bridge.lola.wire import Map

JOINT_KEYS = ("Position", "Stiffness")


class Demand:
    """Keeps the last value of each joint; what a map leaves out stays as it was.

    Args:
        position: where the joints are wanted before the client has said so: as measured, rad.
        stiffness: likewise, as in force.
    """

    def __init__(self, position: Sequence[float], stiffness: Sequence[float]) -> None:
        self._wanted = {"Position": list(position), "Stiffness": list(stiffness)}

    def take(self, values: Map) -> str:
        """Take over what a map says of the joints; lights and unknown keys are let pass.

        An array of another length is ignored, an element that is no finite number leaves its joint as it was,
        and a stiffness outside -1 to 1 is clipped.

        Returns:
            One sentence on what was wrong with the map; empty when nothing was.
        """
        wrong = ""
        for key in JOINT_KEYS:
            array = values.get(key, self._wanted[key])
            if isinstance(array, list) and len(array) == N_JOINTS:
                for slot, value in enumerate(array):
                    wrong = self._put(key, slot, value) or wrong
            else:
                found = f"{len(array)} elements" if isinstance(array, list) else "no array"
                wrong = f"`{key}` needs {N_JOINTS} numbers and has {found}; it was ignored."
        return wrong

    def _put(self, key: str, slot: int, value: object) -> str:
        if not isinstance(value, (int, float)) or not math.isfinite(value):
            return f"`{key}` of {JOINTS[slot]} is {value!r} and was ignored; a finite number is expected."
        if key == "Stiffness" and not -1.0 <= value <= 1.0:
            self._wanted[key][slot] = math.copysign(1.0, value)
            return f"`{key}` of {JOINTS[slot]} is {value:g} and was clipped; -1 to 1 is allowed."
        self._wanted[key][slot] = float(value)
        return ""

    @property
    def position(self) -> tuple[float, ...]:
        """Of all joints, rad."""
        return tuple(self._wanted["Position"])

    @property
    def stiffness(self) -> tuple[float, ...]:
        """Of all joints."""
        return tuple(self._wanted["Stiffness"])
