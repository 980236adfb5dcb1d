"""Joint and chain names as ALMotion uses them.

Order of `Body` and members of the chains: vendor's body-parts pages (H25: 26 names with both HipYawPitch; H21
without wrists and hands).
"""

from __future__ import annotations

from typing import Any, Final

from bridge.body import Body
from bridge.body.joints import INDEX_WITH_MIRROR
from bridge.body.quantities import absent_joints
from bridge.errors import NaoqiRefused
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
    """Resolves what ALMotion's methods take as `names` for one body."""

    def __init__(self, body: Body) -> None:
        self._body = body.name
        self._absent = set(absent_joints(body))
        self.all = self.group("Body")
        """All joints of the body in ALMotion's order."""

    def group(self, name: str) -> tuple[str, ...]:
        """Joints of a chain, of a group of chains, or the one joint of that name.

        Raises:
            NaoqiRefused: nothing of this body has the name.
        """
        if name in _GROUPS:
            return tuple(joint for joint in _GROUPS[name] if joint not in self._absent)
        if name in INDEX_WITH_MIRROR and name not in self._absent:
            return (name,)
        raise NaoqiRefused(f"{self._body}: {unknown_name('joint or chain', name, [*_GROUPS, *self.all])}.")

    def resolve(self, names: Any) -> tuple[str, ...]:
        """Joints of one name or of a list of names.

        Raises:
            NaoqiRefused: neither, or an unknown name.
        """
        if isinstance(names, str):
            return self.group(names)
        if isinstance(names, list) and all(isinstance(name, str) for name in names):
            return tuple(joint for name in names for joint in self.group(name))
        raise NaoqiRefused(f"names is {names!r:.60}; a name or a list of names is expected.")


def slot(joint: str) -> int:
    """Frame slot of a joint; both hips have that of the one motor."""
    return INDEX_WITH_MIRROR[joint]


def actuator(joint: str, kind: str = "Position") -> str:
    """Name of a joint's actuator; RHipYawPitch has that of the motor that drives both hips."""
    motor = "LHipYawPitch" if joint == "RHipYawPitch" else joint
    return f"{motor}/{kind}/Actuator/Value"
