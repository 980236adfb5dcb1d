"""A walk that is told to stop at any moment: how many robots stand afterwards, by velocity."""

from __future__ import annotations

from typing import Any, Final

import msgspec
import numpy as np

from bridge.body import load_body
from bridge.guard import Guard
from bridge.types import Vec3
from nao_hil.analysis.report.render import table
from nao_hil.analysis.statistics import share_of
from nao_hil.experiments.experiment import Experiment, Measured
from nao_hil.runs.build import build_robot, controller_maker
from nao_hil.runs.config import RunConfig

VELOCITIES: Final[dict[str, Vec3]] = {
    "0.1 m/s ahead": (0.1, 0.0, 0.0),
    "0.3 m/s ahead": (0.3, 0.0, 0.0),
    "0.15 m/s back": (-0.15, 0.0, 0.0),
    "0.15 m/s to the left": (0.0, 0.15, 0.0),
    "0.8 rad/s": (0.0, 0.0, 0.8),
}
STOPPED: Final = (2.0, 6.0)
"""s after the start in which the walk is told to stop: drawn, so at any phase of a step."""
STANDS: Final = 4.0
"""s after that word at which the robot is judged."""


class Stop(msgspec.Struct, frozen=True, kw_only=True):
    """One walk that was told to stop."""

    velocity: str
    """Name in `VELOCITIES`."""
    seed: int
    told: float
    """s after the start of the run."""
    walked: bool
    """It had not fallen until then."""
    stands: bool
    """It walked, and was in a stand and upright when it was judged."""


def stop(task: tuple[str, RunConfig]) -> Stop:
    """Walk at a velocity, stop, and stand.

    Args:
        task: name in `VELOCITIES`; body, wear, engine, gait and seed.
    """
    velocity, config = task
    config = msgspec.structs.replace(config, velocity=VELOCITIES[velocity], steps=0)
    body = load_body(config.robot)
    controller, guard = controller_maker(config)(body, body.cycle), Guard(body)
    walked: bool | None = None
    with build_robot(config) as robot:
        told = robot.time + float(np.random.default_rng(config.seed).uniform(*STOPPED))
        while robot.time < told + STANDS:
            frame = robot.frame
            if walked is None and robot.time >= told:
                walked = controller.state == "walk"
                controller.stop()
            answer = controller.tick(frame)
            robot.advance(guard.cycle(frame, guard.check(answer, frame.seq), supervised=True))
        stands = controller.state in ("stand", "done") and not robot.truth().fell
    return Stop(
        velocity=velocity, seed=config.seed, told=told, walked=bool(walked), stands=bool(walked) and stands
    )


def _stood(measured: Measured[list[Stop]]) -> dict[str, list[bool]]:
    """Whether each that walked until the word stands, by velocity."""
    walked = [each for each in measured.results if each.walked]
    return {name: [each.stands for each in walked if each.velocity == name] for name in VELOCITIES}


def _quantities(measured: Measured[list[Stop]]) -> dict[str, Any]:
    shares = {
        name: msgspec.structs.asdict(share_of(stood)) for name, stood in _stood(measured).items() if stood
    }
    return {"stand": shares, "stops": measured.results}


STOPS: Final = Experiment(
    title="Walks that are told to stop",
    source="Not in the thesis.",
    setup=(("told", f"{STOPPED[0]:g} to {STOPPED[1]:g} s after the start"), ("judged", f"{STANDS:g} s later")),
    measure=lambda context: context.map(
        "stop", stop, [(name, config) for config in context.configs() for name in VELOCITIES]
    ),
    quantities=_quantities,
    claims=lambda _: [],
    tables=lambda measured: [
        table(
            "Robots that stand",
            list(_stood(measured).items()),
            {
                "walked at": "{0[0]}",
                "told to stop": lambda row: str(len(row[1])),
                "stand": lambda row: str(sum(row[1])),
            },
        )
    ],
)
