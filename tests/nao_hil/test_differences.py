"""Differences of two runs: values in force, events, and the curves of `plot`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from matplotlib.figure import Figure

from bridge.body.postures import POSTURES
from bridge.config import read_toml
from bridge.messages import Notice
from bridge.recording.recorder import Recorder
from nao_hil.analysis.differences import config_differences, event_differences, titles
from nao_hil.analysis.plots.difference import draw_difference
from nao_hil.cli.main import run
from nao_hil.runs.config import RunConfig
from tests.frames import standing_frame
from walker.gaits.catalogue import gait_file

Config = dict[str, Any] | None
"""Settings that differ from the defaults; None: a recording of a robot on the link."""


def recorded(folder: Path, name: str, config: Config, pushed: int | None = None) -> Path:
    """Half a second of a robot that stands, pushed at a cycle."""
    file = folder / name / "frames.mcap"
    file.parent.mkdir()
    whole = {"robot": "nao-v3", "side": "real"} if config is None else msgspec.to_builtins(RunConfig()) | config
    with Recorder(file, whole) as recorder:
        for k in range(50):
            position = [angle + 0.001 * (k if pushed else 0) for angle in POSTURES["StandInit"]]
            recorder.write(standing_frame(k, time=0.01 * k, position=tuple(position), fsr=(6.0,) * 8))
            if k == pushed:
                recorder.write(Notice(seq=k, level="info", code="world", text="pushed"))
    return file


def differing(
    folder: Path, first: dict[str, Any] | None, second: dict[str, Any] | None
) -> dict[str, list[Any]]:
    return config_differences(recorded(folder, "a", first), recorded(folder, "b", second))


def test_a_value_that_is_set_stands_beside_the_default_in_force(tmp_path: Path) -> None:
    shipped = read_toml(gait_file("omni", "control.toml"))["damping"]["roll"]
    second = {"controller": {"damping": {"roll": 0.07}}, "velocity": [0.123, 0.0, 0.0], "start": "sit"}
    found = differing(tmp_path, {}, second)
    velocity = found.pop("velocity")
    assert velocity[1] == [0.123, 0.0, 0.0] and all(isinstance(number, float) for number in velocity[0])
    assert found == {"start": ["stand", "sit"], "controller.damping.roll": [shipped, 0.07]}


def test_events_of_one_run_only_are_named(tmp_path: Path) -> None:
    first, second = (
        recorded(tmp_path, "a", {}),
        recorded(tmp_path, "b", {"scenario": "/away/ice.toml"}, pushed=20),
    )
    alone = event_differences(first, second)
    assert alone[0] == [] and [time for time, text in alone[1] if text == "pushed"] == [
        pytest.approx(0.2, abs=0.011)
    ]
    assert event_differences(second, second) == []
    later = event_differences(second, recorded(tmp_path, "c", {}, pushed=30))
    assert ["pushed" in [text for _, text in events] for events in later] == [True, True]
    lines = titles(config_differences(first, second), alone)
    assert lines[0] == "they differ in scenario (flat, ice.toml)" and "only in the second: " in lines[1]


def test_the_difference_is_drawn_on_common_time_up_to_a_fall() -> None:
    """A second run that is 2 higher and starts half a second later: 2 on the time that both have."""
    figures = [Figure(), Figure()]
    for figure, begin, level in zip(figures, (0.0, 0.5), (1.0, 3.0), strict=True):
        curves, marks = figure.subplots(2, 1, sharex=True)
        time = np.arange(begin, 4.0, 0.02 + 0.01 * begin)
        curves.plot(time, level + np.sin(time), label="angle")
        curves.axvline(1.0)
        marks.set_xlabel("time, s")
    panel = Figure()
    draw_difference(figures[0], figures[1], panel, end=3.0)
    (axes,) = panel.axes  # the one without curves is left out
    _, line = axes.lines
    time, values = (np.asarray(data, dtype=np.float64) for data in line.get_data())
    assert (time.min(), time.max()) == pytest.approx((0.5, 3.0), abs=0.021)
    assert values == pytest.approx(2.0, abs=1e-3)


def test_a_plot_of_two_runs_names_what_differs_and_draws_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = [str(recorded(tmp_path, "a", {})), str(recorded(tmp_path, "b", {"seed": 3}, pushed=20))]
    assert run(["plot", *runs, "--what", "torso,joints", "--format", "svg", "--json"]) == 0
    found = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert found["differences"]["config"] == {"seed": [0, 3]}
    for file in found["files"]:
        picture = Path(file).read_text()
        assert "second less first" in picture and "seed (0, 3)" in picture
    assert run(["diff", *runs, "--json"]) == 1
    assert json.loads(capsys.readouterr().out.splitlines()[-1])["config"] == {"seed": [0, 3]}
