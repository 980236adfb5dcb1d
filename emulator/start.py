"""The beginning of a run: a scenario becomes a world with its events, and the robot is put into it.

Degrees of a scenario become radians here. The robot begins on its feet, sitting, lying or hanging.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import Final, NamedTuple, TypeVar

import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX_WITH_MIRROR, JOINTS, N_JOINTS
from bridge.body.postures import POSTURES
from bridge.body.quantities import absent_joints, limits
from bridge.errors import ConfigurationError
from bridge.messages.world import PlateUnderFoot, Push, SetFriction, SwingPendulum, TiltFloor
from bridge.messages.world_state import Terrain
from bridge.types import Quaternion
from bridge.validation import unknown_name
from emulator.engine.base import Multibody
from emulator.engine.catalogue import open_engine
from emulator.engine.settings import PhysicsSettings
from emulator.engine.shapes import FOOT_LINKS, link_shapes, lowest_point, sole_points
from emulator.engine.values import Box, HeightField
from emulator.poses import ORIGIN, Pose, compose, inverse, point_of, quaternion, yaw_of
from emulator.scenarios import START_NAMES
from emulator.scenarios.events import ScenarioEvent
from emulator.scenarios.model import Scenario, terrain_of
from emulator.world.events import WorldEvent
from emulator.world.world import SURFACES, World, solid

E = TypeVar("E", bound=ScenarioEvent)
_FOUNDATION_DEPTH = 0.02
"""Depth of a tile below the floor, m: no tile is so thin that a foot could slip through between two steps."""


def add_terrain(world: World, terrain: Terrain) -> None:
    """Fix tiles and heightfield on the floor of a world, and paint it."""
    engine = world.engine
    if terrain.grid is not None:
        grid = terrain.grid
        heights = np.array(grid.heights, dtype=np.float64)
        engine.add(HeightField(heights, grid.spacing), Pose((*grid.centre, 0.0)))
    for tile in terrain.tiles:
        size = (tile.edge, tile.edge, tile.height + _FOUNDATION_DEPTH)
        pose = Pose((*tile.at, size[2] / 2.0 - _FOUNDATION_DEPTH))
        engine.add(Box(size), pose)
    world.terrain = terrain


def build_world(engine: str, settings: PhysicsSettings, scenario: Scenario, seed: int) -> World:
    """The world of a scenario as it is before anything happens.

    Args:
        engine: Name of the physics engine, or `auto`.
        settings: Of the physics.
        scenario: The world to build.
        seed: For tiles and heightfields without a seed of their own: the first child of its generator.

    Raises:
        ConfigurationError: no such engine.
    """
    floor = scenario.floor
    surface = SURFACES[floor.surface]
    if floor.friction is not None:
        surface = replace(surface, friction=floor.friction)
    if floor.stiffness is not None:
        surface = replace(surface, stiffness_per_area=floor.stiffness)
    opened = open_engine(engine, settings)
    world = World(opened, surface, math.radians(floor.roll), math.radians(floor.pitch))
    world.again = partial(build_world, engine, settings, scenario, seed)
    add_terrain(world, terrain_of(scenario, np.random.default_rng(seed).spawn(2)[0]))
    for box in scenario.objects():
        shape = solid(box.shape, box.size, box.mass, box.friction)
        world.add_object(box.name, shape, box.at, math.radians(box.yaw), height=box.height)
    for thing in scenario.things:
        yaw = math.radians(thing.yaw)
        world.place_thing(thing.name, thing.kind, thing.at, yaw, thing.height, thing.size)
    return world


def require_robots(scenario: Scenario, names: Iterable[str]) -> None:
    """Refuse events of robots that are not in the world.

    Args:
        scenario: With the events.
        names: Of the robots.

    Raises:
        ConfigurationError: an event names another one.
    """
    for event in scenario.events:
        if event.robot and event.robot not in names:
            raise ConfigurationError(f"Scenario: {unknown_name('robot', event.robot, names)}.")


def timeline(scenario: Scenario, names: Collection[str]) -> list[tuple[float, WorldEvent]]:
    """Time (s) and event, as the commands that would do it live; events of one time in the order here.

    Args:
        scenario: With the events.
        names: Only the events whose `robot` is one of these.
    """

    def own(happening: Iterable[E]) -> list[E]:
        return [event for event in happening if event.robot in names]

    events: list[tuple[float, WorldEvent]] = []
    for change in own(scenario.frictions):
        events.append((change.time, SetFriction(friction=change.friction)))
    for tilt in own(scenario.tilts):
        command = TiltFloor(
            roll=math.radians(tilt.roll), pitch=math.radians(tilt.pitch), duration=tilt.duration
        )
        events.append((tilt.time, command))
    for plate in own(scenario.plates):
        events.append(
            (
                plate.time,
                PlateUnderFoot(
                    foot=plate.foot,
                    size=plate.size,
                    shift=plate.shift,
                    yaw=math.radians(plate.yaw),
                    name=plate.name,
                ),
            )
        )
    for push in own(scenario.pushes):
        impulse = push.impulse_vector()
        events.append((push.time, Push(impulse=impulse, duration=push.duration, target=push.target)))
    for strike in own(scenario.pendulums):
        events.append(
            (
                strike.time,
                SwingPendulum(
                    mass=strike.mass,
                    length=strike.length,
                    angle=math.radians(strike.angle),
                    direction=math.radians(strike.direction),
                    height=strike.height,
                ),
            )
        )
    return events


_ARMS_DOWN: Final = {
    "LShoulderPitch": 1.571,
    "RShoulderPitch": 1.571,
    "LShoulderRoll": 0.2,
    "RShoulderRoll": -0.2,
}
_ARMS_AHEAD: Final = {"RShoulderPitch": 0.6, "LShoulderRoll": 0.2, "RShoulderRoll": -0.2}
"""Arm joints of a robot on its side: with the arms down it would roll onto its front."""
_H: Final = 0.7071067811865476
HOOK_CLEARANCE: Final = 0.10
"""Height of the lowest point of a hanging robot over the floor, m."""
_MAX_START_SLOPE: Final = 0.5
"""Gradient of the steepest ground on which a robot is put as it slopes; no pose rests on a steeper one."""


class StartPose(NamedTuple):
    """A start other than standing."""

    angles: tuple[float, ...]
    """25 in frame order, rad."""
    orientation: Quaternion | None
    """Orientation of the torso, whose heading is along x where it has one; None: the left sole is level."""
    rest: float
    """Stiffness of all joints once it has settled."""
    settle: float = 2.0
    """Time in which it settles, s."""
    height: float = 0.0
    """Height of its lowest point over the ground at first, m."""
    held: bool = False
    """The torso hangs on a hook."""


def _straight(arms: dict[str, float] = _ARMS_DOWN) -> tuple[float, ...]:
    """Legs straight."""
    return tuple(arms.get(name, 0.0) for name in JOINTS)


STAND: Final = "stand"
START_POSES: Final[dict[str, StartPose]] = {
    # SitRelax leans on the hands; a V3 leans by 0.6 rad, its arms are short, and more upright it would roll
    # over when it stands up. A real robot stays sitting limp, and with its knees up too (Sit); the emulated one
    # has round buttocks: it needs some stiffness, and with its knees up it rolls over.
    "sit": StartPose(POSTURES["SitRelax"], quaternion(pitch=-0.5), 0.3),
    # its thighs do not rest on its calves, as a real robot's do
    "crouch": StartPose(POSTURES["Crouch"], None, 0.1),
    "lie-back": StartPose(_straight(), (0.0, -_H, 0.0, _H), 0.0),
    "lie-front": StartPose(_straight(), (0.0, _H, 0.0, _H), 0.0),
    "lie-side": StartPose(_straight(_ARMS_AHEAD), (-_H, 0.0, 0.0, _H), 0.0),
    "hang": StartPose(_straight(), ORIGIN.orientation, 0.0, height=HOOK_CLEARANCE, held=True),
}
"""By name; `stand` is the scenario's posture, stiff. On its side the robot lies on the left arm.

Legs straight and arms down are rUNSWift's pose for a lying robot.
"""


def start_pose(name: str) -> StartPose | None:
    """A start pose by its name; None: on its feet.

    Raises:
        ConfigurationError: no such pose.
    """
    if name not in START_NAMES:
        raise ConfigurationError(unknown_name("start pose", name, START_NAMES))
    return START_POSES.get(name)


def random_drop(body: Body, height: float, random: np.random.Generator) -> StartPose:
    """A limp robot over the ground: any orientation and any angles within the joints' ranges are as likely.

    Args:
        body: Data sheet.
        height: Of its lowest point over the ground, m.
        random: Source.
    """
    from scipy.spatial.transform import Rotation  # here: no other start needs SciPy

    absent = absent_joints(body)
    angles = [0.0 if name in absent else float(random.uniform(*limits(body, name))) for name in JOINTS]
    x, y, z, w = Rotation.random(random_state=random).as_quat().tolist()
    return StartPose(tuple(angles), (x, y, z, w), 0.0, height=height)


def start_posture(posture: str | Sequence[float]) -> tuple[float, ...]:
    """25 joint angles in frame order, rad, of a posture given by name or by its angles.

    Raises:
        ConfigurationError: unknown name, or another number of angles.
    """
    if isinstance(posture, str):
        if posture not in POSTURES:
            raise ConfigurationError(f"No posture `{posture}`; known are {', '.join(sorted(POSTURES))}.")
        return POSTURES[posture]
    if len(posture) != N_JOINTS:
        raise ConfigurationError(
            f"A start posture of {len(posture)} angles; {N_JOINTS} are expected: {', '.join(JOINTS)}."
        )
    return tuple(float(angle) for angle in posture)


def place(
    world: World,
    robot: Multibody,
    angles: Sequence[float],
    orientation: Quaternion | None,
    lift: float,
    at: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> None:
    """Set the joints, and put the robot at rest on the ground.

    Args:
        world: With the ground; the pose is meant in its floor's frame.
        robot: In the world.
        angles: 25 joint angles in frame order, rad.
        orientation: Of the torso; None: the left sole is parallel to the floor and the torso looks along x.
        lift: Height of the lowest corner of the soles above the ground, m.
        at: Place of the torso on the floor, x and y in m, and its heading, rad.
    """
    robot.place(ORIGIN, joints=[angles[INDEX_WITH_MIRROR[name]] for name in robot.joints])
    soles = {side: robot.state(link).pose for side, link in FOOT_LINKS.items()}
    turned = Pose(orientation=_level(soles["L"].orientation) if orientation is None else orientation)
    corners = [
        point_of(compose(turned, sole), corner)
        for side, sole in soles.items()
        for corner in sole_points(robot.body, side).tolist()
    ]
    lowest = min(0.0, *(corner[2] for corner in corners))
    where = _on_ground(world, [(x, y) for x, y, _ in corners], at, lift - lowest)
    robot.place(compose(world.pose, compose(where, turned)))


def _on_ground(
    world: World, points: Sequence[tuple[float, float]], at: tuple[float, float, float], height: float
) -> Pose:
    """A frame over the ground with its mean slope, in the floor's frame; no point of the ground is over it.

    Args:
        world: With the ground.
        points: Where the ground counts, in the frame, m.
        at: Of the frame on the floor, x and y in m, and its heading, rad.
        height: Of the frame over the ground, m.
    """
    heading = quaternion(yaw=at[2])
    if not world.uneven:
        return Pose((at[0], at[1], height), heading)
    x, y = np.array(points).T
    turn = np.array([[math.cos(at[2]), -math.sin(at[2])], [math.sin(at[2]), math.cos(at[2])]])
    places = (turn @ (x, y)).T
    ground = np.array(world.ground([(at[0] + dx, at[1] + dy) for dx, dy in places.tolist()]))
    plane = np.column_stack([places, np.ones(len(places))])
    along_x, along_y, level = np.linalg.lstsq(plane, ground, rcond=None)[0].tolist()
    if math.hypot(along_x, along_y) > _MAX_START_SLOPE:  # a wall or an edge, not a slope
        along_x = along_y = level = 0.0
    level += float((ground - plane @ (along_x, along_y, level)).max())
    slope = quaternion(roll=math.atan(along_y * math.cos(math.atan(along_x))), pitch=-math.atan(along_x))
    over = point_of(Pose((at[0], at[1], level), slope), (0.0, 0.0, height))
    return Pose(over, compose(Pose(orientation=slope), Pose(orientation=heading)).orientation)


def place_lying(
    world: World, robot: Multibody, pose: StartPose, at: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> None:
    """Put the robot at rest with its lowest point on or over the ground, or on a hook; then let it settle.

    Args:
        world: With the ground.
        robot: In the world.
        pose: Joints and torso.
        at: Place of the torso on the floor, x and y in m, and its heading, rad.
    """
    if pose.orientation is None:
        place(world, robot, pose.angles, None, 0.0, at)
        return
    turned = Pose(orientation=pose.orientation)
    robot.place(turned, joints=[pose.angles[INDEX_WITH_MIRROR[name]] for name in robot.joints])
    shapes = link_shapes(robot.body)
    lowest = min(lowest_point(shape, robot.state(link).pose) for link, shape in shapes.items())
    around = [(0.1 * i, 0.1 * j) for i in range(-3, 4) for j in range(-3, 4)]
    where = _on_ground(world, around, at, pose.height - lowest)
    robot.place(compose(world.pose, compose(where, turned)), held=pose.held)


def _level(sole: Quaternion) -> Quaternion:
    """Orientation of a torso that looks along x and has the given sole, seen from it, level."""
    level = inverse(Pose(orientation=sole))
    back = quaternion(yaw=-yaw_of(level.orientation))
    return compose(Pose(orientation=back), level).orientation
