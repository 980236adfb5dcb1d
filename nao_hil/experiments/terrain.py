"""Ground and robots that the walk does not know of, gait against gait on the same seeds and worlds."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from bridge.errors import ConfigurationError
from bridge.messages.world import PlaceObject
from bridge.types import Vec3
from emulator.scenarios import Scenario
from emulator.scenarios.ground import ScenarioFloor, Tiles
from nao_hil.analysis.report.render import Claim
from nao_hil.analysis.statistics import mcnemar
from nao_hil.experiments.conditions import falls_finding
from nao_hil.experiments.context import NO_CHANGE, Context, Task
from nao_hil.experiments.experiment import Experiment, Measured
from nao_hil.experiments.gait_against_gait import (
    STANDS,
    CourseWalks,
    course_table,
    stand_claims,
    walk_courses,
)
from nao_hil.runs.events import TorsoLoad
from nao_hil.runs.walk import Walk
from walker.gaits import gait_parameters

GAIT: Final = "omni"
COMPARED_GAIT: Final = {"nao-v6": "huang"}
"""The gait to compare with, by body; of the others `dynamic`."""
DURATION: Final = 20.0
"""Duration of a walk, s."""
WORN_DURATION: Final = 30.0
SPEED: Final = 0.15
"""Velocity of a walk, m/s."""
WORN_SPEED: Final = 0.12
SLOPE: Final = 5.0
"""Degrees"""
HEIGHT: Final = 0.01
"""Height of tiles and plates, m."""
PLATES: Final = 5
PLATE: Final = (0.04, 0.20)
"""Shortest and longest edge of a plate, m."""
AHEAD: Final = 0.30
"""Distance from the robot to a new plate, m."""
ASIDE: Final = 0.08
"""Farthest place of a plate to either side, m."""
FRICTION: Final = 0.3
LOAD: Final = 0.5
"""Mass of the load, kg."""
LOAD_AT: Final[Vec3] = (-0.08, 0.0, 0.05)
"""In the Torso frame, m: behind the back, at the height of the torso's centre of mass."""
TITLES: Final = {
    "flat": "Flat floor",
    "slope": f"Slope of {SLOPE:g} degrees in a random direction",
    "tiles": f"Tiles of up to {1e3 * HEIGHT:g} mm",
    "plates": f"{PLATES} plates of {1e3 * HEIGHT:g} mm",
    "friction": f"Friction {FRICTION:g}",
    "load": f"{LOAD:g} kg on the back",
    "worn": "Worn robot",
}


def ground_tasks(gait: str, duration: float | None = None) -> dict[str, Task]:
    """Walks over each ground, and by a worn robot; worlds are drawn from the seed.

    Args:
        gait: Name.
        duration: Of every walk, s; None: each one's own.
    """
    seconds, worn_seconds = duration or DURATION, duration or WORN_DURATION
    velocity, worn_velocity = ({"velocity": _velocity(gait, speed)} for speed in (SPEED, WORN_SPEED))
    way = SPEED * seconds
    tiles = Tiles(area=(way + 1.0, 2.0), centre=(0.5 * way, 0.0), height=HEIGHT)
    kinds: dict[str, dict[str, Any]] = {
        "flat": {},
        "slope": {"by_seed": _slope},
        "tiles": {"fields": {"scenario": Scenario(tiles=tiles)}},
        "plates": {"by_seed": _plates},
        "friction": {"changes": {"scenario.floor.friction": FRICTION}},
        "load": {"fields": {"load": TorsoLoad(mass=LOAD, at=LOAD_AT)}},
        "worn": {"changes": {"wear": "worn"} | worn_velocity},
    }
    return {
        name: Task(
            gait,
            worn_seconds if name == "worn" else seconds,
            velocity | kind.get("changes", {}),
            kind.get("by_seed", lambda _: NO_CHANGE),
            {"keep_track": False} | kind.get("fields", {}),
        )
        for name, kind in kinds.items()
    }


def _slope(walk: Walk) -> dict[str, Any]:
    way = np.random.default_rng(walk.config.seed).uniform(0.0, math.tau)
    return {"scenario": Scenario(floor=ScenarioFloor(roll=SLOPE * math.sin(way), pitch=SLOPE * math.cos(way)))}


def _plates(walk: Walk) -> dict[str, Any]:
    """Ahead of the robot wherever it went, of random edges at a random angle."""
    random, every = np.random.default_rng(walk.config.seed), walk.duration / (PLATES + 1)
    events = []
    for i in range(PLATES):
        length, width = random.uniform(*PLATE, 2).tolist()
        at = (AHEAD, float(random.uniform(-ASIDE, ASIDE)))
        yaw, size = float(random.uniform(0.0, math.pi)), (length, width, HEIGHT)
        plate = PlaceObject(name=f"plate-{i}", size=size, at=at, yaw=yaw, frame="robot")
        events.append((every * (i + 0.5), plate))
    return {"world_events": tuple(events)}


def _velocity(gait: str, speed: float) -> tuple[float, ...]:
    """Empty where the steps of a gait have a fixed length."""
    try:
        gait_parameters(gait).with_velocity((speed, 0.0, 0.0))
    except ConfigurationError:
        return ()
    return speed, 0.0, 0.0


def _gaits(context: Context) -> tuple[str, ...]:
    return (context.gait,) if context.gait else (GAIT, COMPARED_GAIT.get(context.robot, "dynamic"))


def _measure(context: Context) -> CourseWalks:
    """All grounds with both gaits; with one named gait, each until its verdict is certain."""
    tasks = {gait: ground_tasks(gait, context.duration) for gait in _gaits(context)}
    by_ground = {ground: {gait: of[ground] for gait, of in tasks.items()} for ground in TITLES}
    return walk_courses(context, "terrain", by_ground, STANDS if len(tasks) == 1 else None)


def _quantities(measured: Measured[CourseWalks]) -> dict[str, Any]:
    walks, planned = measured.results
    done = sum(len(found) for by_gait in walks.values() for found in by_gait.values())
    return {
        "grounds": measured.results.conditions,
        # walks that could not have changed the verdict of their ground
        "left_out": 0 if measured.context.campaign.interrupted else planned - done,
    }


def _claims(measured: Measured[CourseWalks]) -> list[Claim]:
    first, *others = _gaits(measured.context)
    grounds = measured.figures["grounds"]
    claims = [claim for ground in grounds for claim in stand_claims(TITLES, grounds, ground, first)]
    for second in others:
        each = [measured.results.pairs(ground, second) for ground in TITLES]
        only_first, only_second = sum(p.only_with for p in each), sum(p.only_without for p in each)
        p_value = mcnemar(only_first, only_second)
        more_often = Claim(
            f"Over all grounds {first} stands more often than {second}",
            f"{only_first} walks stand with {first} only, {only_second} with {second} only; exact McNemar "
            f"p = {p_value:.2g}",
            only_first > only_second and p_value < 0.05,
        )
        claims.append(more_often)
    return claims


def _setup(measured: Measured[CourseWalks]) -> list[tuple[str, str]]:
    gaits, seconds = _gaits(measured.context), measured.context.duration
    own = {gait: gait_parameters(gait).periodic_step.velocity for gait in gaits if not _velocity(gait, SPEED)}
    return [
        ("walks", f"{SPEED:g} m/s, {seconds or DURATION:g} s; worn {WORN_SPEED:g} m/s"),
        *((gait, f"at its own velocity, {speed:.3g} m/s") for gait, speed in own.items()),
        ("switch", "the gait, with its own controllers; seeds and worlds are the same"),
        (
            "left out",
            f"{measured.figures['left_out']} of {measured.results.planned} walks, after the verdict was "
            "certain",
        ),
    ]


TERRAIN: Final = Experiment(
    title=lambda measured: f"Unknown ground, the gait {' and '.join(_gaits(measured.context))}",
    source="No figures for a NAO are published.",
    setup=_setup,
    measure=_measure,
    quantities=_quantities,
    claims=_claims,
    tables=lambda measured: [
        course_table("Grounds", "ground", TITLES, measured.results, measured.figures["grounds"])
    ],
    findings=lambda measured: [
        falls_finding(f"{TITLES[ground]}, {gait}", results, measured.body)
        for ground, by_gait in measured.results.walks.items()
        for gait, results in by_gait.items()
    ],
)
