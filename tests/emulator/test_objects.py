"""Ball and poles on every engine, against closed forms: rolling, striking, standing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from bridge.body import load_body
from bridge.errors import FrameError
from bridge.messages.world import PlaceObject, Push
from emulator.engine.base import Engine
from emulator.engine.catalogue import open_engine
from emulator.engine.settings import PhysicsSettings
from emulator.engine.values import Ball
from emulator.poses import ORIGIN, Pose
from emulator.robot import EmulatedRobot
from emulator.world.world import LEAGUE_BALL, SURFACES, solid
from tests.engines import passive

BODY = load_body("nao-v6")
MASS = sum(link.mass for link in BODY.links.values())
G, DT = 9.81, 0.001


@pytest.fixture
def engine(physics: str) -> Iterator[Engine]:
    found = open_engine(physics, PhysicsSettings(step=DT, gravity=G))
    yield found
    found.close()


def weightless(engine: Engine) -> None:
    engine.surround(engine.surroundings._replace(gravity=(0.0, 0.0, 0.0)))


def at(x: float, y: float, z: float) -> Pose:
    return Pose((x, y, z), ORIGIN.orientation)


def way_of_a_pushed_ball(ball: Ball, speed: float, friction: float) -> tuple[float, float, float]:
    """Way (m) and time (s) until it rests, and its speed after 0.11 s.

    It slides until it rolls, at 5/7 of its speed but for the rolling friction, then loses speed evenly.
    """
    arm = ball.rolling_arm(G) / ball.radius
    sliding = speed / (friction * G + 2.5 * G * (friction - arm))
    rolls = speed - friction * G * sliding
    way = speed * sliding - 0.5 * friction * G * sliding**2 + rolls**2 / (2.0 * ball.rolling)
    return way, sliding + rolls / ball.rolling, rolls - ball.rolling * (0.11 - sliding)


@pytest.mark.parametrize("surface", ["wood", "turf"])
def test_a_ball_pushed_at_one_metre_per_second_rolls_as_far_as_the_closed_form(
    engine: Engine, surface: str
) -> None:
    engine.surround(engine.surroundings._replace(surface=SURFACES[surface]))
    ball = engine.add(LEAGUE_BALL, at(0.0, 0.0, LEAGUE_BALL.radius))
    engine.run(200)
    start = np.array(ball.state().position)
    ball.push((LEAGUE_BALL.mass * 1.0 / DT, 0.0, 0.0))
    way, time, rolling = way_of_a_pushed_ball(LEAGUE_BALL, 1.0, SURFACES[surface].friction)
    speeds = []
    for _ in range(round(time / 0.01) + 50):
        engine.run(10)
        speeds.append(ball.state().velocity[0])
    moved = np.array(ball.state().position) - start
    assert moved[0] == pytest.approx(way, rel=0.03)
    assert np.abs(moved[1:]).max() < 2e-3
    assert 0.01 * int(np.argmax(np.array(speeds) < 0.005)) == pytest.approx(time, rel=0.03)
    assert speeds[10] == pytest.approx(rolling, abs=0.01)
    assert abs(speeds[-1]) < 1e-3


def test_balls_that_collide_keep_their_momentum_and_do_not_bounce(engine: Engine) -> None:
    weightless(engine)
    heavy = replace(LEAGUE_BALL, mass=3.0 * LEAGUE_BALL.mass)
    balls = [engine.add(heavy, at(0.0, 0.0, 1.0)), engine.add(LEAGUE_BALL, at(0.3, 0.0, 1.0))]
    balls[0].place(at(0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    engine.run(600)
    speeds = [ball.state().velocity[0] for ball in balls]
    assert 3.0 * speeds[0] + speeds[1] == pytest.approx(3.0, rel=0.01)
    assert speeds[1] - speeds[0] == pytest.approx(0.0, abs=0.1)


def test_a_ball_takes_from_a_robot_the_momentum_that_it_gets(engine: Engine) -> None:
    """A limp robot flies against a ball at rest: together they keep their momentum."""
    weightless(engine)
    robot = engine.add_robot(BODY, passive(BODY))
    robot.place(at(0.0, 0.0, 2.0), (1.0, 0.0, 0.0))
    heavy = replace(LEAGUE_BALL, mass=1.0)
    ball = engine.add(heavy, at(0.4, 0.0, 2.0))
    engine.run(400)
    before = np.array(robot.com())
    engine.run(10)
    speed = (robot.com()[0] - before[0]) / 0.01
    state = ball.state()
    assert state.velocity[0] > 0.5
    assert MASS * speed + heavy.mass * state.velocity[0] == pytest.approx(MASS, rel=0.01)


def test_an_object_is_in_the_truth_with_its_shape_and_can_be_pushed(physics: str) -> None:
    with EmulatedRobot(BODY, engine=physics, seed=0, settle=0.1) as robot:
        send = robot.world_events.execute
        send(PlaceObject(name="ball", shape="ball", size=(0.1, 0.1, 0.1), mass=0.044, at=(0.5, 0.3)))
        send(PlaceObject(name="pole", shape="pole", size=(0.1, 0.1, 0.8), at=(1.5, 0.3), friction=0.3))
        send(Push(target="ball", impulse=(0.044, 0.0, 0.0), duration=0.001))
        for _ in range(50):
            robot.advance(None)
        ball, pole = robot.world.object_states()
        assert (ball.shape, pole.shape) == ("ball", "pole")
        assert (ball.size, pole.size) == (pytest.approx((0.1, 0.1, 0.1)), pytest.approx((0.1, 0.1, 0.8)))
        assert 0.7 < ball.position[0] < 1.0
        assert pole.position == pytest.approx((1.5, 0.3, 0.4), abs=1e-6)


@pytest.mark.parametrize(
    ("shape", "size", "mass", "what"),
    [
        ("ball", (0.1, 0.1, 0.2), 0.044, "its diameter, three times"),
        ("pole", (0.1, 0.2, 0.8), 0.0, "its diameter, twice"),
        ("ball", (0.1, 0.1, 0.1), 0.0, "needs a mass"),
    ],
)
def test_a_shape_that_cannot_be_is_refused(shape, size, mass: float, what: str) -> None:
    with pytest.raises(FrameError, match=what):
        solid(shape, size, mass, None)
