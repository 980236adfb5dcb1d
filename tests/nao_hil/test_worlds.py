"""Several robots in one world: each is itself, and they are bodies for each other."""

from __future__ import annotations

import math

import numpy as np
import pytest

import nao_hil
from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.errors import ConfigurationError
from bridge.messages.world import Push
from emulator.engine.catalogue import open_engine
from emulator.engine.settings import PhysicsSettings
from emulator.poses import Pose, quaternion
from tests.engines import passive

BODY = load_body("nao-v6")
HEAD = INDEX["HeadYaw"]


def moved(stand: tuple[float, ...], angle: float) -> list[float]:
    position = list(stand)
    position[HEAD] = angle
    return position


def three(physics: str) -> nao_hil.World:
    """Unlike robots of one cycle, 0.7 m from each other."""
    world = nao_hil.World(engine=physics)
    for number, (body, wear) in enumerate((("nao-v3", "nominal"), ("nao-v4", "worn"), ("nao-v5", "ideal"))):
        world.add(body, name=f"r{number}", seed=10 + number, wear=wear, at=(0.0, 0.7 * number, 0.0))
    return world


def test_a_robot_alone_in_a_world_gives_the_frames_of_a_single_one(physics: str) -> None:
    random = np.random.default_rng(1)
    with nao_hil.Robot("nao-v6", seed=5, wear="worn", engine=physics, scenario="rough") as robot:
        commands = robot.frame.position + random.normal(0.0, 0.05, (30, 25))
        expected = [robot.frame, *(robot.step(command, 0.8) for command in commands)]
        truth = robot.truth
    with nao_hil.World("rough", engine=physics, seed=5) as world:
        world.add("nao-v6", name="alone", seed=5, wear="worn")
        found = [world.frames, *(world.step({"alone": (command, 0.8)}) for command in commands)]
        assert [frames["alone"] for frames in found] == expected
        assert world.truth.robots["alone"] == truth


def test_commands_reach_the_robot_of_their_name_and_runs_repeat(physics: str) -> None:
    runs = []
    with three(physics) as world:
        for _ in range(2):
            stands = {name: frame.position for name, frame in world.frames.items()}
            # the head of each robot turns in cycles of its own
            for cycle in range(60):
                turning = f"r{cycle // 20}"
                world.step({turning: moved(stands[turning], 0.5)})
                heads = {name: frame.position[HEAD] for name, frame in world.frames.items()}
                waiting = [heads[f"r{number}"] for number in range(3) if number > cycle // 20]
                assert max(map(abs, waiting), default=0.0) < 0.03
            assert all(abs(heads[name] - 0.5) < 0.1 for name in world.names)
            runs.append((world.frames, world.truth))
            world.reset()
    assert runs[0] == runs[1]
    assert {truth.fell for truth in runs[0][1].robots.values()} == {False}


def test_a_falling_robot_strikes_the_one_beside_it(physics: str) -> None:
    """It lies on the other or knocks it over, and is not inside it; without the push both stand."""
    for impulse, touched, cycles in ((0.0, False, 50), (7.0, True, 200)):
        with nao_hil.World(engine=physics) as world:
            for name, y in (("striking", 0.0), ("struck", 0.4)):
                world.add("nao-v6", name=name, seed=2, at=(0.0, y, 0.0))
            before = world.truth.robots["struck"].torso_position
            if impulse:
                world.send(Push(target="Torso", impulse=(0.0, impulse, 0.0), duration=0.1))
            way = deepest = 0.0
            engine = world._world.engine
            for _ in range(cycles):
                world.step()
                way = max(way, math.dist(world.truth.robots["struck"].torso_position, before))
                deepest = max(deepest, engine.overlap(*engine.robots))
            assert (way > 0.02) is touched
            assert deepest < 0.005


def test_a_robot_hears_the_other_one_by_its_sonar(physics: str) -> None:
    distances = []
    for ahead in (1.0, 5.0):
        with nao_hil.World(engine=physics) as world:
            world.add("nao-v6", name="near", wear="ideal")
            world.add("nao-v6", name="far", wear="ideal", at=(ahead, 0.0, math.pi))
            for _ in range(10):
                world.step()
            distances.append(min(world.frames["near"].sonar))
    assert 0.6 < distances[0] < 1.0
    assert distances[1] > 2.5


def test_robots_that_collide_in_the_air_keep_their_momentum(physics: str) -> None:
    """Two limp robots fly at each other: the sum of their momenta stays, the speed at which they part falls."""
    engine = open_engine(physics, PhysicsSettings())
    engine.surround(engine.surroundings._replace(gravity=(0.0, 0.0, 0.0)))
    robots = [engine.add_robot(BODY, passive(BODY)) for _ in range(2)]
    for robot, side, speed in zip(robots, (-0.3, 0.3), (1.0, -0.4), strict=True):
        robot.place(Pose((side, 0.02 * side, 2.0), quaternion(yaw=0.1 * side)), (speed, 0.0, 0.0))

    def velocities() -> np.ndarray:
        before = np.array([robot.com() for robot in robots])
        engine.run(10)
        return (np.array([robot.com() for robot in robots]) - before) / 0.01

    first = velocities()
    np.testing.assert_allclose(first, [(1.0, 0.0, 0.0), (-0.4, 0.0, 0.0)], atol=2e-3)
    engine.run(600)
    last = velocities()
    engine.close()
    np.testing.assert_allclose(last.sum(axis=0), first.sum(axis=0), atol=0.02)
    assert last[1, 0] - last[0, 0] < 0.5 * 1.4
    assert last[1, 0] > 0.1


def test_what_a_world_refuses_is_said_in_a_sentence() -> None:
    with nao_hil.World(engine="mujoco") as world:
        with pytest.raises(ConfigurationError, match="has no robot"):
            world.step()
        world.add("nao-v3", name="a")
        with pytest.raises(ConfigurationError, match="robots of one cycle share a world"):
            world.add("nao-v6", name="b", at=(1.0, 0.0, 0.0))
        with pytest.raises(ConfigurationError, match="Robot `a` stands inside"):
            world.add("nao-v4", name="b", at=(0.05, 0.0, 0.0))
        with pytest.raises(ConfigurationError, match="called `a`"):
            world.add("nao-v4", name="a", at=(1.0, 0.0, 0.0))
        world.add("nao-v4", name="b", at=(1.0, 0.0, 0.0))
        world.step()
        assert world.names == ("a", "b")
        with pytest.raises(ConfigurationError, match="before the first step"):
            world.add("nao-v4", name="c")
        with pytest.raises(ConfigurationError, match="'c'"):
            world.step({"c": 0.0})
    with pytest.raises(ConfigurationError, match="closed"):
        world.step()
