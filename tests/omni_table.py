"""Measures the table of `docs/omni-measured.md`: walks, grounds, pushes and get-ups of the gait `omni`.

    python -m tests.omni_table --engine pybullet --seeds 50 --first-seed 1500000 > table.md

Each row is a cell of `CELLS`: walks on fresh seeds, with Wilson's interval of 95 %. `--only WORD` measures the
rows whose name has the word; `--set controller.damping.roll=0.05` changes a parameter of the walks (not of
get-ups); `--processes N` spreads the walks over processes.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np

from bridge import rotations
from bridge.messages.world import PlaceObject
from emulator.scenarios import Scenario
from emulator.scenarios.ground import ScenarioFloor, Tiles
from emulator.wear.ensemble import wear_of_seed
from nao_hil.analysis.statistics import percent, wilson
from nao_hil.campaigns.quantities import changed_all
from nao_hil.experiments.get_up import get_up
from nao_hil.experiments.velocity import heading_velocity
from nao_hil.runs.config import RunConfig
from nao_hil.runs.events import StridePush, TorsoLoad
from nao_hil.runs.walk import Walk, walk

PARAMETERS: Final = ("v_x", "v_y", "v_yaw")


class Cell(NamedTuple):
    """A row of the table."""

    name: str
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """m/s, m/s, rad/s"""
    robot: str = "nao-v6"
    wear: str = "nominal"
    duration: float = 10.0
    """s"""
    ground: str = ""
    push: tuple[float, float | None] | None = None
    """Impulse, N s, and direction, rad; None: drawn."""
    stand: bool = False
    get_up: bool = False


def _cells() -> Iterator[Cell]:
    for robot, wear, velocities in (
        (
            "nao-v6",
            "nominal",
            ((0.4, 0, 0), (0.35, 0, 0), (0.2, 0, 0), (-0.25, 0, 0), (0, 0.25, 0), (0, -0.25, 0), (0, 0.15, 0)),
        ),
        ("nao-v6", "nominal", ((0, 0, 1.5), (0, 0, -1.5), (0, 0, 0.8), (0.15, 0, 0.6), (0.2, 0.1, 0.5))),
        ("nao-v6", "nominal", ((-0.1, -0.1, -0.8),)),
        ("nao-v6", "ensemble", ((0.32, 0, 0), (-0.2, 0, 0), (0, 0.2, 0), (0, 0, 1.2))),
        ("nao-v3", "nominal", ((0.32, 0, 0), (0, 0.2, 0), (0, 0.15, 0), (0, 0, 1.2))),
    ):
        for x, y, turn in velocities:
            yield Cell(f"{robot} {wear} {x:g} {y:g} m/s {turn:g} rad/s", (x, y, turn), robot, wear)
    slow = (0.15, 0.0, 0.0)
    for ground in ("slope 8", "slope 5", "tiles", "plates", "friction", "load"):
        yield Cell(f"ground: {ground}", slow, duration=20.0, ground=ground)
    yield Cell("ground: worn robot", slow, wear="worn", duration=30.0)
    yield Cell(
        "push: 1.5 N s in a walk at 0.15 m/s, any direction and phase", slow, duration=8.0, push=(1.5, None)
    )
    turn = (0.0, 0.0, 0.8)
    yield Cell("push: 1.5 N s to a side in a turn of 0.8 rad/s", turn, duration=8.0, push=(1.5, math.pi / 2))
    for degrees in (0, 90, -120, 135, 180):
        name = f"push: 3.0 N s in a stand, {degrees} deg"
        yield Cell(name, stand=True, duration=8.0, push=(3.0, math.radians(degrees)))
    for robot in ("nao-v6", "nao-v3"):
        yield Cell(f"get-up: {robot}, any side", robot=robot, get_up=True)


CELLS: Final = tuple(_cells())


def _world(cell: Cell, random: np.random.Generator) -> dict[str, Any]:
    """What the ground changes in a walk; directions and plates are drawn."""
    kind, _, size = cell.ground.partition(" ")
    if kind == "slope":
        way, angle = random.uniform(0.0, math.tau), float(size)
        floor = ScenarioFloor(roll=angle * math.sin(way), pitch=angle * math.cos(way))
        return {"scenario": Scenario(floor=floor)}
    if kind == "tiles":
        return {"scenario": Scenario(tiles=Tiles(area=(4.0, 2.0), centre=(1.5, 0.0), height=0.01))}
    if kind == "plates":
        every = cell.duration / 6
        plates = tuple(
            PlaceObject(
                name=f"plate-{i}",
                size=(*random.uniform(0.04, 0.20, 2).tolist(), 0.01),
                at=(0.30, float(random.uniform(-0.08, 0.08))),
                yaw=float(random.uniform(0.0, math.pi)),
                frame="robot",
            )
            for i in range(5)
        )
        return {"world_events": tuple((every * (i + 0.5), plate) for i, plate in enumerate(plates))}
    if kind == "friction":
        return {"scenario": Scenario(floor=ScenarioFloor(friction=0.3))}
    return {"load": TorsoLoad(mass=0.5, at=(-0.08, 0.0, 0.05))} if kind == "load" else {}


def _push(cell: Cell, random: np.random.Generator) -> tuple[StridePush, ...]:
    if cell.push is None:
        return ()
    impulse, direction = cell.push
    way = random.uniform(0.0, math.tau) if direction is None else direction * random.choice((-1.0, 1.0))
    phase = None if cell.stand else float(random.uniform())
    return (StridePush(time=2.0, phase=phase, impulse=impulse, direction=float(way)),)


class Result(NamedTuple):
    """One walk."""

    stood: bool
    velocity: tuple[float, float, float] | None
    """Mean in the torso's heading after the settling."""
    turns: tuple[float, float] | None
    """Largest and last turn off the heading at the start, deg; None: a turn was asked, or a push given."""


def measure(cell: Cell, engine: str, changes: Mapping[str, float], seed: int) -> Result:
    """One walk, or one drop, of a cell; `changes`: quantities of a campaign and their values."""
    config = RunConfig(
        robot=cell.robot,
        engine=engine,
        gait="omni",
        seed=seed,
        wear=wear_of_seed(cell.wear, seed),
        parameters=dict(zip(PARAMETERS, cell.velocity, strict=True)),
    )
    if cell.get_up:
        return Result(get_up(config).drop.stands, None, None)
    random = np.random.default_rng(seed)
    task = Walk(
        name=cell.name, config=config, duration=cell.duration, stand=cell.stand, pushes=_push(cell, random)
    )
    task = msgspec.structs.replace(task, **_world(cell, random))
    outcome = walk(changed_all(task, changes))
    moves = not cell.stand and cell.push is None
    track = outcome.track.until(outcome.end.time)
    velocity = heading_velocity(track) if moves else None
    if not moves or cell.velocity[2]:
        return Result(outcome.end.survived, velocity, None)
    heading = np.degrees(np.unwrap(rotations.yaw(track["world/truth.torso_orientation"])))
    turned = np.abs(heading - heading[0])
    return Result(outcome.end.survived, velocity, (float(turned.max()), float(turned[-1])))


def main() -> None:
    """Print a row as soon as its walks are done."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--engine", default="mujoco", choices=("mujoco", "pybullet"))
    parser.add_argument("--seeds", type=int, default=50)
    parser.add_argument("--first-seed", type=int, default=1500000)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--only", default="")
    parser.add_argument(
        "--set", metavar="NAME=VALUE", default=[], nargs="+", help="quantities as of a campaign"
    )
    given = parser.parse_args()
    changes = {name: float(value) for name, value in (each.split("=") for each in given.set)}
    print(f"| {given.engine}, n = {given.seeds} | stood | interval | measured, median | turn, deg |")
    print("|---|---|---|---|---|")
    seeds = range(given.first_seed, given.first_seed + given.seeds)
    with ProcessPoolExecutor(given.processes) as pool:
        for cell in (each for each in CELLS if given.only in each.name):
            results = list(pool.map(partial(measure, cell, given.engine, changes), seeds))
            stood = sum(result.stood for result in results)
            walked = [result.velocity for result in results if result.velocity is not None]
            median = ", ".join(f"{v:.3f}" for v in np.median(walked, axis=0)) if walked else ""
            interval = percent(wilson(stood, len(results)))
            turns = np.array([result.turns for result in results if result.turns is not None])
            turn = (
                f"{np.median(turns[:, 0]):.0f}, at most {turns[:, 0].max():.0f}; at the end "
                f"{math.sqrt(np.mean(np.square(turns[:, 1]))):.0f} in the quadratic mean"
                if len(turns)
                else ""
            )
            print(f"| {cell.name} | {stood} of {len(results)} | {interval} | {median} | {turn} |")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
