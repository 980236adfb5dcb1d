"""Gaits and learned policies side by side: the same seeds, wear, delays, floors and pushes."""

from __future__ import annotations

from typing import Any, Final

from bridge.errors import ConfigurationError
from emulator.scenarios import Scenario
from emulator.scenarios.events import PushEvent
from emulator.scenarios.ground import ScenarioFloor, Tiles
from nao_hil.experiments.context import Context, Task
from nao_hil.experiments.experiment import Experiment, Measured
from nao_hil.experiments.gait_against_gait import CourseWalks, course_table, stand_claims, walk_courses
from walker.gaits import gait_parameters

DEFAULT: Final = ("omni", "dynamic", "onnx:imitation")
SPEED: Final = 0.08
"""m/s; of gaits that take a velocity. Straight ones walk at their own."""
DURATION: Final = 15.0
"""s"""
SLOPE: Final = 3.0
"""Degrees uphill."""
TILES: Final = 0.005
"""Largest height of a tile, m."""
FRICTION: Final = 0.5
DELAY: Final = 0.010
"""Added to the delay of the drives, s."""
PUSH: Final = 1.0
"""N s, forward and to the left, at `PUSH_AT`."""
PUSH_AT: Final = 6.0
"""s of robot time."""
TITLES: Final = {
    "nominal": "Flat floor",
    "worn": "Worn robot",
    "delay": f"Drives {1e3 * DELAY:g} ms later",
    "slope": f"{SLOPE:g} degrees uphill",
    "tiles": f"Tiles of up to {1e3 * TILES:g} mm",
    "friction": f"Friction {FRICTION:g}",
    "push ahead": f"Push of {PUSH:g} N s forward",
    "push aside": f"Push of {PUSH:g} N s to the left",
}


def _gaits(context: Context) -> tuple[str, ...]:
    """Those given, separated by commas.

    Raises:
        ConfigurationError: one of them twice.
    """
    given = tuple(context.gait.split(",")) if context.gait else DEFAULT
    if len(set(given)) < len(given):
        raise ConfigurationError(f"--gait {context.gait}: names a gait twice; each is compared with the first.")
    return given


def _tasks(context: Context, gait: str) -> dict[str, Task]:
    """Walks of a gait on each course."""
    from emulator.wear import load_wear

    seconds = context.duration or DURATION
    delay = load_wear(context.wear.replace("ensemble", "nominal"), context.body).servo.delay + DELAY
    tiles = Tiles(area=(SPEED * seconds + 1.0, 2.0), centre=(0.5 * SPEED * seconds, 0.0), height=TILES)
    worlds = {
        "slope": Scenario(floor=ScenarioFloor(pitch=-SLOPE)),
        "tiles": Scenario(tiles=tiles),
        "friction": Scenario(floor=ScenarioFloor(friction=FRICTION)),
        "push ahead": Scenario(pushes=(PushEvent(time=PUSH_AT, impulse=PUSH),)),
        "push aside": Scenario(pushes=(PushEvent(time=PUSH_AT, impulse=PUSH, direction=90.0),)),
    }
    changes: dict[str, dict[str, Any]] = {"worn": {"wear": "worn"}, "delay": {"wear.servo.delay": delay}}
    steered = gait_parameters(gait).limits is not None
    velocity: dict[str, Any] = {"velocity": (SPEED, 0.0, 0.0)} if steered else {}
    return {
        course: Task(
            gait,
            seconds,
            velocity | changes.get(course, {}),
            fields={"keep_track": False} | ({"scenario": worlds[course]} if course in worlds else {}),
        )
        for course in TITLES
    }


def _measure(context: Context) -> CourseWalks:
    tasks = {gait: _tasks(context, gait) for gait in _gaits(context)}
    by_course = {course: {gait: of[course] for gait, of in tasks.items()} for course in TITLES}
    return walk_courses(context, "policies", by_course)


def _quantities(measured: Measured[CourseWalks]) -> dict[str, Any]:
    walks, others = measured.results, _gaits(measured.context)[1:]
    return {
        "courses": walks.conditions,
        "pairs": {course: {gait: walks.pairs(course, gait) for gait in others} for course in walks.walks},
    }


POLICIES: Final = Experiment(
    title=lambda measured: f"Gaits and policies: {', '.join(_gaits(measured.context))}",
    source="A comparison of this project; no figures for a NAO are published.",
    setup=lambda measured: [
        ("walks", f"{SPEED:g} m/s where the gait can, {measured.context.duration or DURATION:g} s"),
        ("pairs", f"each with {_gaits(measured.context)[0]} on the same seeds"),
        ("switch", "the gait, with its own controllers"),
    ],
    measure=_measure,
    quantities=_quantities,
    claims=lambda measured: stand_claims(
        TITLES, measured.figures["courses"], "nominal", *_gaits(measured.context)
    ),
    tables=lambda measured: [
        course_table("Courses", "course", TITLES, measured.results, measured.figures["courses"])
    ],
)
