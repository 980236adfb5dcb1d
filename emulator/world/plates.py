"""Plates that wait for a foot to be lifted, to lie under it when it lands."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from bridge.body import Body
from bridge.errors import FrameError
from bridge.messages.world import PlateUnderFoot
from bridge.rotations import planar_point
from bridge.types import Side, Vec3
from emulator.engine.shapes import FOOT_LINKS, sole_points
from emulator.poses import Pose, matrix
from emulator.vectors import add, rotate
from emulator.world.world import World

GAP: Final = 0.001
"""Air between a lifted sole and the plate that appears under it, m."""
_SIDES: Final[dict[str, tuple[Side, ...]]] = {"left": ("L",), "right": ("R",), "swing": ("L", "R")}
_FOOT: Final = {"L": "left", "R": "right"}


class WaitingPlates:
    """Plates that are to lie under a foot.

    Args:
        world: Where they will lie.
        body: Data sheet of the robot.
        say: Told in one sentence that a plate lies, with a short code.
    """

    def __init__(self, world: World, body: Body, say: Callable[[str, str], None]) -> None:
        self._world, self._say = world, say
        self._waiting: list[PlateUnderFoot] = []
        self._soles: dict[Side, list[Vec3]] = {
            "L": sole_points(body, "L").tolist(),
            "R": sole_points(body, "R").tolist(),
        }
        x, y = body.foot.centre
        bottom = -body.lengths.FootHeight
        self._middle: dict[Side, Vec3] = {"L": (x, y, bottom), "R": (x, -y, bottom)}

    def add(self, plate: PlateUnderFoot) -> None:
        """Let a plate wait."""
        self._waiting.append(plate)

    def begin_cycle(self) -> None:
        """Lay every plate whose foot is high enough now."""
        if self._waiting:
            self._waiting = [plate for plate in self._waiting if not self._lay(plate)]

    def _lay(self, plate: PlateUnderFoot) -> bool:
        """Put a waiting plate under its foot if that is high enough; True when done."""
        for side in _SIDES[plate.foot]:
            foot = self._world.engine.robot.link_pose(FOOT_LINKS[side])
            lowest = min(self._world.clearance(_point(foot, corner)) for corner in self._soles[side])
            if lowest >= plate.size[2] + GAP:
                self._place(plate, side, foot)
                return True
        return False

    def _place(self, plate: PlateUnderFoot, side: Side, foot: Pose) -> None:
        world = self._world
        x, y, _ = world.to_floor(_point(foot, self._middle[side]))
        ahead = world.to_floor(_point(foot, (1.0, 0.0, 0.0)))
        here = world.to_floor(foot.position)
        yaw = math.atan2(ahead[1] - here[1], ahead[0] - here[0])
        at = planar_point((x, y, yaw), plate.shift)
        try:
            world.add_box(plate.name, plate.size, at, yaw + plate.yaw, height=0.0, beside_robot=True)
        except FrameError as error:  # it reaches into the other foot
            self._say("world-refused", str(error))
            return
        self._say(
            "world",
            f"A plate of {1e3 * plate.size[2]:.0f} mm lies under the {_FOOT[side]} foot "
            f"at ({at[0]:.3f}, {at[1]:.3f}).",
        )


def _point(pose: Pose, point: Vec3) -> Vec3:
    """A point of a frame in the frame that its pose is in."""
    return add(pose.position, rotate(matrix(pose.orientation), point))
