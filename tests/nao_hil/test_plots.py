"""The named plots: their numbers against closed forms, and that each is drawn of what was recorded."""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.spatial import ConvexHull

from bridge.body import load_body
from bridge.body.joints import N_JOINTS
from bridge.body.postures import POSTURES
from bridge.errors import ConfigurationError
from bridge.messages import ActuatorFrame, Contact, Notice
from bridge.recording.recorder import Recorder
from nao_hil.analysis.plots import PLOTS
from nao_hil.analysis.plots.balance_figures import torso
from nao_hil.analysis.plots.draw import FIGURES, draw, missing
from nao_hil.analysis.plots.motion_figures import cycle
from nao_hil.analysis.plots.time_axes import explain_marks, fit_to_walk
from nao_hil.runs.run import Run, load
from tests.frames import standing_frame, truth_frame, walk_telemetry

BODY = load_body("nao-v3")
HEADING = math.radians(30.0)
CYCLES = 60
CONTACT = Contact(force=(0.0, 0.0, 24.0), cop=(0.02, 0.0))


def record(path: Path, *, robot_alone: bool = False) -> Path:
    """A robot that faces 30 degrees left of the world's x axis and glides forwards with 0.1 m/s."""
    joints = POSTURES["StandInit"]
    turned = (0.0, 0.0, math.sin(HEADING / 2), math.cos(HEADING / 2))
    with Recorder(path, {"robot": "nao-v3"}) as recorder:
        for k in range(CYCLES):
            time, x = k * BODY.cycle, 0.1 * k * BODY.cycle
            place = (1.0 + x * math.cos(HEADING), 2.0 + x * math.sin(HEADING))
            recorder.write(
                standing_frame(k, time=time, position=joints, fsr=(6.0,) * 8, angle=(0.01, 0.02), command=k - 1)
            )
            if robot_alone:
                continue
            at = {"torso_position": (*place, 0.3), "torso_orientation": turned, "com": (*place, 0.25)}
            at |= {"torso_velocity": (0.1, 0.0, 0.0), "zmp": place if k % 10 else None, "fell": k > 50}
            recorder.write(truth_frame(k, joints=joints, left=CONTACT, right=CONTACT, **at))
            plan = {"phase": "SSL" if k < 30 else "DSR", "zmp": (0.02, 0.05), "com": (0.02 + x, 0.0)}
            plan |= {"right": (0.0, -0.05, 0.01 if k < 30 else 0.0, 0.0, 0.0, 0.0)}
            recorder.write(walk_telemetry(k, zmp_measured=(0.03, 0.05) if k else None, **plan))
            recorder.write(ActuatorFrame(reply_to=k, position=joints, stiffness=(1.0,) * N_JOINTS))
            if k == 20:
                recorder.write(Notice(seq=k, level="info", code="push", text="A push."))
    return path


@pytest.fixture(scope="module")
def walk(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return load(record(tmp_path_factory.mktemp("plots") / "walk.mcap"))


def lines(walk: Run, name: str, axis: int = 0) -> dict[str, np.ndarray]:
    figure = Figure()
    FIGURES[name][0](walk, figure)
    return {str(line.get_label()): line.get_xydata() for line in figure.axes[axis].lines}  # type: ignore[misc]


def test_the_truth_is_drawn_in_the_walk_frame(walk: Run) -> None:
    """Forwards at 0.1 m/s from where the plan has the centre of mass, whatever the heading in the world."""
    along, across = (lines(walk, "com", axis)["ground truth"] for axis in (0, 1))
    time = np.arange(CYCLES) * BODY.cycle
    np.testing.assert_allclose(along, np.column_stack([time, 20.0 + 100.0 * time]), atol=1e-9)
    np.testing.assert_allclose(across[:, 1], 0.0, atol=1e-9)
    assert len(lines(walk, "path")["torso, ground truth"]) == 51  # up to the fall


def test_the_margin_is_the_distance_to_the_sole_s_edge(walk: Run) -> None:
    """On the left foot alone: the convex outline's nearest edge to the point 30 mm ahead of the ankle."""
    drawn = lines(walk, "margin")["ZMP from the foot sensors"]
    edges = ConvexHull(np.array(BODY.foot.sole)).equations  # outward normals, offsets
    nearest = -(edges[:, :2] @ (0.03, 0.0) + edges[:, 2]).max()
    assert math.isnan(drawn[0, 1])
    np.testing.assert_allclose(drawn[1:30, 1], 1e3 * nearest, rtol=1e-6)
    assert (drawn[30:, 1] > drawn[1, 1] - 1e-9).all()  # two feet are no smaller than one


def test_angles_forces_and_ages(walk: Run) -> None:
    np.testing.assert_allclose(lines(walk, "torso", 1)["fused angle of the robot"][:, 1], math.degrees(0.02))
    np.testing.assert_allclose(lines(walk, "torso", 1)["ground truth"][:, 1], 0.0, atol=1e-9)
    np.testing.assert_allclose(lines(walk, "fsr")["left foot"][:, 1], 24.0)
    np.testing.assert_allclose(lines(walk, "error")["measured less asked for"][:, 1], 0.0)
    figure = Figure()
    cycle(walk, figure)
    np.testing.assert_allclose(figure.axes[0].lines[-1].get_ydata()[1:], 1.0)


@pytest.mark.parametrize("name", PLOTS)
def test_each_plot_is_written(walk: Run, name: str, tmp_path: Path) -> None:
    draw([(walk, "walk.mcap")], name, tmp_path / "plot.svg")
    root = ElementTree.parse(tmp_path / "plot.svg").getroot()
    assert root.tag.endswith("svg")


def test_a_robot_without_truth_and_telemetry_has_plots_too(tmp_path: Path) -> None:
    alone = load(record(tmp_path / "alone.mcap", robot_alone=True))
    drawn = {name for name in PLOTS if not missing(alone, name)}
    assert drawn == set(["torso", "fsr", "cells", "joints", "current", "imu", "path", "cycle"])
    with pytest.raises(ConfigurationError, match="nothing of walk/telemetry was recorded"):
        draw([(alone, "alone.mcap")], "zmp", tmp_path / "no.png")
    draw([(alone, "alone.mcap")], "torso", tmp_path / "torso.png")
    assert (tmp_path / "torso.png").read_bytes().startswith(b"\x89PNG")
    assert not (tmp_path / "no.png").exists()


def lying(path: Path, *, from_: int, up: int = 1000, turn: float = 0.0) -> Run:
    """Four seconds of a robot that turns about the vertical, rad/s, and lies from one cycle up to another."""
    with Recorder(path, {"robot": "nao-v3"}) as recorder:
        for k in range(400):
            down, yaw = from_ <= k < up, turn * k * BODY.cycle
            roll = 1.5 if from_ - 20 <= k < up else 0.02 * math.sin(0.3 * k)
            recorder.write(standing_frame(k, time=k * BODY.cycle, angle=(roll, 0.01 * math.cos(k))))
            turned = (0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw))
            recorder.write(
                truth_frame(
                    k, time=k * BODY.cycle, torso_orientation=turned, left=CONTACT, right=CONTACT, fell=down
                )
            )
    return load(path)


@pytest.mark.parametrize(("up", "end"), [(1000, 2.3), (260, 4.0)])
def test_a_plot_ends_after_the_last_fall_and_shows_the_range_of_a_robot_on_its_feet(
    tmp_path: Path, up: int, end: float
) -> None:
    walk, figure = lying(tmp_path / "fall.mcap", from_=180, up=up), Figure()
    torso(walk, figure)
    fit_to_walk(walk, figure)
    explain_marks(walk, figure)
    low, high = figure.axes[0].get_ylim()
    assert math.degrees(0.0199) <= high < 2.0 and -2.0 < low <= -math.degrees(0.0199)
    assert figure.axes[0].get_xlim()[1] == pytest.approx(end, abs=0.3 if up < 400 else 0.01)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["fall"]


def test_a_heading_past_half_a_turn_draws_no_jump(tmp_path: Path) -> None:
    walk, figure = lying(tmp_path / "turn.mcap", from_=1000, turn=2.0), Figure()
    torso(walk, figure)
    heading = next(line for line in figure.axes[2].lines if line.get_label() == "ground truth").get_ydata()
    np.testing.assert_allclose(np.diff(heading), math.degrees(2.0 * BODY.cycle), rtol=1e-6)
