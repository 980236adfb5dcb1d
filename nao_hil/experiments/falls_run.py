"""One walk with a push that may fell it: is the fall foreseen, how hard is it, and does the robot walk on."""

from __future__ import annotations

import math
from typing import Final

import msgspec
import numpy as np

from bridge.body import load_body
from bridge.guard import Guard
from bridge.messages.world import Push
from emulator.engine.shapes import link_shapes, lowest_point
from emulator.robot import EmulatedRobot
from emulator.world.queries import carry_out
from nao_hil.runs.build import build_robot, controller_maker
from nao_hil.runs.config import RunConfig

IMPULSE: Final = (1.0, 4.0)
"""N s of the push, from where to where, in any level direction; it lasts 50 ms."""
PUSHED: Final = (5.0, 8.0)
"""s after the beginning in which it comes."""
WALKS: Final = 6.0
"""s that the robot is to be on its feet and walk again after it got up."""
LONGEST: Final = 50.0
"""s after which a run ends."""
FALLEN: Final = math.radians(45.0)
_TOUCH: Final = 0.002
"""m over the ground at which a part has reached it."""
_PARTS: Final = ("Torso", "HeadPitch")


class Fall(msgspec.Struct, frozen=True, kw_only=True):
    """One walk and its push."""

    seed: int
    impulse: float
    """N s"""
    walked: float
    """s from the end of the first approach to the push."""
    false_alarms: int
    """Falls that the walker saw before the push."""
    fell: bool
    """The torso came to lean by 45 degrees."""
    lead: float
    """s from the walker's notice until the torso leaned by 45 degrees; of a robot that fell."""
    tilt: float
    """Of the torso at the notice, degrees."""
    speed: dict[str, float]
    """Downward, of torso and head as they reached the ground, m/s; those that did."""
    walks_on: bool
    """It was on its feet and walked for `WALKS` after the push, or after it got up."""


def fall(config: RunConfig) -> Fall:
    """Walk, push, and look.

    Args:
        config: Body, wear, engine, gait and seed are read.
    """
    random = np.random.default_rng([config.seed, 2])
    at, way = float(random.uniform(*PUSHED)), float(random.uniform(-math.pi, math.pi))
    impulse = float(random.uniform(*IMPULSE))
    walk = msgspec.structs.replace(config, steps=0, duration=LONGEST, recover=True)
    body = load_body(config.robot)
    controller, guard = controller_maker(walk)(body, body.cycle), Guard(body)
    began = noticed = down = math.inf
    lean, upright_since, alarms = 0.0, math.inf, 0
    speed: dict[str, float] = {}
    heights: dict[str, float] = {}
    with build_robot(walk) as robot:
        while robot.time < LONGEST:
            frame, before = robot.frame, controller.state
            answer = controller.tick(frame)
            robot.advance(guard.cycle(frame, guard.check(answer, frame.seq), supervised=True))
            now, tilt = robot.time, _tilt(robot)
            began = min(began, now) if controller.state == "walk" else began
            if controller.state == "fallen" and before not in ("fallen", "motion"):
                alarms += now < at
                if now >= at and noticed == math.inf:
                    noticed, lean = now, tilt
            if now - body.cycle < at <= now:
                x, y = impulse * math.cos(way), impulse * math.sin(way)
                carry_out(robot, Push(target="Torso", impulse=(x, y, 0.0), duration=0.05))
            if now >= at and tilt > FALLEN:
                down = min(down, now)
            if noticed < math.inf and now - noticed < 2.0:
                _impacts(robot, heights, speed)
            walking = now > at and controller.state == "walk" and tilt < 0.5 * FALLEN
            upright_since = min(upright_since, now) if walking else math.inf
            if now - upright_since >= WALKS:
                break
    return Fall(
        seed=config.seed,
        impulse=impulse,
        walked=max(at - began, 0.0),
        false_alarms=alarms,
        fell=down < math.inf,
        lead=max(down - noticed, 0.0) if down < math.inf else 0.0,
        tilt=math.degrees(lean),
        speed=speed,
        walks_on=upright_since < math.inf,
    )


def _tilt(robot: EmulatedRobot) -> float:
    return math.acos(max(-1.0, min(1.0, robot.engine.robot.torso().rotation[8])))


def _impacts(robot: EmulatedRobot, heights: dict[str, float], speed: dict[str, float]) -> None:
    """Note how fast the lowest points of torso and head came down as they reached the ground."""
    shapes = link_shapes(robot.body)
    for part in _PARTS:
        height = lowest_point(shapes[part], robot.engine.robot.link_pose(part))
        if part in heights and part not in speed and height < _TOUCH:
            speed[part] = (heights[part] - height) / robot.body.cycle
        heights[part] = height
