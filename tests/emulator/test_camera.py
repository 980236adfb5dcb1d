"""Pictures of the cameras against an independent pinhole: places, pitch and fields of the vendor's pages."""

from __future__ import annotations

import itertools
import math
import socket
import threading
import time
from collections.abc import Callable
from io import BytesIO
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from bridge.adapters.naoqi.core.cameras import Pipe
from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.postures import POSTURES
from bridge.host import robot_info
from bridge.messages import TruthFrame, encode
from bridge.messages.world_state import WorldObject, WorldReply, WorldThing
from bridge.types import Vec3
from emulator.camera import process
from emulator.camera.picture import draw, hidden
from emulator.camera.scene import (
    CameraScene,
    encode_picture,
    floor_of,
    objects_of,
    picture_file,
    thing_of,
)
from emulator.camera.shapes import Cylinder
from tests.frames import truth_frame, world_reply

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


def picture(body: str, camera: int, frame: TruthFrame, reply: WorldReply, width: int) -> np.ndarray:
    scene = CameraScene(load_body(body))
    links = scene.links(frame)
    solids = [*scene.limbs(links), *objects_of(reply), *map(thing_of, reply.things)]
    return draw(scene.view(camera, links), floor_of(reply), solids, width, 3 * width // 4)


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
    scene = CameraScene(load_body("nao-v5"))
    view = scene.view(0, scene.links(frame))
    place = np.array(thing.position)
    assert not hidden(place, view, objects_of(world()))
    assert hidden(place, view, objects_of(world(boxes=(box,))))
    assert red(picture("nao-v5", 0, frame, world(thing), 160)).any()
    assert not red(picture("nao-v5", 0, frame, world(thing, boxes=(box,)), 160)).any()


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


def test_a_garbled_ground_truth_is_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """Anybody may publish on an unencrypted link; the next good frame is drawn."""
    received: list[Callable[[bytes], None]] = []
    monkeypatch.setattr(process, "open_client", lambda *_: None)
    monkeypatch.setattr(process, "subscribe", lambda _session, _key, receive: received.append(receive))
    info = encode(robot_info(load_body("nao-v6"), robot="nao", side="emulator", mode="real-time", software=""))
    monkeypatch.setattr(process, "ask", lambda *_: info)
    monkeypatch.setattr(process, "WorldClient", lambda *_: SimpleNamespace(send=lambda _: world()))
    ours, theirs = socket.socketpair()
    ours.settimeout(10.0)
    pipe = Pipe(ours)
    cameras = process.CameraProcess("nao", "", Pipe(theirs))
    received[0](b"\x01")
    threading.Thread(target=cameras.serve, daemon=True).start()
    pipe.send([1, 0, 40, 30, 11, ""])
    time.sleep(0.1)
    received[0](encode(truth(0.0, 0.0)))
    answer = pipe.receive()
    assert answer is not None and answer[:2] == [1, True]
    pipe.close()


def test_it_is_idle_until_the_first_request(monkeypatch: pytest.MonkeyPatch) -> None:
    """It starts with the server, so that a first face is seen at once, and costs little before."""
    received: list[Callable[[bytes], None]] = []
    asked = threading.Event()
    monkeypatch.setattr(process, "open_client", lambda *_: None)
    monkeypatch.setattr(process, "subscribe", lambda _session, _key, receive: received.append(receive))
    info = encode(robot_info(load_body("nao-v6"), robot="nao", side="emulator", mode="real-time", software=""))
    monkeypatch.setattr(process, "ask", lambda *_: info)
    face = WorldThing(name="Anna", kind="face", size=0.15, position=(1.0, 0.0, 0.45), facing=(-1.0, 0.0, 0.0))
    client = SimpleNamespace(send=lambda _: asked.set() or world(face))
    monkeypatch.setattr(process, "WorldClient", lambda *_: client)
    ours, theirs = socket.socketpair()
    ours.settimeout(10.0)
    pipe = Pipe(ours)
    cameras = process.CameraProcess("nao", "", Pipe(theirs))
    received[0](encode(truth(0.0, 0.0)))
    threading.Thread(target=cameras.serve, daemon=True).start()
    assert not asked.wait(0.5)
    pipe.send([0])
    answer = pipe.receive()
    assert answer is not None and answer[0] == 0
    assert {sight[2] for sight in answer[1]} == {"Anna"}
    pipe.close()
