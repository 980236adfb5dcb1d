"""A campaign on two worker processes against one: speed-up, and the share of the time outside walks."""

from __future__ import annotations

import os
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import psutil

from nao_hil.campaigns.results import ask
from nao_hil.runs.campaign import Campaign
from nao_hil.runs.config import RunConfig
from nao_hil.runs.walk import Walk


class _Condition(NamedTuple):
    """Some walks on some workers; times in s."""

    wall: float
    inside: float
    """Wall time of the walks, summed."""
    workers: float
    """Processor time of the workers."""
    command: float
    """Processor time of command and scheduler."""


def measure(rounds: int = 3, walks: int = 16, duration: float = 10.0) -> dict[str, Any]:
    """The same walks on one worker and on two, in turn; all are kept on disk as in any campaign.

    Args:
        rounds: Of both.
        walks: Of a round, on each.
        duration: Of a walk, s.

    Returns:
        Per walk, of each number of workers: wall time, processor time of the workers, and of the command with
        its scheduler; the share of the workers' time outside walks. Speed-up by the wall clock, for an idle
        machine. For a busy one: at least this speed-up by processor time, `2 c1 / (c2 + s2)` times the ratio
        of the shares inside walks, as if all that the command needs (s2) were taken from the two workers.
    """
    conditions: dict[int, list[_Condition]] = {1: [], 2: []}
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        campaigns = {
            n: stack.enter_context(Campaign(Path(name) / str(n), cluster=f"local:{n}")) for n in conditions
        }
        for n, campaign in campaigns.items():
            list(campaign.stream(_flat(10_000, 4 * n, 0.1)))  # starts the workers
        for number in range(rounds):
            for n, campaign in campaigns.items():
                conditions[n].append(
                    _walk(campaign, Path(name) / str(n), _flat(number * walks, walks, duration))
                )
    means = {
        n: _Condition(*(sum(values) / rounds / walks for values in zip(*found, strict=True)))
        for n, found in conditions.items()
    }
    inside = {n: condition.inside / (n * condition.wall) for n, condition in means.items()}
    one, two = means[1], means[2]
    return {
        "walks": rounds * walks,
        "speed_up": one.wall / two.wall,
        "speed_up_by_processor_time": 2.0 * one.workers / (two.workers + two.command) * inside[2] / inside[1],
        **{
            f"{n}_workers": {
                "wall": condition.wall,
                "outside_walks": 1.0 - inside[n],
                "processor": condition.workers,
                "processor_of_command": condition.command,
            }
            for n, condition in means.items()
        },
        "load": os.getloadavg()[0],
    }


def _flat(seed: int, number: int, duration: float) -> list[Walk]:
    """Walks of a nominal V6 on the flat floor, which last to their end."""
    configs = (RunConfig(robot="nao-v6", engine="mujoco", seed=seed + k) for k in range(number))
    return [Walk(name="flat", config=config, duration=duration, keep_track=False) for config in configs]


def _walk(campaign: Campaign, folder: Path, walks: list[Walk]) -> _Condition:
    begin, workers, command = time.perf_counter(), _used_by_workers(), time.process_time()
    if len(list(campaign.stream(walks))) < len(walks):
        raise RuntimeError("not all walks are there")
    wall = time.perf_counter() - begin
    workers, command = _used_by_workers() - workers, time.process_time() - command
    first, last = walks[0].config.seed, walks[-1].config.seed
    ((inside,),) = ask(f"SELECT sum(seconds) FROM walks WHERE seed BETWEEN {first} AND {last}", folder).rows
    return _Condition(wall, inside, workers, command)


def _used_by_workers() -> float:
    """Processor time of all processes below this one, s."""
    times = [process.cpu_times() for process in psutil.Process().children(recursive=True)]
    return float(sum(each.user + each.system for each in times))
