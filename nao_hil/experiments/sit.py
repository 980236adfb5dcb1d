"""Sitting down by order and standing up again, through the walker and the guard."""

from __future__ import annotations

import math
from typing import Any, Final

import msgspec

from bridge.body import load_body
from bridge.body.fall import tilt
from bridge.guard import Guard
from bridge.motion import GetUp, MotionPlayer, get_up_motions, named_motion
from nao_hil.analysis.report.render import table, yes_no
from nao_hil.analysis.statistics import share_of, wilson
from nao_hil.experiments.experiment import Experiment, Measured, bounded
from nao_hil.runs.build import build_robot, controller_maker
from nao_hil.runs.config import RunConfig

SEATED: Final = 2.0
"""s that the robot sits, nearly limp."""
HOLD: Final = 1.0
"""s that it is to stand at the end."""
LONGEST: Final = 40.0
"""s after which a run ends."""
LOWEST_BOUND: Final = wilson(100, 100)[0]
"""A share counts as "100 of 100" when the lower bound of its interval is at least that one's."""


class Sit(msgspec.Struct, frozen=True, kw_only=True):
    """One robot that sat down and stood up."""

    seed: int
    sat: bool
    """Upright on its seat, not on its feet, after `SEATED`; the guard saw no fall on the way."""
    stands: bool
    """On its feet for `HOLD` at the end, by the ground truth."""
    tries: int
    """Number of tries of getting up."""
    lean: float
    """Largest of the torso, by the fused angle, rad."""
    temperature: float
    """Temperature of the hottest motor, degrees Celsius."""


def sit(config: RunConfig) -> Sit:
    """Sit down, wait, stand up.

    Args:
        config: Body, wear, engine, gait and seed are read.
    """
    body = load_body(config.robot)
    settings = msgspec.structs.replace(config, recover=True)
    controller, guard = controller_maker(settings, waits=True)(body, body.cycle), Guard(body)
    down = MotionPlayer(named_motion("sit-down", body), body)
    up = GetUp(get_up_motions(body), body)
    lean = temperature = 0.0
    sat = fell = False
    seated = stood = math.inf
    with build_robot(settings) as robot:
        while robot.time < LONGEST and robot.time < stood + HOLD:
            frame, before = robot.frame, controller.state
            answer = controller.tick(frame)
            robot.advance(guard.cycle(frame, guard.check(answer, frame.seq), supervised=True))
            lean, temperature = max(lean, tilt(frame.angle)), max(temperature, *frame.temperature)
            fell = fell or guard.state == "fallen"
            if controller.state != before and controller.state == "stand":
                if seated == math.inf:
                    controller.play(down)
                else:
                    stood = robot.time
            elif controller.state != before and controller.state == "rest":
                seated = robot.time
            if not sat and robot.time >= seated + SEATED:
                sat = controller.lying_side == "upright" and robot.truth().fell and not fell
                controller.play(up)
        stands = stood < math.inf and not robot.truth().fell
    return Sit(
        seed=config.seed, sat=sat, stands=stands, tries=len(up.began), lean=lean, temperature=temperature
    )


def _quantities(measured: Measured[list[Sit]]) -> dict[str, Any]:
    sits = measured.results
    both = share_of([each.sat and each.stands for each in sits])  # sat, and stood again
    return {**msgspec.structs.asdict(both), "sat": sum(each.sat for each in sits), "sits": sits}


SIT: Final = Experiment(
    title="Sitting down and standing up",
    source="Not in the thesis.",
    setup=(("sits", f"{SEATED:g} s"), ("stands", f"{HOLD:g} s at the end")),
    measure=lambda context: context.map("sit", sit, context.configs()),
    quantities=_quantities,
    claims=lambda measured: [
        bounded(
            "100 of 100 sit down and stand up again",
            share_of([each.sat and each.stands for each in measured.results]),
            LOWEST_BOUND,
        )
    ],
    tables=lambda measured: [
        table(
            "Robots",
            measured.results,
            {
                "seed": "{0.seed}",
                "sat": lambda each: yes_no(each.sat),
                "stands": lambda each: yes_no(each.stands),
                "tries": "{0.tries}",
                "lean, degrees": lambda each: f"{math.degrees(each.lean):.0f}",
                "hottest motor, degrees Celsius": "{0.temperature:.0f}",
            },
        )
    ],
)
