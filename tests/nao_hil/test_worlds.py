"""Several robots in one world: each is itself, and they are bodies for each other."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest

import nao_hil
from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.errors import ConfigurationError, FrameError
from bridge.messages import TruthFrame
from bridge.messages.faults import JointHot, JointLimp
from bridge.messages.walk import WalkCommand
from bridge.messages.world import (
    Pause,
    PlaceObject,
    PlateUnderFoot,
    Press,
    Push,
    Remove,
    Reset,
    SetFriction,
    StartFault,
)
from emulator.engine.catalogue import open_engine
from emulator.engine.settings import PhysicsSettings
from emulator.engine.values import Ball
from emulator.poses import Pose, quaternion
from tests.engines import passive
from tests.loops import repeat_while

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


@pytest.mark.parametrize("aside", [0.0, 0.03])
def test_a_kicked_ball_takes_the_momentum_that_the_robot_loses(aside: float, physics: str) -> None:
    """A limp robot flies foot first into a ball at rest: the sum of the momenta stays."""
    engine = open_engine(physics, PhysicsSettings())
    engine.surround(engine.surroundings._replace(gravity=(0.0, 0.0, 0.0)))
    robot = engine.add_robot(BODY, passive(BODY))
    robot.place(Pose((0.0, 0.0, 2.0), quaternion()), (1.0, 0.0, 0.0))
    mass, ankle = 0.3, robot.state("LAnkleRoll").position  # a heavy ball: the robot feels it
    foot = (ankle[0] + 0.25, ankle[1] + aside, ankle[2] - 0.03)
    ball = engine.add(Ball(radius=0.05, mass=mass, rolling=0.0), Pose(foot, quaternion()))
    robot_mass = sum(link.mass for link in BODY.links.values())

    def velocities() -> tuple[np.ndarray, np.ndarray]:
        before = np.array(robot.com()), np.array(ball.state().position)
        engine.run(10)
        after = np.array(robot.com()), np.array(ball.state().position)
        return (after[0] - before[0]) / 0.01, (after[1] - before[1]) / 0.01

    first, at_rest = velocities()
    np.testing.assert_allclose(at_rest, 0.0, atol=1e-6)
    engine.run(400)
    last, kicked = velocities()
    engine.close()
    np.testing.assert_allclose(robot_mass * last + mass * kicked, robot_mass * first, atol=0.02 * mass)
    assert kicked[0] > 0.3
    assert last[0] < first[0] - 0.01
    if not aside:
        assert math.hypot(*kicked[1:]) < 0.5 * kicked[0]


def turning(world: nao_hil.World, cycles: int, begin: int = 0) -> list[dict[str, TruthFrame]]:
    """Two robots turn their heads to and fro while the one between them stands."""
    found = []
    stand = world.frames["r0"].position
    for cycle in range(begin, begin + cycles):
        angle = 0.5 * math.sin(0.1 * cycle)
        world.step({"r0": moved(stand, angle), "r2": moved(stand, -angle)})
        found.append(world.truth.robots)
    return found


def encoder_error(world: nao_hil.World) -> np.ndarray:
    """Of the middle robot, which is worn: each encoder has an error of its own, by the seed."""
    return np.subtract(world.frames["r1"].position, world.truth.robots["r1"].joints)


def test_a_robot_begins_again_alone_and_the_motion_of_the_others_goes_on(physics: str) -> None:
    """They move as if nothing had happened, but for their backlash; it stands where it began, cool, sound."""
    with three(physics) as world:
        undisturbed = turning(world, 200)
        world.reset()
        first, began, error = world.frames["r1"], world.truth.robots["r1"], encoder_error(world)
        world.send(StartFault(fault=JointLimp(joint="LKneePitch")), "r1")
        world.send(StartFault(fault=JointHot(joint="RKneePitch", temperature=95.0)), "r1")
        world.send(Press(button="chest"), "r1")
        world.send(Push(target="Torso", impulse=(-6.0, 0.0, 0.0), duration=0.1), "r1")
        found = turning(world, 150)
        assert found[-1]["r1"].fell
        frames = world.reset("r1")
        assert (frames["r0"].seq, frames["r1"].seq, frames["r2"].seq) == (150, 0, 150)
        assert world.truth.time == pytest.approx(1.5)
        assert frames["r1"].temperature == pytest.approx(first.temperature, abs=0.1)
        assert frames["r1"].touch == first.touch
        np.testing.assert_allclose(encoder_error(world), error, atol=2e-3)
        found += turning(world, 50, 150)
        for name in ("r0", "r2"):
            for row, expected in zip(found, undisturbed, strict=True):
                assert row[name].seq == expected[name].seq
                np.testing.assert_allclose(row[name].joints, expected[name].joints, atol=0.02)
                np.testing.assert_allclose(row[name].torso_position, expected[name].torso_position, atol=0.01)
        last = world.truth.robots["r1"]
        assert (last.seq, last.fell) == (50, False)
        np.testing.assert_allclose(last.torso_position, began.torso_position, atol=3e-3)
        np.testing.assert_allclose(last.torso_orientation, began.torso_orientation, atol=5e-3)
        np.testing.assert_allclose(last.joints, began.joints, atol=0.02)


def test_a_robot_whose_place_is_taken_is_not_reset(physics: str) -> None:
    with three(physics) as world:
        world.send(Push(target="Torso", impulse=(30.0, 0.0, 0.0), duration=0.02), "r1")
        for _ in range(100):
            world.step()
        world.send(PlaceObject(name="wall", size=(0.3, 0.04, 0.5), at=(0.0, 0.85)))
        where = world.truth.robots["r1"].torso_position
        with pytest.raises(FrameError, match="wall"):
            world.reset("r1")
        assert world.truth.robots["r1"].torso_position == pytest.approx(where, abs=1e-6)
        world.send(Remove(name="wall"))
        world.send(PlaceObject(name="crate", size=(0.1, 0.1, 0.1), at=(0.0, 0.7), mass=0.5))
        assert "crate" in world.send(Reset(scope="robot"), "r1")  # it is movable, and is taken away
        assert world.frames["r1"].seq == 0
        assert "crate" not in world.truth.objects


def scenario(folder: Path, text: str) -> str:
    file = folder / "events.toml"
    file.write_text(text)
    return str(file)


def test_events_and_faults_concern_the_robot_that_they_name(tmp_path: Path) -> None:
    """By the clock of the world, which the reset of a robot leaves alone; without a name the first one."""
    push = "impulse = 12.0\nduration = 0.1\n"
    text = f'[[pushes]]\ntime = 0.8\nrobot = "blue"\n{push}[[pushes]]\ntime = 1.6\n{push}'
    text += '[[faults]]\ntime = 0.4\nrobot = "green"\nfault = { kind = "sensor-dead", sensor = "fsr" }\n'
    with nao_hil.World(scenario(tmp_path, text), engine="mujoco") as world:
        for number, name in enumerate(("red", "blue", "green")):
            world.add("nao-v6", name=name, seed=3, wear="ideal", at=(0.0, 0.8 * number, 0.0))
        for _ in range(30):
            world.step()
        world.reset("blue")
        fell: dict[str, float] = {}
        dead: set[str] = set()
        for _ in range(220):
            frames = world.step()
            dead |= {name for name, frame in frames.items() if not any(frame.fsr)}
            for name, truth in world.truth.robots.items():
                if truth.fell:
                    fell.setdefault(name, world.truth.time)
    assert dead - {"red", "blue"} == {"green"}
    assert list(fell) == ["blue", "red"]
    assert 0.8 < fell["blue"] < 1.6 < fell["red"]


def test_an_event_of_a_robot_that_is_not_there_is_refused(tmp_path: Path) -> None:
    file = scenario(tmp_path, '[[pushes]]\ntime = 1.0\nimpulse = 1.0\nrobot = "bleu"\n')
    with nao_hil.World(file, engine="mujoco") as world:
        world.add("nao-v6", name="blue")
        with pytest.raises(ConfigurationError, match=r"'bleu'.*'blue'"):
            world.step()
    with pytest.raises(ConfigurationError, match="'bleu'"):
        nao_hil.Robot("nao-v6", engine="mujoco", scenario=file)


BOX: Final[dict[str, Any]] = {"name": "b", "size": (0.1, 0.1, 0.1), "mass": 0.1, "at": (0.5, 0.0)}
WRONG: Final[dict[str, Any]] = {
    "size[1]": PlaceObject(**BOX | {"size": (0.1, -0.1, 0.1)}),
    "at[0]": PlaceObject(**BOX | {"at": (math.nan, 0.0)}),
    "at": PlaceObject(**BOX | {"at": (0.5,)}),
    "mass": PlaceObject(**BOX | {"mass": 1e-9}),
    "name": PlaceObject(**BOX | {"name": ""}),
    "diameter": PlaceObject(**BOX | {"shape": "ball", "size": (0.1, 0.2, 0.1)}),
    "impulse[0]": Push(impulse=(math.nan, 0.0, 0.0)),
    "impulse[1]": Push(impulse=(0.0, 200.0, 0.0)),
    "friction": SetFriction(friction=-1.0),
    "foot": PlateUnderFoot(foot="nose"),  # type: ignore[arg-type]
    "World command": 3,
}


def test_a_wrong_command_is_refused_by_its_field_and_changes_nothing() -> None:
    """Python checks no types: the same bounds hold as on the link."""
    with nao_hil.World(engine="mujoco") as world:
        world.add("nao-v6", name="a")
        for field, command in WRONG.items():
            with pytest.raises(FrameError, match=re.escape(field)):
                world.send(command)
            world.step()
        with pytest.raises(ConfigurationError, match="`step`, `reset` and `truth`"):
            world.send(Pause())
        assert world.truth.objects == {} and not world.truth.robots["a"].fell


@pytest.mark.parametrize("name", ["", "a b", "a/b", "*"])
def test_a_robot_in_a_program_has_a_name_that_the_link_could_have(name: str) -> None:
    with (
        nao_hil.World(engine="mujoco") as world,
        pytest.raises(ConfigurationError, match="1 to 64 letters"),
    ):
        world.add("nao-v6", name=name)


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
        with pytest.raises(ConfigurationError, match="The world has begun"):
            world.add("nao-v4", name="c")
        with pytest.raises(ConfigurationError, match="'c'"):
            world.step({"c": 0.0})
        for wrong in (world.reset, world.add_walker):
            with pytest.raises(ConfigurationError, match="unknown robot 3"):
                wrong(3)  # type: ignore[arg-type]
        with pytest.raises(ConfigurationError, match="a dict by the robot's name"):
            world.step([0.0])  # type: ignore[arg-type]
        with pytest.raises(ConfigurationError, match="position is not made of numbers"):
            world.step({"a": None})  # type: ignore[dict-item]
    with pytest.raises(ConfigurationError, match="closed"):
        world.step()


def test_walkers_in_process_obey_their_robots_orders_and_repeat() -> None:
    """One walks ahead and stands again, the other never moves; refusals name the robot."""
    runs = []
    for whole in (False, True):
        with nao_hil.World(engine="mujoco") as world:
            for number, name in enumerate(("stands", "walks")):
                world.add("nao-v6", name=name, seed=number, at=(0.0, 1.0 * number, 0.0))
            world.add_walker("stands")
            with pytest.raises(ConfigurationError, match="`walks`"):
                world.order("walks", WalkCommand(op="status"))
            world.add_walker("walks")
            with pytest.raises(ConfigurationError, match="`walks` has a walker"):
                world.add_walker("walks", gait="dynamic")
            world.order("walks", WalkCommand(op="walk", velocity=(0.1, 0.0, 0.0)))
            for _ in range(100):
                world.step()
            runs.append(world.frames)
            if not whole:
                continue
            for _ in range(150):
                world.step()
            world.order("walks", WalkCommand(op="stop"))
            status = WalkCommand(op="status")
            for _ in repeat_while(lambda: world.order("walks", status).state != "stand", 500):  # noqa: B023
                world.step()
            ways = {name: robot.torso_position[0] for name, robot in world.truth.robots.items()}
            assert 0.15 < ways["walks"] < 0.4  # 3 s at 0.1 m/s, less the starts and plus the last steps
            assert abs(ways["stands"]) < 0.03
            world.reset()
            assert world.order("walks", WalkCommand(op="status")).state == "approach"
    assert runs[0] == runs[1]
