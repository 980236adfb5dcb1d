"""The identification experiment: the thesis' plant comes out of the mechanics."""

from pathlib import Path

import numpy as np
import pytest

from bridge.body import BODIES, load_body
from bridge.body.joints import INDEX
from bridge.errors import ConfigurationError
from nao_hil.experiments.torso_responses import one_leg_stance
from nao_hil.experiments.torso_step import run
from walker.model.com import CentreOfMass


@pytest.mark.parametrize("name", BODIES)
def test_the_stance_is_upright_over_the_left_foot(name: str) -> None:
    body = load_body(name)
    angles = one_leg_stance(body)
    com = CentreOfMass(body)
    feet = com.tree.link_frames(angles)
    left, right = feet["LAnkleRoll"], feet["RAnkleRoll"]
    np.testing.assert_allclose(left[:3, :3], np.eye(3), atol=1e-9)
    np.testing.assert_allclose((com(angles) - left[:3, 3])[:2], body.foot.centre, atol=1e-4)
    assert right[2, 3] - left[2, 3] > 0.03
    assert angles[INDEX["LKneePitch"]] == 0.0


def test_the_nominal_robot_answers_like_the_thesis_plant(tmp_path: Path) -> None:
    result = run([0], out=tmp_path)
    # (4.12): 7.0 rad/s, damping 0.10, zero 8 rad/s, gain 1, undershoot -0.30; rise 100 ms
    assert result["natural_frequency_rad_s"] == pytest.approx(7.0, rel=0.15)
    assert 0.07 < result["damping"] < 0.15
    assert result["zero_rad_s"] == pytest.approx(8.0, rel=0.25)
    assert result["gain"] == pytest.approx(1.0, abs=0.25)
    assert result["peak"] == pytest.approx(2.0, rel=0.1)  # as read off figure 4.10
    assert result["undershoot"] == pytest.approx(-0.30, abs=0.08)
    assert result["rise_time_s"] == pytest.approx(0.100, rel=0.25)
    assert result["residual_rms"] < 0.2  # the fused angle jumps where its filter switches
    assert (result["n"], result["fallen"]) == (3, 0)
    true = result["true"].natural_frequency_rad_s
    assert true == pytest.approx(result["natural_frequency_rad_s"], rel=0.05)
    assert (tmp_path / "torso-step.png").stat().st_size > 10_000


def test_a_wave_that_throws_the_robot_over_is_one_clear_sentence() -> None:
    with pytest.raises(ConfigurationError, match="No stance on one leg survived a wave of 15 deg"):
        run([0], amplitude=0.2618)
