"""The environments against gymnasium's own checker, single robots and the frames they are made of."""

import math
from collections.abc import Iterator
from importlib.util import find_spec

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import AutoresetMode  # noqa: E402

from bridge.body import load_body  # noqa: E402
from bridge.errors import ConfigurationError  # noqa: E402
from nao_hil.envs import TASKS  # noqa: E402
from nao_hil.envs.tasks import (  # noqa: E402
    LEGS,
    POSTURE,
    ServosTask,
    Task,
    VelocityTask,
)

pytestmark = pytest.mark.skipif(not find_spec("mujoco"), reason="MuJoCo is not installed")


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Episodes of a tenth of a second."""
    monkeypatch.setattr(Task, "SECONDS", 0.1)
    yield


@pytest.mark.parametrize(
    ("name", "engine"), [*((name, "mujoco") for name in TASKS), ("NaoHil-Velocity-v0", "pybullet")]
)
def test_gymnasiums_checker_finds_nothing(name: str, engine: str) -> None:
    """Any warning is an error here. What draws nothing is left out: a machine may have no EGL."""
    if not find_spec(engine):
        pytest.skip(f"{engine} is not installed")
    env = gymnasium.make(name, engine=engine)
    check_env(env.unwrapped, skip_render_check=True)
    env.close()


@pytest.mark.parametrize("name", ["NaoHil-Servos-v0", "NaoHil-Velocity-v0"])
def test_equal_seeds_give_equal_trajectories(name: str) -> None:
    runs = []
    for seed in (1, 1, 2):
        with gymnasium.make(name, engine="mujoco", wear="worn") as env:
            env.action_space.seed(5)
            run = [env.reset(seed=seed)[0]]
            run += [env.step(env.action_space.sample())[0] for _ in range(8)]
            run.append(env.reset()[0])
            runs.append(np.array(run))
    np.testing.assert_array_equal(runs[0], runs[1])
    assert not np.array_equal(runs[0], runs[2])


@pytest.mark.parametrize("name", ["NaoHil-Servos-v0", "NaoHil-Velocity-v0"])
def test_a_vector_environment_is_many_single_ones(name: str, short: None) -> None:
    vector = gymnasium.make_vec(name, num_envs=3, vectorization_mode="vector_entry_point", threads=2)
    singles = [gymnasium.make(name, engine="mujoco").unwrapped for _ in range(3)]
    vector.action_space.seed(0)
    rows, _ = vector.reset(seed=10)
    for i, env in enumerate(singles):
        np.testing.assert_array_equal(rows[i], env.reset(seed=10 + i)[0])
    ended = [False] * 3
    for _ in range(12):
        actions = vector.action_space.sample()
        rows, rewards, terminated, truncated, infos = vector.step(actions)
        for i, env in enumerate(singles):
            if ended[i]:
                row, reward, over, cut = env.reset()[0], 0.0, False, False
            else:
                row, reward, over, cut, info = env.step(actions[i])
                np.testing.assert_array_equal(infos["com"][i], info["com"])
            np.testing.assert_array_equal(rows[i], row)
            assert (rewards[i], terminated[i], truncated[i]) == (reward, over, cut)
            ended[i] = over or cut
    vector.close()
    for env in singles:
        env.close()


def test_an_observation_is_the_sensor_frame_and_the_truth_is_in_info() -> None:
    with gymnasium.make("NaoHil-Velocity-v0", engine="mujoco", wear="worn") as env:
        env.reset(seed=3)
        observation, _, _, _, info = env.step(np.zeros(len(LEGS), dtype=np.float32))
        robot, task = env.unwrapped.robot, env.unwrapped.task
        measured = np.concatenate([getattr(robot.frame, name) for name in task.MEASURED])
        np.testing.assert_allclose(observation[:-3], measured, rtol=1e-6)
        np.testing.assert_allclose(observation[-3:], task.wanted, rtol=1e-6)
        np.testing.assert_array_equal(info["com"], robot.truth.com)
        assert not np.array_equal(observation[:25], np.float32(info["joints"]))


def test_actions_are_ranges_of_joints_and_angles_about_the_posture() -> None:
    body = load_body("nao-v6")
    angles, stiffness = ServosTask(body).command(np.array([-1.0] * 12 + [1.0] * 13 + [0.25] * 25))
    assert angles[0] == body.joints["HeadYaw"].lower
    assert angles[17] == pytest.approx(body.joints["RAnkleRoll"].upper)
    assert set(stiffness) == {0.25}
    angles, _ = VelocityTask(body).command(np.eye(len(LEGS))[0])
    assert np.flatnonzero(angles - POSTURE).tolist() == [LEGS[0]]


@pytest.mark.parametrize("velocity", [0.1, (0.1, 0.0), (math.nan, 0.0, 0.0), "abc", (9.0, 0.0, 0.0)])
def test_a_velocity_that_is_none_is_one_sentence(velocity: object) -> None:
    with pytest.raises(ConfigurationError, match="three numbers are expected"):
        gymnasium.make("NaoHil-Velocity-v0", velocity=velocity)


def test_wrong_arguments_are_one_sentence() -> None:
    with pytest.raises(ConfigurationError, match="VelocityTask has no argument `velocty`; it has velocity"):
        gymnasium.make("NaoHil-Velocity-v0", velocty=(0.1, 0.0, 0.0))
    with pytest.raises(ConfigurationError, match="no argument `render_mode`"):
        gymnasium.make_vec(
            "NaoHil-Servos-v0", num_envs=1, render_mode="rgb_array", vectorization_mode="vector_entry_point"
        )
    for mode in (AutoresetMode.SAME_STEP, AutoresetMode.DISABLED, "SameStep"):
        with pytest.raises(ConfigurationError, match=r"autoreset_mode is .*NEXT_STEP"):
            gymnasium.make_vec(
                "NaoHil-Servos-v0",
                num_envs=1,
                vectorization_mode="vector_entry_point",
                autoreset_mode=mode,
            )
    with pytest.raises(ConfigurationError, match=r"robot is .*a name is expected"):
        gymnasium.make("NaoHil-Servos-v0", robot=["nao-v3", "nao-v6"])
    for n in (0, -1):
        with pytest.raises(ConfigurationError, match=f"num_envs is {n}; a number from 1 on"):
            gymnasium.make_vec("NaoHil-Servos-v0", num_envs=n, vectorization_mode="vector_entry_point")
