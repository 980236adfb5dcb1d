"""A batch is many single robots, bit for bit."""

from importlib.util import find_spec

import numpy as np
import pytest

import nao_hil
from bridge.errors import ConfigurationError, FrameError

SEEDS, WEARS, WORLDS = (3, 4, 5), ("worn", "nominal", "ideal"), ("flat", "rough", "turf")


@pytest.mark.parametrize(("engine", "threads"), [("mujoco", 2), ("pybullet", None)])
def test_a_batch_gives_the_numbers_of_single_robots(engine: str, threads: int | None) -> None:
    if find_spec(engine) is None:
        pytest.skip(f"{engine} is not installed")
    random = np.random.default_rng(0)
    with nao_hil.Batch(SEEDS, wear=WEARS, scenario=WORLDS, engine=engine, threads=threads) as batch:
        stand = batch.frames.position[0]
        commands = stand + random.normal(0.0, 0.05, (12, len(SEEDS), 25))
        stiffness = random.uniform(0.5, 1.0, (12, len(SEEDS), 25))
        together = [batch.step(p, s) for p, s in zip(commands, stiffness, strict=True)]
        for i, (seed, wear, world) in enumerate(zip(SEEDS, WEARS, WORLDS, strict=True)):
            with nao_hil.Robot(seed=seed, wear=wear, scenario=world, engine=engine) as robot:
                for k, frames in enumerate(together):
                    frame = robot.step(commands[k, i], stiffness[k, i])
                    for field in frames.__struct_fields__:
                        np.testing.assert_array_equal(getattr(frames, field)[i], getattr(frame, field))
                assert robot.truth == batch.truths[i]


def test_one_robot_begins_anew_and_the_others_go_on() -> None:
    pytest.importorskip("mujoco")
    with nao_hil.Batch([1, 2], body="nao-v6") as batch:
        first = batch.frames
        later = batch.step(first.position, [0.8] * 25)
        frames = batch.reset([1], which=[0])
        np.testing.assert_array_equal(frames.gyroscope[0], first.gyroscope[0])
        np.testing.assert_array_equal(frames.gyroscope[1], later.gyroscope[1])
        assert frames.time.tolist() == [0.0, batch.cycle]


def test_a_number_that_is_out_of_range_moves_no_robot() -> None:
    pytest.importorskip("mujoco")
    with nao_hil.Batch([1, 2]) as robots:
        wrong = robots.frames.position.copy()
        wrong[1, 3] = np.nan
        with pytest.raises(FrameError, match="is nan, but must be a finite number"):
            robots.step(wrong)
        with pytest.raises(FrameError, match=r"Robot 1: .*stiffness of HeadYaw is -5\.0"):
            robots.step(robots.frames.position, [[1.0] * 25, [-5.0] * 25])
        assert robots.frames.time.tolist() == [0.0, 0.0]
        assert [robot.emulated.dcm.clock.now for robot in robots.robots] == [0, 0]


@pytest.mark.parametrize("which", [[0, 0], [2], [-1], [1.0], ["a"], 1, [True, False, True]])
def test_robots_that_are_not_there_or_meant_twice_are_refused(which: object) -> None:
    pytest.importorskip("mujoco")
    with nao_hil.Batch(np.arange(2)) as batch:
        for call in (lambda: batch.step(batch.frames.position, which=which), lambda: batch.reset(which=which)):
            with pytest.raises(ConfigurationError, match="different indices from 0 to 1 are expected"):
                call()
        assert batch.frames.time.tolist() == [0.0, 0.0]


@pytest.mark.parametrize("seeds", [[3, -1], ["x", 1], [1.5, 2]])
def test_a_wrong_seed_changes_no_robot(seeds: list[object]) -> None:
    pytest.importorskip("mujoco")
    with nao_hil.Batch([1, 2]) as batch:
        batch.step(batch.frames.position)
        with pytest.raises(ConfigurationError, match="a whole number from 0 on is expected"):
            batch.reset(seeds)  # type: ignore[arg-type]
        assert batch.frames.time.tolist() == [batch.cycle] * 2
    with pytest.raises(ConfigurationError, match="whole number from 0 on"):
        nao_hil.Batch(seeds)  # type: ignore[arg-type]


@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
def test_what_is_closed_says_so(engine: str) -> None:
    pytest.importorskip(engine)
    batch, robot = nao_hil.Batch([1, 2], engine=engine), nao_hil.Robot(engine=engine)
    position = batch.frames.position
    for _ in range(2):
        batch.close()
        robot.close()
    for call in (lambda: batch.step(position), batch.reset, robot.step, robot.reset, robot.picture):
        with pytest.raises(ConfigurationError, match="is closed; make a new one"):
            call()
