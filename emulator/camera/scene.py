"""Scene of a robot's cameras, from ground truth, and the bytes of its pictures in NAOqi's colour spaces.

Known weaknesses: tiles and heightfields are drawn as the flat floor under them; pictures have no noise, no
distortion, no blur of motion, and the exposure is always right.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from io import BytesIO
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bridge.body import TORSO, Body, joint_tree
from bridge.body.cameras import CAMERA_LINK, cameras
from bridge.body.joints import INDEX_WITH_MIRROR
from bridge.body.kinematics import homogeneous
from bridge.messages import TruthFrame
from bridge.messages.world_state import WorldObject, WorldReply, WorldThing
from bridge.rotations import R_pitch, about_axis, matrix, rotation
from bridge.types import Array
from emulator.camera.mesh import Mesh
from emulator.camera.picture import Floor, PaintedField, View
from emulator.camera.shapes import Ball, Colour, Convex, Cylinder, Disc, Solid, face, landmark
from emulator.shell import shell

_YUV: Final = np.array(((0.299, 0.587, 0.114), (-0.168736, -0.331264, 0.5), (0.5, -0.418688, -0.081312)))
"""Full range (ITU-R BT.601, as JFIF has it); which range the robot's has is assumed."""


def encode_picture(rgb: NDArray[np.uint8], space: int) -> bytes:
    """The bytes of a picture in a colour space.

    Args:
        rgb: (height, width, 3), with an even width.
        space: 0 to 8 one channel (Y, U, V, R, G, B, H, S, Y), 9 YUV 4:2:2, 10 YUV, 11 RGB, 12 HSY, 13 BGR.
    """
    if space == 11:
        return rgb.tobytes()
    if space == 13:
        return rgb[..., ::-1].tobytes()
    if space in (3, 4, 5):
        return rgb[..., space - 3].tobytes()
    if space in (6, 7):
        return np.ascontiguousarray(_hue_saturation(rgb)[..., space - 6]).tobytes()
    yuv = _yuv(rgb)
    if space in (0, 8):
        return yuv[..., 0].tobytes()
    if space in (1, 2):
        return yuv[..., space].tobytes()
    if space == 9:
        pairs = np.empty((*rgb.shape[:2], 2), dtype=np.uint8)
        pairs[..., 0] = yuv[..., 0]
        mean = yuv[..., 1:].reshape(rgb.shape[0], -1, 2, 2).mean(axis=2)
        pairs[:, 0::2, 1], pairs[:, 1::2, 1] = mean[..., 0], mean[..., 1]
        return pairs.tobytes()
    if space == 12:
        return np.concatenate((_hue_saturation(rgb), yuv[..., :1]), axis=2).tobytes()
    return yuv.tobytes()


def picture_file(rgb: NDArray[np.uint8], space: int, kind: str) -> bytes:
    """A picture as a file, grey in a colour space of one channel.

    Args:
        rgb: (height, width, 3).
        space: see `encode_picture`.
        kind: `bmp`, `jpeg`, `png`, `ppm` or `tiff`.
    """
    from PIL import Image  # imported late: pictures that are not files do without

    grey = space < 9
    pixels = _yuv(rgb)[..., 0] if grey else rgb
    file = BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(file, kind)
    return file.getvalue()


def _yuv(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    shifted = rgb.astype(np.float32) @ _YUV.T.astype(np.float32) + (0.0, 128.0, 128.0)
    whole: NDArray[np.uint8] = np.clip(shifted + 0.5, 0.0, 255.0).astype(np.uint8)
    return whole


def _hue_saturation(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Hue (a turn is 256) and saturation, as HSV has them."""
    c = rgb.astype(np.float32)
    high, low = c.max(axis=2), c.min(axis=2)
    span = np.maximum(high - low, 1e-6)
    r, g, b = c[..., 0], c[..., 1], c[..., 2]
    sixth = np.where(
        high == r, (g - b) / span % 6.0, np.where(high == g, (b - r) / span + 2.0, (r - g) / span + 4.0)
    )
    hue, saturation = sixth * (256.0 / 6.0), 255.0 * (high - low) / np.maximum(high, 1e-6)
    out: NDArray[np.uint8] = np.stack((hue, saturation), axis=2).astype(np.uint8)
    return out


RED = (0.85, 0.08, 0.06)
_WOOD = (0.83, 0.64, 0.36)
_WHITE = (0.92, 0.93, 0.92)


class RobotModel:
    """A robot with its cameras, as cameras see it: in its shell.

    Args:
        body: Data sheet.
    """

    def __init__(self, body: Body) -> None:
        self.body = body
        self._tree = joint_tree(body)
        self._cameras = cameras(body)
        parts = shell(body)
        pieces = [(link, piece) for link, own in parts.items() for piece in own]
        ends = np.cumsum([len(piece.vertices) for _, piece in pieces])
        counts = [len(piece.faces) for _, piece in pieces]
        self._vertices = np.concatenate([piece.vertices for _, piece in pieces]).T.copy()
        self._faces = np.concatenate([piece.faces for _, piece in pieces]).T.copy()
        self._faces += np.repeat([0, *ends[:-1]], counts)
        self._colours = np.repeat([piece.colour for _, piece in pieces], counts, axis=0) / 255.0
        last = np.cumsum([sum(len(piece.vertices) for piece in own) for own in parts.values()]).tolist()
        self._places = {link: slice(*ends) for link, *ends in zip(parts, [0, *last], last, strict=False)}
        """Vertices of each link."""
        of_head = np.repeat([link == CAMERA_LINK for link, _ in pieces], counts)
        self._headless = np.flatnonzero(~of_head)

    def links(self, truth: TruthFrame) -> dict[str, Array]:
        """Frames of all links in the world, (4, 4), by the joint that moves each."""
        frames = {TORSO: homogeneous(matrix(truth.torso_orientation), np.array(truth.torso_position))}
        for name, joint in self._tree.items():
            turn = about_axis(joint.axis, truth.joints[INDEX_WITH_MIRROR[name]])
            frames[name] = frames[joint.parent] @ homogeneous(turn, np.array(joint.offset))
        return frames

    def view(self, camera: int, links: dict[str, Array]) -> View:
        """Camera 0 (top) or 1 (bottom) in the world."""
        eye = self._cameras[camera]
        H = links[CAMERA_LINK] @ homogeneous(R_pitch(eye.pitch), np.array(eye.place))
        return View(H[:3, 3], H[:3, :3], eye.field)

    def mesh(self, links: dict[str, Array], *, head: bool = True) -> Mesh:
        """The shell; without the head for the robot's own cameras, which are inside it."""
        vertices = np.empty_like(self._vertices)
        for link, place in self._places.items():
            H = links[link]
            vertices[:, place] = H[:3, :3] @ self._vertices[:, place] + H[:3, 3:]
        shown = slice(None) if head else self._headless
        return Mesh(vertices, self._faces[:, shown], self._colours[shown], links[TORSO][None, :3, 3])


def floor_of(world: WorldReply, field: PaintedField | None = None) -> Floor:
    """The floor, with a field on it.

    A tilted one passes through the world's origin, as a scenario's does; one that an event tilts about another
    point is drawn shifted.
    """
    roll, pitch = world.floor
    return Floor(np.zeros(3), rotation(roll, pitch, 0.0), field)


def objects_of(world: WorldReply, white: Sequence[str] = ()) -> list[Solid]:
    """The objects of the world; `white`: names of those that are white, the others are wooden."""
    return [_object(o, _WHITE if o.name in white else _WOOD) for o in world.objects]


def _object(thing: WorldObject, colour: Colour) -> Solid:
    centre, R, half = np.array(thing.position), matrix(thing.orientation), 0.5 * np.array(thing.size)
    if thing.shape == "ball":
        return Ball(centre, float(half[0]), _WHITE, R)
    if thing.shape == "pole":
        return Cylinder(centre, half[2] * R[:, 2], float(half[0]), colour)
    return box(centre, R, half, colour)


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
