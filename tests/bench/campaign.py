"""Campaigns: null walks per second, speed-up on two workers, and a cluster whose parts are killed."""

from __future__ import annotations

import contextlib
import heapq
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
import psutil
import pyarrow.dataset as pads

from nao_hil.campaigns.results import ask
from nao_hil.runs.campaign import Campaign
from nao_hil.runs.config import RunConfig
from nao_hil.runs.dataset.dataset import PATTERN
from nao_hil.runs.dataset.journal import SUFFIX
from nao_hil.runs.executors import Job, open_executor
from nao_hil.runs.walk import Walk
from tests.measure.site import ROBOT_ADDRESS, WALKER_ADDRESS, NetworkConditions, Site


def measure(
    walks: int = 20_000, cluster: str = "local:2", walk: float = 3.0, share: float = 0.95
) -> dict[str, Any]:
    """Null walks, streamed through an executor; this process is command and scheduler.

    Args:
        walks: Null walks.
        cluster: As `--cluster`: `local` or `local:N`.
        walk: Wall time of the walks whose workers are counted, s.
        share: Of the time in which a worker is to be busy.

    Returns:
        Null walks per second by the wall clock, and per second of this process' processor time, which the
        machine's load does not change; workers that the latter keeps busy, by `walk / (share * service)` and
        by simulation; memory of this process after a tenth of the walks and after all, MiB.
    """
    executor = open_executor(cluster)
    list(executor.run([Job("null", abs, 0)]))  # starts the workers
    begin, used, early = time.perf_counter(), time.process_time(), 0.0
    done = 0
    for _ in executor.run(Job("null", abs, k) for k in range(walks)):
        done += 1
        if done == walks // 10:
            early = _memory()
    wall, service = time.perf_counter() - begin, (time.process_time() - used) / walks
    late = _memory()
    executor.close()
    return {
        "walks": done,
        "per_second": walks / wall,
        "per_processor_second": 1.0 / service,
        "workers_on_paper": math.floor(walk / (share * service)),
        "workers_simulated": workers_kept_busy(service, walk, share),
        "memory_after_a_tenth": early,
        "memory": late,
        "load": os.getloadavg()[0],
    }


def workers_kept_busy(service: float, walk: float, share: float) -> int:
    """The largest number of workers that one scheduler keeps busy for a share of the time.

    Args:
        service: Time in which the scheduler hands out one walk, s.
        walk: Mean wall time of a walk, s; each takes 0.8 to 1.2 times as long.
        share: Of the time.
    """
    low, high = 1, math.ceil(2.0 * walk / service)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if busy_share(middle, service, walk) >= share else (low, middle)
    return low


def busy_share(workers: int, service: float, walk: float, rounds: int = 30) -> float:
    """Share of the time in which simulated workers walk; the scheduler serves one after the other.

    Args:
        workers: Their number.
        service: As in `workers_kept_busy`.
        walk: As in `workers_kept_busy`.
        rounds: Walks of a worker.
    """
    generator = np.random.default_rng(0)
    idle = list(generator.uniform(0.0, walk, workers))  # when each asks next, s
    heapq.heapify(idle)
    free = waited = walked = 0.0
    for length in generator.uniform(0.8 * walk, 1.2 * walk, rounds * workers):
        asked = heapq.heappop(idle)
        free = max(asked, free) + service
        waited += free - asked
        walked += length
        heapq.heappush(idle, free + length)
    return walked / (walked + waited)


def _memory() -> float:
    """Resident set of this process, MiB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


_SCHEDULER: Final = f"tcp://{WALKER_ADDRESS}:8786"
_TIMEOUT: Final = 600.0
"""s for a campaign."""
_CAMPAIGN: Final = """
seeds = {walks}
duration = 0.2
[base]
engine = "mujoco"
gait = "static"
"""


def measure_faults(tries: int = 2, walks: int = 24, cut: float = 10.0) -> dict[str, Any]:
    """One campaign a try, with all three faults in its middle.

    Args:
        tries: Campaigns.
        walks: Of a campaign, 0.2 s each.
        cut: Length of the cut, s.

    Returns:
        In how many tries all walks are there, each once; of each try the rows, their distinct seeds, and s.
    """
    found = []
    for _ in range(tries):
        begin = time.monotonic()
        rows, seeds = _attempt(walks, cut)
        found.append({"rows": rows, "seeds": seeds, "seconds": time.monotonic() - begin})
        print(f"  {found[-1]}", flush=True)
    whole = sum(each["rows"] == each["seeds"] == walks for each in found)
    return {"tries": tries, "walks": walks, "cut": cut, "all there, each once": whole, "each": found}


def _attempt(walks: int, cut: float) -> tuple[int, int]:
    """A campaign; gives its rows and their distinct seeds."""
    with tempfile.TemporaryDirectory() as name, Site() as site, contextlib.ExitStack() as stack:
        folder = Path(name)
        (folder / "campaign.toml").write_text(_CAMPAIGN.format(walks=walks))

        def start(prefix: Sequence[str], module: str, *arguments: str) -> subprocess.Popen[bytes]:
            """A module as a process, killed at the end."""
            with (folder / "log").open("ab") as log:
                process = subprocess.Popen(
                    [*prefix, sys.executable, "-m", module, *arguments], cwd=folder, stdout=log, stderr=log
                )
            stack.callback(process.wait)
            stack.callback(process.kill)
            return process

        def scheduler() -> subprocess.Popen[bytes]:
            return start(site.walker, "dask", "scheduler", "--host", WALKER_ADDRESS, "--no-dashboard")

        def workers(number: int) -> list[subprocess.Popen[bytes]]:
            options = ("--host", ROBOT_ADDRESS, "--nthreads", "1", "--no-dashboard", "--no-nanny")
            return [start(site.robot, "dask", "worker", _SCHEDULER, *options) for _ in range(number)]

        def wait(rows: int) -> None:
            """Until so many walks are done, or none will be."""
            end = time.monotonic() + _TIMEOUT
            while campaign.poll() is None and _rows(folder) < rows and time.monotonic() < end:
                time.sleep(0.05)

        first, beginning = scheduler(), workers(2)
        while first.poll() is None and b"Scheduler at" not in (folder / "log").read_bytes():
            time.sleep(0.05)
        campaign = start(
            site.walker, "nao_hil.cli", "campaign", "campaign.toml", "--cluster", _SCHEDULER, "--out", "out"
        )
        wait(walks // 6)
        beginning[0].kill()
        workers(1)
        wait(walks // 3)
        first.kill()
        first.wait()
        scheduler()
        workers(2)
        wait(walks * 2 // 3)
        under_way = campaign.poll() is None
        site.link.set(NetworkConditions(outage=True))
        time.sleep(cut)
        site.link.set(NetworkConditions())
        with contextlib.suppress(subprocess.TimeoutExpired):
            campaign.wait(_TIMEOUT)
        if campaign.returncode != 0 or not under_way:
            print((folder / "log").read_text()[-3000:])
        parts = sorted(map(str, (folder / "out" / "walks").glob(PATTERN)))
        found = pads.dataset(parts).to_table(["seed"]).column("seed").to_pylist() if parts else []
        return len(found), len(set(found))


def _rows(folder: Path) -> int:
    """Walks in the journal of a campaign."""
    return sum(path.read_bytes().count(b"\n") for path in folder.glob(f"out/walks/journal/*{SUFFIX}"))


class _Condition(NamedTuple):
    """Some walks on some workers; times in s."""

    wall: float
    inside: float
    """Wall time of the walks, summed."""
    workers: float
    """Processor time of the workers."""
    command: float
    """Processor time of command and scheduler."""


def measure_speed_up(rounds: int = 3, walks: int = 16, duration: float = 10.0) -> dict[str, Any]:
    """The same walks on one worker and on two, in turn; all are kept on disk as in any campaign.

    Args:
        rounds: Of both.
        walks: Of a round, on each.
        duration: Of a walk, s.

    Returns:
        Per walk, of each number of workers: wall time, processor time of the workers, and of the command with
        its scheduler; the share of the workers' time outside walks. Speed-up by the wall clock, for an idle
        machine. For a busy one: at least this speed-up by processor time, `2 c1 / (c2 + s2)` times the ratio
        of the shares inside walks, as if the command's own need (s2) were taken from the two workers.
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
