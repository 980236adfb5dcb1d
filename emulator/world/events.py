"""The events of a world: the timeline of a scenario, commands given live, plates under feet."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

from bridge.body import TORSO
from bridge.errors import FrameError
from bridge.messages.world import (
    PlaceObject,
    PlaceThing,
    PlateUnderFoot,
    Push,
    Remove,
    SetFriction,
    SwingPendulum,
    TiltFloor,
    min_tilt_duration,
)
from bridge.planar import Pose2D
from bridge.types import Side, Vec2, Vec3
from bridge.validation import suggestion
from emulator.engine.base import Multibody
from emulator.engine.shapes import FOOT_LINKS, sole_points
from emulator.engine.values import Box
from emulator.poses import Pose, point_of
from emulator.world.actions import BOB_RADIUS, Action, BoxPush, FloorTilt, LinkPush, PendulumStrike
from emulator.world.world import World, solid

PLATE_GAP: Final = 0.001
"""Air between a lifted sole and the plate that appears under it, m."""
_SIDES: Final[dict[str, tuple[Side, ...]]] = {"left": ("L",), "right": ("R",), "swing": ("L", "R")}
_FOOT: Final = {"L": "left", "R": "right"}
WorldEvent = Push | PlaceObject | PlaceThing | Remove | PlateUnderFoot | SwingPendulum | TiltFloor | SetFriction
"""Commands that an `EventExecutor` carries out."""


class WaitingPlates:
    """Plates to be put under a foot.

    Args:
        world: In which they are put.
        robot: Under whose feet.
        notify: Called with one sentence and a short code when a plate is put.
    """

    def __init__(self, world: World, robot: Multibody, notify: Callable[[str, str], None]) -> None:
        self._world, self._robot, self._notify = world, robot, notify
        body = robot.body
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
        """Put every plate whose foot is high enough now."""
        if self._waiting:
            self._waiting = [plate for plate in self._waiting if not self._put_plate(plate)]

    def _put_plate(self, plate: PlateUnderFoot) -> bool:
        """Put a waiting plate under its foot if that is high enough; True when done."""
        for side in _SIDES[plate.foot]:
            foot = self._robot.state(FOOT_LINKS[side]).pose
            lowest = min(self._world.clearance(point_of(foot, corner)) for corner in self._soles[side])
            if lowest >= plate.size[2] + PLATE_GAP:
                self._place(plate, side, foot)
                return True
        return False

    def _place(self, plate: PlateUnderFoot, side: Side, foot: Pose) -> None:
        world = self._world
        x, y, _ = world.to_floor(point_of(foot, self._middle[side]))
        ahead = world.to_floor(point_of(foot, (1.0, 0.0, 0.0)))
        here = world.to_floor(foot.position)
        yaw = math.atan2(ahead[1] - here[1], ahead[0] - here[0])
        at = Pose2D(x, y, yaw).point(*plate.shift)
        try:
            world.add_object(plate.name, Box(plate.size), at, yaw + plate.yaw, height=0.0, beside_robot=True)
        except FrameError as error:  # it reaches into the other foot
            self._notify("world-refused", str(error))
            return
        self._notify(
            "world",
            f"A plate of {1e3 * plate.size[2]:.0f} mm lies under the {_FOOT[side]} foot "
            f"at ({at[0]:.3f}, {at[1]:.3f}).",
        )


class EventExecutor:
    """Carries out the events in the world of one robot.

    Args:
        world: The world.
        robot: The robot in its engine.
        timeline: Robot time in s and command of each event.
        notify: Called with one sentence and a short code for each event.
    """

    def __init__(
        self,
        world: World,
        robot: Multibody,
        timeline: Sequence[tuple[float, WorldEvent]],
        notify: Callable[[str, str], None],
    ) -> None:
        self._world, self._robot, self._notify = world, robot, notify
        self._engine = world.engine
        self._timeline = sorted(timeline, key=lambda event: event[0], reverse=True)
        self._actions: list[Action] = []
        self._plates = WaitingPlates(world, robot, notify)
        self._dt = world.engine.settings.step

    def begin_cycle(self, time: float) -> Callable[[], None] | None:
        """Carry out the events of the cycle that begins now.

        Args:
            time: Robot time at its beginning, s.

        Returns:
            To be called before each physics step of the cycle; None without a running action.
        """
        while self._timeline and self._timeline[-1][0] <= time + 1e-9:
            self._execute_event(self._timeline.pop()[1])
        self._plates.begin_cycle()
        return self._before_step if self._actions else None

    def _execute_event(self, command: WorldEvent) -> None:
        """Carry out an event of the timeline; one that is no longer possible is reported, not raised."""
        try:
            self.execute(command)
        except FrameError as error:
            self._notify("world-refused", str(error))

    def _before_step(self) -> None:
        self._actions = [action for action in self._actions if action.step()]

    def execute(self, command: WorldEvent) -> str:
        """Carry out a command at a cycle boundary.

        Returns:
            The act, in one sentence, which is also a notice.

        Raises:
            FrameError: the command means something that is not there, or cannot be.
        """
        if isinstance(command, Push):
            text = self._push(command)
        elif isinstance(command, PlaceObject):
            text = self._place(command)
        elif isinstance(command, PlaceThing):
            text = self._place_thing(command)
        elif isinstance(command, Remove):
            text = self._remove(command)
        elif isinstance(command, PlateUnderFoot):
            self._plates.add(command)
            text = f"A plate waits for the {command.foot} foot to be lifted."
        elif isinstance(command, SwingPendulum):
            text = self._pendulum(command)
        elif isinstance(command, TiltFloor):
            text = self._tilt(command)
        else:
            self._world.set_surface(replace(self._world.surface, friction=command.friction))
            text = f"The floor's friction is {command.friction:g}."
        self._notify("world", text)
        return text

    def _heading(self) -> tuple[Vec3, float]:
        """Torso's origin, and its heading in the world, rad."""
        torso = self._robot.state()
        return torso.position, torso.heading

    def _push(self, command: Push) -> str:
        target = command.target
        steps = max(1, round(command.duration / self._dt))
        _, heading = self._heading()
        x, y, z = (part / (steps * self._dt) for part in command.impulse)
        force = (*Pose2D(yaw=heading).point(x, y), z)
        robot = self._robot
        movable = [name for name, (shape, _) in self._world.objects.items() if shape.mass > 0.0]
        if target in (TORSO, *robot.joints):
            self._actions.append(LinkPush(robot, target, force, steps))
        elif target in movable:
            self._actions.append(BoxPush(self._world, target, force, steps))
        else:
            near = suggestion(target, (TORSO, *robot.joints, *movable))
            objects = f"movable objects ({', '.join(movable) or 'none is there'})"
            raise FrameError(
                f"Nothing called `{target}` can be pushed{near}; the Torso, links of joints and {objects} can."
            )
        size = math.sqrt(sum(part * part for part in command.impulse))
        return f"{target} is pushed with {size:.3g} N s over {steps * self._dt:.3g} s."

    def _place(self, command: PlaceObject) -> str:
        world, name = self._world, command.name
        if name in world.things:
            raise FrameError(f"`{name}` is a {world.things[name].kind}; give the {command.shape} another name.")
        at, yaw = self._on_floor(command.at, command.yaw, command.frame)
        shape = solid(command.shape, command.size, command.mass, command.friction)
        world.add_object(name, shape, at, yaw, height=command.height, beside_robot=True)
        kind = f"of {command.mass:g} kg" if command.mass > 0.0 else "fixed to the floor"
        return f"The {command.shape} `{name}`, {kind}, stands at ({at[0]:.3f}, {at[1]:.3f})."

    def _on_floor(self, at: Vec2, yaw: float, frame: str) -> tuple[Vec2, float]:
        """A place (m) and a heading (rad) of the floor frame or of the robot's, in the floor frame."""
        if frame == "floor":
            return at, yaw
        position, heading = self._heading()
        x, y = self._below(position)[:2]
        return Pose2D(x, y, heading).point(*at), yaw + heading

    def _place_thing(self, command: PlaceThing) -> str:
        world, name, kind = self._world, command.name, command.kind
        if name in world.objects:
            raise FrameError(f"`{name}` is there to touch; give the {kind} another name.")
        if kind == "landmark" and not name.isdecimal():
            raise FrameError(f"A landmark's name is its number, not `{name}`.")
        at, yaw = self._on_floor(command.at, command.yaw or 0.0, command.frame)
        if command.yaw is None:
            x, y = self._below(self._heading()[0])[:2]
            yaw = math.atan2(y - at[1], x - at[0])
        world.place_thing(name, kind, at, yaw, command.height, command.size)
        return f"The {kind} `{name}` is at ({at[0]:.3f}, {at[1]:.3f}, {world.things[name].position[2]:.3f})."

    def _remove(self, command: Remove) -> str:
        world, name = self._world, command.name
        if world.things.pop(name, None) is None and not world.remove_object(name):
            known = ", ".join([*world.objects, *world.things]) or "none"
            raise FrameError(f"Nothing called `{name}` to remove; there are {known}.")
        return f"`{name}` is gone."

    def _below(self, position: Vec3) -> Vec3:
        """Floor point vertically below a point of the world, floor frame, m."""
        world = self._world
        drop = world.clearance(position) / world.normal[2]
        return world.to_floor((position[0], position[1], position[2] - drop))

    def _tilt(self, command: TiltFloor) -> str:
        world = self._world
        turn = max(abs(command.roll - world.tilt[0]), abs(command.pitch - world.tilt[1]))
        shortest = min_tilt_duration(turn)
        if command.duration < shortest:
            raise FrameError(
                f"The floor cannot turn by {turn:.3g} rad in {command.duration:.3g} s; "
                f"give it {shortest:.3g} s or more."
            )
        self._actions = [action for action in self._actions if not isinstance(action, FloorTilt)]
        pivot = world.to_world(self._below(self._heading()[0]))
        steps = round(command.duration / self._dt)
        self._actions.append(FloorTilt(world, command.roll, command.pitch, pivot, steps))
        roll, pitch = math.degrees(command.roll), math.degrees(command.pitch)
        return f"The floor turns to roll {roll:.3g} and pitch {pitch:.3g} deg in {command.duration:.3g} s."

    def _pendulum(self, command: SwingPendulum) -> str:
        position, heading = self._heading()
        com = self._robot.link_com(TORSO)
        height = com[2]
        if command.height is not None:
            height = position[2] - self._world.clearance(position) + command.height
        way = heading + command.direction
        x, y = math.cos(way), math.sin(way)
        # the torso's surface on the bob's side
        (hit,) = self._engine.rays([(com[0] - x, com[1] - y, height)], [(com[0], com[1], height)])
        if hit.robot is not self._robot:
            raise FrameError(f"A pendulum would miss the robot {height:.3g} m over the floor's origin.")
        bob = (hit.point[0] - BOB_RADIUS * x, hit.point[1] - BOB_RADIUS * y, height)
        self._actions.append(
            PendulumStrike(self._engine, bob, way, command.mass, command.length, command.angle)
        )
        gravity = self._engine.settings.gravity
        speed = math.sqrt(2.0 * gravity * command.length * (1.0 - math.cos(command.angle)))
        return f"A pendulum of {command.mass:g} kg falls towards the robot and strikes with {speed:.3g} m/s."
