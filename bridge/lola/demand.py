"""What a client of LoLA wants of the joints, over maps that each name only a part of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from bridge.joints import JOINTS, N_JOINTS
from bridge.lola.wire import Map

JOINT_KEYS = ("Position", "Stiffness")


class Fault(NamedTuple):
    """What was wrong with a map."""

    kind: str
    """The same for the same mistake, whatever the joint and the value."""
    text: str
    """One sentence."""


class Demand:
    """Keeps the last value of each joint; what a map leaves out stays as it was.

    Args:
        position: where the joints are wanted before the client has said so: as measured, rad.
        stiffness: likewise, as in force.
    """

    def __init__(self, position: Sequence[float], stiffness: Sequence[float]) -> None:
        self._wanted = {"Position": list(position), "Stiffness": list(stiffness)}

    def take(self, values: Map) -> list[Fault]:
        """Take over what a map says of the joints; lights and unknown keys are let pass.

        An array of another length is ignored, an element that is no finite number leaves its joint as it was,
        and a stiffness outside -1 to 1 is clipped.

        Returns:
            What was wrong with the map; of each kind the first.
        """
        wrong: dict[str, Fault] = {}
        for key in JOINT_KEYS:
            array = values.get(key, self._wanted[key])
            if isinstance(array, list) and len(array) == N_JOINTS:
                for slot, value in enumerate(array):
                    fault = self._put(key, slot, value)
                    if fault is not None:
                        wrong.setdefault(fault.kind, fault)
            else:
                found = f"{len(array)} elements" if isinstance(array, list) else "no array"
                text = f"`{key}` needs {N_JOINTS} numbers and has {found}; it was ignored."
                fault = Fault(f"{key}, length", text)
                wrong[fault.kind] = fault
        return list(wrong.values())

    def _put(self, key: str, slot: int, value: object) -> Fault | None:
        if not isinstance(value, (int, float)) or not math.isfinite(value):
            text = f"`{key}` of {JOINTS[slot]} is {value!r} and was ignored; a finite number is expected."
            return Fault(f"{key}, number", text)
        if key == "Stiffness" and not -1.0 <= value <= 1.0:
            self._wanted[key][slot] = math.copysign(1.0, value)
            text = f"`{key}` of {JOINTS[slot]} is {value:g} and was clipped; -1 to 1 is allowed."
            return Fault(f"{key}, range", text)
        self._wanted[key][slot] = float(value)
        return None

    @property
    def position(self) -> tuple[float, ...]:
        """Of all joints, rad."""
        return tuple(self._wanted["Position"])

    @property
    def stiffness(self) -> tuple[float, ...]:
        """Of all joints."""
        return tuple(self._wanted["Stiffness"])
