"""Scene of a robot's cameras: its own limbs and the world, from ground truth.

Known weaknesses: tiles and heightfields are drawn as the flat floor under them; pictures have no noise, no
distortion, no blur of motion, and the exposure is always right. Limbs are the contact shapes of the emulated
robot (`emulator.engine.shapes`).
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from scipy.spatial import ConvexHull

from bridge.body import TORSO, Body, joint_tree
from bridge.body.cameras import LINK, cameras
from bridge.body.joints import INDEX_WITH_MIRROR
from bridge.messages import TruthFrame
from bridge.messages.world_state import WorldReply, WorldThing
from bridge.rotations import R_pitch, about_axis, matrix, rotation
from bridge.types import Array
from emulator.camera.picture import Floor, View
from emulator.camera.shapes import Ball, Capsule, Colour, Convex, Disc, Solid, face, landmark
from emulator.engine.shapes import BoxShape, PrismShape, Shape, SphereShape, link_shapes

RED = (0.85, 0.08, 0.06)
_WOOD = (0.83, 0.64, 0.36)


class CameraScene:
    """The world around one robot.

    Args:
        body: data sheet.
    """

    def __init__(self, body: Body) -> None:
        self._tree = joint_tree(body)
        self._cameras = cameras(body)
        # the cameras are inside the head
        self._shapes = {link: shape for link, shape in link_shapes(body).items() if link != LINK}
        self._hulls = {
            link: ConvexHull(s.vertices) for link, s in self._shapes.items() if isinstance(s, PrismShape)
        }

    def links(self, truth: TruthFrame) -> dict[str, Array]:
        """Frames of all links in the world, (4, 4), by the joint that moves each."""
        frames = {TORSO: _placed(matrix(truth.torso_orientation), np.array(truth.torso_position))}
        for name, joint in self._tree.items():
            turn = about_axis(joint.axis, truth.joints[INDEX_WITH_MIRROR[name]])
            frames[name] = frames[joint.parent] @ _placed(turn, np.array(joint.offset))
        return frames

    def view(self, camera: int, links: dict[str, Array]) -> View:
        """Camera 0 (top) or 1 (bottom) in the world."""
        eye = self._cameras[camera]
        H = links[LINK] @ _placed(R_pitch(eye.pitch), np.array(eye.place))
        return View(H[:3, 3], H[:3, :3], eye.field)

    def limbs(self, links: dict[str, Array]) -> list[Solid]:
        """The robot's own parts, without the head."""
        return [self._limb(link, shape, links[link]) for link, shape in self._shapes.items()]

    def _limb(self, link: str, shape: Shape, H: Array) -> Solid:
        R, d = H[:3, :3], H[:3, 3]
        r, g, b, _ = shape.colour
        colour = (r, g, b)
        if isinstance(shape, PrismShape):
            equations, corners = self._hulls[link].equations, shape.vertices @ R.T + d
            normals = equations[:, :3] @ R.T
            return Convex(corners, normals, normals @ d - equations[:, 3], colour)
        centre = R @ shape.centre + d
        if isinstance(shape, SphereShape):
            return Ball(centre, shape.radius, colour)
        if isinstance(shape, BoxShape):
            return box(centre, R, np.array(shape.half), colour)
        half = 0.5 * shape.length * (R @ matrix(shape.orientation)[:, 2])
        return Capsule(centre - half, centre + half, shape.radius, colour)


def floor_of(world: WorldReply) -> Floor:
    """The floor.

    A tilted one goes through the world's origin, as a scenario's does; one that was tilted live about another
    point is drawn beside its place.
    """
    roll, pitch = world.floor
    return Floor(np.zeros(3), rotation(roll, pitch, 0.0))


def boxes_of(world: WorldReply) -> list[Solid]:
    """The boxes."""
    return [
        box(np.array(o.position), matrix(o.orientation), 0.5 * np.array(o.size), _WOOD) for o in world.objects
    ]


def thing_of(thing: WorldThing) -> Solid:
    """A ball, a landmark or a face."""
    centre, radius = np.array(thing.position), 0.5 * thing.size
    if thing.kind == "ball":
        return Ball(centre, radius, RED)
    paint = landmark(int(thing.name)) if thing.kind == "landmark" else face
    return Disc(centre, radius, np.array(thing.facing), paint)


def box(centre: Array, R: Array, half: Array, colour: Colour) -> Convex:
    """A box by its middle, its axes and its half edges, m."""
    normals = np.concatenate((R.T, -R.T))
    corners = centre + np.array(list(itertools.product(*((-h, h) for h in half)))) @ R.T
    return Convex(corners, normals, normals @ centre + np.concatenate((half, half)), colour)


def facing_away(thing: WorldThing, eye: Array) -> bool:
    """Whether a camera sees a landmark or a face from too far aside, or from behind (60 deg, assumed)."""
    if thing.kind == "ball":
        return False
    way = eye - np.array(thing.position)
    return float(way @ np.array(thing.facing)) < math.cos(math.radians(60.0)) * float(np.linalg.norm(way))


def _placed(R: Array, d: Array) -> Array:
    H = np.eye(4)
    H[:3, :3], H[:3, 3] = R, d
    return H
