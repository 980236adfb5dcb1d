"""The 3-D part of the page: the robot, its ghost, and everything around them."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from bridge.body import Body
from bridge.rotations import heading
from bridge.types import Array
from nao_hil.analysis.diagnosis import Balance, Stand
from nao_hil.view.looks import Colour, ColouredMesh, link_parts
from nao_hil.view.scene.ground import GroundScene
from nao_hil.view.scene.lines import quaternions, show
from nao_hil.view.scene.marks import BalanceMarks
from nao_hil.view.scene.palette import MEASURED, ROOT
from nao_hil.view.scene.push import Dragged, PushArrow
from walker.model.floating_base import FloatingBase, RobotPose

GHOST_MARGIN: Final = 0.003
"""By which the ghost is larger than the robot, m: where both are at one place it is a skin over it."""
GHOST_APART: Final = 0.03
"""The ghost is shown where it is farther than this from the robot, m: nearer they hide each other."""
GHOST_OPACITY: Final = 0.18
NAME_OVER: Final = 0.28
"""Height of the ghost's name over its torso, m."""
THROUGH: Final = 0.5
"""Opacity of the robot, in which one sees the centre of mass."""
FOLLOW: Final = 0.1
"""Share of the way to the robot that the picture goes in a frame: its sway is not followed."""
LEAP: Final = 0.25
"""Distance from which the picture goes there at once, m."""


class RobotScene:
    """The 3-D part of the page.

    Args:
        server: A `viser.ViserServer`.
        body: Data sheet of the robot.
        dark: The page is dark.
    """

    def __init__(self, server: Any, body: Body, dark: bool) -> None:
        self._server, self._scene = server, server.scene
        self._kinematics = FloatingBase(body)
        self._scene.set_up_direction("+z")
        self._root = self._scene.add_frame(ROOT, show_axes=False)
        self._middle: Array = np.zeros(3)
        self.ground = GroundScene(self._scene, dark)
        self._shells: list[Any] = []
        self._robot = self._links(f"{ROOT}/robot", link_parts(body), None)
        self._ghost = self._links(f"{ROOT}/ghost", link_parts(body, GHOST_MARGIN), MEASURED)
        self._ghost_name = self._scene.add_label(f"{ROOT}/ghost-name", "as its sensors say", visible=False)
        self.marks = BalanceMarks(self._scene, body, self._kinematics, self.ground)
        self.arrow = PushArrow(self._scene)
        self.ghost, self.follow = True, True

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
                    opacity=GHOST_OPACITY if colour else THROUGH,
                )
                if colour is None and not name.endswith("AnkleRoll"):
                    self._shells.append(mesh)
        return frames

    def see_through(self, through: bool) -> None:
        """Draw the robot so that one sees its centre of mass."""
        with self._server.atomic():
            for mesh in self._shells:
                mesh.opacity = THROUGH if through else None

    def on_drag(self, act: Dragged) -> None:
        """A person drags the robot with Shift held; `act` as of `PushArrow.on_drag`."""
        for mesh in self._shells:
            mesh.on_drag("left", modifier="shift")(self.arrow.on_drag(act))

    def draw(self, balance: Balance) -> None:
        """Show one moment."""
        robot = balance.best.robot
        if self.follow:
            aim = np.array([*robot.frames[0, :2, 3], 0.0])
            share = FOLLOW if np.linalg.norm(aim - self._middle) < LEAP else 1.0
            self._middle = self._middle + share * (aim - self._middle)
            self._root.position = -self._middle
        _pose(self._robot, robot)
        shown = self.ghost and balance.true is not None and _apart(balance.true, balance.sensed)
        for handle in (*self._ghost.values(), self._ghost_name):
            show(handle, shown)
        if shown:
            _pose(self._ghost, balance.sensed.robot)
            self._ghost_name.position = balance.sensed.robot.frames[0, :3, 3] + np.array([0.0, 0.0, NAME_OVER])
        self.marks.draw(balance)
        self.arrow.draw(robot.frames[0, :3, 3], heading(robot.frames[0]))


def _apart(true: Stand, sensed: Stand) -> bool:
    """Whether the two are seen to be at two places."""
    way = true.robot.frames[:, :3, 3] - sensed.robot.frames[:, :3, 3]
    return float(np.abs(way).max()) > GHOST_APART


def _pose(frames: dict[int, Any], robot: RobotPose) -> None:
    turns = quaternions(robot.frames[:, :3, :3])
    for i, frame in frames.items():
        frame.wxyz = turns[i]
        frame.position = robot.frames[i, :3, 3]
