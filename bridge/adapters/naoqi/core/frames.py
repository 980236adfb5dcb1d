"""Poses of the robot's parts in NAOqi's three spaces.

The torso's space moves with it; the robot's is between the feet, its z axis vertical and its x axis forward;
the world's is the robot's at the start. Effectors: the hand's middle, below the ankle on the sole,
the neck. Source: vendor's page on Cartesian control.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np
from scipy.spatial import ConvexHull

from bridge.adapters.naoqi.core.joints import CHAINS, CONTACT_FORCE, Joints
from bridge.adapters.naoqi.declared import flag, offers
from bridge.body import TORSO, Body
from bridge.body.cameras import CAMERA_LINK, cameras
from bridge.body.joints import INDEX_WITH_MIRROR, N_JOINTS
from bridge.body.kinematics import BodyTree, homogeneous, inverse
from bridge.body.quantities import total_mass
from bridge.body.sole import sole_hull
from bridge.config import read_toml
from bridge.errors import NaoqiRefused
from bridge.rotations import R_pitch, R_yaw, angles, rotation
from bridge.types import Array, Side, Vec3
from bridge.validation import convert

_HEAD: Final = ("HeadYaw", "HeadPitch")
LinkFrames = Callable[[Sequence[float]], Mapping[str, Array]]
"""Frames of all links in the Torso frame, (4, 4), by the joint that moves each, from 25 positions (rad)."""
SPACES: Final = {0: "FRAME_TORSO", 1: "FRAME_WORLD", 2: "FRAME_ROBOT"}


class _Place(msgspec.Struct, frozen=True):
    link: str
    place: Vec3


_SENSORS: Final[dict[str, _Place]] = convert(
    read_toml(Path(__file__).with_name("sensor_places.toml")), dict[str, _Place]
)


class Effector(NamedTuple):
    """A frame that is fixed to a link."""

    link: str
    fixed: Array
    """In the link's frame, (4, 4)."""


def position6(H: Array) -> list[float]:
    """`[x, y, z, wx, wy, wz]` of a transform, with R = Rz(wz) Ry(wy) Rx(wx)."""
    return [*(float(x) for x in H[:3, 3]), *angles(H)]


def from_position6(position: Sequence[float]) -> Array:
    """The transform of `[x, y, z, wx, wy, wz]`, (4, 4)."""
    x, y, z, roll, pitch, yaw = position
    return homogeneous(rotation(roll, pitch, yaw), (x, y, z))


class RobotFrames:
    """Poses of one robot's parts; not thread-safe, the caller locks.

    Args:
        robot_place: pose of the robot's space in the world's: x, y (m) and yaw (rad).
        steps: footsteps to come, as `WalkingMethods.steps_ahead`.
    """

    def __init__(
        self, joints: Joints, robot_place: Callable[[], Sequence[float]], steps: Callable[[], list[list[Any]]]
    ) -> None:
        self._joints, self._robot_place, self._steps = joints, robot_place, steps
        self.links: LinkFrames = BodyTree(joints.body).link_frames
        self.effectors = self._effectors()

    @property
    def body(self) -> Body:
        """Data sheet of the robot."""
        return self._joints.body

    def _effectors(self) -> dict[str, Effector]:
        body, length = self._joints.body, self._joints.body.lengths
        hand = (length.HandOffsetX, 0.0, -length.HandOffsetZ)
        arm = "WristYaw"
        if body.model == "H21":  # the forearm's frame is the elbow's
            hand, arm = (length.LowerArmLength + hand[0], *hand[1:]), "ElbowRoll"
        fixed: dict[str, Effector] = {
            TORSO: Effector(TORSO, np.eye(4)),
            **{joint: Effector(joint, np.eye(4)) for joint in body.joints},
            "Head": Effector("HeadPitch", np.eye(4)),
        }
        for side in "LR":
            fixed[f"{side}Arm"] = fixed[f"{side}Hand"] = Effector(f"{side}{arm}", homogeneous(np.eye(3), hand))
            foot = homogeneous(np.eye(3), (0.0, 0.0, -length.FootHeight))
            fixed[f"{side}Leg"] = Effector(f"{side}AnkleRoll", foot)
            for cell, place in zip(
                ("FrontLeft", "FrontRight", "RearLeft", "RearRight"), getattr(body.fsr, side), strict=True
            ):
                fixed[f"{side}Foot/FSR/{cell}"] = Effector(f"{side}AnkleRoll", homogeneous(np.eye(3), place))
        for name, sensor in _SENSORS.items():
            fixed[name] = Effector(sensor.link, homogeneous(np.eye(3), sensor.place))
        for camera in cameras(body):
            fixed[camera.name] = Effector(CAMERA_LINK, homogeneous(R_pitch(camera.pitch), camera.place))
        return fixed

    def position(self, measured: bool) -> list[float]:
        """The 25 measured or commanded joint positions, rad."""
        if measured:
            return list(self._joints.frame.position)
        slots = [0.0] * N_JOINTS
        for joint in self._joints.names.all:
            slots[INDEX_WITH_MIRROR[joint]] = self._joints.commanded(joint)
        return slots

    def measured_links(self, head: Sequence[float] | None = None) -> Mapping[str, Array]:
        """Links in the Torso frame by the joint sensors, each (4, 4), m.

        Args:
            head: HeadYaw and HeadPitch of another moment, rad; None: those of now.
        """
        position = self.position(True)
        if head is not None:
            for joint, angle in zip(_HEAD, head, strict=True):
                position[INDEX_WITH_MIRROR[joint]] = angle
        return self.links(position)

    def effector(self, name: Any) -> Effector:
        """The frame of a joint, chain or sensor."""
        if not isinstance(name, str) or name not in self.effectors:
            raise NaoqiRefused(
                f"{name!r:.60} has no frame on a {self._joints.body.name}; Torso, {', '.join(CHAINS)}, joints "
                "and sensors such as CameraTop have."
            )
        return self.effectors[name]

    def in_torso(self, name: str, links: Mapping[str, Array]) -> Array:
        """Frame of an effector in the Torso frame, (4, 4)."""
        link, fixed = self.effector(name)
        H: Array = links[link] @ fixed
        return H

    def space(self, code: Any, links: Mapping[str, Array], measured: bool) -> Array:
        """A space's frame in the Torso frame, (4, 4).

        Args:
            code: 0 the torso's, 1 the world's, 2 the robot's.
            measured: take the vertical from the inertial unit; otherwise from the feet.
        """
        if isinstance(code, bool) or not isinstance(code, int) or code not in SPACES:
            kinds = ", ".join(f"{number} {name}" for number, name in SPACES.items())
            raise NaoqiRefused(f"The space {code!r:.40} is not known; {kinds} are.")
        if code == 0:
            return np.eye(4)
        feet = [self.in_torso(leg, links) for leg in ("LLeg", "RLeg")]
        if measured:
            roll, pitch = self._joints.frame.angle
            z = rotation(roll, pitch, 0.0)[2]
        else:
            z = feet[0][:3, 2] + feet[1][:3, 2]
            z = z / np.linalg.norm(z)
        forward = feet[0][:3, 0] + feet[1][:3, 0]
        x = forward - (forward @ z) * z
        x = x / np.linalg.norm(x)
        robot = homogeneous(np.column_stack((x, np.cross(z, x), z)), 0.5 * (feet[0][:3, 3] + feet[1][:3, 3]))
        if code == 2:
            return robot
        east, north, yaw = self._robot_place()
        world: Array = robot @ inverse(homogeneous(R_yaw(yaw), (east, north, 0.0)))
        return world

    def transform(self, name: Any, code: Any, use_sensors: Any) -> Array:
        """Frame of a joint, chain or sensor in a space, (4, 4), m.

        Args:
            code: Of the space: 0 torso, 1 world, 2 robot.
        """
        effector = self.effector(name)
        measured = flag(use_sensors, "useSensors")
        links = self.links(self.position(measured))
        H: Array = inverse(self.space(code, links, measured)) @ links[effector.link] @ effector.fixed
        return H

    @offers("ALMotion.getCOM")
    def centre_of_mass(self, name: Any, code: Any, use_sensors: bool) -> list[float]:
        """Centre of mass of a joint's link, a chain or the whole body in a space, (3,), m.

        Args:
            name: Of the joint or chain; `Body` is the whole robot.
            code: Of the space, as in `transform`.
        """
        return self.com_at(name, self.position(use_sensors), code, measured=use_sensors)

    def com_at(self, name: Any, position: Sequence[float], code: Any, *, measured: bool = False) -> list[float]:
        """As `centre_of_mass`, with the joints at a position (25, rad)."""
        body = self._joints.body
        parts = [part for part in self._parts(name) if part in body.links]
        if not parts:
            raise NaoqiRefused(f"ALMotion.getCOM: {name!r:.60} has no mass of its own.")
        links = self.links(position)
        masses = np.array([body.links[part].mass for part in parts])
        places = np.array([(links[part] @ (*body.links[part].com, 1.0))[:3] for part in parts])
        com = np.append(masses @ places / masses.sum(), 1.0)
        return [float(x) for x in (inverse(self.space(code, links, measured)) @ com)[:3]]

    @offers("ALMotion.getMass")
    def mass(self, name: Any) -> float:
        """Mass of a joint's link, a chain or the whole body, kg; a hand's is part of its forearm's."""
        body = self._joints.body
        if name in ("Body", "Joints"):
            return total_mass(body)
        return math.fsum(body.links[part].mass for part in self._parts(name) if part in body.links)

    def _parts(self, name: Any) -> Sequence[str]:
        if name in ("Body", "Joints"):
            return list(self._joints.body.links)
        if name == TORSO:
            return [TORSO]
        return self._joints.names.resolve(name)

    @offers("ALMotion.getSupportPolygon")
    def _support_polygon(self, code: Any, use_sensors: bool) -> list[list[float]]:
        """Corners of the support polygon in the robot's or the world's space, counter-clockwise, m."""
        if code == 0:
            raise NaoqiRefused("ALMotion.getSupportPolygon: the frame is 1 FRAME_WORLD or 2 FRAME_ROBOT.")
        links = self.links(self.position(use_sensors))
        to_space = inverse(self.space(code, links, use_sensors))
        corners = []
        sides: tuple[Side, Side] = ("L", "R")
        for i, side in enumerate(sides):
            if sum(self._joints.frame.fsr[4 * i : 4 * i + 4]) > CONTACT_FORCE:
                foot = to_space @ self.in_torso(f"{side}Leg", links)
                corners += [(foot @ (x, y, 0.0, 1.0))[:2] for x, y in sole_hull(self._joints.body, side)]
        if not corners:
            return []
        points = np.array(corners)
        return [[float(x), float(y)] for x, y in points[ConvexHull(points).vertices]]

    @offers("ALMotion.getFootSteps")
    def _foot_steps(self) -> list[Any]:
        """Poses of the two feet in the world, m, m and rad, and the footsteps to come."""
        feet = (position6(self.transform(leg, 1, use_sensors=False)) for leg in ("LLeg", "RLeg"))
        return [[[x, y, turn] for x, y, _, _, _, turn in feet], *self._steps()]

    @offers("ALMotion.getTransform")
    def _get_transform(self, name: Any, space: Any, sensors: Any) -> Any:
        return [float(x) for x in self.transform(name, space, sensors).flat]

    @offers("ALMotion.getPosition")
    def _get_position(self, name: Any, space: Any, sensors: Any) -> Any:
        return position6(self.transform(name, space, sensors))
