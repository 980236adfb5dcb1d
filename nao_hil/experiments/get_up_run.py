"""One robot dropped limp, and what came of its getting up."""

from __future__ import annotations

from typing import Final, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from bridge.body.joints import N_JOINTS
from bridge.messages import ActuatorFrame
from bridge.motion import GetUp, get_up_motions, lying
from emulator.robot import EmulatedRobot
from emulator.start import random_drop
from nao_hil.runs.build import build_robot
from nao_hil.runs.config import RunConfig
from nao_hil.runs.motion import play

DROP: Final = 0.2
"""Height of the lowest point of the limp robot over the ground, m."""
DRAWS: Final = 100
"""Poses that are drawn at most until limbs are apart."""
LIES: Final = 3.0
"""s from the drop until it begins to get up."""
WITHIN: Final = 15.0
"""s in which it is to stand."""
HOLD: Final = 1.0
"""s for which it then has to stand by itself."""


class Drop(msgspec.Struct, frozen=True, kw_only=True):
    """One drop."""

    seed: int
    began: str
    """What of the robot was below: `back`, `front`, `left`, `right` or `upright`."""
    tries: int
    stands: bool
    """On its feet by the ground truth, within the time, and for a second more."""
    time: float
    """From lying to the end of the last motion, s."""
    temperature: float
    """Of the hottest motor, degrees Celsius."""
    current: float
    """Largest of any motor, as a share of its stall current."""
    overlap: float
    """Deepest overlap of two limbs, m."""


class Course(NamedTuple):
    """A drop with the way of the torso, for the pictures."""

    drop: Drop
    time: NDArray[np.float64]
    """(n,), s after it began to get up."""
    height: NDArray[np.float64]
    """Of the torso over the ground, (n,), m."""
    tilt: NDArray[np.float64]
    """Angle between the torso's axis and the vertical, (n,), rad."""


def dropped(config: RunConfig) -> EmulatedRobot:
    """A robot that fell limp from a height, any side first, and lies now; the caller closes it.

    Poses in which limbs are inside each other are drawn anew: a fifth of all (V6).
    """
    robot, random = build_robot(config), np.random.default_rng([config.seed, 1])
    for _ in range(DRAWS):
        robot.lay_down(random_drop(robot.body, DROP, random))
        if robot.engine.robot.overlap() == 0.0:
            break
    for _ in range(round(LIES / robot.body.cycle)):
        robot.advance(None)
    return robot


def get_up(config: RunConfig) -> Course:
    """Drop a robot and let it get up.

    Args:
        config: Body, wear, engine and seed are read.
    """
    with dropped(config) as robot:
        motions, path = get_up_motions(robot.body), []
        start = robot.time

        def watch(now: EmulatedRobot) -> None:
            truth = now.truth()
            path.append((now.time - start, truth.torso_position[2], now.tilt))

        player = GetUp(motions, robot.body)
        result = play(robot, "get-up", player, longest=WITHIN, watch=watch)
        stands = result.stands and player.done
        held = ActuatorFrame(
            reply_to=robot.seq, position=player.position, stiffness=(player.stiffness,) * N_JOINTS
        )
        for _ in range(round(HOLD / robot.body.cycle)):
            robot.advance(held)
            stands = stands and not robot.truth().fell
        began = str(player.began[0]) if player.began else lying(robot.frame.angle)
    drop = Drop(
        seed=config.seed,
        began=began,
        tries=result.tries,
        stands=stands,
        time=result.time,
        temperature=result.temperature,
        current=result.current,
        overlap=result.overlap,
    )
    return Course(drop, *np.array(path).reshape(-1, 3).T)
