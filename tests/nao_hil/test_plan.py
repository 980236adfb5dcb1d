"""`nao-hil plan`, the ground that the lab hands to a planner, and the study."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from bridge.body import load_body
from bridge.config import load_toml
from bridge.errors import ConfigurationError
from emulator.scenarios import Scenario, load_scenario
from emulator.scenarios.ground import PlacedBox, ScenarioFloor, Start
from nao_hil.cli.main import run
from nao_hil.runs.config import RunConfig
from nao_hil.runs.ground import known_ground
from walker.gaits import gait_parameters, make_gait
from walker.gaits.huang import HuangGait

BODY = load_body("nao-v3")
VALUES = ("T_c=0.4", "T_d=0.12", "T_m=0.25", "D_s=0.05", "y_d=0.016", "y_m=0.029")
QUICK = ("--grid", "4", *(f"--set={value}" for value in VALUES))
"""A short step, whose motion along x is searched on a coarse grid."""
NAMED = (*QUICK, "--set=x_sd=0.0187", "--set=x_ed=0.0153")
"""The same, nothing searched."""


def test_plan_writes_what_a_walk_takes_and_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """All parameters and the motion that was found, in a file for --config."""
    assert run(["plan", "--gait", "huang", *QUICK, "--plot", "--out", str(tmp_path / "out"), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    names = result["figures"]
    assert names == ["huang-margin.png", "huang-zmp.png", "huang-trajectories.png", "huang-sticks.png"]
    assert all((tmp_path / "out" / name).stat().st_size > 10_000 for name in names)
    assert result["step_length"] == 0.05 and 0.0 < result["x_sd"] < 0.025 and result["margin_m"] > 0.0
    config = load_toml(tmp_path / "out" / "config.toml", RunConfig)
    assert (config.robot, config.gait) == ("nao-v3", "huang")
    made = make_gait("huang", gait_parameters("huang", config.parameters), BODY)
    assert isinstance(made, HuangGait)
    assert made.choice._asdict() == {name: result[name] for name in ("x_sd", "x_ed", "y_d", "y_m")}
    assert made.parameters.T_c == 0.4 and "ground" not in config.parameters


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--gait", "static"], "nothing to search in the gait static"),
        (["--set", "x_sd=0.05"], "x_sd = 0.05 m violates bound (11) by 20.0 mm"),
        (["--set", "D_s"], "is not NAME=VALUE"),
        (["--set", "D_z=0.05"], "unknown key 'D_z'"),
        (["--set", "H_max=0.26"], "out of reach"),
    ],
)
def test_plan_refuses_with_one_sentence(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["plan", *arguments]) == 2
    error = capsys.readouterr().err
    assert sentence in error.replace("\n", " ") and "Traceback" not in error


def test_a_study_goes_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    optuna = pytest.importorskip("optuna")
    file = tmp_path / "study.db"
    margins = []
    for trials in (1, 1):
        assert run(["plan", *NAMED, "--trials", str(trials), "--study", str(file), "--json"]) == 0
        margins.append(json.loads(capsys.readouterr().out)["margin_m"])
    (name,) = optuna.get_all_study_names(f"sqlite:///{file}")
    trials_made = optuna.load_study(study_name=name, storage=f"sqlite:///{file}").trials
    assert len({tuple(trial.params.values()) for trial in trials_made}) == 2  # none twice
    # without trials: the best of what the file has
    assert run(["plan", *NAMED, "--study", str(file), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["margin_m"] == margins[1]
    assert margins[1] > margins[0] - 1e-3
    file.write_text("no study")
    assert run(["plan", *QUICK, "--trials", "1", "--study", str(file)]) == 2


def test_ground_of_a_scenario() -> None:
    """In the walk frame, whose origin is between the ankles of the robot at its start."""
    ground = known_ground(load_scenario("step"), BODY)
    (patch,) = ground.patches
    assert patch.height == 0.01
    assert patch.x[1] - patch.x[0] == pytest.approx(0.6)
    assert 0.40 < patch.x[0] < 0.42  # the ankles stand some 9 mm behind the torso
    shifted = known_ground(
        Scenario(start=Start(x=0.1), boxes=(PlacedBox(name="a", size=(0.6, 1.0, 0.01), at=(0.8, 0.0)),)), BODY
    )
    assert shifted.patches[0].x == pytest.approx(patch.x)
    assert known_ground(load_scenario("slope-5"), BODY).slope == pytest.approx(math.radians(-5.0))
    assert known_ground(load_scenario("flat"), BODY).flat
    lower = PlacedBox(name="lower", size=(1.2, 1.0, 0.01), at=(1.0, 0.0))
    upper = PlacedBox(name="upper", size=(0.6, 1.0, 0.01), at=(1.0, 0.0))
    stacked = known_ground(Scenario(boxes=(lower, upper)), BODY)
    assert [stacked.height(x, [0.0]) for x in (0.2, 0.6, 1.0, 1.5, 2.0)] == pytest.approx(
        [0.0, 0.01, 0.02, 0.01, 0.0]
    )
    movable = PlacedBox(name="b", size=(0.1, 0.1, 0.1), at=(0.5, 0.0), mass=0.3)
    assert known_ground(Scenario(boxes=(movable,)), BODY).flat


def test_ground_that_cannot_be_planned_for() -> None:
    def box(**changes: object) -> Scenario:
        values = {"name": "b", "size": (0.5, 0.5, 0.01), "at": (0.5, 0.0)} | changes
        return Scenario(boxes=(PlacedBox(**values),))  # type: ignore[arg-type]

    for scenario, sentence in (
        (Scenario(floor=ScenarioFloor(roll=3.0)), "floor.roll = 3 deg"),
        (Scenario(start=Start(yaw=10.0)), "start.yaw = 10 deg"),
        (box(yaw=30.0), "`b` is turned by 30 deg"),
        (box(size=(0.5, 0.5, 0.05)), "`b` is 50 mm high; steps of up to 30 mm"),
        (box(height=0.9), "`b` hangs 900 mm above the ground"),
    ):
        with pytest.raises(ConfigurationError, match=sentence):
            known_ground(scenario, BODY)
