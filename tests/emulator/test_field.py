"""A playing field against rule book and team configurations: lines in pictures, goals in truth and contact."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bridge.body import load_body
from bridge.config import parse_toml
from bridge.errors import ConfigurationError
from bridge.messages.world import Push
from bridge.messages.world_state import Field, Terrain
from bridge.types import Vec2
from emulator.camera.picture import Floor, PaintedField, View, draw
from emulator.engine.settings import SETTINGS
from emulator.robot import EmulatedRobot
from emulator.scenarios import load_scenario
from emulator.scenarios.model import Scenario
from emulator.start import build_world
from emulator.world.world import LEAGUE_BALL

BODY = load_body("nao-v6")
LOOKING_DOWN = np.array(((0.0, 1.0, 0.0), (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0)))
"""Camera to world: its axis downward, its left along x, its upward side along -y."""
# Points that are painted: rule book of 2014, figure 1, with the penalty area of 2020.
FULL = {
    "goal line": (4.5, 2.0),
    "touchline": (-3.0, -3.0),
    "halfway line": (0.0, 1.7),
    "circle": (0.75 * math.cos(0.6), 0.75 * math.sin(0.6)),
    "goal area": (3.9, 0.9),
    "side of the goal area": (-4.2, 1.1),
    "penalty area": (-2.85, -1.9),
    "penalty mark": (3.2, 0.03),
}
SMALL = {
    "goal line": (-3.0, 1.5),
    "touchline": (1.0, 2.0),
    "circle": (0.0, -0.6),
    "penalty area": (2.4, 0.5),
    "penalty mark": (-1.2, 0.03),
}


def field_of(name: str) -> Field:
    field = load_scenario(name).field
    assert field is not None
    return field.painted()


def colour(field: Field, at: Vec2) -> np.ndarray:
    """Of the floor at a point, by a camera 1 m above it that sees 2 mm."""
    view = View(np.array((*at, 1.0)), LOOKING_DOWN, (0.002, 0.002))
    return draw(view, Floor(np.zeros(3), np.eye(3), PaintedField(field)), [], 1, 1)[0, 0].astype(int)


@pytest.mark.parametrize(
    ("name", "place"), [("field", at) for at in FULL.values()] + [("field-small", at) for at in SMALL.values()]
)
def test_the_cameras_see_white_lines_where_the_rules_have_them_on_green(name: str, place: Vec2) -> None:
    field = field_of(name)
    assert colour(field, place).min() > 180
    for aside in ((0.06, 0.06), (-0.06, -0.06)):  # a line is 5 cm wide
        red, green, blue = colour(field, (place[0] + aside[0], place[1] + aside[1]))
        assert green > 1.5 * max(red, blue)


@pytest.mark.parametrize(("name", "carpet"), [("field", (10.4, 7.4)), ("field-small", (7.4, 5.4))])
def test_the_carpet_ends_a_border_beyond_the_lines(name: str, carpet: Vec2) -> None:
    assert field_of(name).size == pytest.approx(carpet)


@pytest.mark.parametrize(("name", "goal_line", "inner"), [("field", 4.5, 1.5), ("field-small", 3.0, 1.4)])
def test_goals_stand_on_their_lines_open_to_the_field(name: str, goal_line: float, inner: float) -> None:
    scenario = load_scenario(name)
    with EmulatedRobot(BODY, seed=0, engine="mujoco", scenario=scenario) as robot:
        objects = {thing.name: thing for thing in robot.world.object_states()}
        assert robot.world.terrain.field == field_of(name)
    assert set(objects) == set(field_of(name).goals) and len(objects) == 6
    for end in ("goal1", "goal2"):
        left, right, bar = (objects[f"{end}-{part}"] for part in ("left", "right", "bar"))
        assert left.position[1] - right.position[1] - left.size[0] == pytest.approx(inner)
        assert abs(left.position[0]) - left.size[0] / 2.0 == pytest.approx(
            goal_line - 0.025
        )  # inner edge of the line
        assert bar.position[2] - bar.size[2] / 2.0 == pytest.approx(0.8) == left.size[2]
        assert left.mass == right.mass == bar.mass == 0.0


def test_a_ball_rolls_into_the_goal_and_a_post_stops_it(physics: str) -> None:
    ends = {}
    for name, y in (("inside", 0.5), ("post", 0.8)):
        world = build_world(physics, SETTINGS, load_scenario("field"), 0)
        world.add_object("ball", LEAGUE_BALL, (4.2, y))
        world.engine.run(100)
        world.objects["ball"].thing.push((LEAGUE_BALL.mass * 1.2 / SETTINGS.step, 0.0, 0.0))
        world.engine.run(round(1.5 / SETTINGS.step))
        ends[name] = world.objects["ball"].thing.state().position[0]
        world.engine.close()
    assert ends["inside"] > 4.7
    assert ends["post"] < 4.475 - 0.045  # of the post's front less the ball's radius, with 5 mm for its give


def test_a_painted_floor_is_as_even_as_a_bare_one() -> None:
    world = build_world("mujoco", SETTINGS, Scenario(), 0)
    world.terrain = Terrain(field=field_of("field"))
    assert not world.uneven
    world.engine.close()


def test_a_robot_far_from_the_goals_moves_as_without_them(physics: str) -> None:
    """Also where a push moves it; within the last digits, as its start is found by rays at the ground."""
    frames = []
    for text in ("[field]\nlength = 9.0\nwidth = 6.0\n", ""):
        scenario = parse_toml(text, "mine", Scenario)
        with EmulatedRobot(BODY, seed=1, engine=physics, scenario=scenario) as robot:
            robot.world_events.execute(Push(impulse=(0.5, 0.0, 0.0)))
            for _ in range(30):
                robot.advance(None)
            frames.append(np.array(robot.frame.position))
    np.testing.assert_allclose(frames[0], frames[1], atol=2e-3)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[field]\nlength = 9.0\n", "width"),
        ("[field]\nlength = 90.0\nwidth = 6.0\n", "field.length: expected a number <= 30"),
        ("[field]\nlength = 3.0\nwidth = 2.0\n", "`goal_area` is 0.6 m deep and 2.2 m wide"),
        ("[field]\nlength = 9.0\nwidth = 6.0\ncirkle = 1.0\n", "did you mean 'circle'"),
        (
            "[field]\nlength = 9.0\nwidth = 6.0\n"
            '[[boxes]]\nname = "goal1-bar"\nsize = [1, 1, 1]\nat = [2, 2]\n',
            "same name",
        ),
    ],
)
def test_a_mistake_in_a_field_is_named(text: str, says: str) -> None:
    with pytest.raises(ConfigurationError, match=says):
        parse_toml(text, "mine.toml", Scenario)
