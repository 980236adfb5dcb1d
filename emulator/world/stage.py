"""What happens in the world when: the timeline of a scenario, and commands given live."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

from bridge.datasheet import TORSO, Body
from bridge.datasheet.model import Side
from bridge.errors import FrameError
from bridge.messages import Vec3
from bridge.world import (
    PlaceBox,
    PlateUnderFoot,
    Push,
    Remove,
    SetFriction,
    SwingPendulum,
    TiltFloor,
    WorldObject,
    least_tilt_time,
)
from emulator.engine import bullet
from emulator.mechanics import Mechanics
from emulator.shapes import sole_points
from emulator.vectors import Rotation, rotate
from emulator.world.actions import BOB_RADIUS, Action, FloorTilt, Pendulum, PushForce
from emulator.world.world import World

Happening = Push | PlaceBox | Remove | PlateUnderFoot | SwingPendulum | TiltFloor | SetFriction
"""Commands that the stage carries out."""
_SIDES: Final[dict[str, tuple[Side, ...]]] = {"left": ("L",), "right": ("R",), "swing": ("L", "R")}
_FOOT: Final = {"L": "left", "R": "right"}
PLATE_GAP: Final = 0.001
"""Air between a lifted sole and the plate that appears under it, m."""
_INSIDE: Final = -1e-4
"""Distance from which a new box counts as standing inside the robot, m."""


class Stage:
    """Carries out what happens in the world of one robot.

    Args:
        world: The world.
        mechanics: The robot in it.
        body: Its data sheet.
        timeline: What happens when: robot time in s, and the command.
        say: Told in one sentence what happened, with a short code.
    """

    def __init__(
        self,
        world: World,
        mechanics: Mechanics,
        body: Body,
        timeline: Sequence[tuple[float, Happening]],
        say: Callable[[str, str], None],
    ) -> None:
        self._world, self._mechanics, self._say = world, mechanics, say
        self._soles: dict[Side, list[Vec3]] = {
            "L": sole_points(body, "L").tolist(),
            "R": sole_points(body, "R").tolist(),
        }
        self._middle = {
            "L": (*body.foot.centre, -body.lengths.FootHeight),
            "R": (body.foot.centre[0], -body.foot.centre[1], -body.lengths.FootHeight),
        }
        self._timeline = sorted(timeline, key=lambda event: event[0], reverse=True)
        self._actions: list[Action] = []
        self._plates: list[PlateUnderFoot] = []
        self._dt = world.parameters.step

    def begin_cycle(self, time: float) -> Callable[[], None] | None:
        """What is due in the cycle that begins now.

        Args:
            time: Robot time at its beginning, s.

        Returns:
            To be called before each physics step of the cycle; None when nothing goes on.
        """
        while self._timeline and self._timeline[-1][0] <= time + 1e-9:
            self._happen(self._timeline.pop()[1])
        if self._plates:
            self._plates = [plate for plate in self._plates if not self._lay(plate)]
        return self._before_step if self._actions else None

    def _happen(self, command: Happening) -> None:
        """Carry out an event of the timeline; what is no longer possible is said, not raised."""
        try:
            self.execute(command)
        except FrameError as error:
            self._say("world-refused", str(error))

    def _before_step(self) -> None:
        self._actions = [action for action in self._actions if action.step()]

    def execute(self, command: Happening) -> str:
        """Carry out a command at a cycle boundary.

        Returns:
            What was done, in one sentence, which is also said.

        Raises:
            FrameError: the command means something that is not there, or cannot be.
        """
        if isinstance(command, Push):
            text = self._push(command)
        elif isinstance(command, PlaceBox):
            text = self._place(command)
        elif isinstance(command, Remove):
            text = self._remove(command)
        elif isinstance(command, PlateUnderFoot):
            self._plates.append(command)
            text = f"A plate waits for the {command.foot} foot to be lifted."
        elif isinstance(command, SwingPendulum):
            text = self._pendulum(command)
        elif isinstance(command, TiltFloor):
            text = self._tilt(command)
        else:
            self._world.set_friction(command.friction)
            text = f"The floor's friction is {command.friction:g}."
        self._say("world", text)
        return text

    def objects(self) -> tuple[WorldObject, ...]:
        """All boxes by name as they lie now."""
        found = []
        for name, box in self._world.boxes.items():
            position, turn = bullet.getBasePositionAndOrientation(box.body, physicsClientId=self._world.client)
            found.append(
                WorldObject(name=name, size=box.size, position=position, orientation=turn, mass=box.mass)
            )
        return tuple(found)

    def _heading(self) -> tuple[Vec3, float]:
        """Torso's origin, and its heading in the world, rad."""
        torso = self._mechanics.torso()
        return torso.position, math.atan2(torso.rotation[3], torso.rotation[0])

    def _push(self, command: Push) -> str:
        model, world = self._mechanics.model, self._world
        box, pushed = world.boxes.get(command.target), None
        if command.target == TORSO:
            body, link = model.robot, -1
        elif command.target in model.joints:
            body, link = model.robot, model.joints.index(command.target)
        elif box is not None and box.mass > 0.0:
            body, link, pushed = box.body, -1, box
        else:
            known = ", ".join((TORSO, *model.joints, *(n for n, b in world.boxes.items() if b.mass > 0.0)))
            raise FrameError(f"Nothing called `{command.target}` can be pushed; there are {known}.")
        steps = max(1, round(command.duration / self._dt))
        _, heading = self._heading()
        c, s = math.cos(heading), math.sin(heading)
        x, y, z = (part / (steps * self._dt) for part in command.impulse)
        self._actions.append(PushForce(world, body, link, (c * x - s * y, s * x + c * y, z), steps, pushed))
        size = math.sqrt(sum(part * part for part in command.impulse))
        return f"{command.target} is pushed with {size:.3g} N s over {steps * self._dt:.3g} s."

    def _place(self, command: PlaceBox) -> str:
        world, model = self._world, self._mechanics.model
        at, yaw = command.at, command.yaw
        if command.frame == "robot":
            position, heading = self._heading()
            x, y = self._below(position)[:2]
            c, s = math.cos(heading), math.sin(heading)
            at, yaw = (x + c * at[0] - s * at[1], y + s * at[0] + c * at[1]), yaw + heading
        before = world.box_as_it_is(command.name)
        box = world.add_box(
            command.name,
            command.size,
            at,
            yaw,
            height=command.height,
            mass=command.mass,
            friction=command.friction,
        )
        near = bullet.getClosestPoints(model.robot, box.body, 0.0, physicsClientId=world.client)
        if any(point[8] < _INSIDE for point in near):
            world.remove_box(command.name)
            if before is not None:
                world.put_back(command.name, before)
            raise FrameError(f"Box `{command.name}` would stand inside the robot; give it another place.")
        kind = f"of {command.mass:g} kg" if command.mass > 0.0 else "fixed to the floor"
        return f"Box `{command.name}`, {kind}, stands at ({at[0]:.3f}, {at[1]:.3f})."

    def _remove(self, command: Remove) -> str:
        if not self._world.remove_box(command.name):
            known = ", ".join(self._world.boxes) or "none"
            raise FrameError(f"No box `{command.name}` to remove; there are {known}.")
        return f"Box `{command.name}` is gone."

    def _lay(self, plate: PlateUnderFoot) -> bool:
        """Put a waiting plate under its foot if that is high enough; True when done."""
        world, model = self._world, self._mechanics.model
        for side in _SIDES[plate.foot]:
            state = bullet.getLinkState(
                model.robot, model.feet[side], computeForwardKinematics=True, physicsClientId=world.client
            )
            origin, matrix = state[4], bullet.getMatrixFromQuaternion(state[5])
            lowest = min(world.clearance(_point(origin, matrix, corner)) for corner in self._soles[side])
            if lowest < plate.size[2] + PLATE_GAP:
                continue
            x, y, _ = world.to_floor(_point(origin, matrix, self._middle[side]))[0]
            ahead = world.to_floor(_point(origin, matrix, (1.0, 0.0, 0.0)))[0]
            here = world.to_floor(origin)[0]
            yaw = math.atan2(ahead[1] - here[1], ahead[0] - here[0])
            c, s = math.cos(yaw), math.sin(yaw)
            dx, dy = plate.shift
            at = (x + c * dx - s * dy, y + s * dx + c * dy)
            world.add_box(plate.name, plate.size, at, yaw, height=0.0)
            self._say(
                "world",
                f"A plate of {1e3 * plate.size[2]:.0f} mm lies under the {_FOOT[side]} foot "
                f"at ({at[0]:.3f}, {at[1]:.3f}).",
            )
            return True
        return False

    def _below(self, position: Vec3) -> Vec3:
        """Floor point vertically below a point of the world, floor frame, m."""
        world = self._world
        drop = world.clearance(position) / world.normal[2]
        return world.to_floor((position[0], position[1], position[2] - drop))[0]

    def _tilt(self, command: TiltFloor) -> str:
        world = self._world
        turn = max(abs(command.roll - world.tilt[0]), abs(command.pitch - world.tilt[1]))
        least = least_tilt_time(turn)
        if command.duration < least:
            raise FrameError(
                f"The floor cannot turn by {turn:.3g} rad in {command.duration:.3g} s; "
                f"give it {least:.3g} s or more."
            )
        self._actions = [action for action in self._actions if not isinstance(action, FloorTilt)]
        pivot = world.to_world(self._below(self._heading()[0]))[0]
        steps = round(command.duration / self._dt)
        self._actions.append(FloorTilt(world, command.roll, command.pitch, pivot, steps))
        roll, pitch = math.degrees(command.roll), math.degrees(command.pitch)
        return f"The floor turns to roll {roll:.3g} and pitch {pitch:.3g} deg in {command.duration:.3g} s."

    def _pendulum(self, command: SwingPendulum) -> str:
        position, heading = self._heading()
        model, world = self._mechanics.model, self._world
        com = bullet.getBasePositionAndOrientation(model.robot, physicsClientId=world.client)[0]
        height = com[2] if command.height is None else position[2] - world.clearance(position) + command.height
        way = heading + command.direction
        ray = (math.cos(way), math.sin(way))
        # the torso's surface where the bob comes from
        hit = bullet.rayTest(
            (com[0] - ray[0], com[1] - ray[1], height), (com[0], com[1], height), physicsClientId=world.client
        )[0]
        if hit[0] != model.robot:
            raise FrameError(f"A pendulum would miss the robot {height:.3g} m over the floor's origin.")
        gap = BOB_RADIUS
        bob = (hit[3][0] - gap * ray[0], hit[3][1] - gap * ray[1], height)
        self._actions.append(Pendulum(world, bob, way, command.mass, command.length, command.angle))
        speed = math.sqrt(2.0 * world.parameters.gravity * command.length * (1.0 - math.cos(command.angle)))
        return f"A pendulum of {command.mass:g} kg falls towards the robot and strikes with {speed:.3g} m/s."


def _point(origin: Vec3, matrix: Rotation, point: Vec3) -> Vec3:
    turned = rotate(matrix, point)
    return origin[0] + turned[0], origin[1] + turned[1], origin[2] + turned[2]
