"""What is drawn in 3-D: robot, ghost, loads, support polygon, points, footprints, obstacles."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from bridge.body import Body
from bridge.messages.world_state import Terrain, WorldObject
from bridge.rotations import R_yaw, heading, rotation
from bridge.types import Array, Quaternion
from nao_hil.analysis.diagnosis import Balance, Stand
from nao_hil.view.footprints import Footprints
from nao_hil.view.looks import Colour, ColouredMesh, link_parts, terrain_meshes
from nao_hil.view.support import soles_that_touch, tips
from walker.estimation.odometry import GroundPlane
from walker.model.floating_base import FloatingBase, RobotPose

PLANNED: Final[Colour] = (51, 154, 240)
MEASURED: Final[Colour] = (255, 146, 43)
TRUE: Final[Colour] = (64, 192, 87)
CAPTURE: Final[Colour] = (204, 93, 232)
COM: Final[Colour] = (250, 82, 82)
SAFE: Final[Colour] = (32, 201, 151)
LOST: Final[Colour] = (250, 82, 82)
CELLS: Final[tuple[Colour, Colour]] = ((214, 218, 224), (62, 66, 74))
SECTIONS: Final[tuple[Colour, Colour]] = ((176, 182, 190), (92, 98, 108))
"""Lines of the floor on a light and on a dark page."""
OBSTACLE: Final[Colour] = (212, 163, 92)
GROUND: Final[Colour] = (104, 92, 72)

GHOST_MARGIN: Final = 0.003
"""By which the ghost is larger than the robot, m: where both are at one place it is a skin over it."""
GHOST_APART: Final = 0.006
"""The ghost is shown where it is farther than this from the robot, m: in one place they hide each other."""
NAME_OVER: Final = 0.28
"""Height of the ghost's name over its torso, m."""
THROUGH: Final = 0.5
"""Opacity of the feet."""
BODY_THROUGH: Final = 0.5
"""Opacity of the body, in which one sees the centre of mass."""
NEWTON: Final = 0.006
"""Height of a load's bar, m/N: 150 mm for a full cell."""
BARS_OVER: Final = 0.02
"""Height over the sole at which the bars begin, m."""
PUSH: Final[Colour] = (252, 196, 25)
NEWTON_SECOND: Final = 0.12
"""Length of the arrow of a push, m/(N s)."""
PUSH_OVER: Final = 0.06
"""Height of its head over the torso's origin, m."""
ARROW_TIME: Final = 8.0
"""How long the arrow is shown, s."""
STEEP: Final = 0.15
"""Sine of the angle below which somebody who looks along the floor sees no place on it."""
OVER: Final = 0.002
"""Height of what is drawn on the floor over it, m."""
ROOT: Final = "/world"
"""Frame that all is drawn in: to follow the robot it moves the other way, so that the camera is free."""
FOLLOW: Final = 0.1
"""Share of the way to the robot that the picture goes in a frame: its sway is not followed."""
LEAP: Final = 0.25
"""Distance from which the picture goes there at once, m."""
PRINTS: Final[dict[str, Colour]] = {"planned": PLANNED, "made": (173, 181, 189)}
"""Colours of the footprints."""
FOOTPRINTS: Final = 40
"""Last ones that are kept."""


Dragged = Callable[[tuple[float, float], bool], None]


class Point(NamedTuple):
    """A point of the balance: its name on the page, and its colour."""

    name: str
    label: str
    colour: Colour
    radius: float
    meaning: str
    """For somebody who sees it for the first time."""


POINTS: Final = (
    Point(
        "zmp_plan", "ZMP planned", PLANNED, 0.008, "where the ground is meant to push back (zero moment point)"
    ),
    Point("zmp_fsr", "ZMP by the FSR", MEASURED, 0.008, "where the foot sensors feel it"),
    Point("zmp_true", "ZMP true", TRUE, 0.008, "where it does; at the edge of the feet the robot tips"),
    Point("com", "centre of mass", COM, 0.012, "of the whole robot"),
    Point("com_ground", "its projection", COM, 0.006, "on the ground"),
    Point(
        "capture",
        "capture point",
        CAPTURE,
        0.009,
        "where a foot would have to be for the robot to come to rest",
    ),
)


class RobotScene:
    """The 3-D part of the page.

    Args:
        server: A `viser.ViserServer`.
        body: Data sheet of the robot.
        dark: The page is dark.
    """

    def __init__(self, server: Any, body: Body, dark: bool) -> None:
        self._dark = dark
        self._server, self._scene = server, server.scene
        self._kinematics = FloatingBase(body)
        self._body = body
        self._floor = GroundPlane()
        self._scene.set_up_direction("+z")
        self._root = self._scene.add_frame(ROOT, show_axes=False)
        self._middle: Array = np.zeros(3)
        self._draw_floor()
        self._shells: list[Any] = []
        self._robot = self._links(f"{ROOT}/robot", link_parts(body), None)
        self._ghost = self._links(f"{ROOT}/ghost", link_parts(body, GHOST_MARGIN), MEASURED)
        self._ghost_name = self._scene.add_label(f"{ROOT}/ghost-name", "as its sensors say", visible=False)
        self._points = {
            p.name: self._scene.add_icosphere(f"{ROOT}/points/{p.name}", p.radius, p.colour, subdivisions=2)
            for p in POINTS
        }
        self._bars = self._lines(f"{ROOT}/loads", 8, SAFE, 10.0, each=True)
        self._plumb = self._lines(f"{ROOT}/plumb", 1, COM, 2.0)
        self._support = self._lines(f"{ROOT}/support/edge", 1, SAFE, 4.0)
        self._support_area = self._scene.add_mesh_simple(
            f"{ROOT}/support/area",
            np.zeros((3, 3)),
            np.array([[0, 1, 2]]),
            color=SAFE,
            opacity=0.25,
            side="double",
        )
        self._print_lines = {
            kind: self._lines(f"{ROOT}/footprints/{kind}", 1, colour, 2.0) for kind, colour in PRINTS.items()
        }
        self._begin_footprints()
        self._terrain = Terrain()
        self._terrain_meshes: list[Any] = []
        self._objects: dict[str, tuple[WorldObject, Any]] = {}
        self.ghost, self.follow = True, True
        self._push, self._pushed_until = (0.0, 0.0), 0.0
        self._heading = 0.0
        self._arrow = self._scene.add_arrows(
            f"{ROOT}/push",
            np.array([[[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]], dtype=np.float32),
            PUSH,
            shaft_radius=0.008,
            head_radius=0.02,
            head_length=0.04,
            visible=False,
        )

    def _draw_floor(self) -> None:
        roll, pitch = self._floor.roll, self._floor.pitch
        wxyz = _wxyz(rotation(roll, pitch, 0.0))
        place = (0.0, 0.0, self._floor.height - 0.001)
        self._scene.add_grid(
            f"{ROOT}/floor",
            width=100.0,
            height=100.0,
            cell_size=0.1,
            section_size=0.5,
            cell_color=CELLS[self._dark],
            section_color=SECTIONS[self._dark],
            wxyz=wxyz,
            position=place,
        )

    def _links(self, root: str, parts: dict[str, list[ColouredMesh]], colour: Colour | None) -> dict[int, Any]:
        """Frames of the links that have parts, by their place in `FloatingBase.links`."""
        frames = {}
        for name, pieces in parts.items():
            if name not in self._kinematics.links:
                continue
            link = self._kinematics.links.index(name)
            frames[link] = self._scene.add_frame(f"{root}/{name}", show_axes=False)
            for i, part in enumerate(pieces):
                mesh = self._scene.add_mesh_simple(
                    f"{root}/{name}/{i}",
                    part.vertices,
                    part.faces,
                    color=colour or part.colour,
                    opacity=0.3 if colour else THROUGH if name.endswith("AnkleRoll") else BODY_THROUGH,
                )
                if colour is None and not name.endswith("AnkleRoll"):
                    self._shells.append(mesh)
        return frames

    def _lines(self, name: str, n: int, colour: Colour, width: float, *, each: bool = False) -> Any:
        """Lines of one colour; `each`: a colour for each point, which later ones of the same shape replace."""
        points = np.zeros((n, 2, 3), dtype=np.float32)
        colours = np.array(_of_line(colour), dtype=np.uint8)
        if each:
            colours = np.tile(colours, (n, 2, 1))
        return self._scene.add_line_segments(name, points, colours, thickness=width, thickness_units="screen")

    def dress(self, dark: bool) -> None:
        """Draw the floor for a dark or a light page."""
        self._dark = dark
        self._draw_floor()

    def see_through(self, through: bool) -> None:
        """Draw the robot so that one sees its centre of mass."""
        with self._server.atomic():
            for mesh in self._shells:
                mesh.opacity = BODY_THROUGH if through else None

    def aim(self, impulse: tuple[float, float]) -> None:
        """Show the impulse of a push, N s, ahead and to the left of the robot, for a while."""
        self._push, self._pushed_until = impulse, time.monotonic() + ARROW_TIME

    def on_drag(self, act: Dragged) -> None:
        """A person drags the robot with Shift held.

        Args:
            act: Told the impulse that the way stands for, N s, ahead and to the left of the robot, and whether
                the person has let go.
        """

        def dragged(event: Any) -> None:
            way = level_way(
                *(np.array(p) for p in (event.start_position, event.end_position, event.client.camera.position))
            )
            x, y, _ = R_yaw(-self._heading) @ way / NEWTON_SECOND
            act((float(x), float(y)), event.phase == "end")

        for mesh in self._shells:
            mesh.on_drag("left", modifier="shift")(dragged)

    def draw(self, balance: Balance) -> None:
        """Show one moment."""
        self._heading = heading(balance.best.robot.frames[0])
        if self.follow:
            aim = np.array([*balance.best.robot.frames[0, :2, 3], 0.0])
            share = FOLLOW if np.linalg.norm(aim - self._middle) < LEAP else 1.0
            self._middle = self._middle + share * (aim - self._middle)
            self._root.position = -self._middle
        _pose(self._robot, balance.best.robot)
        shown = self.ghost and balance.true is not None and _apart(balance.true, balance.sensed)
        for frame in self._ghost.values():
            if frame.visible != shown:
                frame.visible = shown
        if self._ghost_name.visible != shown:
            self._ghost_name.visible = shown
        if shown:
            _pose(self._ghost, balance.sensed.robot)
            self._ghost_name.position = balance.sensed.robot.frames[0, :3, 3] + np.array([0.0, 0.0, NAME_OVER])
        self._draw_points(balance)
        self._draw_loads(balance)
        self._draw_support(balance)
        self._draw_footprints(balance)
        self._draw_push(balance.best.robot)

    def _draw_push(self, robot: RobotPose) -> None:
        """An arrow whose head is at the torso."""
        shown = time.monotonic() < self._pushed_until
        if self._arrow.visible != shown:
            self._arrow.visible = shown
        if shown:
            head = robot.frames[0, :3, 3] + np.array([0.0, 0.0, PUSH_OVER])
            way = NEWTON_SECOND * (R_yaw(self._heading) @ (*self._push, 0.0))
            self._arrow.points = np.array([[head - way, head]], dtype=np.float32)

    def forget(self) -> None:
        """The robot began anew: footprints go."""
        self._begin_footprints()
        for lines in self._print_lines.values():
            lines.points = np.zeros((1, 2, 3), dtype=np.float32)

    def _begin_footprints(self) -> None:
        self._footprints = Footprints(self._kinematics)
        self._prints: dict[str, list[Array]] = {kind: [] for kind in PRINTS}

    def _draw_points(self, balance: Balance) -> None:
        best, plan = balance.best, balance.plan
        com = best.robot.com
        ground = self._floor.at(float(com[0]), float(com[1])) + OVER
        places: dict[str, Sequence[float] | Array | None] = {
            "zmp_plan": self._on_floor(plan.zmp) if plan else None,
            "zmp_fsr": self._on_floor(balance.felt),
            "zmp_true": self._on_floor(balance.true.zmp) if balance.true else None,
            "com": com,
            "com_ground": (com[0], com[1], ground),
            "capture": self._on_floor(best.capture),
        }
        for name, place in places.items():
            handle = self._points[name]
            if handle.visible != (place is not None):
                handle.visible = place is not None
            if place is not None:
                handle.position = np.asarray(place)
        self._plumb.points = np.array([[com, (com[0], com[1], ground)]], dtype=np.float32)

    def _on_floor(self, point: tuple[float, float] | None) -> tuple[float, float, float] | None:
        return None if point is None else (*point, self._floor.at(*point) + OVER)

    def _draw_loads(self, balance: Balance) -> None:
        """A bar over each force cell, from green to red at its end of range."""
        fsr = balance.moment.sensors.fsr
        robot = balance.best.robot
        points, colours = [], []
        for side, forces in (("L", fsr[:4]), ("R", fsr[4:])):
            foot = robot.feet["L" if side == "L" else "R"]
            places = self._body.fsr.L if side == "L" else self._body.fsr.R
            for place, force in zip(places, forces, strict=True):
                start = foot[:3, :3] @ (np.array(place) + np.array([0.0, 0.0, BARS_OVER])) + foot[:3, 3]
                points.append([start, start + np.array([0.0, 0.0, NEWTON * max(force, 0.0)])])
                share = min(max(force / self._body.fsr.range, 0.0), 1.0)
                colours.append([_of_line(_between(SAFE, LOST, share))] * 2)
        self._bars.points = np.array(points, dtype=np.float32)
        self._bars.colors = np.array(colours, dtype=np.uint8)

    def _draw_support(self, balance: Balance) -> None:
        polygon = soles_that_touch(self._kinematics, balance.best)
        for handle in (self._support, self._support_area):
            if handle.visible != (polygon is not None):
                handle.visible = polygon is not None
        if polygon is None or len(polygon.corners) < 3:
            return
        corners = np.array([self._on_floor(corner) for corner in polygon.corners])
        colour = LOST if tips(balance.best, polygon) else SAFE
        self._support.points = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1).astype(np.float32)
        self._support.colors = np.array(_of_line(colour), dtype=np.uint8)  # one for all, however many they are
        n = len(corners)
        self._support_area.vertices = corners.astype(np.float32)
        self._support_area.faces = np.array([(0, i, i + 1) for i in range(1, n - 1)], dtype=np.uint32)
        self._support_area.color = colour

    def _draw_footprints(self, balance: Balance) -> None:
        """A new outline where a foot was meant to come down, and where it did."""
        for kind, flat in self._footprints.update(balance):
            corners = np.array([self._on_floor((float(x), float(y))) for x, y in flat])
            prints = self._prints[kind]
            prints.append(np.stack([corners, np.roll(corners, -1, axis=0)], axis=1).astype(np.float32))
            del prints[:-FOOTPRINTS]
            self._print_lines[kind].points = np.concatenate(prints)

    def set_floor(self, floor: GroundPlane) -> None:
        """Draw the floor as it lies."""
        if floor != self._floor:
            self._floor = floor
            self._draw_floor()

    def set_terrain(self, terrain: Terrain) -> None:
        """Draw tiles and heights; they turn with the floor."""
        if terrain == self._terrain:
            return
        self._terrain = terrain
        for handle in self._terrain_meshes:
            handle.remove()
        self._terrain_meshes = [
            self._scene.add_mesh_simple(
                f"{ROOT}/floor/terrain/{i}",
                vertices,
                faces,
                color=GROUND,
                opacity=0.6,
                flat_shading=True,
                side="double",
            )
            for i, (vertices, faces) in enumerate(terrain_meshes(terrain))
        ]

    def set_objects(self, objects: Sequence[WorldObject]) -> None:
        """Draw the world's boxes as they are."""
        for name in set(self._objects) - {o.name for o in objects}:
            self._objects.pop(name)[1].remove()
        for thing in objects:
            known = self._objects.get(thing.name)
            if known is not None and known[0] == thing:
                continue
            if known is not None and known[0].size == thing.size:
                handle = known[1]
                handle.position, handle.wxyz = thing.position, _reorder(thing.orientation)
            else:
                handle = self._scene.add_box(
                    f"{ROOT}/objects/{thing.name}",
                    OBSTACLE,
                    dimensions=thing.size,
                    position=thing.position,
                    wxyz=_reorder(thing.orientation),
                )
            self._objects[thing.name] = (thing, handle)


def level_way(start: Array, end: Array, eye: Array) -> Array:
    """The level way from a point to where somebody at `eye` sees another, m, shape (3,)."""
    sight = end - eye
    if sight[2] < -STEEP * float(np.linalg.norm(sight)):
        end = eye + (start[2] - eye[2]) / sight[2] * sight
    way: Array = (end - start) * (1.0, 1.0, 0.0)
    return way


def _apart(true: Stand, sensed: Stand) -> bool:
    """Whether the two are seen to be at two places."""
    way = true.robot.frames[:, :3, 3] - sensed.robot.frames[:, :3, 3]
    return float(np.abs(way).max()) > GHOST_APART


def _of_line(colour: Colour) -> Colour:
    """The colour to give to a line that is to look like this: lines are drawn without the screen's gamma."""
    r, g, b = (round(255.0 * (c / 255.0) ** 2.2) for c in colour)
    return r, g, b


def _pose(frames: dict[int, Any], robot: RobotPose) -> None:
    turns = quaternions(robot.frames[:, :3, :3])
    for i, frame in frames.items():
        frame.wxyz = turns[i]
        frame.position = robot.frames[i, :3, 3]


def quaternions(R: Array) -> Array:
    """Unit quaternions (w, x, y, z) of rotation matrices, shape (n, 4) of (n, 3, 3)."""
    xyzw = Rotation.from_matrix(R).as_quat()
    wxyz: Array = xyzw[:, [3, 0, 1, 2]]
    return wxyz


def _wxyz(R: Array) -> Array:
    wxyz: Array = quaternions(R[None])[0]
    return wxyz


def _reorder(xyzw: Quaternion) -> tuple[float, float, float, float]:
    x, y, z, w = xyzw
    return w, x, y, z


def _between(a: Colour, b: Colour, share: float) -> Colour:
    r, g, blue = (round(p + share * (q - p)) for p, q in zip(a, b, strict=True))
    return r, g, blue
