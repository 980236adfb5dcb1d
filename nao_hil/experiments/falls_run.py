"""Walks with pushes that may fell the robot: is the fall foreseen, how hard is it, does the robot walk on."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import msgspec
import numpy as np

from bridge.body import load_body
from bridge.errors import ConfigurationError
from bridge.guard import Guard
from bridge.messages.world import Push
from emulator.engine.shapes import link_shapes, lowest_point
from emulator.robot import EmulatedRobot
from emulator.world.queries import carry_out
from nao_hil.analysis.diagnosis.symptom import FALLEN
from nao_hil.runs.build import build_robot, controller_maker
from nao_hil.runs.config import RunConfig
from walker.controller import Controller

IMPULSE: Final = (1.0, 4.0)
"""N s of a single push, from where to where; it lasts 50 ms, in any level direction."""
FELLING: Final = 4.0
"""N s of each push of a long walk, likewise."""
PUSHED: Final = (5.0, 8.0)
"""s after the beginning in which a single push comes."""
PUSH_PERIOD: Final = 60.0
"""s between two pushes of a long walk, and before the first."""
WALKS: Final = 6.0
"""s that the robot is to be on its feet and walk again after it got up."""
LONGEST: Final = 42.0
"""s after a push in which that must begin and end."""
_TOUCH: Final = 0.002
"""m over the ground at which a part has reached it."""
_PARTS: Final = ("Torso", "HeadPitch")


class Fall(msgspec.Struct, frozen=True, kw_only=True):
    """One push in a walk."""

    seed: int
    impulse: float
    """N s"""
    walked: float
    """s of undisturbed walking before the push."""
    false_alarms: int
    """Falls that the walker saw in that time."""
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


@dataclass
class _PushTrial:
    """A push to come, and what has been seen since the one before."""

    at: float
    """s"""
    direction: float
    """rad; 0: forward."""
    impulse: float
    """N s"""
    walked: float = 0.0
    alarms: int = 0
    noticed: float = math.inf
    lean: float = 0.0
    down: float = math.inf
    upright_since: float = math.inf
    heights: dict[str, float] = field(default_factory=dict)
    speed: dict[str, float] = field(default_factory=dict)

    def look(self, robot: EmulatedRobot, controller: Controller, before: str) -> None:
        """One cycle; `before` is the walker's state before it."""
        now, tilt = robot.time, robot.tilt
        notice = controller.state == "fallen" and before not in ("fallen", "motion")
        if now < self.at:
            self.walked += robot.body.cycle * (controller.state == "walk")
            self.alarms += notice
            return
        if notice and self.noticed == math.inf:
            self.noticed, self.lean = now, tilt
        if tilt > FALLEN:
            self.down = min(self.down, now)
        if self.noticed < math.inf and now - self.noticed < 2.0:
            _impacts(robot, self.heights, self.speed)
        walking = controller.state == "walk" and tilt < 0.5 * FALLEN
        self.upright_since = min(self.upright_since, now) if walking else math.inf

    def over(self, now: float) -> bool:
        """Whether it is known what came of the push."""
        return now - self.upright_since >= WALKS or now >= self.at + LONGEST

    def fall(self, seed: int, now: float) -> Fall:
        """The figures."""
        return Fall(
            seed=seed,
            impulse=self.impulse,
            walked=self.walked,
            false_alarms=self.alarms,
            fell=self.down < math.inf,
            lead=round(max(self.down - self.noticed, 0.0), 6) if self.down < math.inf else 0.0,
            tilt=math.degrees(self.lean),
            speed=self.speed,
            walks_on=now - self.upright_since >= WALKS,
        )


class PushedWalk(msgspec.Struct, frozen=True, kw_only=True):
    """What to walk."""

    config: RunConfig
    """Body, wear, engine, gait and seed are read."""
    duration: float | None = None
    """Of a walk with a push of `FELLING` each minute, s; None: one push, drawn from `IMPULSE`."""


def pushes(duration: float) -> int:
    """Number of pushes in a long walk.

    Args:
        duration: Of the walk, s.

    Raises:
        ConfigurationError: it is too short for one.
    """
    if duration < PUSH_PERIOD:
        raise ConfigurationError(
            f"falls: --duration must be at least {PUSH_PERIOD:g} s, the time between pushes."
        )
    return int(duration / PUSH_PERIOD)


def pushed_walk(task: PushedWalk) -> list[Fall]:
    """Walk, push, and look."""
    config, duration = task.config, task.duration
    random = np.random.default_rng([config.seed, 2])
    if duration is None:
        at, way = float(random.uniform(*PUSHED)), float(random.uniform(-math.pi, math.pi))
        trials = [_PushTrial(at, way, float(random.uniform(*IMPULSE)))]
    else:
        ways = random.uniform(-math.pi, math.pi, pushes(duration)).tolist()
        trials = [_PushTrial(PUSH_PERIOD * (i + 1), way, FELLING) for i, way in enumerate(ways)]
    last = trials[-1].at + LONGEST
    walk = msgspec.structs.replace(config, steps=0, duration=last, recover=True)
    body = load_body(config.robot)
    controller, guard = controller_maker(walk)(body, body.cycle), Guard(body)
    falls: list[Fall] = []
    with build_robot(walk) as robot:
        for trial in trials:
            while not trial.over(robot.time):
                frame, before = robot.frame, controller.state
                answer = controller.tick(frame)
                robot.advance(guard.cycle(frame, guard.check(answer, frame.seq), supervised=True))
                if robot.time - body.cycle < trial.at <= robot.time:
                    x, y = trial.impulse * math.cos(trial.direction), trial.impulse * math.sin(trial.direction)
                    carry_out(robot, Push(target="Torso", impulse=(x, y, 0.0), duration=0.05))
                trial.look(robot, controller, before)
            falls.append(trial.fall(config.seed, robot.time))
    return falls


def _impacts(robot: EmulatedRobot, heights: dict[str, float], speed: dict[str, float]) -> None:
    """Note how fast the lowest points of torso and head came down as they reached the ground."""
    shapes = link_shapes(robot.body)
    for part in _PARTS:
        height = lowest_point(shapes[part], robot.engine.robot.link_pose(part))
        if part in heights and part not in speed and height < _TOUCH:
            speed[part] = (heights[part] - height) / robot.body.cycle
        heights[part] = height
