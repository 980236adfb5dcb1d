"""The torso controllers that the walker loads: designed anew from the inputs beside them, and the command."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bridge.config import load_toml
from bridge.errors import ConfigurationError
from nao_hil.cli.main import run
from nao_hil.design.torso.records import CYCLES, design_torso, shipped_inputs
from nao_hil.design.torso.robust import robust_design
from nao_hil.design.torso.thesis import thesis_design
from nao_hil.design.torso.transfer import thesis_plant
from nao_hil.runs.config import RunConfig
from walker.gaits import GAITS
from walker.mechanisms.torso_control import TorsoController
from walker.parameters import controller_parameters


def numbers(controller: TorsoController) -> list[float]:
    return [
        controller.sample_time,
        controller.integral_gain,
        controller.reset_time,
        *controller.notch_numerator,
        *controller.notch_denominator,
    ]


@pytest.mark.parametrize("gait", GAITS)
def test_designed_anew_by_the_thesis_method_the_numbers_are_the_shipped_ones(gait: str) -> None:
    inputs, records = shipped_inputs(gait, {}), controller_parameters(gait).torso_design.thesis
    assert [record.controller.sample_time for record in records] == list(CYCLES)
    for record in records:
        assert (record.plant, record.specification) == (inputs.plant, inputs.thesis)
        design = thesis_design(thesis_plant(), record.specification, record.controller.sample_time)
        assert numbers(record.controller) == pytest.approx(numbers(design.controller), rel=1e-9)


def test_designed_anew_the_robust_numbers_are_the_shipped_ones() -> None:
    """The search stops within 1e-3 of its parameters' logarithms, elsewhere with another SciPy or processor."""
    records = controller_parameters("static").torso_design.robust
    for gait in GAITS:
        assert controller_parameters(gait).torso_design.robust == records
    designed = design_torso(shipped_inputs("static", {})).records.robust
    for old, new in zip(records, designed, strict=True):
        assert (old.plant, old.specification) == (new.plant, new.specification)
        assert numbers(old.controller) == pytest.approx(numbers(new.controller), rel=1e-2)


def test_a_cycle_time_without_a_design_is_refused_with_the_command() -> None:
    designs = controller_parameters("static").torso_design
    assert designs.controller("robust", 0.012).sample_time == 0.012
    with pytest.raises(ConfigurationError, match=r"nao-hil design torso --cycle 0\.02"):
        designs.controller("robust", 0.02)


def test_the_command_writes_a_file_that_the_walker_takes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "torso.toml"
    changes = ["--set", "thesis.rise_time=0.45", "--set", "robust.spread=0.1", "--cycle", "0.02"]
    assert run(["design", "torso", "--gait", "dynamic", *changes, "--out", str(file), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["gait"] == "dynamic" and [row["method"] for row in result["designs"]] == ["thesis", "robust"]
    assert result["designs"][0]["crossover"] == pytest.approx(1.2 / 0.45, rel=1e-6)
    designs = controller_parameters("dynamic", load_toml(file, RunConfig).controller).torso_design
    assert designs.thesis[0].specification.rise_time == 0.45
    expected = robust_design(thesis_plant(), designs.robust[0].specification, 0.02)
    assert designs.controller("robust", 0.02) == expected.controller


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--set", "thesis.rise=0.4"], "unknown key 'thesis.rise'"),
        (["--set", "theses.rise_time=0.4"], "unknown key 'theses.rise_time'"),
        (["--set", "thesis.rise_time=0"], "it must be positive"),
        (["--set", "thesis.rise_time=0.1", "--cycle", "0.01"], "no PI controller reaches"),
        (["--gait", "statc"], "unknown gait 'statc'"),
        (["--cycle", "0.01", "--out", "/no/such/folder/x.toml"], "cannot be written"),
    ],
)
def test_mistakes_end_in_one_sentence(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["design", "torso", *arguments]) == 2
    error = " ".join(capsys.readouterr().err.split())
    assert sentence in error and "Traceback" not in error
