"""Joint setpoints of a LoLA client: the last value that it sent for each joint."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from bridge.adapters.lola.codec import Map
from bridge.body.joints import JOINTS, N_JOINTS, degrees_warning

JOINT_KEYS = ("Position", "Stiffness")


class MapError(NamedTuple):
    """An error in a client's map."""

    kind: str
    """The same for the same mistake, whatever the joint and the value."""
    text: str
    """One sentence."""


class Setpoints:
    """Keeps the last value of each joint: a map may leave out keys, whose joints then stay as they were.

    Args:
        position: 25 measured angles, rad: where the joints stay until the client sends others.
        stiffness: 25 stiffnesses in force, likewise.
    """

    def __init__(self, position: Sequence[float], stiffness: Sequence[float]) -> None:
        self._values = {"Position": list(position), "Stiffness": list(stiffness)}

    def update(self, values: Map) -> list[MapError]:
        """Take over the joint values of a map; LEDs and unknown keys are ignored.

        An array of another length is ignored, an element that is no finite number leaves its joint as it was,
        and a stiffness outside -1 to 1 is clipped.

        Returns:
            The first error of each kind.
        """
        errors: dict[str, MapError] = {}
        for key in JOINT_KEYS:
            array = values.get(key, self._values[key])
            if isinstance(array, list) and len(array) == N_JOINTS:
                for slot, value in enumerate(array):
                    error = self._put(key, slot, value)
                    if error is not None:
                        errors.setdefault(error.kind, error)
            else:
                found = f"{len(array)} elements" if isinstance(array, list) else "no array"
                text = f"`{key}` needs {N_JOINTS} numbers and has {found}; it was ignored."
                errors[key] = MapError(f"{key}, length", text)
        return list(errors.values())

    def _put(self, key: str, slot: int, value: object) -> MapError | None:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            text = f"`{key}` of {JOINTS[slot]} is {value!r} and was ignored; a finite number is expected."
            return MapError(f"{key}, number", text)
        if key == "Stiffness" and not -1.0 <= value <= 1.0:
            self._values[key][slot] = math.copysign(1.0, value)
            text = f"`{key}` of {JOINTS[slot]} is {value:g} and was clipped; -1 to 1 is allowed."
            return MapError(f"{key}, range", text)
        self._values[key][slot] = float(value)
        if key == "Position" and (why := degrees_warning(JOINTS[slot], value)):
            return MapError(f"{key}, range", f"`{key}` of {why}")
        return None

    @property
    def position(self) -> tuple[float, ...]:
        """Of all joints, rad."""
        return tuple(self._values["Position"])

    @property
    def stiffness(self) -> tuple[float, ...]:
        """Of all joints."""
        return tuple(self._values["Stiffness"])
