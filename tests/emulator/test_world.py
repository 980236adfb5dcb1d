"""The world against closed forms: statics on slopes, Coulomb's law, impulse and momentum, a pendulum."""

import math
from typing import Any

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.errors import ConfigurationError, FrameError
from bridge.messages.world import (
    PlaceObject,
    PlateUnderFoot,
    Push,
    Remove,
    SetFriction,
    SwingPendulum,
    TiltFloor,
)
from emulator.engine.base import Engine
from emulator.engine.catalogue import open_engine
from emulator.engine.settings import PhysicsSettings
from emulator.poses import yaw_of
from emulator.robot import EmulatedRobot
from emulator.scenarios.ground import Heightfield, PlacedBox, ScenarioFloor, Start, Tiles
from emulator.scenarios.model import Scenario, terrain_of
from emulator.start import add_terrain
from emulator.world.actions import PendulumStrike
from emulator.world.world import World

BODY = load_body("nao-v3")
MASS = sum(link.mass for link in BODY.links.values())
G = 9.81


@pytest.fixture
def engine(physics: str):
    engine = open_engine(physics, PhysicsSettings())
    yield engine
    engine.close()


def bob_place(engine: Engine, pendulum: Any) -> np.ndarray:
    """Middle of a pendulum's bob, asked of the engine itself."""
    if hasattr(engine, "simulation"):
        return np.array(engine.simulation.now.body(pendulum.name).xipos)
    from emulator.engine.pybullet.client import bullet

    state = bullet.getLinkState(pendulum.number, 0, physicsClientId=engine.client)
    return np.array(state[0])


def run(robot: EmulatedRobot, seconds: float) -> None:
    for _ in range(round(seconds / BODY.cycle)):
        robot.advance(None)


def test_a_robot_at_rest_on_a_slope_obeys_statics(physics: str) -> None:
    """The ground carries the weight, straight up, through the centre of mass; the torso leans as the floor."""
    roll, pitch = -3.0, 3.0
    scenario = Scenario(floor=ScenarioFloor(roll=roll, pitch=pitch))
    with (
        EmulatedRobot(BODY, engine=physics, seed=0) as level,
        EmulatedRobot(BODY, engine=physics, seed=0, scenario=scenario) as robot,
    ):
        run(robot, 2.0)
        truth = robot.truth()
        force = np.add(truth.left.force, truth.right.force)
        np.testing.assert_allclose(force, (0.0, 0.0, MASS * G), atol=0.01 * MASS * G)
        np.testing.assert_allclose(truth.zmp, truth.com[:2], atol=1e-3)
        assert not truth.fell
        lean = np.subtract(robot.frame.angle, level.frame.angle)
        np.testing.assert_allclose(lean, np.radians((roll, pitch)), atol=0.01)


@pytest.mark.parametrize(("degrees", "slides"), [(5.3, False), (6.2, True)])
def test_friction_between_sole_and_floor_is_the_configured_one(
    degrees: float, slides: bool, physics: str
) -> None:
    """Coulomb: with a coefficient of 0.1 a standing robot begins to slide at atan(0.1) = 5.71 degrees."""
    scenario = Scenario(floor=ScenarioFloor(friction=0.1, roll=degrees))
    with EmulatedRobot(BODY, engine=physics, seed=0, scenario=scenario) as robot:
        before = np.array(robot.truth().torso_position)
        run(robot, 1.6)
        moved = float(np.linalg.norm(np.array(robot.truth().torso_position) - before))
        assert (moved > 0.05) == slides
        assert moved > 0.05 or moved < 0.005


def test_a_tilting_floor_turns_about_the_point_under_the_torso_and_takes_the_robot_along(physics: str) -> None:
    with EmulatedRobot(BODY, engine=physics, seed=0) as robot:
        before = robot.frame.angle
        robot.world_events.execute(PlaceObject(name="step", size=(0.2, 0.2, 0.02), at=(0.6, 0.0)))
        robot.world_events.execute(TiltFloor(pitch=math.radians(4.0), duration=0.6))
        run(robot, 1.5)
        truth = robot.truth()
        assert robot.frame.angle[1] - before[1] == pytest.approx(math.radians(4.0), abs=0.01)
        np.testing.assert_allclose(truth.zmp, truth.com[:2], atol=1e-3)
        assert not truth.fell
        # The box stays on the floor: its middle is 1 cm over it along the normal (sin 4, 0, cos 4).
        box = robot.world.object_states()[0]
        origin = robot.world.pose[0]
        tilt = math.radians(4.0)
        normal = (math.sin(tilt), 0.0, math.cos(tilt))
        assert np.dot(np.subtract(box.position, origin), normal) == pytest.approx(0.01, abs=1e-6)


def test_a_push_in_flight_changes_the_momentum_by_its_impulse(physics: str) -> None:
    """Free fall is the one place where nothing else pushes horizontally."""
    with EmulatedRobot(BODY, engine=physics, seed=0, settle=0.0, lift=1.0) as robot:
        start = np.array(robot.truth().com)
        robot.world_events.execute(Push(impulse=(0.6, -0.3, 0.0), duration=0.05))
        run(robot, 0.1)
        first = np.array(robot.truth().com)
        run(robot, 0.1)
        velocity = (np.array(robot.truth().com) - first) / 0.1
        np.testing.assert_allclose(MASS * velocity[:2], (0.6, -0.3), rtol=1e-3)
        # constant force for 50 ms, then 50 ms of flight: p t^2 / 2 and p t
        way = (0.6 / MASS) * (0.025 + 0.05)
        assert first[0] - start[0] == pytest.approx(way, rel=0.02)


def test_a_movable_box_slides_as_coulomb_says(physics: str) -> None:
    """Pushed to v, it comes to rest after v^2 / (2 mu g)."""
    with EmulatedRobot(BODY, engine=physics, seed=0, settle=0.0) as robot:
        robot.world_events.execute(SetFriction(friction=0.5))
        robot.world_events.execute(PlaceObject(name="box", size=(0.2, 0.2, 0.05), at=(1.0, 0.0), mass=0.5))
        run(robot, 0.2)
        start = robot.world.object_states()[0].position[0]
        robot.world_events.execute(Push(target="box", impulse=(0.5, 0.0, 0.0), duration=0.001))
        run(robot, 1.0)
        way = robot.world.object_states()[0].position[0] - start
        assert way == pytest.approx(1.0 / (2.0 * 0.5 * G), rel=0.05)


def test_a_pendulum_reaches_the_speed_of_its_height(engine: Engine) -> None:
    """v = sqrt(2 g l (1 - cos a)) at the lowest point, corrected for the bob's own moment of inertia."""
    length, angle, mass = 0.8, math.radians(40.0), 2.0
    pendulum = PendulumStrike(engine, (0.0, 0.0, 1.0), 0.3, mass, length, angle)
    places = [bob_place(engine, pendulum.thing)]
    for _ in range(2000):
        engine.run(1)
        places.append(bob_place(engine, pendulum.thing))
        if not pendulum.step():
            break
    steps = np.diff(places, axis=0) / engine.settings.step
    speeds = np.linalg.norm(steps, axis=1)
    fast = int(speeds.argmax())
    fastest, place, direction = speeds[fast], places[fast], steps[fast] / speeds[fast]
    inertia = 1.0 + 0.4 * (0.05 / length) ** 2
    assert fastest == pytest.approx(math.sqrt(2.0 * G * length * (1.0 - math.cos(angle)) / inertia), rel=1e-3)
    np.testing.assert_allclose(place, (0.0, 0.0, 1.0), atol=5e-3)
    np.testing.assert_allclose(direction, (math.cos(0.3), math.sin(0.3), 0.0), atol=5e-3)


def test_a_pendulum_strikes_the_robot_and_is_no_fall(physics: str) -> None:
    with EmulatedRobot(BODY, engine=physics, seed=0) as robot:
        upright = robot.frame.angle[1]
        robot.world_events.execute(SwingPendulum(mass=0.5, length=1.0, angle=math.radians(12.0)))
        tilted = []
        for _ in range(90):
            robot.advance(None)
            tilted.append(robot.frame.angle[1] - upright)
            assert not robot.truth().fell
        assert max(map(abs, tilted[:40])) < 1e-3
        assert max(tilted) > 5e-3


def test_the_robot_stands_on_a_plate_as_high_as_the_plate(physics: str) -> None:
    plate = PlacedBox(name="plate", size=(0.5, 0.5, 0.01), at=(0.0, 0.0))
    with (
        EmulatedRobot(BODY, engine=physics, seed=0) as level,
        EmulatedRobot(BODY, engine=physics, seed=0, scenario=Scenario(boxes=(plate,))) as robot,
    ):
        run(robot, 0.5)
        rise = robot.truth().torso_position[2] - level.truth().torso_position[2]
        assert rise == pytest.approx(0.01, abs=3e-4)
        assert not robot.truth().fell
        assert sum(robot.frame.fsr) == pytest.approx(MASS * G, rel=0.01)


def test_a_plate_appears_under_a_lifted_foot_and_not_before(physics: str) -> None:
    with EmulatedRobot(BODY, engine=physics, seed=0) as robot:
        robot.world_events.execute(PlateUnderFoot(foot="right", size=(0.1, 0.08, 0.01), shift=(0.02, 0.01)))
        run(robot, 0.3)
        assert robot.world.object_states() == ()
    with EmulatedRobot(BODY, engine=physics, seed=0, settle=0.0, lift=0.012) as robot:
        robot.world_events.execute(
            PlateUnderFoot(foot="right", size=(0.1, 0.08, 0.01), shift=(0.02, 0.01), yaw=-0.5)
        )
        robot.advance(None)
        (plate,) = robot.world.object_states()
        foot = robot.multibody.state("RAnkleRoll").position
        x, y = BODY.foot.centre[0] + 0.02, -BODY.foot.centre[1] + 0.01
        np.testing.assert_allclose(plate.position, (foot[0] + x, foot[1] + y, 0.005), atol=2e-3)
        assert yaw_of(plate.orientation) == pytest.approx(-0.5, abs=0.02)
        assert [notice.code for notice in robot.take_notices()] == ["world", "world"]


@pytest.mark.parametrize(
    ("start", "box"),
    [
        (Start(), PlacedBox(name="crate", size=(0.2, 0.2, 0.3), at=(0.0, 0.0), mass=0.3)),
        (Start(), PlacedBox(name="crate", size=(0.05, 0.1, 0.5), at=(0.0, 0.13))),
        (
            Start(x=1.0, yaw=90.0, pose="lie-back"),
            PlacedBox(name="crate", size=(0.1, 0.1, 0.2), at=(1.0, 0.2), mass=0.3),
        ),
    ],
    ids=["about the feet", "in the left arm", "in the legs of one that lies"],
)
def test_a_scenario_with_a_box_in_the_robot_at_its_start_is_refused(
    start: Start, box: PlacedBox, physics: str
) -> None:
    with pytest.raises(ConfigurationError, match=r"Object `crate` of the scenario stands inside robot `nao`"):
        EmulatedRobot(BODY, engine=physics, seed=0, scenario=Scenario(start=start, boxes=(box,)))


@pytest.mark.parametrize("mass", [0.0, 0.2])
def test_a_refused_place_leaves_the_box_of_that_name_where_it_is(mass: float, physics: str) -> None:
    scenario = Scenario(floor=ScenarioFloor(pitch=2.0))
    with EmulatedRobot(BODY, engine=physics, seed=0, settle=0.0, scenario=scenario) as robot:
        robot.world_events.execute(
            PlaceObject(name="wall", size=(0.1, 0.2, 0.3), at=(0.5, 0.1), yaw=0.4, mass=mass)
        )
        robot.advance(None)
        (before,) = robot.world.object_states()
        with pytest.raises(FrameError, match="inside robot `nao`"):
            robot.world_events.execute(PlaceObject(name="wall", size=(0.1, 0.1, 1.0), at=(0.0, 0.0)))
        (after,) = robot.world.object_states()
        assert (after.name, after.size, after.mass) == (before.name, before.size, before.mass)
        np.testing.assert_allclose(after.position, before.position, atol=1e-9)
        np.testing.assert_allclose(after.orientation, before.orientation, atol=1e-9)


def test_a_push_of_what_is_not_there_is_refused_with_the_nearest_name() -> None:
    with EmulatedRobot(BODY, engine="mujoco", seed=0, settle=0.0) as robot:
        send = robot.world_events.execute
        send(PlaceObject(name="crate", size=(0.1, 0.1, 0.1), at=(1.0, 0.0), mass=0.2))
        for wrong, near in (("crates", "'crate'"), ("LKneepitch", "'LKneePitch'")):
            with pytest.raises(FrameError, match=near) as refused:
                send(Push(target=wrong, impulse=(0.5, 0.0, 0.0)))
            assert "RAnkleRoll" not in str(refused.value)


@pytest.mark.parametrize("replaced", [False, True])
def test_a_push_ends_with_the_box_it_pushes(replaced: bool, physics: str) -> None:
    """Neither does the robot stop working, nor does what takes the box's place get the rest of the push."""
    box = PlaceObject(name="box", size=(0.1, 0.1, 0.1), at=(1.0, 0.0), mass=0.2, friction=0.0)
    with EmulatedRobot(BODY, engine=physics, seed=0, settle=0.0) as robot:
        robot.world_events.execute(box)
        robot.world_events.execute(Push(target="box", impulse=(0.0, 0.2, 0.0), duration=0.5))
        robot.advance(None)
        robot.world_events.execute(box if replaced else Remove(name="box"))
        run(robot, 0.3)
        assert [abs(found.position[1]) < 1e-3 for found in robot.world.object_states()] == [True] * replaced


def test_boxes_are_placed_from_the_robot_and_on_one_another(physics: str) -> None:
    scenario = Scenario(start=Start(x=1.0, y=2.0, yaw=90.0))
    with EmulatedRobot(BODY, engine=physics, seed=0, scenario=scenario) as robot:
        x, y, _ = robot.truth().torso_position
        for name in ("lower", "upper"):
            robot.world_events.execute(
                PlaceObject(name=name, size=(0.2, 0.1, 0.05), at=(0.4, 0.0), frame="robot")
            )
        lower, upper = robot.world.object_states()
        np.testing.assert_allclose(lower.position, (x, y + 0.4, 0.025), atol=2e-3)
        np.testing.assert_allclose(np.subtract(upper.position, lower.position), (0.0, 0.0, 0.05), atol=1e-4)


def sloped(ground: str, gradient: float) -> Scenario:
    """Ground that falls along x, of each kind."""
    if ground == "floor":
        return Scenario(floor=ScenarioFloor(pitch=math.degrees(math.atan(gradient))))
    rows = tuple(tuple(2.0 - 0.05 * gradient * i for i in range(61)) for _ in range(61))
    return Scenario(heightfield=Heightfield(spacing=0.05, heights=rows))


@pytest.mark.parametrize(
    ("start", "yaw", "physics"), [(None, 90.0, "pybullet"), (None, 90.0, "mujoco"), ("lie-back", 0.0, "mujoco")]
)
def test_a_robot_starts_on_a_slope_of_heights_as_on_a_tilted_floor(
    start: str | None, yaw: float, physics: str
) -> None:
    pytest.importorskip(physics)
    angles = {}
    for ground in ("floor", "heights"):
        scenario = msgspec.structs.replace(sloped(ground, 0.1), start=Start(yaw=yaw))
        with EmulatedRobot(BODY, seed=0, engine=physics, scenario=scenario, start=start) as robot:
            for _ in range(30):
                robot.advance(None)
            angles[ground] = np.array(robot.frame.angle)
            assert start == "lie-back" or not robot.truth().fell
    np.testing.assert_allclose(angles["heights"], angles["floor"], atol=0.02)


def test_tiles_have_the_asked_heights_and_leave_the_start_free(engine: Engine) -> None:
    world = World(engine)
    tiles = Tiles(area=(1.0, 1.0), height=0.02, edge=0.1, free=0.3)
    add_terrain(world, terrain_of(Scenario(tiles=tiles), np.random.default_rng(1)))
    at = [(0.1 * i - 0.45, 0.1 * j - 0.45) for i in range(10) for j in range(10)]
    heights = np.array(world.ground(at))
    free = np.hypot(*np.array(at).T) < 0.3
    np.testing.assert_allclose(heights[free], 0.0, atol=1e-6)
    assert heights.min() >= 0.0 and heights.max() <= 0.02 + 1e-6
    # uniform: mean h / 2, standard deviation h / sqrt(12), from about 70 tiles
    assert heights[~free].mean() == pytest.approx(0.01, abs=4 * 0.02 / math.sqrt(12 * 70))
    assert len(set(np.round(heights[~free], 7))) > 50


def test_a_heightfield_is_as_high_as_its_numbers_between_them_too(engine: Engine) -> None:
    world = World(engine)
    heights = tuple(tuple(0.01 * i + 0.003 * j for i in range(5)) for j in range(4))
    field = Heightfield(spacing=0.1, heights=heights, centre=(1.0, -2.0))
    add_terrain(world, terrain_of(Scenario(heightfield=field), np.random.default_rng(0)))
    points = [(1.0 - 0.2 + 0.1 * i, -2.0 - 0.15 + 0.1 * j) for i in range(1, 4) for j in range(1, 3)]
    expected = [0.01 * i + 0.003 * j for i in range(1, 4) for j in range(1, 3)]
    np.testing.assert_allclose(world.ground(points), expected, atol=1e-5)
    (between,) = world.ground([(1.0 - 0.2 + 0.15, -2.0 - 0.15 + 0.1)])
    assert between == pytest.approx(0.01 * 1.5 + 0.003, abs=1e-5)


def test_a_fallen_robot_is_put_back_on_its_feet_where_it_lies(physics: str) -> None:
    with EmulatedRobot(BODY, engine=physics, seed=0) as robot:
        standing = robot.truth()
        robot.world_events.execute(Push(impulse=(0.0, 5.0, 0.0)))
        run(robot, 2.0)
        fallen = robot.truth()
        assert fallen.fell
        robot.stand_up()
        run(robot, 1.0)
        again = robot.truth()
        assert not again.fell
        assert again.torso_position[2] == pytest.approx(standing.torso_position[2], abs=1e-3)
        np.testing.assert_allclose(again.torso_position[:2], fallen.torso_position[:2], atol=0.01)
        np.testing.assert_allclose(robot.frame.angle, (0.0, 0.1), atol=0.15)


def test_a_turning_floor_carries_what_lies_on_it_at_its_own_speed() -> None:
    """A box far from the pivot is lifted by the velocity of its place, without being thrown or left behind."""
    with EmulatedRobot(BODY, seed=0) as robot:
        robot.world_events.execute(PlaceObject(name="box", size=(0.1, 0.1, 0.02), at=(0.5, 0.0), mass=0.3))
        run(robot, 0.2)
        robot.world_events.execute(TiltFloor(pitch=math.radians(-4.0), duration=1.0))
        gaps = []
        for _ in range(100):
            robot.advance(None)
            (box,) = robot.world.object_states()
            gaps.append(robot.world.clearance(box.position) - 0.01)
        assert max(map(abs, gaps)) < 2e-4
