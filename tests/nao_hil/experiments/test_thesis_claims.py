"""The thesis' own claims on a nominal robot (`experiment torso-drift`: twenty): thesis 4.2 and figure 4.9."""

from __future__ import annotations

from nao_hil.experiments.torso_control import SWITCHES, drift_per_step
from nao_hil.runs.config import RunConfig
from nao_hil.runs.walk import Walk, walk


def test_without_torso_control_the_static_gait_pitches_further_with_every_step_until_it_falls() -> None:
    """Figure 4.9: with the admittances alone the robot falls after about 20 s; torso control holds it."""
    outcomes = {
        name: walk(
            Walk(
                name=f"{name} torso control",
                config=RunConfig(
                    robot="nao-v3", engine="mujoco", gait="static", seed=500, controller={"switches": switches}
                ),
                duration=25.0,
            )
        )
        for name, switches in SWITCHES.items()
    }
    with_, without = outcomes["with"], outcomes["without"]
    assert without.end.ending == "fell" and without.end.pitch > 0.3
    growth, held = drift_per_step(without), drift_per_step(with_)
    assert growth is not None and held is not None
    assert growth > 1.0  # deg per step, forward
    assert abs(held) < 0.3 * growth
    assert with_.end.time > without.end.time
