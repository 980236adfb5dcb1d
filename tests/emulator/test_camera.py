"""Pictures of the cameras against an independent pinhole: places, pitch and fields of the vendor's pages."""

from __future__ import annotations

import itertools
import math
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from io import BytesIO
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageDraw

from bridge.adapters.naoqi.core.cameras import Pipe
from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.kinematics import FloatingBase, homogeneous
from bridge.body.postures import POSTURES
from bridge.link.robots import LinkRobot
from bridge.messages import TruthFrame, encode
from bridge.messages.world_state import WorldObject, WorldReply, WorldThing
from bridge.rotations import matrix
from bridge.types import Vec3
from emulator.camera import process
from emulator.camera.picture import draw, hidden
from emulator.camera.scene import (
    RobotModel,
    encode_picture,
    floor_of,
    objects_of,
    picture_file,
    thing_of,
)
from emulator.camera.shapes import Cylinder
from emulator.shell import shell
from tests.frames import truth_frame, world_reply
from tests.loops import TIMEOUT

LOOKS = {
    # vendor's video pages: x, z (m) and pitch (deg) of each camera in the head's frame, field of view (deg)
    "nao-v3": (((0.0539, 0.0679, 0.0), (0.0488, 0.02381, 40.0)), (47.8, 36.8)),
    "nao-v5": (((0.05871, 0.06364, 1.2), (0.05071, 0.01774, 39.7)), (60.9, 47.6)),
    "nao-v6": (((0.05871, 0.06364, 1.2), (0.05071, 0.01774, 39.7)), (56.3, 43.7)),
}
NECK = 0.1265
"""Of the head's joints over the Torso frame, m (vendor's page on links)."""


def truth(yaw: float, pitch: float, at: Vec3 = (0.0, 0.0, 0.33), heading: float = 0.0) -> TruthFrame:
    joints = list(POSTURES["StandInit"])
    joints[INDEX["HeadYaw"]], joints[INDEX["HeadPitch"]] = yaw, pitch
    turn = (0.0, 0.0, math.sin(heading / 2.0), math.cos(heading / 2.0))
    return truth_frame(torso_position=at, torso_orientation=turn, joints=tuple(joints))


def world(*things: WorldThing, boxes: tuple[WorldObject, ...] = ()) -> WorldReply:
    return world_reply(objects=boxes, things=things)


def ball(at: Vec3, size: float = 0.06) -> WorldThing:
    return WorldThing(name="ball", kind="ball", size=size, position=at, facing=(1.0, 0.0, 0.0))


def pinhole(
    body: str, camera: int, frame: TruthFrame, heading: float, yaw: float, pitch: float, point: Vec3
) -> tuple[float, float, float]:
    """Depth (m), and place in a picture from (0, 0) upper left to (1, 1), written out turn by turn."""
    (eyes, (across, down)) = LOOKS[body]
    ex, ez, tilt = eyes[camera]
    x, y, z = (p - t for p, t in zip(point, frame.torso_position, strict=True))
    angle = heading + yaw
    x, y = math.cos(angle) * x + math.sin(angle) * y, -math.sin(angle) * x + math.cos(angle) * y
    z -= NECK
    x, z = math.cos(pitch) * x - math.sin(pitch) * z, math.sin(pitch) * x + math.cos(pitch) * z
    x, z = x - ex, z - ez
    t = math.radians(tilt)
    x, z = math.cos(t) * x - math.sin(t) * z, math.sin(t) * x + math.cos(t) * z
    u = 0.5 - 0.5 * (y / x) / math.tan(math.radians(across / 2.0))
    v = 0.5 - 0.5 * (z / x) / math.tan(math.radians(down / 2.0))
    return x, u, v


def picture(
    body: str, camera: int, frame: TruthFrame, reply: WorldReply, width: int, others: Sequence[TruthFrame] = ()
) -> np.ndarray:
    model = RobotModel(load_body(body))
    links = model.links(frame)
    robots = [model.mesh(links, head=False), *(model.mesh(model.links(other)) for other in others)]
    solids = [*objects_of(reply), *map(thing_of, reply.things)]
    return draw(model.view(camera, links), floor_of(reply), solids, width, 3 * width // 4, robots)


def red(rgb: np.ndarray) -> np.ndarray:
    r, g, b = (rgb[..., i].astype(int) for i in range(3))
    return (r > 2 * g) & (r > 2 * b)


@pytest.mark.parametrize(
    ("body", "camera", "width", "heading", "yaw", "pitch", "at"),
    [
        ("nao-v5", 0, 320, 0.0, 0.0, 0.0, (1.2, 0.1, 0.30)),
        ("nao-v5", 1, 320, 0.0, 0.0, 0.0, (0.35, -0.1, 0.03)),
        ("nao-v5", 1, 640, 0.7, -0.4, 0.2, (0.3, 0.12, 0.03)),
        ("nao-v3", 0, 320, -1.0, 0.5, 0.3, (0.7, -0.4, 0.15)),
        ("nao-v6", 1, 320, 0.0, 0.3, -0.1, (0.5, 0.15, 0.03)),
    ],
)
def test_a_ball_is_where_the_cameras_geometry_says(
    body: str, camera: int, width: int, heading: float, yaw: float, pitch: float, at: Vec3
) -> None:
    frame = truth(yaw, pitch, heading=heading)
    depth, u, v = pinhole(body, camera, frame, heading, yaw, pitch, at)
    seen = red(picture(body, camera, frame, world(ball(at)), width))
    rows, columns = np.nonzero(seen)
    assert math.hypot(columns.mean() + 0.5 - u * width, rows.mean() + 0.5 - v * 0.75 * width) < 2.0
    focal = 0.5 * width / math.tan(math.radians(LOOKS[body][1][0] / 2.0))
    assert math.sqrt(seen.sum() / math.pi) == pytest.approx(focal * 0.03 / depth, rel=0.1)


def test_a_box_before_the_ball_hides_it() -> None:
    frame, thing = truth(0.0, 0.0), ball((1.2, 0.0, 0.3))
    box = WorldObject(
        name="b", size=(0.1, 0.4, 0.8), position=(0.8, 0.0, 0.4), orientation=(0.0, 0.0, 0.0, 1.0), mass=0.0
    )
    model = RobotModel(load_body("nao-v5"))
    view = model.view(0, model.links(frame))
    place = np.array(thing.position)
    assert not hidden(place, view, objects_of(world()))
    assert hidden(place, view, objects_of(world(boxes=(box,))))
    assert red(picture("nao-v5", 0, frame, world(thing), 160)).any()
    assert not red(picture("nao-v5", 0, frame, world(thing, boxes=(box,)), 160)).any()


def pixels_of(frame: TruthFrame, other: TruthFrame, width: int) -> np.ndarray:
    """Another V6 in the picture of a V6's upper camera, by Pillow, with all pixels that edges touch."""
    body = load_body("nao-v6")
    kinematics = FloatingBase(body)
    torso = homogeneous(matrix(other.torso_orientation), np.array(other.torso_position))
    frames = dict(zip(kinematics.links, torso @ kinematics.in_torso(other.joints), strict=True))
    image = Image.new("1", (width, 3 * width // 4))
    drawing = ImageDraw.Draw(image)
    for link, pieces in shell(body).items():
        R, d = frames[link][:3, :3], frames[link][:3, 3]
        for piece in pieces:
            corners = [pinhole("nao-v6", 0, frame, 0.0, 0.0, 0.0, point) for point in piece.vertices @ R.T + d]
            places = [(u * width - 0.5, v * 0.75 * width - 0.5) for _, u, v in corners]
            for face in piece.faces:
                drawing.polygon([places[corner] for corner in face], fill=1, outline=1)
    return np.array(image)


def covered(frame: TruthFrame, others: Sequence[TruthFrame], width: int, *boxes: WorldObject) -> np.ndarray:
    """Pixels of the upper camera that are others with other robots than without."""
    bare, seen = (picture("nao-v6", 0, frame, world(boxes=boxes), width, robots) for robots in ((), others))
    return (bare != seen).any(axis=-1)


@pytest.mark.parametrize(
    ("at", "heading"), [((1.5, 0.0, 0.33), math.pi), ((0.9, 0.25, 0.33), 0.4), ((4.0, -1.0, 0.33), -1.6)]
)
def test_another_robot_covers_the_pixels_that_a_pinhole_gives_it(at: Vec3, heading: float) -> None:
    frame, other = truth(0.0, 0.0), truth(0.3, 0.1, at, heading)
    seen, touched = covered(frame, [other], 320), pixels_of(frame, other, 320)
    padded = np.pad(touched, 1)
    around = [padded[1 + i : 241 + i, 1 + k : 321 + k] for i in (-1, 0, 1) for k in (-1, 0, 1)]
    inner, outer = np.min(around, axis=0), np.max(around, axis=0)
    assert inner.sum() > 300
    assert not (seen & ~outer).any()
    assert (inner & ~seen).sum() < 0.01 * inner.sum()  # a part of it may have the background's colour


def test_another_robot_behind_is_not_seen() -> None:
    frame = truth(0.0, 0.0)
    assert not covered(frame, [truth(0.0, 0.0, (-1.5, 0.0, 0.33))], 160).any()
    assert covered(truth(0.0, 0.0, heading=math.pi), [truth(0.0, 0.0, (-1.5, 0.0, 0.33))], 160).any()


def test_the_nearer_of_robots_and_boxes_is_seen() -> None:
    """A box hides the legs of a robot behind it up to the far edge of its top, and nothing of one before it."""
    frame, near, far = truth(0.0, 0.0), truth(0.0, 0.0, (1.0, 0.0, 0.33)), truth(0.0, 0.0, (2.0, 0.0, 0.33))
    box = WorldObject(
        name="b", size=(0.1, 1.2, 0.2), position=(1.5, 0.0, 0.1), orientation=(0.0, 0.0, 0.0, 1.0), mass=0.0
    )
    free, behind = covered(frame, [far], 160), covered(frame, [far], 160, box)
    rows = np.flatnonzero(free.any(axis=1))
    _, _, edge = pinhole("nao-v6", 0, frame, 0.0, 0.0, 0.0, (1.55, 0.0, 0.2))
    assert rows[0] < edge * 120.0 < rows[-1]
    hidden_rows = np.flatnonzero(behind.any(axis=1))
    assert hidden_rows[0] == rows[0] and hidden_rows[-1] == pytest.approx(edge * 120.0, abs=1.5)
    np.testing.assert_array_equal(covered(frame, [near], 160), covered(frame, [near], 160, box))
    first, second = (picture("nao-v6", 0, frame, world(), 160, order) for order in ([near, far], [far, near]))
    np.testing.assert_array_equal(first, second)


def test_a_robot_hides_a_thing_behind_it() -> None:
    model, frame = RobotModel(load_body("nao-v6")), truth(0.0, 0.0)
    view = model.view(0, model.links(frame))
    for other, is_hidden in (((1.0, 0.0, 0.33), True), ((1.0, 0.5, 0.33), False), ((2.0, 0.0, 0.33), False)):
        robots = [model.mesh(model.links(truth(0.0, 0.0, other)))]
        assert hidden(np.array((1.5, 0.0, 0.4)), view, [], robots) is is_hidden


def test_rays_strike_a_pole_where_a_ray_march_does() -> None:
    """Of an upright, an inclined and a short one, also from above and from below."""
    random = np.random.default_rng(3)
    for half in ((0.0, 0.0, 0.4), (0.1, -0.2, 0.3), (0.0, 0.0, 0.02)):
        pole = Cylinder(np.array((1.0, 0.1, 0.3)), np.array(half), 0.1, (1.0, 1.0, 1.0))
        axis = np.array(half) / np.linalg.norm(half)
        for eye in (np.array((0.0, 0.0, 0.35)), np.array((0.9, 0.0, 1.2)), np.array((1.1, 0.3, -0.8))):
            rays = pole.centre + random.normal(0.0, 0.12, (200, 3)) - eye
            depth = pole.intersect(eye, rays)
            steps = np.arange(0.2, 1.8, 5e-4)
            points = eye + steps[None, :, None] * rays[:, None] - pole.centre
            along = points @ axis
            radius = np.linalg.norm(points - along[..., None] * axis, axis=-1)
            inside = (np.abs(along) <= np.linalg.norm(half)) & (radius <= 0.1)
            marched = np.where(inside.any(axis=1), steps[inside.argmax(axis=1)], np.inf)
            both = np.isfinite(depth) & np.isfinite(marched)
            assert (np.isfinite(depth) != np.isfinite(marched)).mean() < 0.02 and both.sum() > 10
            np.testing.assert_allclose(depth[both], marched[both], atol=1e-3)
            _, normals = pole.colours_and_normals(eye + depth[both][:, None] * rays[both])
            np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)
            assert (np.einsum("ij,ij->i", normals, rays[both]) < 1e-9).all()


def test_a_ball_that_can_be_touched_is_white_with_dark_spots_that_turn_with_it() -> None:
    """The spots, of 21.6 degrees about six points, cover six times (1 - 0.93) / 2 of its surface."""
    normals = np.random.default_rng(0).normal(size=(20000, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    turn = (0.0, 0.0, math.sin(0.3), math.cos(0.3))
    thing = WorldObject(
        name="b", shape="ball", size=(0.1,) * 3, position=(1.0, 2.0, 0.05), orientation=turn, mass=0.044
    )
    (solid,) = objects_of(world(boxes=(thing,)))
    colours, _ = solid.colours_and_normals(np.array(thing.position) + 0.05 * normals)
    dark = colours[:, 0] < 0.2
    assert dark.mean() == pytest.approx(0.21, abs=0.01) and colours[~dark].min() > 0.9
    ahead = normals @ (math.cos(0.6), math.sin(0.6), 0.0) > 0.95  # its x axis, turned by 0.6 rad
    assert dark[ahead].all() and not dark[normals[:, 0] > 0.98].any()


def test_a_pole_is_as_wide_from_all_sides_and_a_box_is_not() -> None:
    """0.2 m in diameter at 1 m, turned about its axis by half a right angle."""
    turn = (0.0, 0.0, math.sin(math.pi / 8.0), math.cos(math.pi / 8.0))
    widths = {}
    for shape, orientation in itertools.product(("pole", "box"), ((0.0, 0.0, 0.0, 1.0), turn)):
        size, at = (0.2, 0.2, 0.9), (1.0, 0.0, 0.45)
        thing = WorldObject(
            name="p",
            shape=shape,  # type: ignore[arg-type]
            size=size,
            position=at,
            orientation=orientation,
            mass=0.0,
        )
        frame = truth(0.0, 0.0)
        bare = picture("nao-v6", 0, frame, world(), 320)
        seen = picture("nao-v6", 0, frame, world(boxes=(thing,)), 320) != bare
        widths[shape, orientation] = int(seen.any(axis=-1)[120].sum())
    straight, turned = ((0.0, 0.0, 0.0, 1.0), turn)
    assert widths["pole", straight] == pytest.approx(widths["pole", turned], abs=1)
    assert widths["box", turned] > 1.2 * widths["box", straight]


@pytest.mark.parametrize(
    ("space", "expected"),
    # ITU-R BT.601, full range, of pure red, as JFIF has it
    [
        *((0, [76]), (1, [85]), (2, [255]), (3, [255]), (4, [0]), (6, [0]), (7, [255])),
        *(
            (9, [76, 85, 76, 255]),
            (10, [76, 85, 255]),
            (11, [255, 0, 0]),
            (12, [0, 255, 76]),
            (13, [0, 0, 255]),
        ),
    ],
)
def test_colour_spaces_of_red(space: int, expected: list[int]) -> None:
    picture_ = np.zeros((2, 2, 3), dtype=np.uint8)
    picture_[..., 0] = 255
    data = list(encode_picture(picture_, space))
    assert data[: len(expected)] == pytest.approx(expected, abs=1)
    assert len(data) == 4 * (2 if space == 9 else len(expected))


@pytest.mark.parametrize("kind", ["bmp", "jpeg", "png", "ppm", "tiff"])
@pytest.mark.parametrize(("space", "mode", "middle"), [(13, "RGB", (255, 0, 0)), (0, "L", 76)])
def test_a_picture_as_a_file_is_read_by_others(kind: str, space: int, mode: str, middle: Any) -> None:
    """Grey is luma (ITU-R BT.601)."""
    red_ = np.zeros((12, 16, 3), dtype=np.uint8)
    red_[..., 0] = 255
    with Image.open(BytesIO(picture_file(red_, space, kind))) as read:
        assert (read.size, read.mode) == ((16, 12), mode)
        assert read.getpixel((8, 6)) == pytest.approx(middle, abs=2)


class FakeLink:
    """Two robots, whose ground truth a test gives."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, reply: Callable[[], WorldReply]) -> None:
        body = load_body("nao-v6")
        self.found = {name: LinkRobot(body, deque(maxlen=1)) for name in ("nao", "other")}
        monkeypatch.setattr(process, "LinkRobots", lambda _: self)
        monkeypatch.setattr(process, "WorldClient", lambda *_: SimpleNamespace(send=lambda _: reply()))

    def update(self) -> dict[str, LinkRobot]:
        return self.found

    def receive(self, payload: bytes, robot: str = "nao") -> None:
        self.found[robot].newest.append((time.time(), payload))


def test_a_garbled_ground_truth_is_passed_over_and_others_are_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Anybody may publish on an unencrypted link; the next good frame is drawn."""
    link = FakeLink(monkeypatch, world)
    ours, theirs = socket.socketpair()
    ours.settimeout(TIMEOUT)
    pipe = Pipe(ours)
    cameras = process.CameraProcess("nao", "", Pipe(theirs))
    link.receive(b"\x01")
    threading.Thread(target=cameras.serve, daemon=True).start()
    pipe.send([1, 0, 40, 30, 11, ""])
    time.sleep(0.1)
    link.receive(encode(truth(0.0, 0.0)))
    alone = pipe.receive()
    assert alone is not None and alone[:2] == [1, True]
    link.receive(encode(truth(0.0, 0.0, (1.0, 0.0, 0.33))), "other")
    pipe.send([2, 0, 40, 30, 11, ""])
    together = pipe.receive()
    assert together is not None and together[:2] == [2, True]
    assert together[2][1] != alone[2][1]
    pipe.close()


def test_it_is_idle_until_the_first_request(monkeypatch: pytest.MonkeyPatch) -> None:
    """It starts with the server, so that a first face is seen at once, and costs little before."""
    asked = threading.Event()
    face = WorldThing(name="Anna", kind="face", size=0.15, position=(1.0, 0.0, 0.45), facing=(-1.0, 0.0, 0.0))
    link = FakeLink(monkeypatch, lambda: asked.set() or world(face))
    ours, theirs = socket.socketpair()
    ours.settimeout(TIMEOUT)
    pipe = Pipe(ours)
    cameras = process.CameraProcess("nao", "", Pipe(theirs))
    link.receive(encode(truth(0.0, 0.0)))
    threading.Thread(target=cameras.serve, daemon=True).start()
    assert not asked.wait(0.5)
    pipe.send([0])
    answer = pipe.receive()
    assert answer is not None and answer[0] == 0
    assert {sight[2] for sight in answer[1]} == {"Anna"}
    pipe.close()
