"""The front door: its names, the robot in process, a walk in process, recordings as arrays."""

from __future__ import annotations

import ast
import builtins
import math
import sys
import textwrap
from collections.abc import Callable, Mapping, Sequence
from inspect import getdoc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nao_hil
from nao_hil.analysis.inspection import inspect


def test_ten_names_at_most_each_with_a_docstring() -> None:
    assert len(nao_hil.__all__) <= 10
    for name in nao_hil.__all__:
        assert name in dir(nao_hil)
        assert getattr(nao_hil, name).__doc__
    for name in ("Robot", "walk", "connect", "load", "WalkClient", "WorldClient"):
        assert "Example:" in (getattr(nao_hil, name).__doc__ or ""), name
    with pytest.raises(AttributeError, match="Robott"):
        nao_hil.Robott  # noqa: B018


@pytest.mark.parametrize("name", sorted(set(nao_hil.__all__) - {"JOINTS", "NaoHilError"}))
def test_an_example_imports_what_it_uses(name: str) -> None:
    text = getdoc(getattr(nao_hil, name)) or ""
    example = text.split("```python\n")[1].split("```")[0]
    nodes = list(ast.walk(ast.parse(textwrap.dedent(example))))
    used = [node for node in nodes if isinstance(node, ast.Name)]
    made = {node.id for node in used if isinstance(node.ctx, ast.Store)}
    imported = {alias.name for node in nodes if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert {node.id for node in used} <= made | imported | {"nao_hil", *dir(builtins)}


def test_the_robot_takes_arrays_and_sequences_and_repeats_itself() -> None:
    with nao_hil.Robot("nao-v6", seed=1, wear="worn") as robot:
        assert robot.body == "nao-v6" and robot.cycle == pytest.approx(0.012)
        first = robot.frame
        position = np.array(first.position)
        position[0] += 0.1
        ways: Sequence[tuple[Any, Any]] = [(position, 0.7), (list(position), np.full(25, 0.7))]
        runs = [robot_frames(robot, *way) for way in ways]
        assert runs[0] == runs[1]
        assert runs[0][-1].position[0] > first.position[0] + 0.05
        assert robot.reset(seed=2) != first
        assert robot.reset(seed=1) == first
        assert robot.truth.seq == 0


def robot_frames(robot: nao_hil.Robot, position: Any, stiffness: Any) -> list[Any]:
    robot.reset()
    return [robot.step(position, stiffness) for _ in range(30)] + [robot.step()]


@pytest.mark.parametrize(
    ("position", "stiffness", "said"),
    [
        ([0.0] * 24, 1.0, "position has 24 values"),
        (np.zeros((5, 5)), 1.0, r"position has the shape \(5, 5\)"),
        (["a"] * 25, 1.0, "position is not made of numbers"),
        ([0.0, [0.0]] * 12, 1.0, "position is not made of numbers"),
        ([math.nan] * 25, 1.0, r"HeadYaw\): is nan"),
        (0.0, [*[1.0] * 24, 2.0], "stiffness of RHand is 2.0; it must be between -1 and 1"),
        (np.zeros(()), -5.0, "stiffness of HeadYaw is -5.0; it must be between -1 and 1"),
    ],
)
def test_a_wrong_command_is_one_sentence(position: Any, stiffness: Any, said: str) -> None:
    with nao_hil.Robot(wear="ideal") as robot, pytest.raises(nao_hil.NaoHilError, match=said):
        robot.step(position, stiffness)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: nao_hil.load(None), "file is None; the path of a file"),  # type: ignore[arg-type]
        (lambda: nao_hil.walk(steps=2, record=5), "record is 5; the path of a file"),  # type: ignore[arg-type]
        (lambda: nao_hil.walk(None, steps=2), "gait is None; a name"),  # type: ignore[arg-type]
        (lambda: nao_hil.walk(steps=2, seed=-1), "a whole number from 0 on"),
        (lambda: nao_hil.Robot(None), "body is None; a name"),  # type: ignore[arg-type]
        (lambda: nao_hil.Robot(seed=True), "A seed is True; a whole number"),
        (lambda: nao_hil.connect(5).__enter__(), "Endpoint 5 must be text"),  # type: ignore[arg-type]
        (lambda: nao_hil.connect(robot=5).__enter__(), "Robot id 5 must be"),  # type: ignore[arg-type]
        (lambda: nao_hil.connect(timeout=-1).__enter__(), "timeout is -1; seconds from 0 on"),
        (lambda: nao_hil.WorldClient(connect=None), "Endpoint None must be text"),  # type: ignore[arg-type]
        (lambda: nao_hil.WalkClient(connect_timeout=math.nan), "connect_timeout is nan; seconds from 0 on"),
    ],
)
def test_a_wrong_argument_is_one_sentence(call: Callable[[], object], said: str) -> None:
    with pytest.raises(nao_hil.NaoHilError, match=said):
        call()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, Path]:
    file = tmp_path_factory.mktemp("walk") / "walk.mcap"
    return nao_hil.walk("dynamic", steps=2, wear="ideal", torso="none", engine="mujoco", record=file), file


def test_a_recording_is_arrays(recorded: tuple[Any, Path]) -> None:
    summary, file = recorded
    assert inspect(file).frames_sha256 == summary.frames_sha256
    recording = nao_hil.load(file)
    assert isinstance(recording, Mapping) and recording.config["gait"] == "dynamic"
    sensors, truth = recording["sensors"], recording["world/truth"]
    assert sensors["position"].shape == (summary.cycles + 1, 25) and sensors.rows == summary.cycles + 1
    assert f"sensors: {sensors.rows} rows of seq, time (s), position (25, rad)" in repr(recording)
    assert repr(sensors) in repr(recording).splitlines()[0]
    for wrong in (lambda: recording["sensor"], lambda: sensors["postion"]):
        with pytest.raises(KeyError, match=r"unknown (table|column) '\w+' \(did you mean '(sensors|position)'"):
            wrong()
    assert "nothing" not in recording and recording.get("sensor") is None
    np.testing.assert_allclose(sensors["time"], 0.01 * sensors["seq"], atol=1e-9)
    assert truth["left.force"].shape == (truth.rows, 3)
    both = truth["left.force"][:, 2] + truth["right.force"][:, 2]
    assert np.median(both) == pytest.approx(np.median(sensors["fsr"].sum(axis=1)), rel=0.05)
    assert truth["zmp"].dtype == np.float64 and set(recording["walk/telemetry"]["phase"]) >= {"SSL", "SSR"}


def test_tables_become_data_frames_where_pandas_is(
    recorded: tuple[Any, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    class DataFrame(dict[str, Any]):
        def set_index(self, name: str) -> DataFrame:
            assert name in self
            return self

    class Pandas:
        pass

    Pandas.DataFrame = DataFrame  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "pandas", Pandas)
    table = nao_hil.load(recorded[1])["sensors"]
    frame = table.to_pandas()
    assert (frame["position.LKneePitch"] == table["position"][:, nao_hil.JOINTS.index("LKneePitch")]).all()
    assert {"fsr.RRR", "missed", "gyroscope.z"} <= set(frame)
