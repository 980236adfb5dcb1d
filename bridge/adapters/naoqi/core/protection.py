"""ALMotion's protections: conditions of a walk, falls, and arms that stay clear of the body.

Sources: vendor's pages on motion configuration, the fall manager and self-collision avoidance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Final

import numpy as np

from bridge.adapters.naoqi.core.frames import LinkFrames
from bridge.adapters.naoqi.core.joints import CHAINS, CONTACT_FORCE, slot
from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import OneOf, Pairs, Setting, flag, offers, text
from bridge.body import Body
from bridge.errors import NaoqiRefused
from bridge.guard.config import FallSettings
from bridge.guard.status import FallMonitor
from bridge.messages import SensorFrame
from bridge.stance import STANCE
from bridge.types import Array
from bridge.validation import unknown_name

WALK_STIFFNESS: Final = 0.6
"""Stiffness that the legs must exceed for a walk (confirmed: vendor's page)."""
FOOT_CONTACT: Final = "ENABLE_FOOT_CONTACT_PROTECTION"
LEG_STIFFNESS: Final = "ENABLE_STIFFNESS_PROTECTION"
FALL_MANAGER_SWITCH: Final = "ENABLE_DISACTIVATION_OF_FALL_MANAGER"
"""Whether programs may switch the fall manager off."""


def stays_stiff(stiffnesses: Any) -> bool:
    """Whether legs of these stiffnesses can walk."""
    values = stiffnesses if isinstance(stiffnesses, list) else [stiffnesses]
    return all(isinstance(value, int | float) and value > WALK_STIFFNESS for value in values)


class WalkProtection(Service):
    """Conditions of a walk."""

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self._enabled = {FOOT_CONTACT: True, LEG_STIFFNESS: True, FALL_MANAGER_SWITCH: True}

    @offers("ALMotion.setMotionConfig")
    def configure(self, config: Pairs) -> None:
        """Switch conditions on or off: `[[name, True or False], ...]`."""
        wanted = {}
        for name, value in config:
            if text(name, "ALMotion.setMotionConfig: name") not in self._enabled:
                raise NaoqiRefused(f"ALMotion.setMotionConfig: {unknown_name('name', name, self._enabled)}.")
            wanted[name] = flag(value, f"ALMotion.setMotionConfig: {name}")
        self._enabled |= wanted

    def require(self, method: str) -> None:
        """Check that a walk may begin."""
        frame = self._joints.frame
        if self._enabled[FOOT_CONTACT] and sum(frame.fsr) <= CONTACT_FORCE:
            raise NaoqiRefused(
                f"{method}: no foot touches the ground; put the robot on its feet, or switch {FOOT_CONTACT} "
                "off with setMotionConfig."
            )
        soft = [
            j for leg in ("LLeg", "RLeg") for j in CHAINS[leg] if self._joints.stiffness(j) <= WALK_STIFFNESS
        ]
        if self._enabled[LEG_STIFFNESS] and soft:
            raise NaoqiRefused(
                f"{method}: the stiffness of {soft[0]} is not above {WALK_STIFFNESS:g}; call wakeUp or "
                f"setStiffnesses first, or switch {LEG_STIFFNESS} off with setMotionConfig."
            )


FALL_STIFFNESS: Final = FallSettings().stiffness
"""Stiffness of all joints in a fall (assumed: by the vendor's page the stiffness is reduced)."""


class FallManager(Service):
    """Detection of falls, in which all motions end."""

    enabled = Setting("ALMotion.FallManagerEnabled", True, bool)

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self._monitor = FallMonitor(robot.body, FallSettings(), STANCE)

    def update(self, frame: SensorFrame, *, leaning: bool) -> bool:
        """Update in each cycle; whether the robot becomes limp."""
        if not self._monitor.update(frame) or leaning or not self.enabled:
            return False
        self._motion.end_all()
        for joint in self._joints.names.all:
            if self._joints.stiffness(joint) > FALL_STIFFNESS:
                self._joints.put_stiffness(joint, [(0.0, FALL_STIFFNESS)])
        return True


ARMS: Final[Mapping[str, tuple[str, ...]]] = {"Arms": ("LArm", "RArm"), "LArm": ("LArm",), "RArm": ("RArm",)}
Chain = Annotated[str, OneOf("chain", ARMS)]
ARM_MARGIN: Final = 0.001
"""Least distance of an arm from the body, m (assumed; that of the vendor's posture LyingBack)."""
NEAR_DISTANCE: Final = 0.02
"""Distance below which `isCollision` returns `near`, m (assumed)."""
_N_BALLS: Final = 6
"""Along forearm and hand."""
_DELTA: Final = 1e-3
"""rad, of the gradient."""


class ArmClearance:
    """Distances of forearm and hand from torso, head, legs and the other arm."""

    def __init__(self, body: Body, links: LinkFrames) -> None:
        self._links, self._body = links, body
        hand = np.array([body.lengths.LowerArmLength + body.lengths.HandOffsetX, 0.0, 0.0, 1.0])
        elbow = np.array([0.0, 0.0, 0.0, 1.0])
        self._balls = np.linspace(elbow, hand, _N_BALLS).T
        """In the ElbowRoll frame, (4, balls)."""

    def of(self, arm: str, position: Sequence[float]) -> float:
        """Distance of an arm, m; negative: inside the body.

        Args:
            arm: `LArm` or `RArm`.
            position: the 25 of a frame, rad.
        """
        size, length = self._body.shapes, self._body.lengths
        links = self._links(position)
        balls, others = (
            (links[f"{side}ElbowRoll"] @ self._balls)[:3].T for side in (arm[0], "R" if arm[0] == "L" else "L")
        )
        share = (balls[:, 2] - size.torso_bottom) / (size.torso_top - size.torso_bottom)
        width = size.waist_width + np.clip(share, 0.0, 1.0) * (size.torso_width - size.waist_width)
        outside = np.array(
            [
                abs(balls[:, 0]) - 0.5 * size.torso_depth,
                abs(balls[:, 1]) - 0.5 * width,
                size.torso_bottom - balls[:, 2],
                balls[:, 2] - size.torso_top,
            ]
        )
        torso = np.linalg.norm(np.maximum(outside, 0.0), axis=0) + np.minimum(outside.max(axis=0), 0.0)
        head = links["HeadPitch"] @ (0.0, 0.0, size.head_height, 1.0)
        distances = [
            torso,
            np.linalg.norm(balls - head[:3], axis=1) - size.head_radius,
            np.linalg.norm(balls[:, None] - others, axis=2).ravel() - size.forearm_radius,
        ]
        for side in "LR":
            thigh = (links[f"{side}HipPitch"], -size.thigh_radius, -length.ThighLength, size.thigh_radius)
            shank = (links[f"{side}KneePitch"], 0.0, size.shank_radius - length.TibiaLength, size.shank_radius)
            distances += [_from_limb(balls, *limb) for limb in (thigh, shank)]
        return float(np.concatenate(distances).min()) - size.forearm_radius


def _from_limb(points: Array, frame: Array, top: float, bottom: float, radius: float) -> Array:
    """Distances of points, (n, 3), from a capsule along a frame's z axis, m."""
    begin, end = (frame[:3, 3] + z * frame[:3, 2] for z in (top, bottom))
    along = end - begin
    share = np.clip((points - begin) @ along / (along @ along), 0.0, 1.0)
    distances: Array = np.linalg.norm(points - begin - share[:, None] * along, axis=1) - radius
    return distances


class ArmProtection(Service):
    """Keeps arms clear of the body."""

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self._clearance = ArmClearance(robot.body, robot.frames.links)
        self._enabled = {"LArm", "RArm"}
        """Both at the start (confirmed: as in `robot_facts`)."""
        self._joints.shield = self._clear

    def _clear(self, wanted: tuple[float, ...], sent: tuple[float, ...]) -> tuple[float, ...]:
        """Safe positions for 25 wanted ones, from the last ones sent, rad."""
        position = np.array(wanted)
        for arm in sorted(self._enabled):
            slots = [slot(j) for j in CHAINS[arm] if j in self._joints.guarded and not j.endswith("Hand")]
            if slots and any(wanted[i] != sent[i] for i in slots):
                position[slots] = self._step(arm, slots, position, np.array(sent)[slots])
        return tuple(position.tolist())

    def _step(self, arm: str, slots: list[int], wanted: Array, before: Array) -> Array:
        """The next angles of an arm, rad, (n,)."""

        def clearance(angles: Array) -> float:
            position = wanted.copy()
            position[slots] = angles
            return self._clearance.of(arm, position.tolist())

        if clearance(wanted[slots]) >= ARM_MARGIN:
            return wanted[slots]
        now = clearance(before)
        least = ARM_MARGIN if now >= 0.5 * ARM_MARGIN else now
        step = wanted[slots] - before
        gradient = np.array([clearance(before + row) - now for row in _DELTA * np.eye(len(slots))]) / _DELTA
        short = least - now - gradient @ step
        if short > 0.0 and gradient @ gradient > 0.0:
            step = step + short / (gradient @ gradient) * gradient
        reach = (
            np.array([self._joints.speed(j) for j in CHAINS[arm] if slot(j) in slots]) * self._joints.body.cycle
        )
        after: Array = before + np.clip(step, -reach, reach)
        return after if clearance(after) >= min(least, now) else before

    @offers("ALMotion.setCollisionProtectionEnabled")
    def _enable(self, chain: Chain, enabled: bool) -> bool:
        change = self._enabled.update if enabled else self._enabled.difference_update
        change(ARMS[chain])
        return True

    @offers("ALMotion.isCollision")
    def _state(self, chain: Chain) -> str:
        """State by the commands: an arm sent into the body touches it."""
        arms = ARMS[chain]
        position = list(self._joints.frame.position)
        for joint in self._joints.names.resolve(list(arms)):
            position[slot(joint)] = self._joints.commanded(joint)
        least = min(self._clearance.of(arm, position) for arm in arms)
        return "collision" if least <= 0.0 else "near" if least < NEAR_DISTANCE else "none"

    @offers("ALMotion.getCollisionProtectionEnabled")
    def _get_collision_protection_enabled(self, chain: Chain) -> bool:
        return self._enabled >= set(ARMS[chain])
