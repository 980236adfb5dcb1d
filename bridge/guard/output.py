"""Commands to the drives: checked against the joint ranges, limited in speed."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Final

import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX, JOINTS, N_JOINTS
from bridge.body.quantities import COUPLED_TO, HANDS, CoupledRange, absent_joints, joint_no_load_speed, limits
from bridge.errors import FrameError
from bridge.messages import ActuatorFrame, SensorFrame
from bridge.messages.codec import require_finite
from bridge.types import Array

TOLERANCE: Final = math.radians(0.05)
"""rad beyond a limit that are clipped without a notice: less than its digits show."""
_ROUNDING: Final = 1e-12


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
        self._ranges = {joint: CoupledRange(body, joint) for joint in self._coupled}
        self.clipped = ""
        """One sentence on the clipped joint of the last `check`; empty: none."""

    def check(self, frame: ActuatorFrame, seq: int) -> ActuatorFrame:
        """The frame with its angles inside their ranges; the slots of absent joints become 0.

        Args:
            frame: as received.
            seq: of the robot's present sensor frame.

        Raises:
            FrameError: an element that is not finite, a stiffness outside -1..1, or an answer to a future
                frame; names the field, the joint and the value.
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
        """As `clip`, and one sentence on the first clipped joint."""
        asked = np.array(wanted)
        asked[self._absent] = 0.0
        position = np.minimum(np.maximum(asked, self._lower), self._upper).tolist()
        # a coupled range follows the clipped angle of the other joint
        for joint, (slot, other) in self._coupled.items():
            lower, upper = self._ranges[joint].at(position[other])
            position[slot] = min(max(position[slot], lower), upper)
        outside = np.flatnonzero(np.abs(asked - position) > TOLERANCE)
        return tuple(position), self._sentence(int(outside[0]), asked, position) if outside.size else ""

    def _sentence(self, slot: int, asked: Array, position: Sequence[float]) -> str:
        """Notice of a clipped joint."""
        joint = JOINTS[slot]
        lower, upper = self._lower[slot], self._upper[slot]
        if joint in self._coupled:
            lower, upper = self._ranges[joint].at(position[self._coupled[joint][1]])
        wanted = f"{asked[slot]:.3f}" if abs(asked[slot]) < 1e4 else f"{asked[slot]:.3g}"
        return (
            f"{joint} was asked to {wanted} rad and clipped to {position[slot]:.3f} rad; its range "
            f"here is {lower:.3f} to {upper:.3f} rad."
        )


def require_numbers(frame: ActuatorFrame) -> None:
    """Check the bounds of a command's numbers that hold on any body.

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
        self._ranges = {joint: CoupledRange(body, joint) for joint, *_ in self._couplings}
        self.steps: Array = np.full(N_JOINTS, np.inf)
        """Longest way of each joint in one cycle, rad."""
        for joint in body.joints:
            if joint in INDEX:
                self.steps[INDEX[joint]] = ratio * joint_no_load_speed(body, joint) * body.cycle
        self.last: tuple[float, ...] | None = None
        """Positions put out last, 25 slots, rad; None: none yet."""

    def follow(
        self, wanted: Sequence[float], slow: Collection[int] = (), speed: float = math.inf
    ) -> tuple[float, ...]:
        """Move one cycle towards `wanted`.

        Args:
            wanted: 25 positions inside their ranges.
            slow: slots of joints that arrive together, so that a crouched robot rises through stable poses; the
                others have only the drives' own limits.
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
        lower, upper = self._ranges[joint].at(out[other])
        start, way = self.last[slot], min(max(wanted, lower), upper) - self.last[slot]
        for step in paces:
            out[slot] = start + way if abs(way) <= step else start + min(max(way, -step), step)
            if lower - _ROUNDING <= out[slot] <= upper + _ROUNDING:
                return
        out[other] = self.last[other]
        lower, upper = self._ranges[joint].at(out[other])
        out[slot] = min(max(out[slot], lower), upper)


class JointOutput:
    """The joints' last commands; all positions are 25 in frame order, rad, inside their ranges.

    Args:
        body: data sheet.
        speed_ratio: limit of each joint's speed over its no-load speed.
    """

    def __init__(self, body: Body, speed_ratio: float) -> None:
        self.ranges = Ranges(body)
        self._limiter = SpeedLimiter(body, speed_ratio)
        absent = absent_joints(body)
        self._revolute = [i for i, joint in enumerate(JOINTS) if joint not in absent and joint not in HANDS]
        self.stiffness: tuple[float, ...] | None = None
        """25 stiffnesses put out last; None: the joints are left alone."""

    @property
    def position(self) -> tuple[float, ...] | None:
        """25 positions put out last; None: the joints are left alone."""
        return self._limiter.last if self.stiffness is not None else None

    def set_position(self, position: Sequence[float]) -> None:
        """Take `position` as the positions put out last."""
        self._limiter.last = tuple(position)

    def move_towards(
        self, position: Sequence[float], slow: Collection[int] = (), speed: float = math.inf
    ) -> tuple[float, ...]:
        """Positions of this cycle on the way to `position`.

        Args:
            position: goal.
            slow: joints that arrive together.
            speed: rad/s that none of them exceeds; the others have the drives' own limits.
        """
        return self._limiter.follow(position, slow, speed)

    def start(self, frame: SensorFrame, weak: float) -> tuple[float, ...]:
        """Beginning of a motion: positions put out last, or measured ones of weak joints.

        Args:
            frame: measured positions.
            weak: largest stiffness of a weak joint.
        """
        last, stiffness = self._limiter.last, self.stiffness
        if last is None or stiffness is None:
            return self.ranges.clip(frame.position)
        free = [i for i in self._revolute if stiffness[i] <= weak]
        if not free:
            return last
        start = list(last)
        for i in free:
            start[i] = frame.position[i]
        return self.ranges.clip(start)

    def stiffened(self, command: ActuatorFrame) -> list[int]:
        """Free joints that the command makes stiff."""
        old = self.stiffness or command.stiffness
        return [i for i in self._revolute if old[i] <= 0.0 < command.stiffness[i]]

    def joint_travel(self, start: Sequence[float], command: ActuatorFrame) -> dict[int, float]:
        """Distance of each joint with a commanded stiffness from `start` to the command, rad."""
        return {i: abs(start[i] - command.position[i]) for i in self._revolute if command.stiffness[i] > 0.0}
