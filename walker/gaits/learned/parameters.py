"""A policy's sheet: which network, what it observes, what its outputs mean. SI units and rad."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Final, Literal

import msgspec

from bridge.body.joints import INDEX_WITH_MIRROR
from bridge.body.postures import POSTURES
from bridge.types import Finite, Fraction, NotNegative, Positive, Vec3
from bridge.validation import unknown_name
from walker.functions import clip
from walker.gaits.gait import GaitParameters, PeriodicStep

Term = Literal[
    "base_angular_velocity",
    "base_linear_velocity",
    "projected_gravity",
    "fused_angle",
    "velocity_command",
    "joint_position",
    "joint_velocity",
    "previous_action",
    "gait_phase_sin",
    "gait_phase_cos",
    "foot_contact",
    "foot_force",
]
SIZES: Final[dict[str, int]] = {
    "base_angular_velocity": 3,
    "base_linear_velocity": 3,
    "projected_gravity": 3,
    "fused_angle": 2,
    "velocity_command": 3,
    "gait_phase_sin": 1,
    "gait_phase_cos": 1,
    "foot_contact": 2,
    "foot_force": 2,
}
"""Numbers of a term. `joint_position` and `joint_velocity` have one for each joint, `previous_action` all."""
_IN_A_FRAME: Final = ("base_angular_velocity", "base_linear_velocity")
Numbers = Finite | tuple[Finite, ...]
"""One for all numbers of a term or an action, or one for each."""
Range = tuple[Finite, Finite]
Count = Annotated[int, msgspec.Meta(ge=1, le=1000)]


class _Part(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    scale: Numbers = 1.0
    offset: Numbers = 0.0

    def _check(self, size: int, what: str) -> None:
        for name in ("scale", "offset"):
            values = getattr(self, name)
            if isinstance(values, tuple) and len(values) != size:
                raise ValueError(f"{what}: {name} has {len(values)} numbers, and {size} are right, or one")


def _check_joints(joints: Sequence[str]) -> None:
    for joint in joints:
        if joint not in INDEX_WITH_MIRROR:
            raise ValueError(unknown_name("joint", joint, INDEX_WITH_MIRROR))


class ObservationTerm(_Part, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One part of the observation: scale (value + offset)."""

    term: Term
    joints: tuple[str, ...] = ()
    """Joints of `joint_position` and `joint_velocity`, in the policy's order; empty: those of the actions."""
    relative: bool = True
    """Joint positions count from the default pose."""
    frame: Literal["torso", "heading"] = "torso"
    """Axes of the base's velocities: the torso's, or level ones along its heading."""
    history: Count = 1
    """Values of this and the last calls, the oldest first."""

    def __post_init__(self) -> None:
        """Raises ValueError for a joint that no NAO has, and for keys that the term does not use."""
        _check_joints(self.joints)
        if self.joints and self.term not in ("joint_position", "joint_velocity"):
            raise ValueError(f"{self.term} has no joints")
        if self.frame != "torso" and self.term not in _IN_A_FRAME:
            raise ValueError(f"{self.term} has no frame; {' and '.join(_IN_A_FRAME)} have one")


class Action(_Part, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Some outputs of the network: angle = scale output + offset, and the default pose where `relative`."""

    joints: tuple[str, ...]
    """In the policy's order. RHipYawPitch is the motor of LHipYawPitch, whose output counts."""
    relative: bool = True

    def __post_init__(self) -> None:
        """Raises ValueError for a joint that no NAO has, and for numbers that do not fit."""
        _check_joints(self.joints)
        self._check(len(self.joints), "action")


class CommandRanges(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Velocities that the policy follows, m/s, m/s, rad/s."""

    default: Vec3
    """Where none is commanded."""
    forward: Range
    left: Range
    turn: Range
    acceleration: tuple[Positive, Positive, Positive] = (0.5, 0.5, 3.0)
    """Fastest change of the command, m/s^2, m/s^2, rad/s^2."""

    def __post_init__(self) -> None:
        """Raises ValueError for a range without 0, and for a default beyond them."""
        for name, value in zip(("forward", "left", "turn"), self.default, strict=True):
            low, high = getattr(self, name)
            if not low <= 0.0 <= high:
                raise ValueError(f"{name} goes from {low:g} to {high:g}; 0 must lie in it")
            if not low <= value <= high:
                raise ValueError(f"default: {value:g} is beyond {name}, {low:g} to {high:g}")

    @property
    def max_velocity(self) -> Vec3:
        """Forward, to either side, m/s, and turn, rad/s."""
        return self.forward[1], min(-self.left[0], self.left[1]), min(-self.turn[0], self.turn[1])

    @property
    def max_acceleration(self) -> Vec3:
        """See `Limits`."""
        return self.acceleration

    def share(self, velocity: Vec3) -> float:
        """Largest part of its range that an axis takes up; infinite on an axis without one."""
        parts = [0.0]
        for value, (low, high) in zip(velocity, (self.forward, self.left, self.turn), strict=True):
            bound = high if value > 0.0 else -low
            if value:
                parts.append(abs(value) / bound if bound else math.inf)
        return max(parts)

    def clipped(self, velocity: Vec3) -> Vec3:
        """A velocity shortened to the ranges; axes without a range are left out."""
        ranges = (self.forward, self.left, self.turn)
        x, y, turn = (0.0 if low == high else v for v, (low, high) in zip(velocity, ranges, strict=True))
        share = max(1.0, self.share((x, y, turn)))
        if math.isinf(share):  # a range to one side only
            x, y, turn = (clip(v, low, high) for v, (low, high) in zip((x, y, turn), ranges, strict=True))
            return x, y, turn
        return x / share, y / share, turn / share


class PhaseClock(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The clock of a walk; without the terms `gait_phase_...` it only counts steps."""

    period: Annotated[float, msgspec.Meta(ge=0.1)]
    """Duration of two steps, s."""
    start: Annotated[float, msgspec.Meta(ge=0.0, lt=1.0)] = 0.0
    """Phase at which a walk begins, in turns."""
    ramp: NotNegative = 0.0
    """Time in which sine and cosine grow to their size at the beginning, and shrink at the end, s."""
    standing: Literal["zero", "runs"] = "zero"
    """Both are zero in the stop, or run on."""
    stop_time: Positive = 1.0
    """Time for which the policy stops the robot, with a command of zero, before its joints are held, s."""


class LearnedParameters(
    GaitParameters, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True
):
    """A sheet; TOML has no word for an absent `clip`, so defaults are left out."""

    model: str
    """The network (.onnx); a path relative to the sheet."""
    title: str = ""
    """Origin of the policy."""
    cycle: Annotated[float, msgspec.Meta(gt=0.0, le=1.0)]
    """Time between two calls, s; targets are held meanwhile. At most one call in each cycle of the robot."""
    delay: Annotated[float, msgspec.Meta(ge=0.0, le=0.5)] = 0.0
    """Time from a call to the first cycle in which its targets count, s."""
    stiffness: Fraction = 1.0
    clip: Range | None = None
    """Bounds of the outputs, before scale and offset; None: none."""
    history: Count = 1
    """Whole observations given to the network, the oldest first."""
    command: CommandRanges
    phase: PhaseClock
    default_pose: dict[str, Finite] = msgspec.field(default_factory=dict)
    """Angles, rad; joints that are not named have those of the posture StandInit."""
    observation: tuple[ObservationTerm, ...]
    action: tuple[Action, ...]

    def __post_init__(self) -> None:
        """Raises ValueError for parts that do not fit together."""
        _check_joints(tuple(self.default_pose))
        outputs = self.outputs
        if not outputs or not self.observation:
            raise ValueError("a policy has one [[observation]] and one joint of an [[action]] at least")
        if twice := sorted({joint for joint in outputs if outputs.count(joint) > 1}):
            raise ValueError(f"two actions turn {', '.join(twice)}")
        if self.clip is not None and self.clip[0] >= self.clip[1]:
            raise ValueError(
                f"clip begins at {self.clip[0]:g} and ends at {self.clip[1]:g}; the lower bound is first"
            )
        for each in self.observation:
            each._check(self.size(each), each.term)

    def __hash__(self) -> int:
        """Hash of its contents: msgspec gives none to a struct that holds a table."""
        return hash(msgspec.json.encode(self))

    @property
    def outputs(self) -> tuple[str, ...]:
        """Joints of all outputs in order."""
        return tuple(joint for each in self.action for joint in each.joints)

    def joints(self, term: ObservationTerm) -> tuple[str, ...]:
        """Joints of a term that has some."""
        return term.joints or self.outputs

    def size(self, term: ObservationTerm) -> int:
        """Numbers of a term, its history left aside."""
        if term.term == "previous_action":
            return len(self.outputs)
        return SIZES.get(term.term) or len(self.joints(term))

    @property
    def inputs(self) -> int:
        """Numbers that the network is given."""
        return self.history * sum(self.size(term) * term.history for term in self.observation)

    @property
    def pose(self) -> tuple[float, ...]:
        """The default pose, 25 angles in frame order, rad."""
        pose = list(POSTURES["StandInit"])
        for joint, angle in self.default_pose.items():
            pose[INDEX_WITH_MIRROR[joint]] = angle
        return tuple(pose)

    @property
    def periodic_step(self) -> PeriodicStep:
        """A step at the default velocity."""
        half = 0.5 * self.phase.period
        return PeriodicStep(self.command.default[0] * half, half)

    @property
    def limits(self) -> CommandRanges:
        """See `GaitParameters`."""
        return self.command

    @property
    def velocity(self) -> Vec3:
        """The velocity without a command, m/s, m/s, rad/s."""
        return self.command.default

    def with_velocity(self, velocity: Vec3) -> LearnedParameters:
        """The parameters with another velocity, shortened to the ranges.

        Args:
            velocity: forward and to the left, m/s, and turn, rad/s.
        """
        command = msgspec.structs.replace(self.command, default=self.command.clipped(velocity))
        return msgspec.structs.replace(self, command=command)
