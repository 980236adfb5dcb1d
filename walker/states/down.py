"""The states of a robot that is down or plays a motion: fallen, resting, moving; and when it gets up."""

from __future__ import annotations

import math
from typing import Final

from bridge.body import Body
from bridge.body.joints import INDEX
from bridge.messages import SensorFrame
from bridge.motion import GetUp, Lying, MotionPlayer, get_up_motions
from bridge.stance import stands
from walker.estimation.fall import FallParameters
from walker.estimation.ground import Corrections
from walker.monitor import Estimate
from walker.states.state import State, StateName, legs_hold

_LEG_POSE: Final = {"HipPitch": -0.9, "KneePitch": 1.8, "AnklePitch": -0.9}
"""Angles of both legs, rad: the mass falls less far, and the soles stay level. Other joints stay."""
_HIP_COUNTER_TURN: Final = {"HipRoll": 0.3, "HipPitch": 0.6}
"""Turn of the hips of both legs in the direction of the fall, rad: the torso turns back over the legs and
leans later. The ranges of HipPitch and HipRoll leave no more."""
_HEAD_PITCH: Final = {"front": -0.65, "back": 0.5}
"""HeadPitch: the face away from the ground, or the chin on the chest (NaoTH turns it the same ways)."""
_ARM_POSE: Final = {"ShoulderPitch": 0.3, "ElbowRoll": -0.8}
"""Angles of the left arm, mirrored for the right: stretched ahead and bent, so that elbow and forearm reach the
ground before the head."""


def brace(frame: SensorFrame) -> tuple[float, ...]:
    """The pose before the impact, 25 in frame order, rad.

    Args:
        frame: when the fall is detected; the direction of the torso's fall gives the side.
    """
    position = list(frame.position)
    position[INDEX["HeadYaw"]] = 0.0
    roll, pitch = (angle + 0.2 * rate for angle, rate in zip(frame.angle, frame.gyroscope, strict=False))
    size = math.hypot(roll, pitch) or 1.0
    position[INDEX["HeadPitch"]] = _HEAD_PITCH["front" if pitch > 0.0 else "back"]
    for side, sign in (("L", 1.0), ("R", -1.0)):
        for joint, angle in _LEG_POSE.items():
            position[INDEX[side + joint]] = angle
        position[INDEX[f"{side}HipRoll"]] += _HIP_COUNTER_TURN["HipRoll"] * roll / size
        position[INDEX[f"{side}HipPitch"]] += _HIP_COUNTER_TURN["HipPitch"] * pitch / size
        position[INDEX[f"{side}ShoulderPitch"]] = _ARM_POSE["ShoulderPitch"]
        position[INDEX[f"{side}ElbowRoll"]] = sign * _ARM_POSE["ElbowRoll"]
    return tuple(position)


class Fallen:
    """Lies limply, so that gears and limbs yield to the ground: each joint's target is its own angle.

    Args:
        frame: when the fall is detected.
        parameters: stiffness, and how long to brace.
        braces: first move into the pose of `brace`.
        gave_up: getting up failed; it is not tried again.
    """

    name: Final[StateName] = "fallen"
    corrections: Final = Corrections()

    def __init__(
        self, frame: SensorFrame, parameters: FallParameters, *, braces: bool = False, gave_up: bool = False
    ) -> None:
        self._p, self._braces = parameters, braces
        self.position = brace(frame) if braces else frame.position
        self.stiffness = parameters.brace_stiffness if braces else parameters.stiffness
        self.settled = 0.0
        self.gave_up = gave_up
        """Getting up failed."""
        self.went_limp = False
        """At least once the legs were no stiffer than requested."""

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> None:
        """Move into the pose, then hold the joints where they are; getting up does not begin here."""
        self.settled += dt
        self.went_limp = self.went_limp or not legs_hold(frame, self.stiffness)
        if not self._braces or self.settled >= self._p.brace_time:
            self._braces = False
            self.position, self.stiffness = frame.position, self._p.stiffness


REST_STIFFNESS: Final = 0.1
"""Stiffness of all joints. With none an emulated robot tips over in the crouch, because its thighs do not rest
on its calves."""


class Resting:
    """Stays where a motion ended, nearly limp, until something is ordered.

    Args:
        position: joint angles at the motion's end, 25 slots, rad.
    """

    name: Final[StateName] = "rest"
    corrections: Final = Corrections()

    def __init__(self, position: tuple[float, ...]) -> None:
        self.position = position
        self.stiffness = REST_STIFFNESS
        self.settled = 0.0
        self.went_limp = False
        """At least once the legs were no stiffer than requested."""

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> None:
        """Rest on."""
        self.settled += dt
        self.went_limp = self.went_limp or not legs_hold(frame, self.stiffness)


class Moving:
    """Plays a motion.

    Args:
        player: at the beginning of its motion.
        position: joint angles until the first cycle, 25 slots, rad.
        from_lying: the robot lies as it begins.
    """

    name: Final[StateName] = "motion"
    settled: Final = 0.0
    corrections: Final = Corrections()

    def __init__(self, player: MotionPlayer | GetUp, position: tuple[float, ...], *, from_lying: bool) -> None:
        self.player = player
        self.position = position
        self.stiffness = player.stiffness
        self.from_lying = from_lying
        """The robot lay at the beginning."""

    @property
    def got_up(self) -> bool:
        """The get-up is done, and the robot on its feet."""
        return isinstance(self.player, GetUp) and self.player.done and not self.player.failed

    @property
    def failed(self) -> bool:
        """The get-up is over, and the robot still lies."""
        return isinstance(self.player, GetUp) and self.player.done and self.player.failed

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> None:
        """One cycle."""
        self.position = self.player.advance(frame, dt)
        self.stiffness = self.player.stiffness


LYING_TIME: Final = 2.0
"""s that a robot lies before it gets up: longer than its guard refuses commands after a fall."""


class Recovery:
    """Decides when a robot gets up, and counts it.

    Args:
        body: Data sheet; its motions get it up.
        after_falls: Get up after a fall. A robot that sits, or rests, gets up in any case.
    """

    def __init__(self, body: Body, *, after_falls: bool) -> None:
        self.body = body
        """Data sheet."""
        self._motions = get_up_motions(body)
        self.after_falls = after_falls and bool(self._motions)
        """A robot that falls gets up again."""
        self.count = 0
        """Number of times that the robot got up from lying."""

    def begins_down(self, frame: SensorFrame, lying_side: Lying) -> bool:
        """Whether the robot of the first frame is to get up before anything else."""
        may = self.after_falls or lying_side == "upright"
        return may and lying_side in self._motions and not stands(self.body, frame)

    def pending(self, state: State) -> bool:
        """Whether a robot that fell is yet to try to get up."""
        return self.after_falls and isinstance(state, Fallen) and not state.gave_up

    def due(self, state: State, *, ordered: bool) -> bool:
        """Whether the robot gets up now.

        Args:
            state: Of the controller.
            ordered: A walk waits for the robot.
        """
        return (isinstance(state, Resting) and ordered) or (self.pending(state) and state.settled >= LYING_TIME)

    def get_up(self, frame: SensorFrame, *, from_lying: bool) -> Moving:
        """The state in which the robot gets up."""
        return Moving(GetUp(self._motions, self.body), frame.position, from_lying=from_lying)

    def note_end(self, state: State) -> None:
        """Count a get-up that has put a lying robot on its feet."""
        self.count += isinstance(state, Moving) and state.got_up and state.from_lying
