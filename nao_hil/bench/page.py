"""Cost of the live page for the robot's real-time cycle."""

from __future__ import annotations

import multiprocessing
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, Final

from bridge.body import load_body
from bridge.errors import LinkError
from bridge.realtime import ROBOT_PRIORITY, quiet_process
from emulator.engine.catalogue import ENGINES
from emulator.robot import EmulatedRobot
from emulator.timing import CycleTimer
from nao_hil.bench.floor import bare_cycle
from nao_hil.bench.viewers import Browser, Receiver, Viewer
from nao_hil.runs.config import RunConfig
from nao_hil.runs.supervisor import Child, free_endpoint
from nao_hil.view.child import READY, LivePage

TIMEOUT: Final = 120.0
"""s for each process to start, and for a page to be shown."""
LISTENS: Final = "; recording to"
FOUND: Final = "found:"
LOADING: Final = 3.0
"""s until the robot walks."""
CASES: Final[dict[str, tuple[type[Viewer] | None, bool]]] = {
    "without": (None, False),
    "page": (Receiver, False),
    "page, one core busy": (Receiver, True),
    "browser": (Browser, False),
}
"""Who looks at the page, and whether another process computes all the time."""
BUSY: Final = (sys.executable, "-c", "while True: pass")


def measure(seconds: float = 15.0, rounds: int = 2) -> dict[str, Any]:
    """A walking robot's recording process on each engine, in turn without a page, with one, and with a browser.

    In the cases "page" a client takes the rows and draws nothing, as if a graphics card did that. The
    browser draws in software, beside the robot. The floor is a process that makes the engine's own steps of a
    standing robot at the same pace and priority, and no other process runs.

    Returns:
        Of each engine and case: p50, p99 and max of the lateness, p50 and p99 of a cycle's work, s, the worst
        of the rounds; cycles, and cycles missed, of all rounds; pictures per second, sent or drawn, the fewest.
        Of "engine alone" the work, likewise.

    Raises:
        LinkError: one of the processes failed.
        ConfigurationError: there is no Chromium.
    """
    results: dict[str, Any] = {"seconds": seconds, "rounds": rounds}
    for engine in ENGINES:
        walks: dict[str, list[dict[str, float]]] = {case: [] for case in CASES}
        alone: list[dict[str, float]] = []
        for _ in range(rounds):
            with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
                alone.append(process.submit(_engine_alone, engine, seconds).result())
            for case, (viewer, busy) in CASES.items():
                other = subprocess.Popen(BUSY) if busy else None
                try:
                    walks[case].append(_walk(engine, seconds, viewer() if viewer else None))
                finally:
                    if other is not None:
                        other.kill()
                        other.wait()
        floor = {name: max(each[name] for each in alone) for name in alone[0]}
        results[engine] = {"engine alone": floor} | {case: _together(each) for case, each in walks.items()}
    return results


def _engine_alone(engine: str, seconds: float) -> dict[str, float]:
    """The engine's own steps of a standing robot, cycle by cycle; for a process of its own."""
    config = RunConfig()
    body = load_body(config.robot)
    with EmulatedRobot(body, seed=config.seed, engine=engine) as robot:
        timer = CycleTimer(body.cycle)
        quiet_process(ROBOT_PRIORITY)
        timer.restart()
        for _ in range(round(seconds / body.cycle)):
            timer.wait()
            bare_cycle(robot)
        work = timer.times.work
    return {"work_p50": work.p50, "work_p99": work.p99}


def _walk(engine: str, seconds: float, viewer: Viewer | None) -> dict[str, float]:
    endpoint = free_endpoint()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        emulate = ["emulate", "--engine", engine, "--listen", endpoint, "--out", name, "--json"]
        robot = Child("robot", emulate, folder)
        _wait(robot, LISTENS)
        walker = Child("walker", ["walk", "--connect", endpoint, "--steps", "0"], folder)
        page = LivePage("nao", endpoint, viewer.port, folder) if viewer is not None else None
        if page is not None:
            _wait(page, READY)
        _wait(walker, FOUND)
        time.sleep(LOADING)
        if viewer is not None:
            viewer.open(TIMEOUT)
        time.sleep(seconds)
        pictures = viewer.close() if viewer is not None else 0.0
        walker.end(5.0)
        outcome = robot.end(5.0)
        if page is not None:
            page.end(5.0)
    if outcome.result is None:
        raise LinkError(f"the robot's process failed: {outcome.error}")
    timing = outcome.result["timing"]
    late: dict[str, float] = {name: timing["lateness"][name] for name in ("p50", "p99", "max")}
    work = {f"work_{name}": timing["work"][name] for name in ("p50", "p99")}
    return (
        late
        | work
        | {"cycles": timing["cycles"], "missed": outcome.result["cycles_missed"], "pictures": pictures}
    )


def _wait(child: Child, word: str) -> None:
    """Until it says so."""
    deadline = time.monotonic() + TIMEOUT
    while word not in child.stderr:
        if not child.running or time.monotonic() > deadline:
            raise LinkError(f"the {child.name} did not start: {child.end(1.0).error}")
        time.sleep(0.1)


def _together(walks: list[dict[str, float]]) -> dict[str, float]:
    worst = {name: max(walk[name] for walk in walks) for name in ("p50", "p99", "max", "work_p50", "work_p99")}
    sums = {name: sum(walk[name] for walk in walks) for name in ("cycles", "missed")}
    return worst | sums | {"pictures": min(walk["pictures"] for walk in walks)}
