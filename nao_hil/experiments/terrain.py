"""Ground and robots that the walk does not know of, gait against gait on the same seeds and worlds."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final, TypeAlias

import msgspec
import numpy as np

from bridge.body import load_body
from bridge.errors import ConfigurationError
from bridge.messages.world import PlaceBox
from bridge.types import Vec3
from emulator.scenarios import Scenario
from emulator.scenarios.ground import ScenarioFloor, Tiles
from emulator.world.events import WorldEvent
from nao_hil.analysis.report.render import Claim, Outcome, ReportTable
from nao_hil.analysis.statistics import few_words, mcnemar, percent, wilson
from nao_hil.experiments.conditions import Condition, condition, falls_finding, pairs
from nao_hil.experiments.context import Context
from nao_hil.runs.events import TorsoLoad
from nao_hil.runs.walk import Walk, WalkOutcome
from walker.gaits import gait_parameters

GAIT: Final = "omni"
COMPARED_GAIT: Final = {"nao-v6": "huang"}
"""The gait to compare with, by body; of the others `dynamic`."""
STANDS: Final = wilson(45, 50)[0]
"""A share counts as "45 of 50 stand" when the lower bound of its interval is at least that one's."""


@dataclass(frozen=True)
class TerrainSetup:
    """The experiment's numbers, SI units and rad."""

    duration: float = 20.0
    speed: float = 0.15
    worn_duration: float = 30.0
    worn_speed: float = 0.12
    slope_deg: float = 5.0
    height: float = 0.01
    """Of tiles and plates."""
    plates: int = 5
    plate: tuple[float, float] = (0.04, 0.20)
    """Shortest and longest edge of a plate."""
    ahead: float = 0.30
    """Of the robot at which a plate is laid."""
    aside: float = 0.08
    """Farthest to either side."""
    friction: float = 0.3
    load: float = 0.5
    """kg"""
    load_at: Vec3 = (-0.08, 0.0, 0.05)
    """In the Torso frame: behind the back, at the height of the torso's centre of mass."""


Grounds: TypeAlias = dict[str, dict[str, Condition]]
"""By ground, or `worn` for the robot, and gait."""
Change = Callable[[Walk, np.random.Generator], dict[str, Any]]
"""Changes of a walk by a ground, from the walk's seed."""


def experiment(context: Context, setup: TerrainSetup | None = None) -> Outcome:
    """All grounds with both gaits; with one named gait, each until its verdict is certain."""
    setup = setup or TerrainSetup()
    if context.duration is not None:
        setup = replace(setup, duration=context.duration, worn_duration=context.duration)
    gaits = (context.gait,) if context.gait else (GAIT, COMPARED_GAIT.get(context.robot, "dynamic"))
    names = [(ground, gait) for ground in (*_grounds(setup), "worn") for gait in gaits]
    conditions = [ground_walks(context, setup, *name) for name in names]
    results = context.run(*conditions) if len(gaits) == 2 else context.run_until_certain(STANDS, *conditions)
    found = dict(zip(names, results, strict=True))
    left_out = 0 if context.campaign.interrupted else sum(map(len, conditions)) - sum(map(len, results))
    grounds: Grounds = {}
    for (ground, gait), outcomes in found.items():
        grounds.setdefault(ground, {})[gait] = condition(outcomes)
    claims = [
        Claim(
            f"{_title(ground, setup)}: 45 of 50 stand, {gaits[0]}",
            by_gait[gaits[0]].words(),
            by_gait[gaits[0]].interval[0] >= STANDS,
        )
        for ground, by_gait in grounds.items()
    ]
    if len(gaits) == 2:
        claims.append(_comparison(found, grounds, gaits))
    body, planned = load_body(context.robot), sum(map(len, conditions))
    return context.outcome(
        "terrain",
        f"Unknown ground, the gait {' and '.join(gaits)}{few_words(len(context.seeds))}",
        "No figures for a NAO are published.",
        setup=[
            ("walks", f"{setup.speed:g} m/s, {setup.duration:g} s; worn {setup.worn_speed:g} m/s"),
            *((gait, _speed_words(gait, setup)) for gait in gaits),
            ("switch", "the gait, with its own controllers; seeds and worlds are the same"),
            ("left out", f"{left_out} of {planned} walks, after the verdict was certain"),
        ],
        claims=claims,
        tables=[_table(grounds, setup, found, gaits)],
        findings=[
            falls_finding(f"{_title(ground, setup)}, {gait}", results, body)
            for (ground, gait), results in found.items()
        ],
        figures={
            "grounds": grounds,
            "left_out": left_out,  # walks that could not have changed the verdict of their ground
        },
    )


def _grounds(setup: TerrainSetup) -> dict[str, Change]:
    """By name; each draws its world from a generator of the walk's seed."""

    def slope(walk: Walk, random: np.random.Generator) -> dict[str, Any]:
        way = random.uniform(0.0, math.tau)
        floor = ScenarioFloor(roll=setup.slope_deg * math.sin(way), pitch=setup.slope_deg * math.cos(way))
        return {"scenario": Scenario(floor=floor)}

    def tiles(walk: Walk, random: np.random.Generator) -> dict[str, Any]:
        way = setup.speed * walk.duration
        area, centre = (way + 1.0, 2.0), (0.5 * way, 0.0)
        return {"scenario": Scenario(tiles=Tiles(area=area, centre=centre, height=setup.height))}

    def plates(walk: Walk, random: np.random.Generator) -> dict[str, Any]:
        every = walk.duration / (setup.plates + 1)
        return {
            "world_events": tuple((every * (i + 0.5), _plate(setup, i, random)) for i in range(setup.plates))
        }

    return {
        "flat": lambda walk, random: {},
        "slope": slope,
        "tiles": tiles,
        "plates": plates,
        "friction": lambda walk, random: {"scenario": Scenario(floor=ScenarioFloor(friction=setup.friction))},
        "load": lambda walk, random: {"load": TorsoLoad(mass=setup.load, at=setup.load_at)},
    }


def _plate(setup: TerrainSetup, number: int, random: np.random.Generator) -> WorldEvent:
    """Ahead of the robot wherever it went, of random edges at a random angle."""
    length, width = random.uniform(*setup.plate, 2).tolist()
    return PlaceBox(
        name=f"plate-{number}",
        size=(length, width, setup.height),
        at=(setup.ahead, float(random.uniform(-setup.aside, setup.aside))),
        yaw=float(random.uniform(0.0, math.pi)),
        frame="robot",
    )


def ground_walks(context: Context, setup: TerrainSetup, ground: str, gait: str) -> list[Walk]:
    """One walk per seed.

    Args:
        context: Robot, seeds, changes.
        setup: Numbers.
        ground: `flat`, `slope`, `tiles`, `plates`, `friction`, `load`, or `worn` for the robot.
        gait: Name.
    """
    if ground == "worn":
        worn = context.on("worn")
        velocity = _velocity(gait, setup.worn_speed)
        return worn.walks(_name(ground, gait), gait, setup.worn_duration, velocity=velocity, keep_track=False)
    change = _grounds(setup)[ground]
    walks = context.walks(
        _name(ground, gait), gait, setup.duration, velocity=_velocity(gait, setup.speed), keep_track=False
    )
    return [
        msgspec.structs.replace(walk, **change(walk, np.random.default_rng(walk.config.seed))) for walk in walks
    ]


def _name(ground: str, gait: str) -> str:
    return f"terrain, {ground}, {gait}"


def _velocity(gait: str, speed: float) -> tuple[float, ...]:
    """Empty where the steps of a gait have a fixed length."""
    try:
        gait_parameters(gait).with_velocity((speed, 0.0, 0.0))
    except ConfigurationError:
        return ()
    return speed, 0.0, 0.0


def _speed_words(gait: str, setup: TerrainSetup) -> str:
    own = gait_parameters(gait).periodic_step.velocity
    return "at these velocities" if _velocity(gait, setup.speed) else f"at its own velocity, {own:.3g} m/s"


def _comparison(
    found: dict[tuple[str, str], list[WalkOutcome]], grounds: Grounds, gaits: tuple[str, ...]
) -> Claim:
    """All grounds together, pair by pair of the same seed and world."""
    first, second = gaits
    each = [pairs(found[ground, first], found[ground, second]) for ground in grounds]
    only_first, only_second = sum(p.only_with for p in each), sum(p.only_without for p in each)
    p_value = mcnemar(only_first, only_second)
    return Claim(
        f"Over all grounds {first} stands more often than {second}",
        f"{only_first} walks stand with {first} only, {only_second} with {second} only; exact McNemar "
        f"p = {p_value:.2g}",
        only_first > only_second and p_value < 0.05,
    )


def _title(ground: str, setup: TerrainSetup) -> str:
    return {
        "flat": "Flat floor",
        "slope": f"Slope of {setup.slope_deg:g} degrees in a random direction",
        "tiles": f"Tiles of up to {1e3 * setup.height:g} mm",
        "plates": f"{setup.plates} plates of {1e3 * setup.height:g} mm",
        "friction": f"Friction {setup.friction:g}",
        "load": f"{setup.load:g} kg on the back",
        "worn": "Worn robot",
    }[ground]


def _table(
    grounds: Grounds,
    setup: TerrainSetup,
    found: dict[tuple[str, str], list[WalkOutcome]],
    gaits: tuple[str, ...],
) -> ReportTable:
    rows = []
    for ground, by_gait in grounds.items():
        cells = []
        for a in by_gait.values():
            cells += [f"{a.survived} of {a.n} ({percent(a.interval)})", f"{a.speed:.3f}"]
        if len(gaits) == 2:
            pair = pairs(found[ground, gaits[0]], found[ground, gaits[1]])
            cells.append(f"{pair.only_with} / {pair.only_without}, p = {pair.p_value:.2g}")
        rows.append((_title(ground, setup), *cells))
    head = ["ground"]
    for gait in gaits:
        head += [f"{gait}: stand", "m/s over ground"]
    if len(gaits) == 2:
        head.append(f"only {gaits[0]} / only {gaits[1]}, McNemar")
    return ReportTable("Grounds", tuple(head), tuple(rows))
