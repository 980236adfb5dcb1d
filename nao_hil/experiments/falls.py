"""Falls in a walk: prediction, impact, and the walk after getting up."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import msgspec
import numpy as np

from bridge.body import load_body
from bridge.body.fall import FALLEN_TILT, has_fallen
from bridge.errors import ConfigurationError
from bridge.guard import Guard
from bridge.messages.world import Push
from emulator.engine.shapes import link_shapes, lowest_point
from emulator.queries import carry_out
from emulator.robot import EmulatedRobot
from nao_hil.analysis.report.render import Claim, Columns, table, yes_no
from nao_hil.analysis.statistics import wilson
from nao_hil.experiments.context import Context
from nao_hil.experiments.experiment import Experiment, Measured
from nao_hil.runs.build import build_robot, controller_maker
from nao_hil.runs.config import RunConfig
from walker.controller import Controller

IMPULSE: Final = (1.0, 4.0)
"""N s of a single push, from where to where; it lasts 50 ms, in any level direction."""
FELLING: Final = 4.0
"""N s of each push of a long walk, likewise."""
PUSHED: Final = (5.0, 8.0)
"""s after the beginning in which a single push begins."""
PUSH_PERIOD: Final = 60.0
"""s between two pushes of a long walk, and before the first."""
WALKS: Final = 6.0
"""s that the robot is to be on its feet and walk again after it got up."""
LONGEST: Final = 42.0
"""s after a push in which that must begin and end."""
_TOUCH: Final = 0.002
"""m over the ground at which a part has reached it."""
_PARTS: Final = ("Torso", "HeadPitch")
LEAD: Final = 0.2
"""s before the torso leans by 45 degrees."""
SHARE: Final = 0.9
SPEED: Final = 2.0
"""Largest speed at the impact, m/s."""


class Fall(msgspec.Struct, frozen=True, kw_only=True):
    """One push in a walk."""

    seed: int
    impulse: float
    """N s"""
    walked: float
    """s of undisturbed walking before the push."""
    false_alarms: int
    """Falls that the walker reported in that time."""
    fell: bool
    """The torso leaned by 45 degrees."""
    lead: float
    """s from the walker's notice until the torso leaned by 45 degrees; of a robot that fell."""
    tilt: float
    """Tilt of the torso at the notice, degrees."""
    speed: dict[str, float]
    """Downward, of torso and head as they reached the ground, m/s; those that did."""
    walks_on: bool
    """It walked on its feet for `WALKS` after the push, or after it got up."""


@dataclass
class _PushTrial:
    """A push, and the observations since the one before."""

    at: float
    """Time of the fall, s."""
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

    def observe(self, robot: EmulatedRobot, controller: Controller, before: str) -> None:
        """One cycle; `before` is the walker's state before it."""
        now, tilt = robot.time, robot.tilt
        notice = controller.state == "fallen" and before not in ("fallen", "motion")
        if now < self.at:
            self.walked += robot.body.cycle * (controller.state == "walk")
            self.alarms += notice
            return
        if notice and self.noticed == math.inf:
            self.noticed, self.lean = now, tilt
        if has_fallen(tilt):
            self.down = min(self.down, now)
        if self.noticed < math.inf and now - self.noticed < 2.0:
            _impacts(robot, self.heights, self.speed)
        walking = controller.state == "walk" and tilt < 0.5 * FALLEN_TILT
        self.upright_since = min(self.upright_since, now) if walking else math.inf

    def over(self, now: float) -> bool:
        """Whether the outcome of the push is known."""
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
    """A walk with pushes, for a worker."""

    config: RunConfig
    """Body, wear, engine, gait and seed are read."""
    duration: float | None = None
    """Duration of a walk with a push of `FELLING` each minute, s; None: one push, drawn from `IMPULSE`."""


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
    """Walk, push, and record the course of each push."""
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
                trial.observe(robot, controller, before)
            falls.append(trial.fall(config.seed, robot.time))
    return falls


def _impacts(robot: EmulatedRobot, heights: dict[str, float], speed: dict[str, float]) -> None:
    """Note the downward speed of torso and head as their lowest points reach the ground."""
    shapes = link_shapes(robot.body)
    for part in _PARTS:
        height = lowest_point(shapes[part], robot.multibody.state(part).pose)
        if part in heights and part not in speed and height < _TOUCH:
            speed[part] = (heights[part] - height) / robot.body.cycle
        heights[part] = height


def judge(falls: Sequence[Fall]) -> dict[str, Any]:
    """The figures of all pushes."""
    down = [each for each in falls if each.fell]
    foreseen = sum(each.lead >= LEAD for each in down)
    parts = sorted({part for each in falls for part in each.speed})
    return {
        "n": len(falls),
        "fell": len(down),
        "foreseen": foreseen,  # noticed `LEAD` before
        "foreseen_interval": wilson(foreseen, len(down)),
        "lead_median_s": float(np.median([each.lead for each in down])) if down else 0.0,
        "tilt_max_deg": max((each.tilt for each in down), default=0.0),  # of the torso at the notice
        "needless": sum(not each.fell and each.tilt > 0.0 for each in falls),
        "false_alarms": sum(each.false_alarms for each in falls),
        "walked_s": sum(each.walked for each in falls),  # undisturbed walking, in which the alarms were
        "speed_max": {part: max(each.speed.get(part, 0.0) for each in falls) for part in parts},
        "walks_on": sum(each.walks_on for each in falls),
        "falls": list(falls),
    }


def claims(found: dict[str, Any]) -> list[Claim]:
    """The claims on the figures of `judge`."""
    low, high = found["foreseen_interval"]
    hardest = max(found["speed_max"].values(), default=0.0)
    return [
        Claim(
            f"{SHARE:.0%} of the falls are noticed {LEAD:g} s before 45 degrees, by the interval's lower bound",
            f"{found['foreseen']} of {found['fell']} (95 % interval {low:.0%} to {high:.0%}), "
            f"median {found['lead_median_s']:.2f} s",
            low >= SHARE,
        ),
        Claim(
            "Every fall is noticed before 20 degrees",
            f"at {found['tilt_max_deg']:.0f} degrees at most",
            found["tilt_max_deg"] < 20.0,
        ),
        Claim(
            "No false alarm in undisturbed walking",
            f"{found['false_alarms']} in {found['walked_s']:.0f} s",
            found["false_alarms"] == 0,
        ),
        Claim(
            f"Torso and head reach the ground at no more than {SPEED:g} m/s",
            f"{hardest:.1f} m/s",
            hardest <= SPEED,
        ),
        Claim(
            f"After every push the robot walks on for {WALKS:g} s",
            f"{found['walks_on']} of {found['n']}",
            found["walks_on"] == found["n"],
        ),
    ]


def measure(context: Context) -> list[Fall]:
    """One push per seed; with a duration, one a minute."""
    if context.duration is not None:
        pushes(context.duration)
    tasks = [PushedWalk(config=config, duration=context.duration) for config in context.configs()]
    return [fall for walk in context.map("falls", pushed_walk, tasks) for fall in walk]


def _setup(measured: Measured[list[Fall]]) -> list[tuple[str, str]]:
    push, duration = f"{IMPULSE[0]:g} to {IMPULSE[1]:g} N s", measured.context.duration
    if duration is not None:
        push = f"{FELLING:g} N s every {PUSH_PERIOD:g} s of {duration:g} s"
    return [
        ("gait", measured.context.changes.gait),
        ("push", f"{push}, on the torso in any level direction, 50 ms"),
    ]


COLUMNS: Final[Columns] = {
    "seed": "{0.seed}",
    "push": "{0.impulse:.1f} N s",
    "fell": lambda each: yes_no(each.fell),
    "noticed before": lambda each: f"{each.lead:.2f} s" if each.fell else "",
    "at degrees": "{0.tilt:.0f}",
    "reached the ground": lambda each: ", ".join(f"{part} {v:.1f} m/s" for part, v in each.speed.items()),
    "walks on": lambda each: yes_no(each.walks_on),
}
FALLS: Final = Experiment(
    title="Pushes that fell a walking robot",
    source="Not in the thesis.",
    setup=_setup,
    measure=measure,
    quantities=lambda measured: judge(measured.results),
    claims=lambda measured: claims(measured.figures),
    tables=lambda measured: [table("Pushes", measured.results, COLUMNS)],
)
