"""Joints of the served robot: their names, their commands, the service `DCM`, and their share during a walk.

Order of `Body` and members of the chains: vendor's body-parts pages (H25: 26 names with both HipYawPitch; H21
without wrists and hands).

During a walk the head is always the program's, an arm by `setMoveArmsEnabled`; a motion of the program has
precedence over the walk's arms (vendor's sample motion_walk.py: "arms motion from user have always the
priority").
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Annotated, Any, Final

from bridge.adapters.naoqi.declared import OneOf, Range, offers
from bridge.body import Body
from bridge.body.joints import INDEX_WITH_MIRROR
from bridge.body.quantities import HANDS, absent_joints, joint_no_load_speed, joint_nominal_torque, limits
from bridge.dcm import Dcm
from bridge.dcm.requests import SetRequest, TimedCommand, Update, alias_request, set_alias_request, set_request
from bridge.errors import NaoqiRefused
from bridge.messages import ActuatorFrame, SensorFrame
from bridge.messages.walk import UpperBody
from bridge.validation import unknown_name

CHAINS: Final[dict[str, tuple[str, ...]]] = {
    "Head": ("HeadYaw", "HeadPitch"),
    "LArm": ("LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll", "LWristYaw", "LHand"),
    "LLeg": ("LHipYawPitch", "LHipRoll", "LHipPitch", "LKneePitch", "LAnklePitch", "LAnkleRoll"),
    "RLeg": ("RHipYawPitch", "RHipRoll", "RHipPitch", "RKneePitch", "RAnklePitch", "RAnkleRoll"),
    "RArm": ("RShoulderPitch", "RShoulderRoll", "RElbowYaw", "RElbowRoll", "RWristYaw", "RHand"),
}
_BODY: Final = tuple(joint for chain in CHAINS.values() for joint in chain)
_GROUPS: Final[dict[str, tuple[str, ...]]] = {
    **CHAINS,
    "Arms": CHAINS["LArm"] + CHAINS["RArm"],
    "Legs": CHAINS["LLeg"] + CHAINS["RLeg"],
    "Body": _BODY,
    "Joints": _BODY,
    "JointActuators": _BODY,
    "Actuators": _BODY,
}


class JointNames:
    """Resolves the argument `names` of ALMotion's methods for one body."""

    def __init__(self, body: Body) -> None:
        self._body = body.name
        self._absent = set(absent_joints(body))
        self.all = self.group("Body")
        """All joints of the body in ALMotion's order."""

    def group(self, name: str) -> tuple[str, ...]:
        """Joints of a chain, of a group of chains, or the one joint of that name."""
        if name in _GROUPS:
            return tuple(joint for joint in _GROUPS[name] if joint not in self._absent)
        if name in INDEX_WITH_MIRROR and name not in self._absent:
            return (name,)
        raise NaoqiRefused(f"{self._body}: {unknown_name('joint or chain', name, [*_GROUPS, *self.all])}.")

    def resolve(self, names: Any) -> tuple[str, ...]:
        """Joints of one name or of a list of names."""
        if isinstance(names, str):
            return self.group(names)
        if isinstance(names, list) and all(isinstance(name, str) for name in names):
            return tuple(joint for name in names for joint in self.group(name))
        raise NaoqiRefused(f"names is {names!r:.60}; a name or a list of names is expected.")


def slot(joint: str) -> int:
    """Frame slot of a joint; both hips share their motor's."""
    return INDEX_WITH_MIRROR[joint]


def actuator(joint: str, kind: str = "Position") -> str:
    """Name of a joint's actuator; RHipYawPitch has that of both hips' motor."""
    motor = "LHipYawPitch" if joint == "RHipYawPitch" else joint
    return f"{motor}/{kind}/Actuator/Value"


Positions = tuple[float, ...]
"""25 in frame order, rad."""
HAND_SPEED: Final = 8.33
"""1/s (confirmed: vendor's URDFs, V3.3 to V6)."""
HAND_TORQUE: Final = 0.292
"""N m (confirmed: the same)."""

CONTACT_FORCE: Final = 5.0
"""Force on a sole (or on both together) from which it touches the ground, N (assumed)."""
SUPPLY_VOLTAGE: Final = 21.6
"""V (confirmed: vendor's battery page, 6 cells of 3.6 V)."""


class Joints:
    """Joints, stiffnesses and clock of one robot; not thread-safe, the caller locks.

    Args:
        frame: First frame; the joints hold their angles and stiffnesses.
    """

    def __init__(self, body: Body, frame: SensorFrame) -> None:
        self.body = body
        self.names = JointNames(body)
        self.dcm = Dcm(body, frame.position, start=round(1000.0 * frame.time))
        self.frame = self._last_frame = frame
        self.guarded: set[str] = set()
        """Joints whose present motion must keep clear of the body."""
        self.shield: Callable[[Positions, Positions], Positions] = lambda wanted, _: wanted
        """`(wanted, sent)` -> positions that keep clear of the body."""
        self._wanted = self._shielded = self._before = frame.position
        self.hold()

    def hold(self, without: Iterable[str] = (), targets: Positions = ()) -> None:
        """Hold the joints at their angles and stiffnesses from the next cycle on.

        Args:
            targets: angles commanded last, rad, of which stiff joints keep theirs, since the measured ones sag;
                empty: all hold the measured angles.
        """
        now = zip(targets or self.frame.position, self.frame.position, self.frame.stiffness, strict=True)
        position = tuple(target if stiffness > 0.0 else angle for target, angle, stiffness in now)
        self.dcm.put_frame(position, self.frame.stiffness, {slot(joint) for joint in without})
        self._before = position

    def cycle(self, frame: SensorFrame) -> None:
        """Take a new frame: advance the DCM to it, over missed frames too."""
        self.dcm.run_cycle()
        for joint in self.guarded:
            if self._wanted[slot(joint)] != self._shielded[slot(joint)]:
                self.dcm.move(actuator(joint), self._shielded[slot(joint)])
        self._before = self._shielded
        for _ in range(frame.seq - self.frame.seq - 1):
            self.dcm.skip_cycle()
        self._last_frame, self.frame = self.frame, frame

    def answer(self) -> ActuatorFrame:
        """Command for the cycle of the newest frame, by the calls so far.

        The robot takes the newest answer at the end of that cycle; further calls change it until then.
        """
        targets = self.dcm.ahead()
        self._wanted = targets.position
        self._shielded = self.shield(self._wanted, self._before)
        return ActuatorFrame(reply_to=self.frame.seq, position=self._shielded, stiffness=targets.stiffness)

    @property
    def now(self) -> int:
        """Time of the DCM's clock since the first frame, ms."""
        return self.dcm.clock.now

    def measured(self, joint: str) -> float:
        """Measured angle, rad; of a hand 0 to 1."""
        return self.frame.position[slot(joint)]

    def commanded(self, joint: str) -> float:
        """Commanded angle, and the measured one of a joint without stiffness, rad."""
        return self.dcm.read([actuator(joint)], self.frame.position)[0]

    def stiffness(self, joint: str) -> float:
        """Commanded stiffness, 0 to 1; negative: free."""
        return self.dcm.read([actuator(joint, "Hardness")], self.frame.position)[0]

    def keys(self) -> dict[str, Callable[[], float]]:
        """ALMotion's view of the joints, as keys of ALMemory; of a hand: 1/s, and J for its whole stroke."""
        table: dict[str, Callable[[], float]] = {}
        for joint in self.names.all:
            table[f"Motion/Position/Sensor/{joint}"] = partial(self.measured, joint)
            table[f"Motion/Position/Actuator/{joint}"] = partial(self.commanded, joint)
            table[f"Motion/Command/Position/{joint}"] = partial(self.commanded, joint)
            table[f"Motion/Velocity/Sensor/{joint}"] = partial(self.velocity, joint)
            table[f"Motion/Torque/Sensor/{joint}"] = partial(self.torque, joint)
        return table

    def velocity(self, joint: str) -> float:
        """Mean speed between the last two frames, rad/s."""
        passed = self.frame.time - self._last_frame.time
        moved = self.measured(joint) - self._last_frame.position[slot(joint)]
        return moved / passed if passed > 0.0 else 0.0

    def torque(self, joint: str) -> float:
        """Torque by the motor's current, towards the command, without gear losses, N m.

        A motor's torque constant is its full voltage over its speed without load.
        """
        amount = self.frame.current[slot(joint)] * SUPPLY_VOLTAGE / self.speed(joint)
        return math.copysign(amount, self.commanded(joint) - self.measured(joint))

    def put(self, name: str, points: Sequence[tuple[float, float]]) -> None:
        """Replace an actuator's timed commands: pairs of time from now (s) and value."""
        commands = tuple(TimedCommand(self.dcm.clock.shown(round(1000.0 * t)), value) for t, value in points)
        self.dcm.set(SetRequest(name, Update.CLEAR_ALL, commands))

    def put_position(self, joint: str, points: Sequence[tuple[float, float]]) -> None:
        """Replace a joint's path: pairs of time from now (s) and angle (rad)."""
        self.guarded.discard(joint)
        self.put(actuator(joint), points)

    def put_stiffness(self, joint: str, points: Sequence[tuple[float, float]]) -> None:
        """Replace a joint's stiffnesses; a limp joint that becomes stiff holds its measured angle."""
        if self.stiffness(joint) <= 0.0 < max((value for _, value in points), default=0.0):
            self.put_position(joint, [(0.0, self.measured(joint))])
        self.put(actuator(joint, "Hardness"), points)

    def stop(self, joints: Sequence[str]) -> None:
        """Delete waiting commands of these joints; they hold the last command."""
        for joint in joints:
            self.put_position(joint, [])

    def waits(self, joint: str) -> bool:
        """Whether commands of the joint wait."""
        return bool(self.dcm.waiting(actuator(joint)))

    def speed(self, joint: str) -> float:
        """Largest speed of a joint, rad/s (its motor's without load), of a hand 1/s."""
        return HAND_SPEED if joint in HANDS else joint_no_load_speed(self.body, joint)

    def limits(self, joint: str) -> list[float]:
        """Smallest and largest angle (rad), largest speed (rad/s) and torque (N m)."""
        lower, upper = limits(self.body, "LHipYawPitch" if joint == "RHipYawPitch" else joint)
        torque = HAND_TORQUE if joint in HANDS else joint_nominal_torque(self.body, joint)
        return [lower, upper, self.speed(joint), torque]


class DcmService:
    """The service `DCM`: timed commands of actuators; not thread-safe, the caller locks."""

    def __init__(self, joints: Joints) -> None:
        self._joints, self._dcm = joints, joints.dcm

    @offers("DCM.setAlias", kind="joints")
    def _set_alias(self, *arguments: Any) -> None:
        command = arguments[0] if len(arguments) == 1 else list(arguments)
        if not isinstance(command, list):
            raise NaoqiRefused(f"DCM.setAlias: {command!r:.40} was given; a list is expected.")
        self._dcm.set_alias(set_alias_request(command))
        self._joints.guarded.difference_update(moved_joints(self._dcm, command))

    @offers("DCM.createAlias")
    def _create_alias(self, command: list[Any]) -> list[str | list[str]]:
        return self._dcm.create_alias(alias_request(command))

    @offers("DCM.set", kind="joints")
    def _set(self, command: list[Any]) -> None:
        self._dcm.set(set_request(command))
        self._joints.guarded.difference_update(moved_joints(self._dcm, command))

    @offers("DCM.getTime")
    def _get_time(self, offset: Annotated[int, Range(-1e12, 1e12, "ms")]) -> int:
        """Reading of the DCM's clock plus an offset, ms."""
        return self._dcm.clock.shown(offset)

    _get_prefix = offers("DCM.getPrefix")(lambda self: self._dcm.prefixes())


def moved_joints(dcm: Dcm, command: Any) -> list[str]:
    """Joints whose actuators `set` or `setAlias` writes to."""
    name = command[0] if isinstance(command, list) and command else command
    written = dcm.names_of(name) if isinstance(name, str) else ()
    parts = (actuator.split("/")[0] for actuator in written)
    return [part for part in parts if part in INDEX_WITH_MIRROR]


_SIDES: Final = ("LArm", "RArm")


class UpperBodyShare:
    """Head and arms while the walker holds the robot; not thread-safe, the caller locks."""

    def __init__(self, joints: Joints) -> None:
        self._joints = joints
        self._swings = dict.fromkeys(_SIDES, True)
        """Whether the walk moves an arm."""
        self._upper = joints.names.resolve(["Head", *_SIDES])
        self.taken: set[str] = set()
        """Joints of the program while the walker holds the robot."""

    def begin(self) -> None:
        """Begin the share of a walker's hold."""
        kept = ["Head", *(side for side in _SIDES if not self._swings[side])]
        moving = (joint for joint in self._upper if self._joints.waits(joint))
        self.taken = {*self._joints.names.resolve(kept), *moving}

    def within(self, names: Any) -> tuple[str, ...] | None:
        """Joints that a call names, if all of them are of the head and the arms; else None."""
        try:
            joints = self._joints.names.resolve(names)
        except NaoqiRefused:
            return None
        return joints if set(joints) <= set(self._upper) else None

    def order(self, *, walks: bool) -> UpperBody:
        """Order to the walker in this cycle."""
        if walks:
            for side in _SIDES:
                if self._swings[side]:
                    self.taken -= {j for j in CHAINS[side] if j in self.taken and not self._joints.waits(j)}
        sent = self._joints.answer()
        slots = {joint: slot(joint) for joint in self._upper if joint in self.taken}
        return UpperBody(
            joints=tuple(slots),
            position=tuple(sent.position[i] for i in slots.values()),
            stiffness=tuple(sent.stiffness[i] for i in slots.values()),
        )

    @offers("ALMotion.setMoveArmsEnabled", "ALMotion.setWalkArmsEnabled")
    def _set_move_arms_enabled(self, left: bool, right: bool) -> None:
        self._swings = dict(zip(_SIDES, (left, right), strict=True))
        for side in _SIDES:
            if not self._swings[side]:
                self.taken |= set(self._joints.names.resolve(side))

    @offers("ALMotion.getMoveArmsEnabled")
    def _get_move_arms_enabled(self, arm: Annotated[str, OneOf("chain", ("Arms", *_SIDES))] = "Arms") -> bool:
        return all(self._swings.values()) if arm == "Arms" else self._swings[arm]

    _get_walk_arms_enabled = offers("ALMotion.getWalkArmsEnabled")(
        lambda self: [self._swings[side] for side in _SIDES]
    )
