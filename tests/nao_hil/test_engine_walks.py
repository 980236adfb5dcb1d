"""The same robot walks on both engines."""

import pytest

import nao_hil

pytest.importorskip("pybullet")
pytest.importorskip("mujoco")


@pytest.mark.parametrize(
    ("gait", "steps", "body"), [("static", 2, "nao-v3"), ("dynamic", 6, "nao-v3"), ("huang", 4, "nao-v3")]
)
def test_a_walk_is_as_fast_on_either_engine(gait: str, steps: int, body: str) -> None:
    bullet, mujoco = (
        nao_hil.walk(gait, body=body, seed=1, steps=steps, engine=engine) for engine in ("pybullet", "mujoco")
    )
    assert (bullet.engine, mujoco.engine) == ("pybullet", "mujoco")
    assert not bullet.fell and not mujoco.fell
    assert mujoco.steps == bullet.steps == steps
    assert mujoco.speed == pytest.approx(bullet.speed, rel=0.1)


def test_the_same_seed_gives_the_same_frames_on_mujoco() -> None:
    first, again, other = (
        nao_hil.walk("dynamic", seed=seed, steps=3, engine="mujoco").frames_sha256 for seed in (1, 1, 2)
    )
    assert first == again != other
