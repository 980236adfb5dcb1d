"""A floor that can be tilted, the boxes on it, and the robots that live there.

The floor is turned, not gravity: the world's z axis stays the vertical, so that accelerometer, fused angle and
ground truth mean the same on every slope. All that is fixed on the floor turns with it.

Surfaces that a scenario can give its floor.

No figure of a NAO's soles on a floor is published. The stiffness of the hard floor is calibrated with the
drives on the torso step (2.5e7 to 6e7 N/m^3 agree); all else is assumed: the friction as usual for hard rubber
on dry wood and on short pile, a carpet that sinks by half a millimetre under one sole (47 N on 0.0133 m^2),
artificial turf, 8 mm high and filled, that sinks by a whole one, and a relaxation that lets a landing foot
hardly rebound.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple, Protocol

from bridge.body import Body
from bridge.errors import ConfigurationError, FrameError
from bridge.messages import ActuatorFrame, SensorFrame
from bridge.messages.world import THING_HEIGHT, THING_SIZES, ThingKind
from bridge.messages.world_state import Terrain, WorldThing
from bridge.rotations import planar_point
from bridge.types import Vec2, Vec3
from emulator.engine.base import Engine, Multibody, Thing
from emulator.engine.values import BodyState, Box, Surface
from emulator.poses import ORIGIN, Pose, compose, inverse, matrix, point_of, quaternion, yaw_of
from emulator.vectors import cross, rotate, scaled

WOOD: Final = Surface(friction=0.8, stiffness_per_area=6.0e7, relaxation=0.005)
"""The emulator's own: a hard floor."""
SURFACES: Final = {
    "wood": WOOD,
    "carpet": Surface(friction=0.9, stiffness_per_area=0.7e7, relaxation=0.010),
    "turf": Surface(friction=0.7, stiffness_per_area=0.3e7, relaxation=0.015),
}
"""By the name that a scenario uses."""
_RAY_HEIGHT: Final = 5.0
"""Rays start that far above and end that far below the floor's origin, m."""
_OVERLAP: Final = 1e-4
"""Depth from which a box counts as standing inside a robot, m."""


class WorldBox(NamedTuple):
    """A box in the world."""

    box: Box
    thing: Thing
    """The box in the engine."""


@dataclass(frozen=True)
class VisibleThing:
    """A thing that can be seen, not touched."""

    kind: ThingKind
    size: float
    """Diameter, m."""
    position: Vec3
    """Of its middle, floor frame, m."""
    yaw: float
    """Heading of its front, floor frame, rad."""


class Inhabitant(Protocol):
    """A robot of a world; the methods in the order in which the world calls them."""

    name: str
    body: Body
    multibody: Multibody
    settle: int
    """Cycles in which it settles into its start pose."""

    def begin_run(self) -> None:
        """The robot has settled: its time begins."""

    def begin_cycle(self, command: ActuatorFrame | None) -> None:
        """A cycle begins: latch the command."""

    def begin_physics(self) -> Callable[[], None] | None:
        """The physics of a cycle begins; what is returned is called before each physics step."""

    def runs_ahead(self) -> bool:
        """The command of the cycle that begins now cannot act within it."""

    def measure(self) -> None:
        """The physics of the cycle has run."""

    def end_cycle(self) -> SensorFrame:
        """The cycle has ended; the newest frame."""


class World:
    """Physics, clock, floor and objects, and the robots that live with them.

    The floor frame begins as the world's and turns with the floor. Robots are added, and settle all together
    before the time begins. They share one cycle.

    Args:
        engine: With an empty world.
        surface: Of the floor.
        roll: Of the floor, rad: orientation Ry(pitch) Rx(roll), turned about the origin.
        pitch: Of the floor, rad.
    """

    def __init__(self, engine: Engine, surface: Surface = WOOD, roll: float = 0.0, pitch: float = 0.0) -> None:
        self.engine = engine
        self.boxes: dict[str, WorldBox] = {}
        """By name."""
        self.robots: list[Inhabitant] = []
        """In the order in which they were added."""
        self.again: Callable[[], World] | None = None
        """Makes the same world as it was at its beginning, without robots."""
        self.ahead = False
        """The physics of the present cycle has run already."""
        self.things: dict[str, VisibleThing] = {}
        """By name."""
        self.terrain = Terrain()
        """Tiles and heightfield."""
        self.tilt: Vec2 = (0.0, 0.0)
        """Roll and pitch, rad."""
        self.normal: Vec3 = (0.0, 0.0, 1.0)
        """Of the floor, world frame."""
        self.pose = self._world_pose = ORIGIN
        """Floor frame in the world."""
        self.set_surface(surface)
        if roll or pitch:
            self.set_tilt(roll, pitch, ORIGIN.position)

    def add(self, robot: Inhabitant) -> None:
        """Let a robot live here.

        Raises:
            ConfigurationError: its cycle is not the others', or its name is taken.
        """
        for other in self.robots:
            if other.body.cycle != robot.body.cycle:
                raise ConfigurationError(
                    f"{robot.body.name} has a cycle of {1e3 * robot.body.cycle:g} ms and {other.body.name} one "
                    f"of {1e3 * other.body.cycle:g} ms; robots of one cycle share a world."
                )
            if other.name == robot.name:
                raise ConfigurationError(f"Two robots are called `{robot.name}`; give each a name of its own.")
        self.robots.append(robot)

    def require_room(self, robot: Inhabitant) -> None:
        """Raises ConfigurationError where a box or another robot overlaps a robot at its start."""
        things = {f"Box `{name}` of the scenario": placed.thing for name, placed in self.boxes.items()}
        things |= {f"Robot `{other.name}`": other.multibody for other in self.robots if other is not robot}
        for name, thing in things.items():
            if self.engine.overlap(robot.multibody, thing) > _OVERLAP:
                raise ConfigurationError(
                    f"{name} stands inside {robot.body.name} at its start; give one of them another place."
                )

    def start(self) -> None:
        """Let the robots settle into their start poses; then the time begins."""
        for _ in range(max(robot.settle for robot in self.robots)):
            self.run_physics()
            for robot in self.robots:
                robot.measure()
        for robot in self.robots:
            robot.begin_run()

    def run_physics(self) -> None:
        """Run the physics of a cycle."""
        acts = [act for robot in self.robots if (act := robot.begin_physics()) is not None]

        def before_step() -> None:
            for act in acts:
                act()

        steps = self.engine.settings.steps(self.robots[0].body)
        self.engine.run(steps, before_step if acts else None)

    def advance(self, commands: Mapping[str, ActuatorFrame]) -> None:
        """Run one cycle of all robots.

        Args:
            commands: By the robot's name; without one, the last one stays in force.
        """
        for robot in self.robots:
            robot.begin_cycle(commands.get(robot.name))
        self.end_cycle()

    def end_cycle(self) -> None:
        """Run the rest of a cycle whose commands the robots have latched."""
        if not self.ahead:
            self.run_physics()
        for robot in self.robots:
            robot.end_cycle()
        self.ahead = False

    def run_ahead(self) -> None:
        """Run the physics of the cycle that begins now, before its commands are there.

        Only if all drives delay requests by a cycle or more, so that no command can act within it; otherwise
        nothing happens. The frames are the same as without.
        """
        if not self.ahead and all([robot.runs_ahead() for robot in self.robots]):
            self.run_physics()
            for robot in self.robots:
                robot.measure()
            self.ahead = True

    @property
    def uneven(self) -> bool:
        """Whether any box is fixed on the floor."""
        return self.terrain != Terrain() or any(box.mass <= 0.0 for box, _ in self.boxes.values())

    def set_surface(self, surface: Surface) -> None:
        """Change the surface of the floor and of everything fixed on it; boxes keep a friction of their own."""
        self.surface = surface
        self.engine.surround(self.engine.surroundings._replace(surface=surface))

    def set_tilt(self, roll: float, pitch: float, pivot: Vec3, rate: Vec2 = (0.0, 0.0)) -> None:
        """Turn the floor and all that is fixed on it.

        Args:
            roll: New one, rad.
            pitch: New one, rad.
            pivot: Point of the floor that stays where it is, world frame, m.
            rate: Of roll and pitch, with which the floor turns on, rad/s.
        """
        turn = quaternion(roll, pitch)
        arm = point_of(Pose(orientation=turn), self.to_floor(pivot))
        origin = (pivot[0] - arm[0], pivot[1] - arm[1], pivot[2] - arm[2])
        self.tilt, self.pose = (roll, pitch), Pose(origin, turn)
        self._world_pose = inverse(self.pose)
        rotation = matrix(turn)
        self.normal = (rotation[2], rotation[5], rotation[8])
        # of Ry(pitch) Rx(roll): the roll's axis turns with the pitch
        c, s = math.cos(pitch), math.sin(pitch)
        spin = (c * rate[0], rate[1], -s * rate[0])
        velocity = cross(spin, scaled(arm, -1.0))
        self.engine.surround(self.engine.surroundings._replace(floor=self.pose, velocity=velocity, spin=spin))

    def to_world(self, position: Vec3) -> Vec3:
        """A point of the floor frame in the world."""
        return point_of(self.pose, position)

    def to_floor(self, position: Vec3) -> Vec3:
        """A point of the world in the floor frame."""
        return point_of(self._world_pose, position)

    def in_floor(self, pose: Pose) -> Pose:
        """A pose of the world in the floor frame."""
        return compose(self._world_pose, pose)

    def clearance(self, point: Vec3) -> float:
        """Height of a point of the world over the bare floor, along the floor's normal, m."""
        return self.to_floor(point)[2]

    def ground(self, points: Sequence[Vec2]) -> list[float]:
        """Height of the ground, fixed things included, over the bare floor at points of the floor frame, m."""
        if not self.uneven:
            return [0.0] * len(points)
        starts = [self.to_world((x, y, _RAY_HEIGHT)) for x, y in points]
        ends = [self.to_world((x, y, -_RAY_HEIGHT)) for x, y in points]
        hits = self.engine.rays(starts, ends, ground_only=True)
        return [_RAY_HEIGHT - 2.0 * _RAY_HEIGHT * hit.fraction for hit in hits]

    def add_box(
        self,
        name: str,
        size: Vec3,
        at: Vec2,
        yaw: float = 0.0,
        *,
        height: float | None = None,
        mass: float = 0.0,
        friction: float | None = None,
        beside_robot: bool = False,
    ) -> None:
        """Put a box, or replace the one of its name.

        Args:
            name: Of the box.
            size: m.
            at: Middle of its bottom, floor frame, m.
            yaw: About the floor's normal, rad.
            height: Of its bottom over the floor, m; None: on the ground under its middle and corners.
            mass: kg; 0: fixed on the floor.
            friction: Against the soles; None: as the floor.
            beside_robot: Refuse a place in which the robot is.

        Raises:
            FrameError: the box would overlap the robot; the world stays as it was.
        """
        before = self._box_state(name)
        self.remove_box(name)
        if height is None:
            height = max(self.ground(_footprint(size, at, yaw)))
        pose = Pose((at[0], at[1], height + size[2] / 2.0), quaternion(yaw=yaw))
        box = Box(size, mass, friction)
        self.boxes[name] = WorldBox(box, self.engine.add(box, pose))
        if beside_robot and self.in_robot(name):
            self.remove_box(name)
            if before is not None:
                self._put_back(name, *before)
            raise FrameError(f"Box `{name}` would stand inside the robot; give it another place.")

    def in_robot(self, name: str) -> bool:
        """Whether a box overlaps a robot."""
        thing = self.boxes[name].thing
        return any(self.engine.overlap(robot, thing) > _OVERLAP for robot in self.engine.robots)

    def clear_robots(self) -> tuple[str, ...]:
        """Remove the movable boxes that overlap a robot after it is placed; their names."""
        within = tuple(name for name, (box, _) in self.boxes.items() if box.mass > 0.0 and self.in_robot(name))
        for name in within:
            self.remove_box(name)
        return within

    def _box_state(self, name: str) -> tuple[Box, BodyState] | None:
        """Box and state that `_put_back` takes; None when there is no such box."""
        found = self.boxes.get(name)
        return None if found is None else (found.box, found.thing.state())

    def _put_back(self, name: str, box: Box, state: BodyState) -> None:
        """Restore a box that was replaced."""
        (x, y, z), turn = self.in_floor(state.pose)
        height = z - 0.5 * box.size[2]
        self.add_box(name, box.size, (x, y), yaw_of(turn), height=height, mass=box.mass, friction=box.friction)
        if box.mass > 0.0:
            self.boxes[name].thing.place(state.pose, state.velocity, state.angular_velocity)

    def place_thing(
        self, name: str, kind: ThingKind, at: Vec2, yaw: float, height: float | None, size: float | None
    ) -> None:
        """Put a thing to be seen, or replace that of its name; the fields of `PlaceThing`, floor frame."""
        wide = THING_SIZES[kind] if size is None else size
        if height is None:
            height = 0.5 * wide if kind == "ball" else THING_HEIGHT
        self.things[name] = VisibleThing(kind, wide, (*at, height), yaw)

    def visible_things(self) -> tuple[WorldThing, ...]:
        """All things to be seen, in the world frame."""
        turn = matrix(self.pose.orientation)
        return tuple(
            WorldThing(
                name=name,
                kind=thing.kind,
                size=thing.size,
                position=self.to_world(thing.position),
                facing=rotate(turn, (math.cos(thing.yaw), math.sin(thing.yaw), 0.0)),
            )
            for name, thing in self.things.items()
        )

    def remove_box(self, name: str) -> bool:
        """Take a box away; False when there is none."""
        found = self.boxes.pop(name, None)
        if found is not None:
            self.engine.remove(found.thing)
        return found is not None


def _footprint(size: Vec3, at: Vec2, yaw: float) -> list[Vec2]:
    """Middle and corners of a box's bottom; the corners a little inside, so that neighbours do not count."""
    inside = (-0.499, 0.499)
    corners = [planar_point((*at, yaw), (sx * size[0], sy * size[1])) for sx in inside for sy in inside]
    return [at, *corners]
