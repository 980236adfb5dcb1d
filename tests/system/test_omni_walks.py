"""The omnidirectional gait on emulated robots, each axis, in process: it stays up and goes where it is told."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bridge import rotations
from bridge.messages.world import Push
from nao_hil.runs.build import build_robot, controller_maker
from nao_hil.runs.config import RunConfig
from nao_hil.runs.events import StridePush
from nao_hil.runs.track import PHASES
from nao_hil.runs.walk import Walk, walk
from walker.gaits.plan import Foothold

WALKED = 6.0
"""s; the first two do not count, and what is left are whole strides of a slow sideways walk."""


@pytest.mark.parametrize(
    ("robot", "engine", "velocity", "axis"),
    [
        ("nao-v3", "pybullet", (0.2, 0.0, 0.0), 0),
        ("nao-v3", "pybullet", (0.0, 0.08, 0.0), 1),
        ("nao-v3", "mujoco", (-0.1, 0.0, 0.0), 0),
        ("nao-v3", "mujoco", (0.0, 0.0, 0.8), 2),
        *(
            ("nao-v6", "mujoco", velocity, axis)
            for velocity, axis in (
                ((0.2, 0.0, 0.0), 0),
                ((-0.1, 0.0, 0.0), 0),
                ((0.0, 0.08, 0.0), 1),
                ((0.0, 0.0, 0.8), 2),
            )
        ),
    ],
)
def test_walks_along_each_axis(robot, engine, velocity, axis):
    parameters = dict(zip(("v_x", "v_y", "v_yaw"), velocity, strict=True))
    config = RunConfig(robot=robot, engine=engine, gait="omni", seed=2001, parameters=parameters)
    outcome = walk(Walk(name="axis", config=config, duration=WALKED))
    assert outcome.end.survived
    assert outcome.end.tilt_max < math.radians(20.0)
    track = outcome.track
    late = track["time"] > 2.0
    place, time = track["torso"][late, :2], track["time"][late]
    yaw = np.unwrap(rotations.yaw(track["orientation"][late]))
    turned = (yaw[-1] - yaw[0]) / (time[-1] - time[0])
    way = (place[-1] - place[0]) / (time[-1] - time[0])
    c, s = math.cos(yaw[0]), math.sin(yaw[0])
    measured = (c * way[0] + s * way[1], c * way[1] - s * way[0], turned)[axis]
    assert 0.5 * abs(velocity[axis]) < math.copysign(1.0, velocity[axis]) * measured < 1.5 * abs(velocity[axis])


@pytest.mark.parametrize("target", [(0.1, 0.0, 0.0), (0.3, 0.1, 0.5)])
def test_walks_to_a_place(target):
    """Within 2 cm and 2 % of the way, and 1 cm by which the torso stands off the middle of its feet."""
    config = RunConfig(robot="nao-v6", engine="mujoco", gait="omni", seed=2001, target=target)
    outcome = walk(Walk(name="target", config=config, duration=9.0))
    assert outcome.end.ending != "fell"
    assert outcome.track["phase"][-1] == PHASES.index("stand")
    place, yaw = outcome.track["torso"][:, :2], np.unwrap(rotations.yaw(outcome.track["orientation"]))
    x, y = place[-1] - place[0]
    assert math.dist((x, y), target[:2]) < 0.03 + 0.02 * math.hypot(*target[:2])
    assert yaw[-1] - yaw[0] == pytest.approx(target[2], abs=0.1)


@pytest.mark.parametrize("steps", [True, False])
@pytest.mark.parametrize(("direction", "impulse"), [(0.0, 2.8), (135.0, 2.6)])
def test_a_push_that_fells_a_standing_robot_is_answered_by_a_step(direction, impulse, steps):
    """To a side and ahead or back, degrees, N s: a step takes up the capture point beyond toes or heels."""
    config = RunConfig(
        robot="nao-v6", engine="mujoco", seed=2002, controller={"switches": {"capture_step": steps}}
    )
    push = StridePush(time=0.3, phase=None, impulse=impulse, direction=math.radians(direction))
    outcome = walk(Walk(name="push", config=config, duration=3.5, pushes=(push,), stand=True))
    assert outcome.end.survived == steps
    if steps:
        assert outcome.end.steps == 2
        assert abs(outcome.end.roll) + abs(outcome.end.pitch) < math.radians(5.0)


def test_after_a_step_straight_back_the_robot_balances_on_the_foot_that_landed():
    """2.85 N s: the foot in front hangs in the air for half a second. Without the balance 1 of 12 stood."""
    push = StridePush(time=0.3, phase=None, impulse=2.85, direction=math.pi)
    stood = 0
    for seed in range(2002, 2008):
        config = RunConfig(robot="nao-v6", engine="mujoco", seed=seed)
        stood += walk(
            Walk(name="push", config=config, duration=4.5, pushes=(push,), stand=True, keep_track=False)
        ).end.survived
    assert stood >= 3


@pytest.mark.parametrize("seed", [2003, 2004])
def test_after_a_capture_step_the_feet_close_and_the_robot_stands(seed):
    """2.8 N s ahead, which a V6 does not survive without a step; the feet close 3.5 s later."""
    push = StridePush(time=0.3, phase=None, impulse=2.8, direction=0.0)
    config = RunConfig(robot="nao-v6", engine="mujoco", seed=seed)
    outcome = walk(Walk(name="push", config=config, duration=5.0, pushes=(push,), stand=True))
    assert outcome.end.survived
    assert outcome.end.steps >= 2
    assert abs(outcome.end.roll) + abs(outcome.end.pitch) < math.radians(5.0)


def test_a_capture_step_does_not_depend_on_where_the_frame_of_the_plan_heads():
    """2.4 N s straight back; the frame of the plan is where the walks before left the robot."""
    config = RunConfig(robot="nao-v6", engine="mujoco", gait="omni", seed=302010, velocity=(0.15, 0.0, 0.0))
    places = []
    for yaw in (0.0, 2.5):
        origin = Foothold(0.0, 0.0, yaw)
        with build_robot(config) as robot:
            controller = controller_maker(config, waits=True)(robot.body, robot.body.cycle)
            planner = controller._planner
            planner.plan, planner._origin = planner.plan.transformed(origin), origin
            for k in range(600):
                command = controller.tick(robot.frame)
                if k == 300:
                    robot.world_events.execute(Push(impulse=(-2.4, 0.0, 0.0)))
                robot.advance(command)
            places.append(robot.truth().torso_position)
    assert places[0][2] > 0.28  # it stands
    assert places[1] == pytest.approx(places[0], abs=1e-6)
