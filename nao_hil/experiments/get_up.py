"""Getting up from wherever a robot fell: dropped limp, any side first, with any angles of its joints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np
from matplotlib.figure import Figure

from bridge.body.joints import N_JOINTS
from bridge.messages import ActuatorFrame
from bridge.motion import GetUp, get_up_motions, lying
from bridge.types import Array
from emulator.robot import EmulatedRobot
from emulator.servo.parameters import Heating
from emulator.start import random_drop
from nao_hil.analysis.report.render import Claim, Columns, table
from nao_hil.analysis.statistics import Share
from nao_hil.experiments import axes
from nao_hil.experiments.context import Context
from nao_hil.experiments.experiment import Drawing, Experiment, Measured, bounded
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
SHARE: Final = {"worn": 0.80}
"""Share of the drops after which it is to stand, by wear."""
USUAL: Final = 0.95
"""The same for any other wear."""
MEDIAN: Final = {"back": 8.0, "front": 6.0}
"""s in which half of those that stand are to do so."""
OVERLAP: Final = 0.003
"""Deepest overlap of two limbs, m."""
_ROUNDING: Final = 1e-9
"""Tolerance of a current that the drive limits to the stall current."""
WARM: Final = Heating().warm
"""Degrees Celsius."""


class Drop(msgspec.Struct, frozen=True, kw_only=True):
    """One drop."""

    seed: int
    began: str
    """Side on which it lay: `back`, `front`, `left`, `right` or `upright`."""
    tries: int
    stands: bool
    """On its feet by the ground truth, within the time, and for a second more."""
    time: float
    """From lying to the end of the last motion, s."""
    temperature: float
    """Temperature of the hottest motor, degrees Celsius."""
    current: float
    """Largest of any motor, as a share of its stall current."""
    overlap: float
    """Deepest overlap of two limbs, m."""


class Course(NamedTuple):
    """A drop with the way of the torso, for the pictures."""

    drop: Drop
    time: Array
    """(n,), s after it began to get up."""
    height: Array
    """Height of the torso over the ground, (n,), m."""
    tilt: Array
    """Angle between the torso's axis and the vertical, (n,), rad."""


def dropped(config: RunConfig) -> EmulatedRobot:
    """A robot that fell limp from a height, any side first, and lies now; the caller closes it.

    Poses in which limbs overlap are drawn again: a fifth of all (V6).
    """
    robot, random = build_robot(config), np.random.default_rng([config.seed, 1])
    for _ in range(DRAWS):
        robot.lay_down(random_drop(robot.body, DROP, random))
        if robot.engine.overlap(robot.multibody, robot.multibody) == 0.0:
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


class SideResult(Share, frozen=True, kw_only=True):
    """Drops that ended on one side; survived: stood within the time."""

    median_s: float | None
    """Time of those that stood; None: none did."""
    tries: float
    """Mean number."""


def side(drops: Sequence[Drop]) -> SideResult:
    """The figures of some drops."""
    stood = [drop.time for drop in drops if drop.stands]
    return SideResult(
        n=len(drops),
        survived=len(stood),
        median_s=float(np.median(stood)) if stood else None,
        tries=float(np.mean([drop.tries for drop in drops])) if drops else 0.0,
    )


def judge(drops: Sequence[Drop]) -> dict[str, Any]:
    """The figures of all drops, together and by the side on which they ended."""
    both = ("back", "front")
    return {
        "all": side(drops),
        **{name: side([drop for drop in drops if drop.began == name]) for name in both},
        "other": side([drop for drop in drops if drop.began not in both]),  # on a side, or torso upright
        "temperature": max(drop.temperature for drop in drops),  # hottest motor, degrees Celsius
        "current": max(drop.current for drop in drops),  # largest, as a share of the stall current
        "overlap": max(drop.overlap for drop in drops),  # deepest of two limbs, m
        "drops": list(drops),
    }


def claims(wear: str, found: dict[str, Any]) -> list[Claim]:
    """The claims on the figures of `judge`."""
    share = SHARE.get(wear, USUAL)
    return [
        bounded(
            f"Of all drops {share:.0%} stand within {WITHIN:g} s, by the lower bound of the interval",
            found["all"],
            share,
        ),
        *(
            Claim(
                f"From the {name} half of those that stand do so within {longest:g} s",
                "none stood" if (median := found[name].median_s) is None else f"{median:.1f} s",
                median is not None and median <= longest,
            )
            for name, longest in MEDIAN.items()
            if found[name].n
        ),
        Claim(
            f"No motor is warmer than {WARM:g} degrees Celsius, where its board begins to lower the stiffness",
            f"{found['temperature']:.1f} degrees Celsius",
            found["temperature"] < WARM,
        ),
        bounded(
            "No motor draws more than its stall current",
            found["current"],
            high=1.0 + _ROUNDING,
            words="{:.0%} of it",
        ),
        bounded(
            f"No two limbs overlap by more than {1e3 * OVERLAP:g} mm",
            found["overlap"],
            high=OVERLAP,
            words=f"{1e3 * found['overlap']:.2f} mm",
        ),
    ]


def dropped_courses(context: Context) -> list[Course]:
    """One drop per seed; after a stop the finished ones.

    Raises:
        Interrupted: none is done.
    """
    return context.map("get-up", get_up, context.configs())


def _draw(figure: Figure, measured: Measured[list[Course]]) -> None:
    panel = figure.subplots()
    for course in measured.results:
        colour = axes.GREEN if course.drop.stands else axes.RED
        panel.plot(course.time, course.height, color=colour, linewidth=0.6)
    panel.set(xlabel="time / s", ylabel="height of the torso / m")
    panel.grid(alpha=0.3)


SIDES: Final[Columns] = {
    "lying on": "{0[0]}",
    "n": "{0[1].n}",
    "stand": "{0[1].survived}",
    "median": lambda item: "" if item[1].median_s is None else f"{item[1].median_s:.1f} s",
    "tries": "{0[1].tries:.1f}",
}
GET_UP: Final = Experiment(
    title="Getting up after a fall of any kind",
    source="Not in the thesis.",
    setup=(
        ("drop", f"limp, {DROP:g} m over the ground, any orientation and joint angles as likely"),
        ("stands", f"on its feet by the ground truth, and for {HOLD:g} s more"),
    ),
    measure=dropped_courses,
    quantities=lambda measured: judge([course.drop for course in measured.results]),
    claims=lambda measured: claims(measured.context.wear, measured.figures),
    tables=lambda measured: [
        table(
            "By the lying side", [(side, measured.figures[side]) for side in ("back", "front", "other")], SIDES
        )
    ],
    pictures=(
        Drawing("get-up.png", _draw, "Height of the torso", "Green: stands within the time. Red: does not."),
    ),
    findings=lambda measured: [
        f"Seed {drop.seed}, {drop.began}: does not stand after {drop.time:.1f} s and {drop.tries} tries."
        for drop in measured.figures["drops"]
        if not drop.stands
    ],
)
