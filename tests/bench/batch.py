"""A batch of robots against the single robot and the bare engine, in one run.

Blocks of a single robot, of a batch in one thread and of the same batch in all threads take turns, each with
its floor: MuJoCo's own steps of the same robots in as many threads. Each robot is commanded to stand.
Real-time factors are summed over the robots: by the wall clock, and per second of the processor, which shows
the cost of threads where others use the machine.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import ExitStack
from typing import Any

from emulator.robot import EmulatedRobot
from nao_hil.batch import Batch
from nao_hil.runs.build import build_robot
from nao_hil.runs.config import RunConfig
from tests.bench.cycles import bare_cycle


def measure(robots: int = 16, body: str = "nao-v6", blocks: int = 24, cycles: int = 10) -> dict[str, Any]:
    """Medians over the blocks, nominal robots at a stand, on MuJoCo.

    Returns:
        By condition: the real-time factor, the same per second of the processor, both of its floor too, and the
        median and quartiles over the blocks of the share of the floor's real-time factor that is reached.
    """
    with ExitStack() as opened:
        batches = [opened.enter_context(Batch(range(1), body=body, threads=1))]
        batches += [opened.enter_context(Batch(range(robots), body=body, threads=n)) for n in (1, None)]
        bare = [opened.enter_context(build_robot(_settings(body, seed))) for seed in range(robots)]
        found: dict[str, dict[str, list[float]]] = {_name(batch): {} for batch in batches}
        for _ in range(blocks):
            for batch in batches:
                count = cycles * robots // len(batch)
                for kind, value in _block(batch, bare[: len(batch)], count).items():
                    found[_name(batch)].setdefault(kind, []).append(value)
    result: dict[str, Any] = {}
    for name, values in found.items():
        reached = zip(values["real_time_factor"], values["floor_real_time_factor"], strict=True)
        low, middle, high = statistics.quantiles([ours / floor for ours, floor in reached])
        result[name] = {kind: statistics.median(each) for kind, each in values.items()}
        result[name] |= {"over_floor": middle, "over_floor_quartiles": (low, high)}
    return result


def _settings(body: str, seed: int) -> RunConfig:
    return RunConfig(robot=body, seed=seed, wear="nominal", engine="mujoco")


def _name(batch: Batch) -> str:
    return f"robots: {len(batch)}, threads: {batch.threads}"


def _block(batch: Batch, bare: list[EmulatedRobot], cycles: int) -> dict[str, float]:
    """Cycles of a batch and, in turns with them, as many engine's steps of other robots in as many threads."""
    stand = batch.frames.position

    def run(mine: list[EmulatedRobot]) -> None:
        for robot in mine:
            bare_cycle(robot)

    spent = {"": [0.0, 0.0], "floor_": [0.0, 0.0]}

    def timed(kind: str, work: Callable[[], object]) -> None:
        began, before = time.perf_counter(), time.process_time()
        work()
        spent[kind][0] += time.perf_counter() - began
        spent[kind][1] += time.process_time() - before

    with ThreadPoolExecutor(batch.threads) as threads:
        own, *others = [bare[i :: batch.threads] for i in range(batch.threads)]

        def run_all() -> None:
            waiting = [threads.submit(run, share) for share in others]
            run(own)
            wait(waiting)

        for _ in range(cycles):
            timed("", lambda: batch.step(stand))
            for robot in bare:
                robot.advance(None)  # its drives hold it; not timed
            timed("floor_", run_all)
    time_of_robots = len(batch) * cycles * batch.cycle
    return {
        f"{kind}{name}": time_of_robots / used
        for kind, each in spent.items()
        for name, used in zip(("real_time_factor", "per_processor_second"), each, strict=True)
    }
