"""Learned gaits at the command line, in stored walks and in comparisons; the shipped policy."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nao_hil
from bridge.errors import ConfigurationError, WalkRefused
from bridge.messages.walk import WalkCommand
from nao_hil.analysis.statistics import wilson
from nao_hil.cli.main import run
from nao_hil.experiments.policies import POLICIES
from nao_hil.runs.config import RunConfig, run_config
from nao_hil.runs.store import key
from nao_hil.runs.walk import Walk, WalkEnd, walk
from tests.made_walks import MadeCampaign, made_context, walk_end
from tests.policies import LEGS, sheet, write_policy
from walker.gaits import gait_parameters
from walker.service import WalkService


def up(
    gait: str, folder: Path, capsys: pytest.CaptureFixture[str], *options: str
) -> tuple[int, dict[str, Any]]:
    command = ["up", "--mode", "in-process", "--engine", "mujoco", "--gait", gait, "--duration", "1", "--json"]
    code = run([*command, "--out", str(folder / "run")])
    return code, json.loads(capsys.readouterr().out.splitlines()[-1])


def test_a_walk_tells_how_often_and_how_long_the_network_was_called(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, data = up(write_policy(tmp_path, sheet(cycle=0.02)), tmp_path, capsys)
    assert (code, data["failure"], data["fell"]) == (0, "", False)
    calls = data["inference"]
    assert calls["count"] == pytest.approx(100, abs=20)  # 1 s of the walk, and 1 s of its stop
    assert 0.0 < calls["p50"] <= calls["p99"] <= calls["max"]


def test_a_failed_policy_ends_with_code_3_and_its_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bias = np.zeros(len(LEGS))
    bias[LEGS.index("RKneePitch")] = math.nan
    name = write_policy(tmp_path, sheet(), np.zeros((3, len(LEGS))), bias)
    code, data = up(name, tmp_path, capsys)
    assert code == 3
    assert "RKneePitch" in data["failure"] and "LKneePitch" not in data["failure"]
    assert not data["fell"] and data["stands"]


def test_a_failed_policy_has_not_walked_on_however_short_the_walk(tmp_path: Path) -> None:
    name = write_policy(tmp_path, sheet(), np.zeros((3, len(LEGS))), np.full(len(LEGS), math.nan))
    config = RunConfig(robot="nao-v6", gait=name, engine="mujoco")
    end = walk(Walk(name="", config=config, duration=0.5, keep_track=False)).end
    assert (end.ending, end.survived) == ("gave up", False)


def test_a_walker_in_process_says_why_its_last_walk_ended(tmp_path: Path) -> None:
    name = write_policy(tmp_path, sheet(), np.zeros((3, len(LEGS))), np.full(len(LEGS), math.nan))
    with nao_hil.World(engine="mujoco") as world:
        world.add("nao-v6", name="a")
        world.add_walker("a", name)
        for _ in range(2):  # a new order tries again
            world.order("a", WalkCommand(op="walk"))
            for _ in range(400):
                world.step()
            status = world.order("a", WalkCommand(op="status"))
            assert "not finite" in status.failure and status.failure in status.text
        world.order("a", WalkCommand(op="walk", gait="omni"))
        for _ in range(400):
            world.step()
        status = world.order("a", WalkCommand(op="status"))
        assert (status.state, status.failure) == ("walk", "")


def test_the_path_of_a_sheet_counts_from_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = write_policy(tmp_path, sheet())
    monkeypatch.chdir(tmp_path)
    assert run_config(None, gait="onnx:policy.toml").gait == name
    assert run_config(None, gait="onnx:imitation").gait == "onnx:imitation"
    with pytest.raises(ConfigurationError, match="SHEET"):
        run_config(None, gait="omny")


def test_a_shown_configuration_is_the_same_gait_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["config", "show", "--gait", "onnx:imitation"]) == 0
    (tmp_path / "run.toml").write_text(capsys.readouterr().out)
    settings = run_config(tmp_path / "run.toml")
    assert gait_parameters(settings.gait, settings.parameters) == gait_parameters("onnx:imitation")


def test_a_walk_command_names_no_file_of_the_walkers_machine(tmp_path: Path) -> None:
    own, other = write_policy(tmp_path, sheet()), "onnx:/etc/other.toml"
    service = WalkService(own)
    assert service._changed_request(WalkCommand(op="walk", gait="omni")).gait == "omni"
    assert service._changed_request(WalkCommand(op="walk", gait=own)).gait == own
    with pytest.raises(WalkRefused, match="omni"):
        service._changed_request(WalkCommand(op="walk", gait=other))


def test_a_stored_walk_depends_on_the_network(tmp_path: Path) -> None:
    task = Walk(name="", config=RunConfig(gait=write_policy(tmp_path, sheet())), duration=1.0)
    before = key(task)
    assert key(task) == before
    write_policy(tmp_path, sheet(), np.full((3, len(LEGS)), 0.01))
    assert key(task) != before


def test_each_gait_walks_the_same_courses_and_is_paired_with_the_first(tmp_path: Path) -> None:
    def end(task: Walk) -> WalkEnd:
        tires = task.config.gait == "dynamic" and task.config.wear == "worn"
        return walk_end("fell" if tires else "walked", distance=1.2)

    campaign = MadeCampaign(end)
    context = made_context(campaign, tmp_path, range(20), gait="omni,dynamic")
    outcome = POLICIES.run("policies", context)
    courses: dict[str, dict[str, set[str]]] = {}
    for task in campaign.asked:
        _, course, gait = task.name.split(", ")
        world = repr((task.scenario, task.wear, task.config.wear, task.config.seed, task.duration))
        courses.setdefault(course, {}).setdefault(gait, set()).add(world)
    assert all(by_gait["omni"] == by_gait["dynamic"] for by_gait in courses.values())
    worlds = [frozenset(by_gait["omni"]) for by_gait in courses.values()]
    assert len(set(worlds)) == len(courses) == 8 and all(len(each) == 20 for each in worlds)
    found = outcome.figures
    assert (found["pairs"]["worn"]["dynamic"].only_with, found["pairs"]["slope"]["dynamic"].both) == (20, 20)
    assert found["courses"]["worn"]["dynamic"].interval == wilson(0, 20)
    assert all(claim.holds for claim in outcome.page.claims) and len(outcome.page.claims) == 2
    with pytest.raises(ConfigurationError, match="twice"):
        POLICIES.run("policies", made_context(campaign, tmp_path, range(2), gait="omni,omni"))


@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
def test_the_shipped_policy_walks_ahead(engine: str) -> None:
    if engine == "pybullet":
        pytest.importorskip("pybullet")
    config = RunConfig(gait="onnx:imitation", engine=engine, velocity=(0.08, 0.0, 0.0), seed=31)  # type: ignore[arg-type]
    end = walk(Walk(name="", config=config, duration=6.0, keep_track=False)).end
    assert end.survived
    assert 0.5 * 0.08 < end.speed < 1.5 * 0.08
