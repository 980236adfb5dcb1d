"""The robot as URDF: links, masses, joints, primitive shapes.

URDF has no word for backlash, gear compliance, delay, rotor inertia, the torque-speed line and the stiffness of
contacts. Prisms become the boxes around them, capsules a cylinder with two balls.
"""

from __future__ import annotations

from xml.etree import ElementTree as Xml

import numpy as np

from bridge.body import Body, joint_tree
from bridge.body.model import Link
from bridge.body.quantities import joint_no_load_speed, joint_stall_torque, tensor_matrix
from bridge.rotations import angles
from bridge.types import Vec3
from emulator.engine.shapes import BoxShape, CapsuleShape, PrismShape, Shape, SphereShape, link_shapes
from emulator.poses import matrix
from emulator.wear import WearProfile

_AXES = ((0, 0, "ixx"), (0, 1, "ixy"), (0, 2, "ixz"), (1, 1, "iyy"), (1, 2, "iyz"), (2, 2, "izz"))


def to_urdf(body: Body, wear: WearProfile, notice: str) -> str:
    """The file's text.

    Args:
        body: Data sheet.
        wear: State of the drives: their dry friction.
        notice: At the head of the file.
    """
    robot = Xml.Element("robot", name=body.name)
    robot.append(Xml.Comment(notice))
    shapes = link_shapes(body)
    for name, link in body.links.items():
        _add_link(robot, name, link, shapes.get(name))
    for name in joint_tree(body):
        _add_joint(robot, body, name, wear)
    Xml.indent(robot)
    return Xml.tostring(robot, encoding="unicode", xml_declaration=True) + "\n"


def _words(numbers: object) -> str:
    return " ".join(f"{number:.9g}" for number in np.asarray(numbers, dtype=np.float64).ravel().tolist())


def _add_link(robot: Xml.Element, name: str, link: Link, shape: Shape | None) -> None:
    element = Xml.SubElement(robot, "link", name=name)
    inertial = Xml.SubElement(element, "inertial")
    Xml.SubElement(inertial, "origin", xyz=_words(link.com))
    Xml.SubElement(inertial, "mass", value=_words(link.mass))
    tensor = tensor_matrix(link.inertia)
    Xml.SubElement(inertial, "inertia", {key: _words(tensor[i, j]) for i, j, key in _AXES})
    for kind in ("visual", "collision"):
        for solid in [] if shape is None else _solids(shape):
            part = Xml.SubElement(element, kind)
            part.extend(solid)
            if kind == "visual" and shape is not None:
                material = Xml.SubElement(part, "material", name=name)
                Xml.SubElement(material, "color", rgba=_words(shape.colour))


def _solids(shape: Shape) -> list[list[Xml.Element]]:
    """Origin and geometry of each solid of a shape."""
    if isinstance(shape, BoxShape):
        return [_solid(shape.centre, "box", size=_words(2.0 * np.array(shape.half)))]
    if isinstance(shape, PrismShape):
        low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
        x, y, z = (0.5 * (low + high)).tolist()
        return [_solid((x, y, z), "box", size=_words(high - low))]
    if isinstance(shape, SphereShape):
        return [_solid(shape.centre, "sphere", radius=_words(shape.radius))]
    return _capsule(shape)


def _capsule(shape: CapsuleShape) -> list[list[Xml.Element]]:
    turn = np.reshape(matrix(shape.orientation), (3, 3))
    half = 0.5 * shape.length * turn[:, 2]
    radius = _words(shape.radius)
    middle = _solid(shape.centre, "cylinder", angles(turn), radius=radius, length=_words(shape.length))
    first, last = (np.array(shape.centre) + half).tolist(), (np.array(shape.centre) - half).tolist()
    return [middle, *(_solid((x, y, z), "sphere", radius=radius) for x, y, z in (first, last))]


def _solid(at: Vec3, kind: str, turn: Vec3 = (0.0, 0.0, 0.0), **size: str) -> list[Xml.Element]:
    geometry = Xml.Element("geometry")
    Xml.SubElement(geometry, kind, size)
    return [Xml.Element("origin", xyz=_words(at), rpy=_words(turn)), geometry]


def _add_joint(robot: Xml.Element, body: Body, name: str, wear: WearProfile) -> None:
    joint, sheet = joint_tree(body)[name], body.joints[name]
    element = Xml.SubElement(robot, "joint", name=name, type="revolute")
    Xml.SubElement(element, "parent", link=joint.parent)
    Xml.SubElement(element, "child", link=name)
    Xml.SubElement(element, "origin", xyz=_words(joint.offset))
    Xml.SubElement(element, "axis", xyz=_words(joint.axis))
    limits = {"lower": sheet.lower, "upper": sheet.upper}
    strength = {"effort": joint_stall_torque(body, name), "velocity": joint_no_load_speed(body, name)}
    Xml.SubElement(element, "limit", {key: _words(value) for key, value in (limits | strength).items()})
    Xml.SubElement(element, "dynamics", damping="0", friction=_words(wear.servo.dry_friction))
    if name == "RHipYawPitch":
        Xml.SubElement(element, "mimic", joint="LHipYawPitch")
