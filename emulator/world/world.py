"""A floor that can be tilted, the objects on it, and the robots that live there.

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
from typing import Final, NamedTuple, Protocol, get_args

from bridge.body import Body
from bridge.errors import ConfigurationError, FrameError
from bridge.messages import ActuatorFrame, SensorFrame
from bridge.messages.game import GameReport
from bridge.messages.world import (
    LEAGUE_BALL_DIAMETER,
    LEAGUE_BALL_MASS,
    THING_HEIGHT,
    THING_SIZES,
    SolidShape,
    ThingKind,
    solid_fault,
)
from bridge.messages.world_state import Terrain, WorldObject, WorldThing
from bridge.planar import Pose2D
from bridge.types import Vec2, Vec3
from bridge.validation import unknown_name
from emulator.engine.base import Engine, Multibody, Thing
from emulator.engine.values import Ball, BodyState, Box, Pole, Solid, Surface
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
"""Depth from which an object counts as standing inside a robot, m."""


LEAGUE_BALL: Final = Ball(radius=0.5 * LEAGUE_BALL_DIAMETER, mass=LEAGUE_BALL_MASS, rolling=0.30)
"""The ball of the Standard Platform League. It loses 0.30 m/s^2 on the league's turf by the configuration of
the team NomadZ (2024); B-Human once had 0.13 on carpet. Both take the deceleration to be constant."""


def solid(shape: SolidShape, size: Vec3, mass: float, friction: float | None) -> Solid:
    """An object by the edges of the box around it.

    Args:
        shape: Of the object.
        size: Edges, m.
        mass: kg; 0: fixed on the floor.
        friction: Against the soles; None: as the floor.

    Raises:
        FrameError: no ball or pole fits the box, or a ball without mass.
    """
    if shape not in (known := get_args(SolidShape)):
        raise FrameError(unknown_name("shape", shape, known))
    if fault := solid_fault(shape, size, mass):
        raise FrameError(fault)
    if shape == "box":
        return Box(size, mass, friction)
    if shape == "pole":
        return Pole(size[0] / 2.0, size[2], mass, friction)
    return Ball(size[0] / 2.0, mass, LEAGUE_BALL.rolling, friction)


def edges(shape: Solid) -> Vec3:
    """Edges of the box around an object, m."""
    if isinstance(shape, Box):
        return shape.size
    wide = 2.0 * shape.radius
    return wide, wide, wide if isinstance(shape, Ball) else shape.height


_NAMES: Final[dict[type, SolidShape]] = {Box: "box", Ball: "ball", Pole: "pole"}


class WorldBody(NamedTuple):
    """An object in the world."""

    shape: Solid
    thing: Thing
    """The object in the engine."""


@dataclass(frozen=True)
class VisibleThing:
    """A thing that can be seen, not touched."""

    kind: ThingKind
    size: float
    """Diameter, m."""
    position: Vec3
    """Position of its middle, floor frame, m."""
    yaw: float
    """Heading of its front, floor frame, rad."""


class Inhabitant(Protocol):
    """A robot of a world; the methods in the order in which the world calls them."""

    name: str
    body: Body
    multibody: Multibody
    player: tuple[int, int] | None
    """Number of its team, and its own there, in the league's games."""
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

    def report_game(self, report: GameReport) -> None:
        """The GameController reports the league's game."""


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
        self.objects: dict[str, WorldBody] = {}
        self._fixed_from_start: set[str] = set()
        """Names of the objects that stay where the scenario has them."""
        """By name."""
        self.robots: list[Inhabitant] = []
        """In the order in which they were added."""
        self.again: Callable[[], World] | None = None
        """Makes the same world as it was at its beginning, without robots."""
        self.referee: Callable[[float], GameReport | None] | None = None
        """Reports the league's game at a time of the world, s; None of it: nothing new is due."""
        self._cycles = 0
        self.ahead = False
        """The physics of the present cycle has run already."""
        self.things: dict[str, VisibleThing] = {}
        """By name."""
        self.terrain = Terrain()
        """Tiles, heightfield and field."""
        self.tilt: Vec2 = (0.0, 0.0)
        """Roll and pitch, rad."""
        self.normal: Vec3 = (0.0, 0.0, 1.0)
        """Normal of the floor, world frame."""
        self.pose = self._world_pose = ORIGIN
        """Floor frame in the world."""
        self.set_surface(surface)
        if roll or pitch:
            self.set_tilt(roll, pitch, ORIGIN.position)

    def add(self, robot: Inhabitant) -> None:
        """Let a robot live here.

        Raises:
            ConfigurationError: its cycle is not the others', or its name or number is taken.
        """
        for other in self.robots:
            if other.body.cycle != robot.body.cycle:
                raise ConfigurationError(
                    f"{robot.body.name} has a cycle of {1e3 * robot.body.cycle:g} ms and {other.body.name} one "
                    f"of {1e3 * other.body.cycle:g} ms; robots of one cycle share a world."
                )
            if other.name == robot.name:
                raise ConfigurationError(f"Two robots are called `{robot.name}`; give each a name of its own.")
            if robot.player is not None and other.player == robot.player:
                team, number = robot.player
                raise ConfigurationError(f"Two robots are player {number} of team {team}; give each a number.")
        self.robots.append(robot)

    def require_room(self, robot: Inhabitant, *, movable: bool = True) -> None:
        """Refuse the start of a robot where something is.

        Args:
            robot: At its start.
            movable: Movable objects count too.

        Raises:
            ConfigurationError: an object or another robot overlaps it.
        """
        things = {
            f"Object `{name}` of the scenario": thing
            for name, (shape, thing) in self.objects.items()
            if movable or shape.mass <= 0.0
        }
        things |= {f"Robot `{other.name}`": other.multibody for other in self.robots if other is not robot}
        for name, thing in things.items():
            if self.engine.overlap(robot.multibody, thing) > _OVERLAP:
                raise ConfigurationError(
                    f"{name} stands inside robot `{robot.name}` at its start; give one of them another place."
                )

    def start(self) -> None:
        """Let the robots settle into their start poses; then the time begins."""
        self._fixed_from_start = {name for name, (shape, _) in self.objects.items() if shape.mass <= 0.0}
        for _ in range(max(robot.settle for robot in self.robots)):
            self.run_physics()
            for robot in self.robots:
                robot.measure()
        for robot in self.robots:
            robot.begin_run()
        self._ask_referee()

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
        self._cycles += 1
        self._ask_referee()

    def _ask_referee(self) -> None:
        if self.referee is not None:
            report = self.referee(self._cycles * self.robots[0].body.cycle)
            if report is not None:
                self._report(report)

    def _report(self, report: GameReport) -> None:
        for robot in self.robots:
            robot.report_game(report)

    def report_game(self, report: GameReport) -> None:
        """Report the league's game to all robots.

        Raises:
            FrameError: the world has a referee, whose report holds.
        """
        if self.referee is not None:
            raise FrameError(
                "This world has a referee of its own; start it without --game for a GameController."
            )
        self._report(report)

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
        raised = bool(self.terrain.tiles) or self.terrain.grid is not None
        return raised or any(shape.mass <= 0.0 for shape, _ in self.objects.values())

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

    def add_object(
        self,
        name: str,
        shape: Solid,
        at: Vec2,
        yaw: float = 0.0,
        *,
        height: float | None = None,
        beside_robot: bool = False,
    ) -> None:
        """Put an object, or replace the one of its name.

        Args:
            name: Of the object.
            shape: Its shape and mass.
            at: Middle of its bottom, floor frame, m.
            yaw: About the floor's normal, rad.
            height: Of its bottom over the floor, m; None: on the ground under its middle and corners.
            beside_robot: Refuse a place in which a robot is.

        Raises:
            FrameError: the object would overlap a robot; the world stays as it was.
        """
        before, size = self._state(name), edges(shape)
        self.remove_object(name)
        if height is None:
            height = max(self.ground(_footprint(size, at, yaw)))
        pose = Pose((at[0], at[1], height + size[2] / 2.0), quaternion(yaw=yaw))
        self.objects[name] = WorldBody(shape, self.engine.add(shape, pose))
        self._fixed_from_start.discard(name)
        if beside_robot and (robot := self.robot_at(name)):
            self.remove_object(name)
            if before is not None:
                self._put_back(name, *before)
            raise FrameError(f"`{name}` would stand inside robot `{robot}`; give it another place.")

    def robot_at(self, name: str) -> str:
        """Name of a robot that an object overlaps; empty: none."""
        thing = self.objects[name].thing
        overlapping = (r.name for r in self.robots if self.engine.overlap(r.multibody, thing) > _OVERLAP)
        return next(overlapping, "")

    def clear_robots(self) -> tuple[str, ...]:
        """Remove the movable objects that overlap a robot after it is placed; their names."""
        within = tuple(
            name for name, (shape, _) in self.objects.items() if shape.mass > 0.0 and self.robot_at(name)
        )
        for name in within:
            self.remove_object(name)
        return within

    def _state(self, name: str) -> tuple[Solid, BodyState] | None:
        """Shape and state that `_put_back` takes; None when there is no such object."""
        thing = self.objects.get(name)
        return None if thing is None else (thing.shape, thing.thing.state())

    def _put_back(self, name: str, shape: Solid, state: BodyState) -> None:
        """Restore an object that was replaced."""
        (x, y, z), turn = self.in_floor(state.pose)
        self.add_object(name, shape, (x, y), yaw_of(turn), height=z - 0.5 * edges(shape)[2])
        if shape.mass > 0.0:
            self.objects[name].thing.place(state.pose, state.velocity, state.angular_velocity)

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

    def object_states(self, *, recorded: bool = False) -> tuple[WorldObject, ...]:
        """All objects, or those of the ground truth: movable ones, and fixed ones that came after the start."""
        return tuple(
            WorldObject(
                name=name,
                shape=_NAMES[type(shape)],
                size=edges(shape),
                position=(state := thing.state()).position,
                orientation=state.orientation,
                mass=shape.mass,
            )
            for name, (shape, thing) in self.objects.items()
            if not recorded or name not in self._fixed_from_start
        )

    def remove_object(self, name: str) -> bool:
        """Take an object away; False when there is none."""
        thing = self.objects.pop(name, None)
        if thing is not None:
            self.engine.remove(thing.thing)
        return thing is not None


def _footprint(size: Vec3, at: Vec2, yaw: float) -> list[Vec2]:
    """Middle and corners of a box's bottom; the corners a little inside, so that neighbours do not count."""
    inside = (-0.499, 0.499)
    corners = [Pose2D(*at, yaw).point(sx * size[0], sy * size[1]) for sx in inside for sy in inside]
    return [at, *corners]
