"""Speed limit of the joints: bounds the way from the last output to the wanted position in each cycle."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bridge.body import Body
from bridge.body.joints import INDEX, N_JOINTS
from bridge.body.quantities import COUPLED_TO, coupled_limits, joint_no_load_speed

_ROUNDING: Final = 1e-12


class SpeedLimiter:
    """Follows wanted positions by at most a step per cycle and joint, inside the coupled ranges all the way.

    Hands and absent joints are not limited: the data sheets have no motor for them.

    Args:
        body: data sheet; its motors' no-load speeds over the gears are the limit.
        ratio: times that speed.
    """

    def __init__(self, body: Body, ratio: float = 1.0) -> None:
        self._body = body
        self._couplings = [(j, INDEX[j], INDEX[o]) for j, o in COUPLED_TO.items() if j in body.joints]
        self.steps: NDArray[np.float64] = np.full(N_JOINTS, np.inf)
        """Longest way of each joint in one cycle, rad."""
        for joint in body.joints:
            if joint in INDEX:
                self.steps[INDEX[joint]] = ratio * joint_no_load_speed(body, joint) * body.cycle
        self.last: tuple[float, ...] | None = None
        """What was put out last, 25 slots; None: nothing yet."""

    def follow(
        self, wanted: Sequence[float], slow: Collection[int] = (), speed: float = math.inf
    ) -> tuple[float, ...]:
        """Move one cycle towards `wanted`.

        Args:
            wanted: 25 positions inside their ranges.
            slow: slots of joints that arrive together, so that a crouched robot rises through poses in which
                it stands; the others have only the drives' own limits.
            speed: rad/s that no joint of `slow` exceeds either.

        Returns:
            25 positions inside their ranges; exactly `wanted` when it is within reach.
        """
        assert self.last is not None
        limits = steps = self.steps
        last, goal = np.array(self.last), np.array(wanted)
        way = goal - last
        if slow:
            together = np.zeros(N_JOINTS, dtype=bool)
            together[list(slow)] = True
            limits = np.where(together, np.minimum(limits, speed * self._body.cycle), limits)
            farthest = float(np.abs(way[together]).max())
            fraction = min(1.0, speed * self._body.cycle / farthest) if farthest > 0.0 else 1.0
            steps = np.minimum(limits, np.where(together, fraction * np.abs(way), np.inf))
        if (np.abs(way) <= steps).all():
            self.last = tuple(wanted)
        else:
            out = np.where(np.abs(way) <= steps, goal, last + np.clip(way, -steps, steps)).tolist()
            for joint, slot, other in self._couplings:
                self._couple(joint, slot, other, out, wanted[slot], (float(steps[slot]), float(limits[slot])))
            self.last = tuple(out)
        return self.last

    def _couple(
        self, joint: str, slot: int, other: int, out: list[float], wanted: float, paces: tuple[float, float]
    ) -> None:
        """Keep a coupled joint in its range: by a longer step, or the other joint waits.

        Args:
            joint: the coupled one.
            slot: its slot.
            other: slot of the joint that its range depends on.
            out: 25 positions of this cycle, rad; changed in place.
            wanted: goal of the joint, rad.
            paces: steps to try, rad.
        """
        assert self.last is not None
        lower, upper = coupled_limits(self._body, joint, out[other])
        start, way = self.last[slot], min(max(wanted, lower), upper) - self.last[slot]
        for step in paces:
            out[slot] = start + way if abs(way) <= step else start + min(max(way, -step), step)
            if lower - _ROUNDING <= out[slot] <= upper + _ROUNDING:
                return
        out[other] = self.last[other]
        lower, upper = coupled_limits(self._body, joint, out[other])
        out[slot] = min(max(out[slot], lower), upper)
