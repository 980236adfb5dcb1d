"""The front door: its names, the robot in process, a walk in process, recordings as arrays."""

from __future__ import annotations

import ast
import builtins
import math
import subprocess
import sys
import textwrap
from collections.abc import Mapping, Sequence
from inspect import getdoc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nao_hil
from nao_hil.analysis.inspection import inspect
from tests.loops import TIMEOUT

REPOSITORY = Path(__file__).parents[2]


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
    example = text.split("Example:\n")[1].split("\n\n")[0]
    nodes = list(ast.walk(ast.parse(textwrap.dedent(example))))
    used = [node for node in nodes if isinstance(node, ast.Name)]
    made = {node.id for node in used if isinstance(node.ctx, ast.Store)}
    imported = {alias.name for node in nodes if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert {node.id for node in used} <= made | imported | {"nao_hil", *dir(builtins)}


def test_the_import_loads_no_library() -> None:
    heavy = ["numpy", "scipy", "pybullet", "zenoh", "msgspec", "bridge"]
    script = f"import sys, nao_hil; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=REPOSITORY, capture_output=True, text=True, timeout=TIMEOUT
    )
    assert done.stdout == "[]\n"


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


@pytest.mark.parametrize("wrong", [[0.0] * 24, np.zeros((5, 5)), ["a"] * 25, [math.nan] * 25])
def test_a_wrong_command_is_one_sentence(wrong: Any) -> None:
    with nao_hil.Robot(wear="ideal") as robot, pytest.raises(nao_hil.NaoHilError, match="position"):
        robot.step(wrong)


def test_a_walk_has_an_end() -> None:
    with pytest.raises(nao_hil.NaoHilError, match="needs an end"):
        nao_hil.walk(steps=0)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, Path]:
    file = tmp_path_factory.mktemp("walk") / "walk.mcap"
    return nao_hil.walk("dynamic", steps=2, wear="ideal", torso="none", record=file), file


def test_a_recording_is_arrays(recorded: tuple[Any, Path]) -> None:
    summary, file = recorded
    assert inspect(file).frames_sha256 == summary.frames_sha256
    recording = nao_hil.load(file)
    assert isinstance(recording, Mapping) and recording.config["gait"] == "dynamic"
    sensors, truth = recording["sensors"], recording["world/truth"]
    assert sensors["position"].shape == (summary.cycles + 1, 25) and sensors.rows == summary.cycles + 1
    assert f"sensors: {sensors.rows} rows of seq, time, position (25)" in repr(recording)
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
    monkeypatch.setitem(sys.modules, "pandas", Pandas)  # type: ignore[arg-type]
    table = nao_hil.load(recorded[1])["sensors"]
    frame = table.to_pandas()
    assert (frame["position.LKneePitch"] == table["position"][:, nao_hil.JOINTS.index("LKneePitch")]).all()
    assert {"fsr.7", "missed", "gyroscope.2"} <= set(frame)


def test_without_pandas_a_sentence_says_so(recorded: tuple[Any, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    def no_pandas(name: str, *rest: Any) -> Any:
        if name == "pandas":
            raise ImportError
        return importing(name, *rest)

    importing = builtins.__import__
    table = nao_hil.load(recorded[1])["sensors"]
    monkeypatch.setattr(builtins, "__import__", no_pandas)
    with pytest.raises(nao_hil.NaoHilError, match="pip install pandas"):
        table.to_pandas()
