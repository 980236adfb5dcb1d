"""Objects that move or come during a run, in recordings: as tables, on the page, and as Foxglove draws them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

import nao_hil
from bridge.body import load_body
from bridge.config import parse_toml
from bridge.messages.world import PlaceObject, Push, Remove
from bridge.recording.foxglove import RobotScene
from bridge.recording.recorder import Recorder
from emulator.engine.settings import SETTINGS
from emulator.robot import EmulatedRobot
from emulator.scenarios import Scenario
from emulator.world.world import LEAGUE_BALL, WOOD
from nao_hil.runs.run import Table
from nao_hil.view.recorded_run import recorded_rows
from nao_hil.view.rows import ROW_PERIOD
from tests.emulator.test_objects import way_of_a_pushed_ball
from tests.nao_hil.test_export_run import unpacked

BODY = load_body("nao-v6")
PUSHED = 100
"""Cycle at which the ball is pushed, with 1 m/s; a box is placed then, too."""
GONE = 200
"""Cycle at which the box is taken away."""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of a robot that stands beside a ball that rolls; a wall is there from the start, a post comes."""
    file = tmp_path_factory.mktemp("objects") / "frames.mcap"
    world = parse_toml('[[boxes]]\nname = "wall"\nsize = [0.1, 1.0, 0.5]\nat = [3.0, 0.0]', "world", Scenario)
    with (
        EmulatedRobot(BODY, engine="mujoco", seed=0, scenario=world) as robot,
        Recorder(file, {"robot": BODY.name}, lambda: RobotScene(BODY, None)) as recorder,
    ):
        send = robot.world_events.execute
        send(PlaceObject(name="ball", shape="ball", size=(0.1, 0.1, 0.1), mass=LEAGUE_BALL.mass, at=(0.5, 0.5)))
        send(PlaceObject(name="post", shape="pole", size=(0.1, 0.1, 0.8), at=(0.0, 1.5)))
        for cycle in range(450):
            recorder.sensors(robot.frame, robot.truth())
            if cycle == PUSHED:
                send(Push(target="ball", impulse=(LEAGUE_BALL.mass, 0.0, 0.0), duration=SETTINGS.step))
                send(PlaceObject(name="box", size=(0.1, 0.2, 0.3), mass=1.0, at=(1.0, -1.0)))
            if cycle == GONE:
                send(Remove(name="box"))
            robot.advance(None)
    return file


def of(table: Table, name: str) -> Table:
    return table.where(table["name"] == name)


def test_a_recorded_ball_rolls_as_the_closed_form_has_it(recording: Path) -> None:
    """It slides for 3 cm, rolls with 5/7 of its speed less the rolling friction, and rests after 0.86 m."""
    run = nao_hil.load(recording)
    ball = of(run["world/objects"], "ball")
    assert ball.rows == run["world/truth"].rows == 450
    assert set(ball["shape"]) == {"ball"} and (ball["size"] == 0.1).all()
    assert (ball.columns["position"].unit, ball.columns["position"].frame) == ("m", "world")
    way, time, rolling = way_of_a_pushed_ball(LEAGUE_BALL, 1.0, WOOD.friction)
    assert (way, rolling) == (pytest.approx(0.86, abs=0.01), pytest.approx(0.7, abs=0.03))
    begin = ball["time"][PUSHED]
    moved = ball["position"] - ball["position"][PUSHED]
    np.testing.assert_allclose(moved[-1], (way, 0.0, 0.0), atol=0.03 * way)
    speed = np.gradient(moved[:, 0], ball["time"])
    assert np.interp(begin + 0.11, ball["time"], speed) == pytest.approx(rolling, abs=0.02)
    assert speed[ball["time"] > begin + 1.05 * time].max() < 5e-3
    # where it rolls it turns by its way over its radius
    later = ball.where((ball["time"] > begin + 0.2) & (ball["time"] < begin + 1.0))
    before, after = later["orientation"][:-1], later["orientation"][1:]
    turns = 2.0 * np.arccos(np.abs((before * after).sum(axis=1)).clip(max=1.0))
    ways = np.diff(later["position"][:, 0])
    np.testing.assert_allclose(np.sum(turns), ways.sum() / LEAGUE_BALL.radius, rtol=0.02)


def test_an_object_that_comes_has_rows_while_it_is_there_and_a_fixed_one_of_the_scenario_has_none(
    recording: Path,
) -> None:
    run = nao_hil.load(recording)
    objects = run["world/objects"]
    assert set(objects["name"]) == {"ball", "box", "post"}
    post = of(objects, "post")
    assert post.rows == run["world/truth"].rows and set(post["mass"]) == {0.0}
    np.testing.assert_allclose(post["position"], np.tile((0.0, 1.5, 0.4), (post.rows, 1)), atol=1e-6)
    box = of(objects, "box")
    assert box["time"] == pytest.approx(BODY.cycle * np.arange(PUSHED + 1, GONE + 1))
    assert box["position"][-1] == pytest.approx((1.0, -1.0, 0.15), abs=1e-3)


def test_the_page_of_a_recording_has_the_objects_where_they_were(recording: Path) -> None:
    run = nao_hil.load(recording)
    header, tables = unpacked(recorded_rows(run, "", None))
    names = [thing["name"] for thing in header["objects"] if thing["moves"]]
    poses = tables["objects"].reshape(len(tables["time"]), len(names), 7)
    for name in names:
        truth, drawn = of(run["world/objects"], name), poses[:, names.index(name)]
        there = ~np.isnan(drawn[:, 0])
        rows = np.searchsorted(truth["time"], tables["time"][there, 0] - 1e-3)
        np.testing.assert_allclose(drawn[there, :3], truth["position"][rows], atol=1e-4)
        np.testing.assert_allclose(drawn[there, 3:], truth["orientation"][rows][:, [3, 0, 1, 2]], atol=1e-4)
    shown = tables["time"][~np.isnan(poses[:, names.index("box"), 0]), 0]
    assert shown[[0, -1]] == pytest.approx([BODY.cycle * PUSHED, BODY.cycle * GONE], abs=1.5 * ROW_PERIOD)


def test_foxglove_shows_the_ball_where_it_is(recording: Path) -> None:
    ball = of(nao_hil.load(recording)["world/objects"], "ball")
    with recording.open("rb") as stream:
        updates = [json.loads(m.data) for _, _, m in make_reader(stream).iter_messages(topics=["3d/scene"])]
    shown = [entity for update in updates for entity in update["entities"] if entity["spheres"]]
    assert len(shown) > 80 and len({entity["id"] for entity in shown}) == 1
    for entity in shown:
        time = entity["timestamp"]["sec"] + 1e-9 * entity["timestamp"]["nsec"]
        (sphere,) = entity["spheres"]
        row = ball.last("time", [time + 1e-6])[0]
        assert [sphere["pose"]["position"][k] for k in "xyz"] == pytest.approx(ball["position"][row].tolist())
        assert sphere["size"] == {"x": 0.1, "y": 0.1, "z": 0.1}
